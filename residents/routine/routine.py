# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a routine, and the reading of durations and times of day.

All durations and times are in seconds.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
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
# The spread of a log-normal duration: the standard deviations of its logarithm below and above the
# median.
Spread = tuple[float, float]
# Parts of an activity in which steps can be done, by their names.
SHARES = {
    "first half": (0.0, 1 / 2),
    "second half": (1 / 2, 1.0),
    "first third": (0.0, 1 / 3),
    "second third": (1 / 3, 2 / 3),
    "last third": (2 / 3, 1.0),
    "first quarter": (0.0, 1 / 4),
    "last quarter": (3 / 4, 1.0),
    "whole": (0.0, 1.0),
}
# When the day begins in which activities are counted, s since midnight: as in surveys of time use.
NEW_DAY = 4 * 3600.0


@dataclass(frozen=True)
class Meanwhile:
    """Small movements that are repeated at random times during an activity.

    Attributes
    ----------
    do : tuple of str
        The movements, such as "shift"; each time, one of them is drawn at random.
    every : float
        The mean time from one movement to the next, s.
    varies : float
        The standard deviation of the logarithm of the rests between movements.
    burst : float or None
        The mean number of movements in a row; None for the default.
    where : tuple of str
        The position of each movement in the file.
    """

    do: tuple[str, ...]
    every: float
    varies: float
    burst: float | None = None
    where: tuple[str, ...] = ()


@dataclass(frozen=True)
class UsualUse:
    """How long each use of a place, or of what a leaf shuts, lasts.

    Attributes
    ----------
    lasts : float or None
        The median of a step that does not say its duration, s; None for the default.
    varies : Spread or None
        The spread of the log-normally distributed durations; None for the default.
    where : str
        The position in the file.
    """

    lasts: float | None
    varies: Spread | None
    where: str


@dataclass(frozen=True)
class StepGroup:
    """Steps of an activity that are not the same each time.

    Attributes
    ----------
    do : tuple
        The steps, in order: texts such as "sit Sofa", or further groups. If `weights` is not empty,
        they are alternatives, of which one is drawn.
    where : tuple of str
        The position of each step in the file.
    weights : tuple of float
        The weight of each alternative; empty for steps that are all done.
    daily : bool
        Whether an alternative is drawn once a day, from `NEW_DAY` to `NEW_DAY`, rather than each
        time.
    chance : float
        The probability that the steps are done.
    times : tuple of int
        The least and the largest number of repetitions.
    any_order : bool
        Whether the order of the steps is drawn each time.
    varies : Spread or None
        The spread of the durations of the steps; None for the default.
    share : tuple of float or None
        The part of the activity, of 0 … 1, in which the steps are done at a random time; None for
        steps that follow the step before.
    """

    do: tuple[str | StepGroup, ...]
    where: tuple[str, ...]
    weights: tuple[float, ...] = ()
    daily: bool = True
    chance: float = 1.0
    times: tuple[int, int] = (1, 1)
    any_order: bool = False
    varies: Spread | None = None
    share: tuple[float, float] | None = None


