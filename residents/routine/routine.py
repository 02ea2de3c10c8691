# SPDX-License-Identifier: GPL-3.0-or-later
"""A routine as read and checked, and the durations and times of day in it.

All durations and times are in seconds.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date, datetime

WEEKDAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
# Meteorological seasons of the northern hemisphere, by month.
SEASONS = {
    "winter": (12, 1, 2),
    "spring": (3, 4, 5),
    "summer": (6, 7, 8),
    "autumn": (9, 10, 11),
}
DAY = 86_400.0
# The activity of a person who is not at home.
AWAY = "Away"


@dataclass(frozen=True)
class Meanwhile:
    """Movements that are repeated during an activity, of which one in `do` is chosen each time.

    `every` is their mean interval in s, and `burst` their mean number in a row (None for the
    default). The rests between have the log-normal spread `varies`. `where` has the lines of the
    steps in the file.
    """

    do: tuple[str, ...]
    every: float
    varies: float
    burst: float | None = None
    where: tuple[str, ...] = ()


@dataclass(frozen=True)
class RoutineActivity:
    """An activity: its steps in order, and the movements repeated during the last step.

    `labels` are its names in other data sets. `where` has the lines of the steps in the file.
    """

    name: str
    do: tuple[str, ...]
    meanwhile: tuple[Meanwhile, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    where: tuple[str, ...] = ()


@dataclass(frozen=True)
class Calendar:
    """The days to which a rule applies: weekdays (0 is Monday), months and inclusive dates."""

    weekdays: frozenset[int] = frozenset(range(7))
    months: frozenset[int] = frozenset(range(1, 13))
    first: date = date.min
    last: date = date.max

    def __contains__(self, day: date) -> bool:
        return (
            day.weekday() in self.weekdays
            and day.month in self.months
            and self.first <= day <= self.last
        )


@dataclass(frozen=True)
class FixedPoint:
    """An activity of a plan at a time of day.

    The start is normally distributed around `at` with the standard deviation `spread`. Either the
    duration is log-normal, with the median `lasts` and the spread `varies`, or the end is at the
    time of day `until`. For the next day `until` is above 24 h. `chance` is the probability that it
    happens. `where` is its line in the file.
    """

    activity: str
    at: float
    spread: float
    lasts: float | None
    until: float | None
    varies: float
    chance: float
    where: str


@dataclass(frozen=True)
class FixedPoints:
    """A person's plan for some days."""

    person: str
    days: Calendar
    entries: tuple[FixedPoint, ...]


@dataclass(frozen=True)
class Pastime:
    """An activity of a filler: its weight, and its duration (median and log-normal spread)."""

    activity: str
    weight: float
    lasts: float
    varies: float


@dataclass(frozen=True)
class Filler:
    """What a person does between the fixed points, from one time of day to another."""

    person: str
    days: Calendar
    begins: float
    ends: float
    choices: tuple[Pastime, ...]


@dataclass(frozen=True)
class Interruption:
    """An activity that interrupts the activity `during`, on average `times` in each stretch."""

    person: str
    during: str
    activity: str
    times: float
    lasts: float
    varies: float


@dataclass(frozen=True)
class Absence:
    """A time for which a person is away."""

    person: str
    begins: datetime
    ends: datetime


@dataclass(frozen=True)
class Person:
    """A person of the routine.

    A `visitor` is away except for planned activities. `resident` is the name of the object in the
    home. `begins` is the activity at the first midnight. `where` is the person's line in the file.
    """

    name: str
    resident: str
    visitor: bool
    begins: str
    where: str = ""


@dataclass(frozen=True)
class Routine:
    """All persons, activities and rules of a routine."""

    persons: Mapping[str, Person]
    activities: Mapping[str, RoutineActivity]
    plans: tuple[FixedPoints, ...]
    fillers: tuple[Filler, ...]
    interruptions: tuple[Interruption, ...]
    absences: tuple[Absence, ...]


@dataclass(frozen=True)
class Segment:
    """The activity of a person from `start` to `end`, in s since midnight of the first day.

    `where` is its line in a diary.
    """

    start: float
    end: float
    person: str
    activity: str
    where: str = field(default="", compare=False)


# Durations such as "1 h 30 min", and times of day such as "07:30".

_UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_PART = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(s|min|h)\s*")


def seconds(text: object) -> float:
    """Return a duration in seconds; raise `ValueError` for any other text."""
    total, at, last = 0.0, 0, float("inf")
    shown = str(text)
    while isinstance(text, str) and at < len(text):
        part = _PART.match(text, at)
        if part is None or _UNITS[part.group(2)] >= last:
            break
        last = _UNITS[part.group(2)]
        total += float(part.group(1)) * last
        at = part.end()
    if not isinstance(text, str) or not text.strip() or at < len(text):
        raise ValueError(f'{shown!r} is no duration, such as "20 s", "25 min" or "1 h 30 min"')
    return total


def time_of_day(text: object) -> float:
    """Return a time of day in seconds since midnight; raise `ValueError` for any other text.

    "24:00" is the end of the day.
    """
    found = re.fullmatch(r"(\d{1,2}):(\d{2})(?::(\d{2}))?", text) if isinstance(text, str) else None
    if found is not None:
        hours, minutes, rest = (int(part or 0) for part in found.groups())
        total = hours * 3600.0 + minutes * 60 + rest
        if minutes < 60 and rest < 60 and total <= 86_400:
            return total
    raise ValueError(f'{text!r} is no time of day, such as "07:30"')
