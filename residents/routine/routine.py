# SPDX-License-Identifier: GPL-3.0-or-later
"""A routine as it was read and checked, and its durations and times of day as people write them;
here they are in seconds."""

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
# What a person who is not at home does.
AWAY = "Away"


@dataclass(frozen=True)
class Meanwhile:
    """A movement that is repeated while an activity lasts, one of those in `do` each time: one in
    about `every` so many seconds. They come in bursts of `burst` on average (None: as many as is
    usual for such movements) with rests between, whose length has a log-normal spread of `varies`.
    `where` each stands in the file."""

    do: tuple[str, ...]
    every: float
    varies: float
    burst: float | None = None
    where: tuple[str, ...] = ()


@dataclass(frozen=True)
class RoutineActivity:
    """Steps in order, what is repeated while the last of them lasts, and what other data sets call
    the activity. `where` each step stands in the file."""

    name: str
    do: tuple[str, ...]
    meanwhile: tuple[Meanwhile, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    where: tuple[str, ...] = ()


@dataclass(frozen=True)
class Calendar:
    """On which days something holds: weekdays (0 is Monday), months, and dates, both included."""

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
    """A fixed point of a person's day: `at` a time of day, normally distributed with the standard
    deviation `spread`; it `lasts` a log-normal time of that median, or `until` a time of day (past
    midnight: above 24 h). `where` it stands in the file."""

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
    person: str
    days: Calendar
    entries: tuple[FixedPoint, ...]


@dataclass(frozen=True)
class Pastime:
    """What fills time: its weight beside the others, and how long it lasts (median, log-normal)."""

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
    """What comes in between: `times` on average in each stretch of the activity `during`."""

    person: str
    during: str
    activity: str
    times: float
    lasts: float
    varies: float


@dataclass(frozen=True)
class Absence:
    person: str
    begins: datetime
    ends: datetime


@dataclass(frozen=True)
class Person:
    """Somebody who lives in the home or, a `visitor`, is away but for what is planned. `resident`
    is the object in the home, and `where` that stands in the file; `begins`, the activity at the
    first midnight."""

    name: str
    resident: str
    visitor: bool
    begins: str
    where: str = ""


@dataclass(frozen=True)
class Routine:
    persons: Mapping[str, Person]
    activities: Mapping[str, RoutineActivity]
    plans: tuple[FixedPoints, ...]
    fillers: tuple[Filler, ...]
    interruptions: tuple[Interruption, ...]
    absences: tuple[Absence, ...]


@dataclass(frozen=True)
class Segment:
    """What a person does from `start` to `end`, seconds since midnight of the first day; `where`
    a diary says so."""

    start: float
    end: float
    person: str
    activity: str
    where: str = field(default="", compare=False)


# Durations ("1 h 30 min") and times of day ("07:30") as people write them.

_UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_PART = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(s|min|h)\s*")


def seconds(text: object) -> float:
    """A duration in seconds. Raises ValueError, whose text says what would be one."""
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
    """Seconds since midnight; "24:00" is the end of the day. Raises ValueError."""
    found = re.fullmatch(r"(\d{1,2}):(\d{2})(?::(\d{2}))?", text) if isinstance(text, str) else None
    if found is not None:
        hours, minutes, rest = (int(part or 0) for part in found.groups())
        total = hours * 3600.0 + minutes * 60 + rest
        if minutes < 60 and rest < 60 and total <= 86_400:
            return total
    raise ValueError(f'{text!r} is no time of day, such as "07:30"')
