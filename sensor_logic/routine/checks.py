# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds plans that ask for two things at once, and bodies that are asked for twice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..error import InputError
from .routine import DAY, FixedPoint, FixedPoints, Person, Routine


def check_bodies(persons: Mapping[str, Person]) -> None:
    """Raises InputError where two persons have the same body."""
    bodies: dict[str, str] = {}
    for person in persons.values():
        other = bodies.setdefault(person.resident, person.name)
        if other != person.name:
            raise InputError(
                f"{person.where}: {person.resident!r} is the body of {other!r} already; "
                f"give {person.name!r} another resident"
            )


def check(routine: Routine, name: str) -> None:
    """Raises InputError where a person is to be in two activities at the same time of the same
    day, or where a day's plan takes longer than the day. Entries that only may happen do not count:
    where they do, what comes later waits."""
    for person in routine.persons:
        plans = [plan for plan in routine.plans if plan.person == person]
        for today, tomorrow in _days_together(plans):
            entries = sorted(today, key=lambda entry: entry.at)
            after = [(entry, entry.at) for entry in entries]
            after += [(entry, entry.at + DAY) for entry in tomorrow]
            for place, entry in enumerate(entries):
                for other, at in after[place + 1 :]:
                    if at < _end(entry):
                        raise InputError(_twice(person, entry, other, at))


def _days_together(plans: list[FixedPoints]) -> Iterator[tuple[list[FixedPoint], list[FixedPoint]]]:
    """What is certain on each sort of day, and on the one after it."""
    for month in range(1, 13):
        for weekday in range(7):
            yield _certain(plans, weekday, month), _certain(plans, (weekday + 1) % 7, month)


def _certain(plans: list[FixedPoints], weekday: int, month: int) -> list[FixedPoint]:
    # Plans for some dates only may take turns: those are not compared with others.
    always = [plan for plan in plans if plan.days.first.year == 1 and plan.days.last.year == 9999]
    return [
        entry
        for plan in always
        if weekday in plan.days.weekdays and month in plan.days.months
        for entry in plan.entries
        if entry.chance == 1.0
    ]


def _end(entry: FixedPoint) -> float:
    if entry.until is not None:
        return entry.until
    return entry.at + (entry.lasts or 0.0)


def _clock(seconds: float) -> str:
    minutes = round(seconds % DAY / 60)
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def _twice(person: str, entry: FixedPoint, other: FixedPoint, at: float) -> str:
    lasting = f"{entry.activity!r} from {_clock(entry.at)} lasts until {_clock(_end(entry))}"
    if _end(entry) - entry.at > DAY:
        lasting = f"{entry.activity!r} lasts {(_end(entry) - entry.at) / 3600:.0f} hours"
    what = f"{other.activity!r}" if other is not entry else "it"
    return (
        f"{other.where}: {person!r} cannot do two things at once: {lasting}, "
        f"and {what} begins {'again ' if other is entry else ''}at {_clock(at)}"
    )
