# SPDX-License-Identifier: GPL-3.0-or-later
"""Judges what sensors told of days by what people did."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ...residents.days.rows import DayRows
from ..kinds import KINDS
from ..log import format_value

DAY_S = 86_400.0
# Fields of other quantities than these tell nothing of people by being on.
TELLING = ("motion", "opening", "occupancy", "proximity")
Span = tuple[float, float]


class CausedEvent(NamedTuple):
    """A row of events.csv; `time_s` since the first row's midnight."""

    time_s: float
    sensor: str
    kind: str
    field: str
    value: str
    person: str
    because: str


class Activity(NamedTuple):
    """A row of activities.csv; in seconds since that midnight."""

    start_s: float
    end_s: float
    person: str
    activity: str
    room: str


class Where(NamedTuple):
    """A row of people.csv: from then on the person is in the room (empty: away), until the next."""

    time_s: float
    person: str
    room: str
    posture: str


@dataclass(frozen=True)
class Truth:
    """What a user's own function gets as `truth`: what people did, and where they were."""

    activities: tuple[Activity, ...]
    people: tuple[Where, ...]


@dataclass(frozen=True)
class Lived:
    """What a user's own function gets as `recording` of days, and the truth beside it; it ended
    `days` whole days after its first midnight."""

    events: tuple[CausedEvent, ...]
    truth: Truth
    days: int


def lived(rows: DayRows, days: int) -> Lived:
    """What these rows of `days` whole days tell, to the milliseconds that their tables have."""
    told = (
        CausedEvent(
            _seconds(e.time), e.sensor, e.kind, e.field, format_value(e.value), e.person, e.because
        )
        for e in rows.events
    )
    done = (
        Activity(_seconds(row.start), _seconds(row.end), row.person, row.activity, row.room)
        for row in rows.activities
    )
    where = (Where(_seconds(row.time), row.person, row.room, row.posture) for row in rows.people)
    return Lived(tuple(told), Truth(tuple(done), tuple(where)), days)


def _seconds(time: int) -> float:
    """Of µs: whole ms."""
    return time // 1000 / 1000


def judged(lived: Lived, rooms: Mapping[str, str], empty_for: float) -> dict[str, float | None]:
    """How well the sensors, whose rooms these are, tell what people did:

    `noticed`: the share of activities (those away from home apart) during which some sensor of
    their room is on; `missed_per_day`: the others; `delay_s`: from an activity's start to the first
    of them, on average over those noticed; `false_alarms_per_day`: times that a sensor goes on
    while nobody is in its room from `empty_for` seconds before until as long after. None: there is
    nothing to tell of.
    """
    end = lived.days * DAY_S
    on = when_on(lived)
    by_room: dict[str, list[Span]] = {}
    for sensor, spans in on.items():
        by_room.setdefault(rooms.get(sensor, ""), []).extend(spans)
    merged = {room: _merged(spans) for room, spans in by_room.items()}
    at_home = [activity for activity in lived.truth.activities if activity.room]
    delays = [
        delay
        for activity in at_home
        if (delay := _delay(merged.get(activity.room, []), activity)) is not None
    ]
    there = _occupied(lived.truth.people, end)
    false = sum(
        not _overlaps(there.get(rooms.get(sensor, ""), []), start - empty_for, start + empty_for)
        for sensor, spans in on.items()
        for start, _ in spans
        if start > 0.0
    )
    return {
        "noticed": len(delays) / len(at_home) if at_home else None,
        "missed_per_day": (len(at_home) - len(delays)) / lived.days,
        "delay_s": sum(delays) / len(delays) if delays else None,
        "false_alarms_per_day": false / lived.days,
        "activities_per_day": len(at_home) / lived.days,
    }


def when_on(lived: Lived) -> dict[str, list[Span]]:
    """When each sensor was on (s), by any of its telling fields."""
    since: dict[tuple[str, str], float] = {}
    found: dict[str, list[Span]] = {}
    for event in lived.events:
        if not _tells(event.kind, event.field):
            continue
        key = event.sensor, event.field
        if event.value == "1":
            since.setdefault(key, event.time_s)
        elif key in since:
            found.setdefault(event.sensor, []).append((since.pop(key), event.time_s))
    for (sensor, _), start in since.items():
        found.setdefault(sensor, []).append((start, lived.days * DAY_S))
    return {sensor: _merged(spans) for sensor, spans in found.items()}


def _tells(kind: str, field: str) -> bool:
    return any(
        f.name == field and f.type is bool and f.quantity in TELLING for f in KINDS[kind].events
    )


def _occupied(people: Iterable[Where], end: float) -> dict[str, list[Span]]:
    """When somebody was in each room."""
    last: dict[str, Where] = {}
    found: dict[str, list[Span]] = {}
    for where in people:
        before = last.get(where.person)
        if before is not None:
            found.setdefault(before.room, []).append((before.time_s, where.time_s))
        last[where.person] = where
    for where in last.values():
        found.setdefault(where.room, []).append((where.time_s, end))
    found.pop("", None)
    return {room: _merged(spans) for room, spans in found.items()}


def _merged(spans: Iterable[Span]) -> list[Span]:
    """In order, those that meet as one."""
    found: list[Span] = []
    for start, end in sorted(spans):
        if found and start <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end))
        else:
            found.append((start, end))
    return found


def _delay(spans: list[Span], activity: Activity) -> float | None:
    """From its start until a sensor is on; None: none is before its end."""
    at = bisect_right(spans, activity.start_s, key=lambda span: span[1])
    if at == len(spans) or spans[at][0] >= activity.end_s:
        return None
    return max(spans[at][0] - activity.start_s, 0.0)


def _overlaps(spans: list[Span], start: float, end: float) -> bool:
    at = bisect_left(spans, start, key=lambda span: span[1])
    return at < len(spans) and spans[at][0] <= end