@dataclass(frozen=True)
class RoutineActivity:
    """An activity of a routine.

    Attributes
    ----------
    name : str
        The activity's name.
    do : tuple
        Its steps, in order: texts such as "sit Sofa", or groups of steps.
    meanwhile : tuple of Meanwhile
        The small movements that are repeated during its last step.
    labels : mapping of str to str
        Its name in each of several public data sets.
    where : tuple of str
        The position of each step in the file.
    usual_rest : bool
        Whether somebody who sits or lies then moves as people do who rest, rather than only as
        `meanwhile` says.
    """

    name: str
    do: tuple[str | StepGroup, ...]
    meanwhile: tuple[Meanwhile, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    where: tuple[str, ...] = ()
    usual_rest: bool = True


@dataclass(frozen=True)
class Calendar:
    """The days to which a plan or filler applies.

    They are on the given weekdays (0 is Monday), in the given months, from `first` to `last`
    inclusive.
    """

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
    """An entry of a plan: an activity at a fixed time of day.

    Attributes
    ----------
    activity : str
        The activity's name.
    at : float
        The mean of the normally distributed start, s.
    spread : tuple of float
        The standard deviations of the start and of the end that `until` gives, s.
    lasts : float or None
        The median of the log-normally distributed duration, s. None if `until` is given.
    until : float or None
        The mean end, s since midnight; more than 24 h is on the next day.
    varies : Spread
        The spread of the duration.
    chance : float
        The probability that the entry happens on a day.
    where : str
        The entry's position in the file.
    either : str
        The name of the alternatives to which the entry belongs, or "".
    share : tuple of float
        The entry of some alternatives happens if a number that is drawn for them once a day is from
        the first to below the second.
    """

    activity: str
    at: float
    spread: tuple[float, float]
    lasts: float | None
    until: float | None
    varies: Spread
    chance: float
    where: str
    either: str = ""
    share: tuple[float, float] = (0.0, 1.0)


@dataclass(frozen=True)
class FixedPoints:
    """A plan: what a person does at fixed times of day, on the days of a calendar."""

    person: str
    days: Calendar
    entries: tuple[FixedPoint, ...]


@dataclass(frozen=True)
class Pastime:
    """One of the activities from which a filler draws at random.

    The probability is proportional to the weight.

    Attributes
    ----------
    weight : float
        The weight after any activity that `after` does not name.
    lasts : float or None
        The median of the log-normally distributed duration, s. None if `until` is given.
    varies : Spread
        The spread of the duration.
    until, spread : float
        Mean and standard deviation of the end, s since midnight; `until` is None if `lasts` is
        given.
    after : mapping of str to float
        The weight after each of some activities, by their names.
    usual : tuple of float
        How many times a day it has usually begun when the filler begins, and when it ends. A day
        is from `NEW_DAY` to `NEW_DAY`.
    regular : float
        The share by which the weight grows for each time that it has begun less often than usual,
        and shrinks for each time more.
    """

    activity: str
    weight: float
    lasts: float | None
    varies: Spread
    until: float | None = None
    spread: float = 0.0
    after: Mapping[str, float] = field(default_factory=dict)
    usual: tuple[float, float] = (0.0, 0.0)
    regular: float = 0.0

    @property
    def goes_on(self) -> bool:
        """Whether it goes on over midnight, where other choices begin a date by itself."""
        return bool(self.after) or self.until is not None

    def weight_now(self, last: str, times: int, part: float) -> float:
        """Return the weight at a time.

        Parameters
        ----------
        last : str
            The activity before.
        times : int
            How many times this activity has begun on the day.
        part : float
            The part of the filler that is over.
        """
        before, later = self.usual
        missing = before + part * (later - before) - times
        return self.after.get(last, self.weight) * max(1.0 + self.regular * missing, 0.0)


@dataclass(frozen=True)
class Filler:
    """What a person does between two times of day while no plan has an activity.

    Activities are drawn from `choices`, one after another.
    """

    person: str
    days: Calendar
    begins: float
    ends: float
    choices: tuple[Pastime, ...]


@dataclass(frozen=True)
class Interruption:
    """An activity that interrupts another one, `during`, at random times.

    `times` is the mean number of interruptions each time that `during` is done. The duration is
    log-normal, with the median `lasts` (s) and the spread `varies`.
    """

    person: str
    during: str
    activity: str
    times: float
    lasts: float
    varies: Spread


@dataclass(frozen=True)
class Absence:
    """A span of time in which a person is away."""

    person: str
    begins: datetime
    ends: datetime


@dataclass(frozen=True)
class Person:
    """A person of the routine.

    Attributes
    ----------
    name : str
        The person's name.
    resident : str
        The name of the resident's object in the home.
    visitor : bool
        Whether the person is away except for planned activities.
    begins : str
        The activity under way at the first midnight.
    where : str
        The person's position in the file.
    """

    name: str
    resident: str
    visitor: bool
    begins: str
    where: str = ""


@dataclass(frozen=True)
class Routine:
    """All persons, activities and rules of a routine; `uses` by the names of places and leaves."""

    persons: Mapping[str, Person]
    activities: Mapping[str, RoutineActivity]
    plans: tuple[FixedPoints, ...]
    fillers: tuple[Filler, ...]
    interruptions: tuple[Interruption, ...]
    absences: tuple[Absence, ...]
    uses: Mapping[str, UsualUse] = field(default_factory=dict)

    def done(self) -> Iterator[tuple[str, str]]:
        """Yield each person with each activity that the person may do, by their names."""
        for person in self.persons.values():
            yield person.name, person.begins
        for plan in self.plans:
            yield from ((plan.person, entry.activity) for entry in plan.entries)
        for filler in self.fillers:
            yield from ((filler.person, choice.activity) for choice in filler.choices)
        for rule in self.interruptions:
            yield rule.person, rule.activity


@dataclass(frozen=True)
class Segment:
    """What a person does from `start` to `end`, in s since midnight of the first day.

    `where` is the segment's position in a diary, or "" without a diary.
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
    """Return the duration that a text such as "20 s" gives, s.

    Raise `ValueError` for any other text.
    """
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
        raise ValueError(f'{shown!r} is not a duration, such as "20 s", "25 min" or "1 h 30 min"')
    return total


def time_of_day(text: object) -> float:
    """Return the time of day that a text such as "07:05" gives, s since midnight.

    "24:00" is the end of the day. Raise `ValueError` for any other text.
    """
    found = re.fullmatch(r"(\d{1,2}):(\d{2})(?::(\d{2}))?", text) if isinstance(text, str) else None
    if found is not None:
        hours, minutes, rest = (int(part or 0) for part in found.groups())
        total = hours * 3600.0 + minutes * 60 + rest
        if minutes < 60 and rest < 60 and total <= 86_400:
            return total
    raise ValueError(f'{text!r} is not a time of day, such as "07:30"')
