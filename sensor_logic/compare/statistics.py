# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of how sensors behave, and the distance between two homes in each.

The distance is that of Kolmogorov and Smirnov: the greatest difference of the two empirical
distribution functions, 0 to 1 (Smirnov 1939; `scipy.stats.ks_2samp` gives the same).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from .intervals import DAY_S, HomeIntervals, SensorIntervals

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
# Fewer values tell no difference: the usual level of a test.
CHANCE = 0.05
Values = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Measure:
    """One measure of a group of sensors: its values (n,) in each home, in `unit`."""

    group: str
    name: str
    unit: str
    values: tuple[Values, Values]

    @property
    def distance(self) -> float:
        """The Kolmogorov-Smirnov distance; NaN where a home has too few values."""
        return ks_distance(*self.values) if self.has_enough_values else math.nan

    @property
    def has_enough_values(self) -> bool:
        """Whether a distance means something: both homes have more than one value, and two alike
        are at the largest distance, 1, in at most CHANCE of all cases."""
        n, m = map(len, self.values)
        return min(n, m) > 1 and 2 / math.comb(n + m, n) <= CHANCE


def ks_distance(a: Values, b: Values) -> float:
    """The greatest difference of the empirical distributions of `a` (n,) and `b` (m,)."""
    if not len(a) or not len(b):
        return math.nan
    a, b = np.sort(a), np.sort(b)
    at = np.concatenate([a, b])
    below_a = np.searchsorted(a, at, side="right") / len(a)
    below_b = np.searchsorted(b, at, side="right") / len(b)
    return float(np.abs(below_a - below_b).max())


def quantiles(values: Values) -> list[float]:
    """The interpolated QUANTILES; NaN without values."""
    return [float(q) for q in np.quantile(values, QUANTILES)] if len(values) else [math.nan] * 6


def measures(one: HomeIntervals, two: HomeIntervals) -> list[Measure]:
    """All measures of each group of sensors (motion, opening …) that either home has."""
    groups = sorted({s.quantity for home in (one, two) for s in home.sensors.values()})
    return [
        Measure(group, name, unit, (of(one, group), of(two, group)))
        for group in groups
        for name, unit, of in (
            ("on for", "s", on_times),
            ("from on to on", "s", gaps),
            ("on a sensor and day", "times", counts),
            ("any on", "% of a day", shares),
        )
    ]


def _of(home: HomeIntervals, group: str) -> list[SensorIntervals]:
    return [sensor for sensor in home.sensors.values() if sensor.quantity == group]


def on_times(home: HomeIntervals, group: str) -> Values:
    """The durations in s of all complete intervals in which a sensor was on."""
    return _seconds([end - begin for s in _of(home, group) for begin, end in s.intervals])


def gaps(home: HomeIntervals, group: str) -> Values:
    """The times in s from each change to on, of any sensor of the group, to the next."""
    return _seconds(np.diff(np.sort([start for s in _of(home, group) for start in s.starts])))


def _seconds(values: list[float] | Values) -> Values:
    """Durations rounded to microseconds, the resolution of logs, so that equal ones stay equal."""
    return np.round(np.asarray(values, float), 6)


def counts(home: HomeIntervals, group: str) -> Values:
    """Counts how often each sensor went on: a number for each sensor and day."""
    edges, scale = _days(home)
    found = [np.histogram(s.starts, edges)[0] * scale for s in _of(home, group)]
    return np.concatenate(found) if found else np.empty(0)


def shares(home: HomeIntervals, group: str) -> Values:
    """The percentage of each day in which any sensor of the group was on, a value for each day."""
    merged: list[list[float]] = []
    for begin, end in sorted(i for s in _of(home, group) for i in s.intervals):
        if merged and begin <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([begin, end])
    edges, scale = _days(home)
    on = np.array(merged, float).reshape(-1, 2)
    within = [np.clip(on, *day) for day in pairwise(edges)]
    if not _of(home, group):
        return np.empty(0)
    return np.array([(w[:, 1] - w[:, 0]).sum() * scale / DAY_S * 100.0 for w in within])


def _days(home: HomeIntervals) -> tuple[Values, float]:
    """The edges (s) of the log's days, 24 hours each from its begin, and the factor for counts.
    Time after the last whole day is ignored; a log of less than a day is scaled to one."""
    whole = int(home.length // DAY_S)
    if whole:
        return np.array([home.begin + DAY_S * day for day in range(whole + 1)]), 1.0
    return np.array([home.begin, home.end]), DAY_S / home.length
