# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare two logs: how long and how often sensors are on, and how much the logs differ."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..error import InputError
from ..formats import activities
from ..formats.log import DEFAULT_START, Log
from ..formats.reading import read_log
from ..wording import shown_duration

# The intervals in which each sensor of a log, in any format, was on.

DAY_S = 86400.0


@dataclass
class SensorIntervals:
    """The intervals in which a sensor was on.

    Attributes
    ----------
    quantity
        The quantity that the sensor measures, such as "motion".
    starts
        The times in s of all changes from off to on.
    intervals
        The begin and the end in s of each interval whose begin and end are both in the log.
    """

    quantity: str
    starts: list[float] = field(default_factory=list)
    intervals: list[tuple[float, float]] = field(default_factory=list)


@dataclass
class HomeIntervals:
    """The intervals of all sensors in a log.

    Attributes
    ----------
    name
        The name of the log.
    begin, end
        The begin and the end of the log in s since its t = 0. A folder of days ends at midnight,
        any other log with its last change.
    sensors
        The intervals of each sensor by name. In a log of activities, each activity is a sensor and
        its own quantity, and t = 0 is a midnight.
    notes
        A sentence for each repair or omission while the log was read.
    has_activities
        Whether it is a log of activities.
    """

    name: str
    begin: float
    end: float
    sensors: dict[str, SensorIntervals]
    notes: tuple[str, ...] = ()
    has_activities: bool = False

    @property
    def length(self) -> float:
        """The length of the log in seconds, which is more than 0."""
        return self.end - self.begin


def read(path: Path) -> HomeIntervals:
    """Return the intervals of all sensors in a log at `path`.

    It can be an event log, a folder of simulated days, or a log in a format of another tool. Raise
    InputError if the content is not valid, or OSError if it cannot be read.
    """
    source = read_log(path)
    log = source.log(start=source.start or DEFAULT_START)
    home = _home(path, _log_changes(log), source.has_states)
    end = home.end if source.end is None else source.end
    if end <= home.begin:
        raise InputError(
            f"all changes in {path} are at the same time, so there is nothing to "
            "compare: give a longer log"
        )
    return replace(home, end=end, notes=source.notes)


def read_both(
    one: Path, two: Path, labels: Mapping[str, str] | None = None
) -> tuple[HomeIntervals, HomeIntervals]:
    """Return the intervals of two logs: those of activities if one has only these, else of sensors.

    `labels` has other names for some activities. Raise InputError or OSError as `read` does.
    """
    if any(activities.is_activities(path) for path in (one, two)):
        return _read_activities(one, labels or {}), _read_activities(two, labels or {})
    return read(one), read(two)


def _read_activities(path: Path, labels: Mapping[str, str]) -> HomeIntervals:
    """Return the intervals of a log of activities, on whole days by the calendar."""
    found, notes = activities.read(path)
    midnight = found[0].start.replace(hour=0, minute=0, second=0, microsecond=0)
    done: dict[str, SensorIntervals] = {}
    last = 0.0
    for row in found:
        begin, end = ((at - midnight).total_seconds() for at in (row.start, row.end))
        name = labels.get(row.activity, row.activity)
        one = done.setdefault(name, SensorIntervals(name))
        one.starts.append(begin)
        one.intervals.append((begin, end))
        last = max(last, end)
    # A day of which up to three hours are missing counts as whole.
    first = math.ceil((found[0].start - midnight).total_seconds() / DAY_S - 1 / 8)
    days = max(math.floor(last / DAY_S + 1 / 8) - first, 0)
    if not days:
        raise InputError(f"{path} has no whole day, so there is nothing to compare")
    return HomeIntervals(
        path.name, first * DAY_S, (first + days) * DAY_S, done, tuple(notes), has_activities=True
    )


Row = tuple[float, str, str, bool]


def _log_changes(log: Log) -> Iterator[Row]:
    """Yield each change of a boolean field: time in s, sensor, quantity, and the new value."""
    for change in log.changes:
        channel = change.channel
        if isinstance(change.value, bool) and channel.quantity != "validity":
            yield change.time / 1e6, channel.sensor.name, channel.quantity, change.value


