# SPDX-License-Identifier: GPL-3.0-or-later
"""Which activity is it? A plain recogniser learns from some days and is tried on others.

    python docs/examples/recogniser.py HOME [HOME …] --test 2026-03-04 2026-03-05
    python docs/examples/recogniser.py HOME [HOME …] --on REAL.toml --real 0 1 2 --rules RULES.toml
    python docs/examples/recogniser.py HOME [HOME …] --leave-out days

The first learns from all days but those that are named, and again without each sensor and with each
alone: what that sensor is worth. The second learns from all homes and is tried on a real one, of
which it may know some days; beside it stand the same days with sensors that are on by a rule, and
the real days alone. The third leaves out each day, or each home, in turn.

A HOME is a folder of `angen day`, or a TOML file that names logs and what things are called there:

    events = "sensors.txt"             # a log that `angen convert` reads, or a folder of days
    activities = "activities.txt"      # a log that `angen learn` reads; not of a folder of days
    weight = 2.0                       # how much its days count; 1 without it
    [sensors]                          # with this table, all others are left out
    "Seat Living" = "Pad sofa"
    [labels]
    "Spare_Time/TV" = "Relaxing"

RULES.toml has a table [rules] of the sensors that are on during an activity, with lines such as
Relaxing = ["Pad sofa"]. Needs scikit-learn and the package (`pip install scikit-learn .`).

Each 30 s of a day is one sample. What is known of it: which sensors were on and how often they
changed in it, for each sensor how long ago it changed last, the last three that went on, the time
of day. What it is called: the activity that takes most of it. Each day begins without memory.
"""

from __future__ import annotations

import argparse
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime, timedelta
from pathlib import Path

try:
    import numpy as np
    from angen_sensors.residents.routine.timetable import OTHER
    from angen_sensors.sensor_logic.logs.error import AngenError, InputError
    from angen_sensors.sensor_logic.logs.formats import activities
    from angen_sensors.sensor_logic.logs.formats.log import DEFAULT_START
    from angen_sensors.sensor_logic.logs.formats.reading import read_log
    from sklearn.dummy import DummyClassifier
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import accuracy_score, f1_score
except ModuleNotFoundError as error:
    raise SystemExit(
        f"recogniser: {error}: run `pip install scikit-learn .` in the repository's folder"
    ) from None

DAY_S = 86400
LAST = 3
NOBODY_SENSED_S = 4 * 3600.0  # for longer than this it makes no difference
LEAST_S = 6 * 3600.0  # a day of which activities tell less is left out
Change = tuple[float, str, bool]  # s since midnight, sensor, on
Span = tuple[float, float, str]  # begin and end in s since midnight, activity
Samples = tuple[np.ndarray, np.ndarray, np.ndarray]  # columns, activities, weights


@dataclass
class Day:
    """A day of a home: its changes, its activities, and how much it counts."""

    home: str
    date: date
    weight: float
    changes: list[Change] = field(default_factory=list)
    spans: list[Span] = field(default_factory=list)

    @property
    def covered(self) -> float:
        """For how long activities tell what was done, s."""
        return sum(end - begin for begin, end, _ in self.spans)

    def by_rules(self, rules: Mapping[str, Sequence[str]]) -> Day:
        """The same day, with sensors that are on during the activities that the rules name."""
        changes = [
            change
            for begin, end, activity in self.spans
            for sensor in rules.get(activity, ())
            for change in ((begin, sensor, True), (end, sensor, False))
        ]
        # What ends as the next begins comes first.
        changes.sort(key=lambda change: (change[0], change[2]))
        return Day(self.home, self.date, self.weight, changes, self.spans)


def read_home(path: Path, person: str = "", logs: Path | None = None) -> list[Day]:
    """The days of a home that have events and activities. Raises InputError, OSError.

    The logs that a TOML file names lie beside it, or in the folder `logs`.
    """
    if path.suffix == ".toml":
        values = _toml(path)
        if missing := {"events", "activities"} - values.keys():
            raise InputError(f"{path} has no {' and no '.join(sorted(missing))}")
        folder = logs or path.parent
        events, done = folder / values["events"], folder / values["activities"]
    else:
        values, events, done = {}, path, path
        for name in ("events.csv", "activities.csv"):
            if not (path / name).is_file():
                raise InputError(f"{path} has no {name}: give a folder that `angen day` wrote")
    found: dict[date, Day] = {}

    def day(of: date) -> Day:
        return found.setdefault(of, Day(path.name, of, float(values.get("weight", 1.0))))

    labels = values.get("labels", {})
    for row in activities.read(done)[0]:
        if (person and row.person != person) or row.activity == OTHER:
            continue
        for of, begin, end in pieces(row.start, row.end):
            day(of).spans.append((begin, end, labels.get(row.activity, row.activity)))
    for of, changes in changes_by_day(events, values.get("sensors")).items():
        if of in found:
            day(of).changes = changes
    whole = [one for one in found.values() if one.changes and one.covered >= LEAST_S]
    return sorted(whole, key=lambda one: one.date)


