# SPDX-License-Identifier: GPL-3.0-or-later
"""How like a log of activities are days that are drawn from habits learnt from it?

    python docs/examples/learnt_days.py LOG [--folds 5] [--least 20] [--person NAME]

Needs the package (`pip install .`). LOG is what `angen learn` reads. Each day of the log is left
out once, with others: habits are learnt from the rest, and days are drawn from the routine as its
text is read back. The table compares all drawn days with all days of the log, for each label that
is in it often enough: the distance of Kolmogorov and Smirnov of starts, durations and times a day.
Beside it stands the distance of one half of the real days from the other half, on average: by
chance. Times are rounded to minutes, as in many logs. Days are from 04:00 to 04:00.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

try:
    import numpy as np
    from angen_sensors.residents.routine import file
    from angen_sensors.residents.routine.learn import Begun, draw, learn, lived_days
    from angen_sensors.residents.routine.routine import Person
    from angen_sensors.residents.routine.text import routine_text
    from angen_sensors.residents.routine.timetable import OTHER
    from angen_sensors.sensor_logic.logs.comparison.compare import ks_distance
    from angen_sensors.sensor_logic.logs.error import AngenError, InputError
    from angen_sensors.sensor_logic.logs.formats import activities
except ModuleNotFoundError as error:
    raise SystemExit(
        f"learnt_days: {error}: run `pip install .` in the repository's folder"
    ) from None

DRAWN_DAYS, HALVES = 70, 20
ANNA = Person("anna", "anna", False, "")
DaysBegun = Sequence[Sequence[Begun]]


def figures(days: DaysBegun, label: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts and durations (min) of an activity on some days, and its times a day."""
    of = [[one for one in begun if one.activity == label] for begun in days]
    starts = [one.begins // 60 for begun in of for one in begun]
    lasts = [round(one.lasts / 60) for begun in of for one in begun]
    return np.array(starts, float), np.array(lasts, float), np.array([len(b) for b in of], float)


def distances(one: DaysBegun, two: DaysBegun, label: str) -> list[float]:
    """Distances of starts, durations and times a day of an activity."""
    both = zip(figures(one, label), figures(two, label), strict=True)
    return [ks_distance(a, b) for a, b in both]


def drawn_days(log, folds: int, seed: int) -> list[list[Begun]]:
    """Days drawn from habits that are learnt without some days, each left out once."""
    days = np.random.default_rng(seed).permutation(sorted(log.begun))
    found = []
    for number in range(folds):
        left_out = set(days[number::folds])
        routine = learn(log.only([day for day in days if day not in left_out]), ANNA)
        read_back = file.read(routine_text(routine, [], {}), "learnt")
        found += draw(read_back, ANNA.name, DRAWN_DAYS, 1000 + number).begun.values()
    return found


def table(path: Path, person: str, folds: int, least: int, seed: int) -> tuple[int, list[tuple]]:
    """The number of days, and a row a label: label, count, distances, distances by chance."""
    done, _ = activities.read(path)
    names = sorted({one.person for one in done})
    if person not in names and (person or len(names) > 1):
        raise InputError(f"give one of the log's people with --person: {', '.join(names)}")
    log = lived_days([one for one in done if one.person == (person or names[0])])
    if not 2 <= folds <= len(log.begun):
        raise InputError(f"--folds: give 2 to {len(log.begun)}, the number of days")
    real, ours = list(log.begun.values()), drawn_days(log, folds, seed)
    random = np.random.default_rng(seed)
    splits = [random.permutation(len(real)) for _ in range(HALVES)]
    rows = []
    for label in sorted({one.activity for begun in real for one in begun} - {OTHER}):
        count = len(figures(real, label)[0])
        if count < least:
            continue
        halves = [
            distances([real[n] for n in order[::2]], [real[n] for n in order[1::2]], label)
            for order in splits
        ]
        rows.append((label, count, *distances(real, ours, label), *np.nanmean(halves, axis=0)))
    return len(real), rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("log", type=Path, metavar="LOG")
    parser.add_argument("--folds", type=int, default=5, help="groups of days left out (5)")
    parser.add_argument("--least", type=int, default=20, help="occurrences of a label (20)")
    parser.add_argument("--person", default="", help="whose activities, of several people")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    try:
        days, rows = table(given.log, given.person, given.folds, given.least, given.seed)
    except (AngenError, OSError) as error:
        raise SystemExit(f"learnt_days: {error}") from None
    print(f"{days} days, {given.folds} groups left out\n")
    print("| label | in the log | starts | durations | times a day | real halves |")
    print("|---|---|---|---|---|---|")
    for label, count, *values in rows:
        ours, chance = values[:3], values[3:]
        shown = " | ".join(f"{value:.2f}" for value in ours)
        print(f"| {label} | {count} | {shown} | {' / '.join(f'{c:.2f}' for c in chance)} |")
    if rows:
        means = np.nanmean([row[2:] for row in rows], axis=0)
        shown = " | ".join(f"**{value:.3f}**" for value in means[:3])
        chance = " / ".join(f"{value:.3f}" for value in means[3:])
        print(f"| **all** | {sum(row[1] for row in rows)} | {shown} | {chance} |")


if __name__ == "__main__":
    main()