def _home(path: Path, rows: Iterable[Row], has_states: bool) -> HomeIntervals:
    sensors: dict[str, SensorIntervals] = {}
    since: dict[str, float] = {}
    states: dict[str, bool] = defaultdict(bool)
    begin, last = None, 0.0
    for time, name, quantity, on in rows:
        begin = time if begin is None else begin
        last = time
        is_first = name not in sensors
        sensor = sensors.setdefault(name, SensorIntervals(quantity))
        # A sensor that is on when the log starts has been on for an unknown time.
        if is_first and has_states:
            states[name] = on
            continue
        # Logs of real homes repeat states.
        if on and not states[name]:
            sensor.starts.append(time)
            since[name] = time
        elif not on and name in since:
            sensor.intervals.append((since.pop(name), time))
        states[name] = on
    if begin is None:
        raise InputError(
            f"{path} has no sensor with the states on and off, so there is nothing to compare"
        )
    return HomeIntervals(path.name, begin, last, sensors)


# Statistics of the sensors of a home, and the distance between two homes in each statistic.
#
# The distance is the Kolmogorov-Smirnov statistic: the greatest difference between two empirical
# distribution functions, 0 to 1 (Smirnov 1939; equal to `scipy.stats.ks_2samp`).

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
# Significance level; with too few values no distance reaches it.
CHANCE = 0.05
Values = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Measure:
    """One statistic of a group of sensors, in two logs.

    Attributes
    ----------
    group
        The quantity that these sensors measure, such as "motion".
    name, unit
        The name of the statistic and its unit.
    values
        The values (n,) of the statistic in the first and in the second log.
    """

    group: str
    name: str
    unit: str
    values: tuple[Values, Values]

    @property
    def distance(self) -> float:
        """The Kolmogorov-Smirnov distance between the two logs; NaN if one has too few values."""
        return ks_distance(*self.values) if self.has_enough_values else math.nan

    @property
    def has_enough_values(self) -> bool:
        """Whether both logs have enough values for a distance.

        Each needs more than one value. Two samples of the same distribution can by chance have the
        largest distance, 1. The probability of this must be at most CHANCE.
        """
        n, m = map(len, self.values)
        return min(n, m) > 1 and 2 / math.comb(n + m, n) <= CHANCE


def ks_distance(a: Values, b: Values) -> float:
    """Return the Kolmogorov-Smirnov distance of two samples; NaN if one is empty."""
    if not len(a) or not len(b):
        return math.nan
    a, b = np.sort(a), np.sort(b)
    at = np.concatenate([a, b])
    below_a = np.searchsorted(a, at, side="right") / len(a)
    below_b = np.searchsorted(b, at, side="right") / len(b)
    return float(np.abs(below_a - below_b).max())


def quantiles(values: Values) -> list[float]:
    """Return the quantiles of `values` at QUANTILES, interpolated; NaN if there are no values."""
    return [float(q) for q in np.quantile(values, QUANTILES)] if len(values) else [math.nan] * 6


def measures(one: HomeIntervals, two: HomeIntervals) -> list[Measure]:
    """Return the statistics of the logs `one` and `two`, for each group of sensors."""
    groups = sorted({s.quantity for home in (one, two) for s in home.sensors.values()})
    return [
        Measure(group, name, unit, (of(one, group), of(two, group)))
        for group in groups
        for name, unit, of in (ACTIVITY_FIGURES if one.has_activities else SENSOR_FIGURES)
    ]


def _sensors_in(home: HomeIntervals, group: str) -> list[SensorIntervals]:
    return [sensor for sensor in home.sensors.values() if sensor.quantity == group]


def on_times(home: HomeIntervals, group: str) -> Values:
    """Return the durations in s of all intervals in which sensors of the group were on."""
    return _rounded_seconds(
        [end - begin for s in _sensors_in(home, group) for begin, end in s.intervals]
    )


def gaps(home: HomeIntervals, group: str) -> Values:
    """Return the times in s between successive changes from off to on in a group of sensors."""
    return _rounded_seconds(
        np.diff(np.sort([start for s in _sensors_in(home, group) for start in s.starts]))
    )


def _rounded_seconds(values: list[float] | Values) -> Values:
    """Round durations to microseconds, so that durations that are equal in the log stay equal."""
    return np.round(np.asarray(values, float), 6)


def counts(home: HomeIntervals, group: str) -> Values:
    """Return the number of changes to on for each sensor of the group on each day."""
    edges, scale = _days(home)
    found = [np.histogram(s.starts, edges)[0] * scale for s in _sensors_in(home, group)]
    return np.concatenate(found) if found else np.empty(0)