def _toml(path: Path) -> dict:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None


def changes_by_day(path: Path, names: Mapping[str, str] | None) -> dict[date, list[Change]]:
    """All that is on or off, by day; each day begins with what is on at its midnight."""
    source = read_log(path)
    start = source.start or DEFAULT_START
    log = source.log(start=start)
    zero = start.replace(hour=0, minute=0, second=0, microsecond=0)
    since = (start - zero).total_seconds()
    on: dict[str, set[str]] = defaultdict(set)
    days: dict[date, list[Change]] = {}
    last = -1
    for change in log.changes:
        channel = change.channel
        if channel.type is not bool or channel.quantity == "validity":
            continue
        name = channel.sensor.name if names is None else names.get(channel.sensor.name)
        if name is None:
            continue
        number, second = divmod(since + change.time / 1e6, DAY_S)
        for midnight in range(last + 1, int(number) + 1):
            days[(zero + timedelta(midnight)).date()] = [
                (0.0, s, True) for s, of in on.items() if of
            ]
        last = max(last, int(number))
        # Several sensors with the same name are on while any of them is.
        (set.add if change.value else set.discard)(on[name], channel.sensor.name)
        days[(zero + timedelta(last)).date()].append((second, name, bool(on[name])))
    return days


def pieces(start: datetime, end: datetime) -> Iterator[tuple[date, float, float]]:
    """(day, begin, end in seconds since its midnight) of each day that an activity is in."""
    (day, begin), (last, until) = (
        (at.date(), at.hour * 3600.0 + at.minute * 60 + at.second + at.microsecond / 1e6)
        for at in (start, end)
    )
    while day < last:
        yield day, begin, DAY_S
        day, begin = day + timedelta(days=1), 0.0
    yield day, begin, until


