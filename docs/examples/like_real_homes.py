# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of days beside a real home, CASAS "AL" (one person, 30 days), as a table:

    python docs/examples/like_real_homes.py DAYS

Needs the package (`pip install .`). Of the real home only some figures stand here, not every time;
so a distance of Kolmogorov and Smirnov is a lower bound: the greatest difference at these
quantiles, less what their rounding allows. `angen compare` with the home's log gives the distance
itself: see docs/residents.md.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Sequence
from pathlib import Path

try:
    import numpy as np
    from angen_sensors.sensor_logic.logs.comparison import compare
    from angen_sensors.sensor_logic.logs.formats.source import InputError
except ModuleNotFoundError as error:
    raise SystemExit(
        f"like_real_homes: {error}: run `pip install .` in the repository's folder"
    ) from None

# Shares of values that are at or below so many seconds, and what the seconds are rounded to.
ON_TIMES = (
    (0.001, 1.0, 0.0),
    (0.05, 1.10, 0.01),
    (0.5, 1.86, 0.01),
    (0.95, 6.75, 0.01),
    (0.99, 10.7, 0.1),
)
GAPS = ((0.5, 5.0, 0.1), (0.95, 61.0, 1.0))
DAY_S = 86400.0


def least_distance(values: np.ndarray, known: Sequence[tuple[float, float, float]]) -> float:
    """What the distance of `values` (n,) to a distribution with these quantiles is at least.

    Of a quantile x of p at least p is at or below x, and at most p below it.
    """
    ordered, found = np.sort(values), [0.0]
    for share, seconds, rounded in known:
        low, high = seconds - rounded / 2, seconds + rounded / 2
        below = np.searchsorted(ordered, low, side="left") / len(ordered)
        up_to = np.searchsorted(ordered, high, side="right") / len(ordered)
        found += [below - share, share - up_to]
    return max(found)


def covered(spans: list[tuple[float, float]]) -> float:
    """Seconds that are in any of the spans."""
    total, reached = 0.0, -np.inf
    for begin, end in sorted(spans):
        total += max(end - max(begin, reached), 0.0)
        reached = max(reached, end)
    return total


def quantiles(values: np.ndarray, *shares: float) -> str:
    return " / ".join(f"{q:.2f}" if q < 10 else f"{q:.0f}" for q in np.quantile(values, shares))


def changes_a_day(folder: Path) -> list[int]:
    """How many changes of what is on or off each day has, without the states at its midnight."""
    counts: dict[str, int] = {}
    with open(folder / "events.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            day, clock = row["time"].split("T")
            counts.setdefault(day, 0)
            if row["field"] in ("moved", "open", "pressed") and clock != "00:00:00.000":
                counts[day] += 1
    return list(counts.values())


def table(folder: Path) -> list[tuple[str, str, str]]:
    """(figure, the real home, these days) a row. Raises InputError, OSError."""
    home = compare.read(folder)
    motion = [s for s in home.sensors.values() if s.quantity == "motion"]
    on, gaps = compare.on_times(home, "motion"), compare.gaps(home, "motion")
    if len(gaps) < 2 or not len(on):
        raise InputError(f"{folder} has too few times at which motion detectors are on")
    changes = changes_a_day(folder)
    days, time = len(changes), len(changes) * DAY_S
    starts = [start for sensor in motion for start in sensor.starts]
    spans = [span for sensor in motion for span in sensor.intervals]
    edges = [edge for span in spans for edge in span]
    minutes = {m for a, b in spans for m in range(int(a // 60), int(b // 60) + 1)}
    after = [covered([(edge, edge + wait) for edge in edges]) / time for wait in (10, 30, 60)]
    with open(folder / "activities.csv", newline="", encoding="utf-8") as file:
        segments = sum(1 for _ in csv.DictReader(file))
    single = np.mean((on >= 1.1) & (on <= 1.2))
    below = np.mean(on < 1.0)
    sd = np.std(changes, ddof=1) if days > 1 else np.nan
    at = quantiles(on, 0.05, 0.5, 0.95, 0.99)
    distances = least_distance(on, ON_TIMES), least_distance(gaps, GAPS)
    waits = " / ".join(f"{100 * share:.1f}" for share in after)
    return [
        ("events a day, mean (sd)", "2077 (299)", f"{np.mean(changes):.0f} ({sd:.0f})"),
        ("motion ON a sensor and day", "143", f"{len(starts) / days / len(motion):.0f}"),
        ("ON time, 5 / 50 / 95 / 99 %, s", "1.10 / 1.86 / 6.75 / 10.7", at),
        ("ON time 1.1 to 1.2 s", "38 %", f"{100 * single:.0f} %"),
        ("ON time below 1 s", "0.1 %", f"{100 * below:.1f} %"),
        ("ON time, distance at least", "", f"{distances[0]:.2f}"),
        ("from ON to ON, 50 / 95 %, s", "5.0 / 61", quantiles(gaps, 0.5, 0.95)),
        ("from ON to ON, longest, h", "5.4", f"{gaps.max() / 3600:.1f}"),
        ("from ON to ON, distance at least", "", f"{distances[1]:.2f}"),
        ("any motion ON, of the time", "2.9 %", f"{100 * covered(spans) / time:.1f} %"),
        ("any motion ON, of the minutes", "12.0 %", f"{6000 * len(minutes) / time:.1f} %"),
        ("within 10 / 30 / 60 s after a change", "7.2 / 9.9 / 12.1 %", f"{waits} %"),
        ("labelled segments a day", "91 (55 without Other)", f"{segments / days:.0f}"),
        ("motion detectors", "", f"{len(motion)}"),
        ("days", "30", f"{days}"),
    ]  # fmt: skip


def main(folder: str) -> None:
    try:
        rows = table(Path(folder))
    except (InputError, OSError) as error:
        raise SystemExit(f"like_real_homes: {error}") from None
    print('| | CASAS "AL" | these days |\n|---|---|---|')
    for row in rows:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    main(sys.argv[1])