def shares(home: HomeIntervals, group: str) -> Values:
    """Return, for each day, the percentage of time in which any sensor of the group was on."""
    merged: list[list[float]] = []
    for begin, end in sorted(i for s in _sensors_in(home, group) for i in s.intervals):
        if merged and begin <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([begin, end])
    edges, scale = _days(home)
    on = np.array(merged, float).reshape(-1, 2)
    within = [np.clip(on, *day) for day in pairwise(edges)]
    if not _sensors_in(home, group):
        return np.empty(0)
    return np.array([(w[:, 1] - w[:, 0]).sum() * scale / DAY_S * 100.0 for w in within])


def _days(home: HomeIntervals) -> tuple[Values, float]:
    """Return the begin and end of the log's days as n + 1 times (s), and a factor for counts.

    A day has 24 hours from the begin of the log. Time after the last whole day is ignored. A log of
    less than a day is one day, and the factor scales its counts up to 24 hours.
    """
    whole = int(home.length // DAY_S)
    if whole:
        return np.array([home.begin + DAY_S * day for day in range(whole + 1)]), 1.0
    return np.array([home.begin, home.end]), DAY_S / home.length


def hours(home: HomeIntervals, group: str) -> Values:
    """Return the times of day, in h, at which an activity begins: from 4 to 28, as nights do."""
    starts = np.array([start for one in _sensors_in(home, group) for start in one.starts])
    return (starts / 3600 - 4.0) % 24.0 + 4.0


# The name, unit and function of each figure of a sensor, and of an activity.
Figure = tuple[str, str, Callable[[HomeIntervals, str], Values]]
SENSOR_FIGURES: tuple[Figure, ...] = (
    ("on for", "s", on_times),
    ("from on to on", "s", gaps),
    ("on a sensor and day", "times", counts),
    ("any on", "% of a day", shares),
)
ACTIVITY_FIGURES: tuple[Figure, ...] = (
    ("begins at", "h", hours),
    ("lasts", "s", on_times),
    ("times a day", "times", counts),
    ("under way", "% of a day", shares),
)

# The comparison as text, and as data for programs.

HEADS = ("n", *(f"{100 * q:g} %" for q in QUANTILES))


def text(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> str:
    """Return the comparison of the logs `one` and `two` as text.

    Each statistic in `found` has a heading with the distance, and a row for each log. The last
    lines name the logs that are shorter than a day.
    """
    width = max(len(one.name), len(two.name), 8)
    lines = [f"{'':<{width}}" + "".join(f"{head:>10}" for head in HEADS)]
    for measure in found:
        shown = _distance(measure)
        lines.append(f"\n{measure.group}: {measure.name} ({measure.unit}): {shown}")
        for home, values in zip((one, two), measure.values, strict=True):
            figures = [f"{len(values)}", *(_short(q) for q in quantiles(values))]
            lines.append(f"{home.name:<{width}}" + "".join(f"{figure:>10}" for figure in figures))
    for home in (one,) if one == two else (one, two):
        if home.length < DAY_S:
            lines.append(
                f"\n{home.name} lasts {shown_duration(home.length)}: its times and % of a day are "
                "scaled up from that to 24 hours"
            )
    return "\n".join(lines) + "\n"


def _distance(measure: Measure) -> str:
    if not all(map(len, measure.values)):
        return "one log has no values"
    if not measure.has_enough_values:
        return "too few values for a distance"
    return f"distance {measure.distance:.3f}"


def _short(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.4g}"


def data(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> dict[str, Any]:
    """Return the comparison of the logs `one` and `two` as data for JSON.

    `found` has the statistics. A figure is None if there are too few values for it. The figures per
    day of a log shorter than a day are scaled up to 24 hours.
    """
    return {
        "logs": [one.name, two.name],
        "days": [home.length / DAY_S for home in (one, two)],
        "measures": [
            {
                "group": measure.group,
                "measure": measure.name,
                "unit": measure.unit,
                "ks_distance": _plain(measure.distance),
                "logs": [
                    {
                        "n": len(values),
                        "quantiles": {
                            f"{q:g}": _plain(v)
                            for q, v in zip(QUANTILES, quantiles(values), strict=True)
                        },
                    }
                    for values in measure.values
                ],
            }
            for measure in found
        ],
    }


def _plain(value: float) -> float | None:
    return None if math.isnan(value) else value