def labels_of(day: Day, window: int) -> np.ndarray:
    """What was mostly done in each window; "" where nothing is said."""
    shares: dict[int, Counter[str]] = defaultdict(Counter)
    for begin, end, activity in day.spans:
        for number in range(int(begin // window), -int(-end // window)):
            at = number * window
            shares[number][activity] += min(end, at + window) - max(begin, at)
    most = {number: counter.most_common(1)[0][0] for number, counter in shares.items()}
    return np.array([most.get(number, "") for number in range(DAY_S // window)])


def features(changes: Sequence[Change], sensors: Sequence[str], window: int) -> np.ndarray:
    """(windows, columns) of one day, of these sensors alone."""
    number = {name: n for n, name in enumerate(sensors)}
    on = np.zeros(len(sensors))
    changed = np.full(len(sensors), -NOBODY_SENSED_S)
    last = [-1] * LAST
    queue = iter(sorted((c for c in changes if c[1] in number), key=lambda c: c[0]))
    ahead = next(queue, None)
    rows = []
    for place in range(DAY_S // window):
        end = (place + 1) * window
        count, any_on = np.zeros(len(sensors)), on.copy()
        while ahead is not None and ahead[0] < end:
            at, n, on_now = ahead[0], number[ahead[1]], ahead[2]
            if at > 0.0:  # at midnight it is the state that the day begins with
                count[n] += 1
                changed[n] = at
            if on_now and n != last[-1]:
                last = [*last[1:], n]
            on[n] = on_now
            any_on[n] = max(any_on[n], on_now)
            ahead = next(queue, None)
        since = np.minimum(end - changed, NOBODY_SENSED_S)
        which = [float(n == one) for one in last for n in range(len(sensors))]
        turn = 2.0 * np.pi * end / DAY_S
        rows.append([*any_on, *count, *np.log1p(since), *which, np.sin(turn), np.cos(turn), end])
    return np.array(rows)


def samples(days: Sequence[Day], sensors: Sequence[str], window: int) -> Samples:
    """The windows of days in which something is done."""
    return joined([samples_of(day, sensors, window) for day in days])


def samples_of(day: Day, sensors: Sequence[str], window: int) -> Samples:
    """The windows of a day in which something is done."""
    x, y = features(day.changes, sensors, window), labels_of(day, window)
    return x[y != ""], y[y != ""], np.full(np.sum(y != ""), day.weight)


def joined(parts: Sequence[Samples]) -> Samples:
    """The windows of several days as one table."""
    x, y, weights = (np.concatenate(column) for column in zip(*parts, strict=True))
    return x, y, weights


def sensors_of(days: Sequence[Day]) -> list[str]:
    return sorted({sensor for day in days for _, sensor, _ in day.changes})


def scores(guessed: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    """Accuracy and macro F1 (each activity of the days that it is tried on counts alike)."""
    f1 = f1_score(true, guessed, labels=np.unique(true), average="macro", zero_division=0)
    return accuracy_score(true, guessed), f1


def forest_guess(train: Samples, test: Samples, seed: int) -> np.ndarray:
    """What a forest calls the windows of other days."""
    forest = RandomForestClassifier(
        100, min_samples_leaf=2, class_weight="balanced", random_state=seed
    )
    return forest.fit(train[0], train[1], train[2]).predict(test[0])


def forest_scores(train: Samples, test: Samples, seeds: int) -> np.ndarray:
    """(seeds, 2): accuracy and macro F1 of forests that chance grew differently."""
    return np.array([scores(forest_guess(train, test, seed), test[1]) for seed in range(seeds)])


def row(name: str, found: np.ndarray, beside: np.ndarray | None = None) -> str:
    """A row of a table: the means of `found` (n, 2), and the change of F1 against `beside`."""
    (accuracy, f1), (_, sd) = found.mean(axis=0), found.std(axis=0)
    change = f"{f1 - beside[:, 1].mean():+.3f}" if beside is not None else ""
    return f"| {name} | {accuracy:.3f} | {f1:.3f} ± {sd:.3f} | {change} |"


def worth_of_sensors(train: list[Day], test: list[Day], window: int, seeds: int) -> None:
    """Print what each sensor is worth."""
    sensors = sensors_of([*train, *test])

    def of(which: list[str]) -> np.ndarray:
        return forest_scores(samples(train, which, window), samples(test, which, window), seeds)

    data = samples(train, sensors, window), samples(test, sensors, window)
    print(
        f"{len(train)} days to learn, {len(test)} to try; {len(data[1][1])} windows of {window} s,"
    )
    print(f"{len(np.unique(data[1][1]))} activities, {len(sensors)} sensors\n")
    print("Change: against all sensors; of one alone, against the clock.\n")
    print("| sensors | accuracy | macro F1 | change |\n|---|---|---|---|")
    dummy = DummyClassifier(strategy="most_frequent").fit(*data[0][:2])
    most = scores(dummy.predict(data[1][0]), data[1][1])
    print(f"| none: always the most frequent | {most[0]:.3f} | {most[1]:.3f} | |")
    every, clock = of(sensors), of([])
    print(row("none: the clock alone", clock, every))
    print(row("**all**", every))
    for left_out in sensors:
        print(row(f"without {left_out}", of([s for s in sensors if s != left_out]), every))
    for one in sensors:
        print(row(f"{one} alone", of([one]), clock))


def tried(
    days: Sequence[Day], real: Sequence[Day], number: int, sensors: Sequence[str], window: int,
    seeds: int,
) -> np.ndarray:  # fmt: skip
    """(seeds, 2): accuracy and macro F1 on real days, of what is learnt from `days` and `number`
    real ones. Chance draws these, and what is tried are all others."""
    simulated, theirs = (
        [samples_of(day, sensors, window) for day in given] for given in (days, real)
    )
    found = []
    for seed in range(seeds):
        order = np.random.default_rng(seed).permutation(len(real))
        learnt = joined([*simulated, *(theirs[n] for n in order[:number])])
        test = joined([theirs[n] for n in order[number:]])
        found.append(scores(forest_guess(learnt, test, seed), test[1]))
    return np.array(found)


def tried_on(
    train: list[Day], real: list[Day], numbers: Sequence[int], rules: Mapping[str, Sequence[str]],
    window: int, seeds: int,
) -> None:  # fmt: skip
    """Print what days and some real days are worth on the other days of a real home."""
    ruled = [day.by_rules(rules) for day in train] if rules else []
    known, theirs = set(sensors_of(train)), set(sensors_of(real))
    sensors = sorted(known & theirs)
    if not sensors:
        raise InputError("no sensor has the same name in both: give names in a table [sensors]")
    for names, where in ((known - theirs, "only learnt from"), (theirs - known, "only tried on")):
        if names:
            print(f"Sensors {where}, left out: {', '.join(sorted(names))}\n")
    unknown = {name for day in real for *_, name in day.spans} - {
        name for day in train for *_, name in day.spans
    }
    if unknown:
        print(f"Activities that are never learnt: {', '.join(sorted(unknown))}\n")
    print(f"{len(train)} days to learn, {len(real)} real days, {len(sensors)} sensors\n")
    print("Change: against sensors by rules.\n")
    print("| learnt from | accuracy | macro F1 | change |\n|---|---|---|---|")

    def of(days: list[Day], number: int) -> np.ndarray:
        return tried(days, real, number, sensors, window, seeds)

    for number in numbers:
        and_real = f" and {number} real" if number else ""
        control = of(ruled, number) if ruled else None
        print(row(f"these days{and_real}", of(train, number), control))
        if control is not None:
            print(row(f"the same days by rules{and_real}", control))
        if number:
            print(row(f"{number} real alone", of([], number), control))


def left_out(days: list[Day], by: str, window: int, seeds: int) -> None:
    """Print how well each day or home is named by what is learnt from all others."""
    sensors = sensors_of(days)
    groups: dict[str, list[Day]] = defaultdict(list)
    for day in days:
        groups[day.home if by == "homes" else f"{day.home} {day.date}"].append(day)
    if len(groups) < 2:
        raise InputError(f"--leave-out {by}: there is only one")
    print(f"{len(days)} days, {len(sensors)} sensors\n")
    print("| left out | accuracy | macro F1 | |\n|---|---|---|---|")
    guesses: list[list[np.ndarray]] = [[] for _ in range(seeds)]
    true = []
    for name, test in groups.items():
        train = samples([day for day in days if day not in test], sensors, window)
        tried = samples(test, sensors, window)
        guessed = [forest_guess(train, tried, seed) for seed in range(seeds)]
        print(row(name, np.array([scores(guess, tried[1]) for guess in guessed])))
        true.append(tried[1])
        for seed, guess in enumerate(guessed):
            guesses[seed].append(guess)
    whole = np.concatenate(true)
    print(row("**all**", np.array([scores(np.concatenate(of), whole) for of in guesses])))


def day_of(text: str) -> date:
    """Read a date of the option --test."""
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a date such as 2026-03-07") from None


def listed(days: list[date]) -> str:
    """Return dates as a text; of many, the first and the last."""
    texts = [f"{day}" for day in sorted(set(days))]
    return ", ".join(texts) if len(texts) < 15 else f"{texts[0]} to {texts[-1]}"


def rules_of(path: Path | None) -> dict[str, list[str]]:
    """The sensors that are on during each activity."""
    found = _toml(path).get("rules") if path else {}
    if not isinstance(found, dict) or (path and not found):
        raise InputError(f"{path} has no table [rules], with lines such as Sleep = ['Pad bed']")
    return {name: [of] if isinstance(of, str) else list(of) for name, of in found.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("homes", nargs="+", type=Path, metavar="HOME")
    how = parser.add_mutually_exclusive_group(required=True)
    how.add_argument(
        "--test", nargs="+", type=day_of, metavar="DATE",
        help="days to try it on; it learns from the others",
    )  # fmt: skip
    how.add_argument("--on", type=Path, metavar="HOME", help="another home to try it on")
    how.add_argument("--leave-out", choices=["days", "homes"], help="leave out each in turn")
    parser.add_argument(
        "--real", nargs="+", type=int, default=[0], metavar="N",
        help="with --on: numbers of its days to learn from, too (0)",
    )  # fmt: skip
    parser.add_argument("--rules", type=Path, help="with --on: sensors by rules, as a control")
    parser.add_argument("--person", default="", help="whose activities, where several live there")
    parser.add_argument("--window", type=int, default=30, help="seconds of a sample (30)")
    parser.add_argument("--seeds", type=int, default=5, help="forests of each kind (5)")
    given = parser.parse_args()
    try:
        homes = {path: read_home(path, given.person) for path in given.homes}
        days = [day for home in homes.values() for day in home]
        if not days:
            whose = f" of {given.person!r}" if given.person else ""
            raise InputError(f"no day has events and activities{whose}")
        if given.leave_out:
            left_out(days, given.leave_out, given.window, given.seeds)
        elif given.on:
            real = read_home(given.on, given.person)
            if not 0 <= max(given.real) < len(real):
                raise InputError(f"--real: {given.on} has {len(real)} days; one is to be tried")
            tried_on(days, real, given.real, rules_of(given.rules), given.window, given.seeds)
        else:
            known = [day.date for day in days]
            if unknown := set(given.test) - set(known):
                raise InputError(
                    f"--test: there is no {listed(list(unknown))}; the days are {listed(known)}"
                )
            train = [day for day in days if day.date not in given.test]
            if not train:
                raise InputError(
                    f"--test: no day is left to learn from; the days are {listed(known)}"
                )
            test = [day for day in days if day.date in given.test]
            worth_of_sensors(train, test, given.window, given.seeds)
    except (AngenError, OSError) as error:
        raise SystemExit(f"recogniser: {error}") from None


if __name__ == "__main__":
    main()
