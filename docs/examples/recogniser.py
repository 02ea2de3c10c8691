# SPDX-License-Identifier: GPL-3.0-or-later
"""Which activity is it? A plain recogniser learns from some days and is tried on others, then again
without each sensor in turn, and with each alone: what that sensor is worth.

    python docs/examples/recogniser.py DAYS [DAYS …] --test 2026-03-04 2026-03-05

DAYS are folders of `angen day`, of homes with the same sensors. Needs scikit-learn alone.

Each 30 s of a day is one sample. What is known of it: which sensors were on and how often they
changed in it, for each sensor how long ago it changed last, the last three that went on, the time
of day. What it is called: the activity that takes most of it. Each day begins without memory.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter, defaultdict
from collections.abc import Iterator
from datetime import date, datetime, timedelta
from pathlib import Path

try:
    import numpy as np
    from sklearn.dummy import DummyClassifier
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import accuracy_score, f1_score
except ModuleNotFoundError as error:
    raise SystemExit(f"recogniser: {error}: run `pip install scikit-learn`") from None

WINDOW_S, DAY_S = 30, 86400
WINDOWS = DAY_S // WINDOW_S
LAST = 3
NOBODY_SENSED_S = 4 * 3600.0  # for longer than this it makes no difference
Day = tuple[Path, date]


def seconds(time: str) -> tuple[date, float]:
    at = datetime.fromisoformat(time)
    midnight = at.replace(hour=0, minute=0, second=0, microsecond=0)
    return at.date(), (at - midnight).total_seconds()


def read_changes(folder: Path) -> dict[date, list[tuple[float, str, bool]]]:
    """(seconds since midnight, sensor, on) of all that is on or off, by day."""
    days: dict[date, list[tuple[float, str, bool]]] = defaultdict(list)
    with open(folder / "events.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["field"] in ("moved", "open", "pressed"):
                day, second = seconds(row["time"])
                days[day].append((second, row["sensor"], row["value"] == "1"))
    return dict(days)


def pieces(start: str, end: str) -> Iterator[tuple[date, float, float]]:
    """(day, begin, end in seconds since its midnight) of each day that an activity is in."""
    (day, begin), (last, until) = seconds(start), seconds(end)
    while day < last:
        yield day, begin, DAY_S
        day, begin = day + timedelta(days=1), 0.0
    yield day, begin, until


def read_labels(folder: Path, person: str) -> dict[date, list[str]]:
    """What a person mostly did in each window of each day; "" where nothing is said."""
    shares: dict[tuple[date, int], Counter[str]] = defaultdict(Counter)
    with open(folder / "activities.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if person and row["person"] != person:
                continue
            for day, begin, end in pieces(row["start"], row["end"]):
                for window in range(int(begin // WINDOW_S), -int(-end // WINDOW_S)):
                    at = window * WINDOW_S
                    share = min(end, at + WINDOW_S) - max(begin, at)
                    shares[day, window][row["activity"]] += share
    most = {place: counter.most_common(1)[0][0] for place, counter in shares.items()}
    days = {day for day, _ in most}
    return {day: [most.get((day, n), "") for n in range(WINDOWS)] for day in days}


def features(changes: list[tuple[float, str, bool]], sensors: list[str]) -> np.ndarray:
    """(WINDOWS, columns) of one day, of these sensors alone."""
    number = {name: n for n, name in enumerate(sensors)}
    on = np.zeros(len(sensors))
    changed = np.full(len(sensors), -NOBODY_SENSED_S)
    last = [-1] * LAST
    queue = iter(sorted(c for c in changes if c[1] in number))
    ahead = next(queue, None)
    rows = []
    for window in range(WINDOWS):
        end = (window + 1) * WINDOW_S
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


class Home:
    """Days of folders: the changes of their sensors, and what the person did."""

    def __init__(self, folders: list[Path], person: str) -> None:
        self.changes = {(f, day): rows for f in folders for day, rows in read_changes(f).items()}
        labels = {(f, day): row for f in folders for day, row in read_labels(f, person).items()}
        self.days: list[Day] = [day for day in self.changes if day in labels]
        self.labels = {day: np.array(labels[day]) for day in self.days}
        self.sensors = sorted({sensor for of in self.changes.values() for _, sensor, _ in of})

    def samples(self, days: list[Day], sensors: list[str]) -> tuple[np.ndarray, np.ndarray]:
        """(n, columns) and (n,) of the windows in which something is done."""
        x = np.concatenate([features(self.changes[day], sensors) for day in days])
        y = np.concatenate([self.labels[day] for day in days])
        return x[y != ""], y[y != ""]


def score(model: object, train: tuple, test: tuple) -> tuple[float, float]:
    """Accuracy and macro F1 (each activity of the days that it is tried on counts alike)."""
    guessed = model.fit(*train).predict(test[0])
    f1 = f1_score(test[1], guessed, labels=np.unique(test[1]), average="macro", zero_division=0)
    return accuracy_score(test[1], guessed), f1


def forest_score(home: Home, train: list[Day], test: list[Day], sensors: list[str], seeds: int):
    """(seeds, 2): accuracy and macro F1 of forests that chance grew differently."""
    data = home.samples(train, sensors), home.samples(test, sensors)
    grown = [
        RandomForestClassifier(100, min_samples_leaf=2, class_weight="balanced", random_state=seed)
        for seed in range(seeds)
    ]
    return np.array([score(forest, *data) for forest in grown])


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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("days", nargs="+", type=Path, metavar="DAYS")
    parser.add_argument(
        "--test", nargs="+", type=day_of, required=True, metavar="DATE",
        help="days to try it on; it learns from the others",
    )  # fmt: skip
    parser.add_argument("--person", default="", help="whose activities, where several live there")
    parser.add_argument("--seeds", type=int, default=5, help="forests of each kind (5)")
    given = parser.parse_args()
    for folder in given.days:
        for name in ("events.csv", "activities.csv"):
            if not (folder / name).is_file():
                parser.error(f"{folder} has no {name}: give a folder that `angen day` wrote")
    home = Home(given.days, given.person)
    if not home.days:
        whose = f" of {given.person!r}" if given.person else ""
        parser.error(f"no day has events and activities{whose}")
    known = [day for _, day in home.days]
    if unknown := set(given.test) - set(known):
        parser.error(f"--test: there is no {listed(list(unknown))}; the days are {listed(known)}")
    train = [day for day in home.days if day[1] not in given.test]
    test = [day for day in home.days if day[1] in given.test]
    if not train:
        parser.error(f"--test: no day is left to learn from; the days are {listed(known)}")
    data = home.samples(train, home.sensors), home.samples(test, home.sensors)
    print(f"{len(train)} days to learn, {len(test)} to try; {len(data[1][1])} windows of 30 s,")
    print(f"{len(np.unique(data[1][1]))} activities, {len(home.sensors)} sensors\n")
    print("Change: against all sensors; of one alone, against the clock.\n")
    print("| sensors | accuracy | macro F1 | change |\n|---|---|---|---|")
    most = score(DummyClassifier(strategy="most_frequent"), *data)
    print(f"| none: always the most frequent | {most[0]:.3f} | {most[1]:.3f} | |")
    every = forest_score(home, train, test, home.sensors, given.seeds)
    clock = forest_score(home, train, test, [], given.seeds)
    rows = [("none: the clock alone", clock, every), ("**all**", every, every)]
    for left_out in home.sensors:
        rest = [sensor for sensor in home.sensors if sensor != left_out]
        found = forest_score(home, train, test, rest, given.seeds)
        rows.append((f"without {left_out}", found, every))
    for one in home.sensors:
        rows.append((f"{one} alone", forest_score(home, train, test, [one], given.seeds), clock))
    for name, found, beside in rows:
        (accuracy, f1), (_, sd) = found.mean(axis=0), found.std(axis=0)
        change = "" if found is beside else f"{f1 - beside[:, 1].mean():+.3f}"
        print(f"| {name} | {accuracy:.3f} | {f1:.3f} ± {sd:.3f} | {change} |")


if __name__ == "__main__":
    main()
