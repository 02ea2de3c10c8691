# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of a day's tables, the tables of several days, and the frames of a day."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date, datetime, time, timedelta
from operator import attrgetter
from typing import Any

from ...sensor_logic.clock import Clock
from ...sensor_logic.logs.formats.log import Log, LoggedActivity, SensorFacts
from ...sensor_logic.logs.formats.source import ACTIVITY_HEADER, DAY_HEADER, make_log
from ...sensor_logic.logs.log import Event, Value, format_value, rows_of, to_csv
from ...sensor_logic.model import Array
from ...sensor_logic.recording.validity import NotValid
from ..routine.timetable import day_number
from .truth import DAY_S, US, Whereabouts, join_activities

EVENTS = "events.csv"
PEOPLE_HEADER = ("time", "person", "room", "x_m", "y_m", "z_m", "posture")
DAY_US = round(DAY_S) * US
_cells = attrgetter(*DAY_HEADER)


@dataclass(frozen=True)
class Day:
    """A simulated day: its events, and what people did, in µs since midnight.

    Events are in the order of the event log. The first event of each field has its value at
    midnight, and no cause. `not_valid` says how often each sensor was not valid.
    """

    date: date
    events: tuple[Event[int], ...]
    activities: tuple[LoggedActivity, ...]
    people: tuple[Whereabouts, ...]
    not_valid: tuple[NotValid, ...] = ()

    def as_json(self, digest: str) -> str:
        """Return the day as JSON text; `digest` is a hash that identifies its run."""
        activities = [(a.start, a.end, a.person, a.activity, a.room) for a in self.activities]
        found = {
            "run": digest,
            "date": self.date.isoformat(),
            "events": [_cells(event) for event in self.events],
            "activities": activities,
            "people": self.people,
            "not_valid": self.not_valid,
        }
        return json.dumps(found, ensure_ascii=False, separators=(",", ":")) + "\n"

    @classmethod
    def of_json(cls, text: str, digest: str) -> Day | None:
        """Read a day from JSON text; return None if its digest differs from `digest`.

        Raises `ValueError` if the text does not describe a day.
        """
        try:
            found = json.loads(text)
            if found["run"] != digest:
                return None
            people = [
                Whereabouts(t, person, room, None if at is None else tuple(at), posture)
                for t, person, room, at, posture in found["people"]
            ]
            return cls(
                date.fromisoformat(found["date"]),
                tuple(_event(row) for row in found["events"]),
                tuple(LoggedActivity(*row) for row in found["activities"]),
                tuple(people),
                tuple(NotValid(*row) for row in found.get("not_valid", [])),
            )
        except (KeyError, TypeError) as error:
            raise ValueError(str(error)) from None


def _event(cells: Iterable[Any]) -> Event[int]:
    return Event(frame=0.0, **dict(zip(DAY_HEADER, cells, strict=True)))


def attribute_events(events: Iterable[Event[int]]) -> tuple[Event[int], ...]:
    """Return the events of a day in the log's order, each with the person who caused it.

    On input, an event's `person` is the person who then moves the object that caused the event. If
    nobody does, look at the sensor's last event with a cause. Its person is taken if the event has
    the same cause, or none.
    """
    # By sensor, the cause and the person of the last event that has a cause.
    last: dict[str, tuple[str, str]] = {}
    found = []
    for event in sorted(events, key=lambda event: (event.time, event.sensor, event.field)):
        before, person = last.get(event.sensor, ("", ""))
        if event.because:
            if event.person or event.because != before:
                person = event.person
            last[event.sensor] = event.because, person
        found.append(replace(event, person=person))
    return tuple(found)


@dataclass(frozen=True)
class DayRows:
    """The rows of consecutive days, in µs since midnight of the date `start`."""

    start: date
    events: tuple[Event[int], ...]
    activities: tuple[LoggedActivity, ...]
    people: tuple[Whereabouts, ...]

    @classmethod
    def joined(cls, days: Sequence[Day]) -> DayRows:
        """Join days; a value that does not change at midnight has no row at that time."""
        return cls(
            days[0].date,
            tuple(_events(days)),
            tuple(join_activities(day.activities for day in days)),
            tuple(_people(days)),
        )

    def files(self) -> dict[str, str]:
        """Return the text of each table, by file name."""
        begin = datetime.combine(self.start, time())
        activities = (
            (_local_time(begin, a.start), _local_time(begin, a.end), a.person, a.activity, a.room)
            for a in self.activities
        )
        people = (
            (_local_time(begin, w.time), w.person, w.room, *_point(w.at), w.posture)
            for w in self.people
        )
        return {
            EVENTS: to_csv(DAY_HEADER, _event_rows(self.start, self.events)),
            "activities.csv": to_csv(ACTIVITY_HEADER, activities),
            "people.csv": to_csv(PEOPLE_HEADER, people),
        }

    def log(
        self,
        sensors: Mapping[str, SensorFacts],
        about: Mapping[str, str],
        labels: Mapping[str, str],
    ) -> Log:
        """Return the log of these days for the file formats of other tools.

        `labels` has the other tool's name of each activity.
        """
        events = (event.at(event.time / US) for event in self.events)
        activities = [
            LoggedActivity(a.start, a.end, a.person, labels.get(a.activity, a.activity), a.room)
            for a in self.activities
        ]
        begin = datetime.combine(self.start, time())
        return make_log(events, sensors, begin, activities, about)


class GrowingEvents:
    """The text of `events.csv`, made a day at a time. It is the text of `DayRows.files`."""

    def __init__(self) -> None:
        self.days = 0
        self._start: date | None = None
        self._last: dict[tuple[str, str], Value] = {}

    def text_of(self, day: Day) -> str:
        """Return the rows of the next day, for the first one with the header."""
        self._start = self._start or day.date
        rows = _event_rows(self._start, _new_events(day, self.days, self._last))
        self.days += 1
        return to_csv(DAY_HEADER, rows) if self.days == 1 else rows_of(rows)


def _event_rows(start: date, events: Iterable[Event[int]]) -> Iterator[Iterable[str]]:
    """Yield the rows of `events.csv`, for events in µs since midnight of the date `start`."""
    begin = datetime.combine(start, time())
    return ((_local_time(begin, e.time), *map(format_value, _cells(e)[1:])) for e in events)


def _events(days: Sequence[Day]) -> Iterator[Event[int]]:
    """Yield the events of all days; those at midnight only if the value has changed."""
    last: dict[tuple[str, str], Value] = {}
    for number, day in enumerate(days):
        yield from _new_events(day, number, last)


def _new_events(day: Day, number: int, last: dict[tuple[str, str], Value]) -> Iterator[Event[int]]:
    """Yield the events of day `number`; those at midnight only if the value has changed.

    `last` has the value of each sensor's field before the day, and is brought up to date.
    """
    for event in day.events:
        key = event.sensor, event.field
        if event.time == 0 and last.get(key) == event.value:
            continue
        last[key] = event.value
        yield event.at(event.time + number * DAY_US)


def _people(days: Sequence[Day]) -> Iterator[Whereabouts]:
    """Yield where people are on all days; rows at midnight only if they have changed."""
    last: dict[str, Whereabouts] = {}
    for number, day in enumerate(days):
        for where in day.people:
            before = last.get(where.person)
            last[where.person] = where
            if where.time or before is None or where[2:] != before[2:]:
                yield where._replace(time=where.time + number * DAY_US)


def _local_time(begin: datetime, us: int) -> str:
    return (begin + timedelta(microseconds=us)).isoformat(timespec="milliseconds")


def _point(at: tuple[float, float, float] | None) -> Iterable[str]:
    return ("", "", "") if at is None else (f"{x + 0.0:.3f}" for x in at)


def toml(values: Mapping[str, Any], tables: Iterable[Mapping[str, Any]] = ()) -> str:
    """Return the text of a TOML file with `values`; mappings among them become tables.

    `tables` become the array of tables named `sensors`.
    """
    plain = {key: value for key, value in values.items() if not isinstance(value, Mapping)}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in plain.items()]
    for key, value in values.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{_key(key)}]"]
            lines += [f"{_key(name)} = {_value(inner)}" for name, inner in value.items()]
    for table in tables:
        lines += ["", "[[sensors]]"]
        lines += [
            f"{_key(key)} = {_value(value)}" for key, value in table.items() if value is not None
        ]
    return "\n".join(lines) + "\n"


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("_", "a").replace("-", "a").isalnum()
    return name if bare else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        inner = ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items() if v is not None)
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, (bool, int)):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value)
    # TOML's strings are JSON's, apart from one control character.
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")


# The frames and clock of a day: 10 frames a second, midnight at frame 1.

FPS = 10
# A day's run begins this long before midnight, so that detectors have settled by then, s.
LEAD_S = 120.0
# Noise repeats after this many days, because larger times in s lose digits.
CYCLE = 1 << 13
HOUR_S = 3600.0
# The shortest rest in which a day is cut, s.
REST = 2.0


def frame_at(time: float) -> int:
    """Return the first whole frame at or after a time, which is in s since midnight."""
    return 1 + math.ceil(time * FPS - 1e-6)


def time_at(frame: float) -> float:
    """Return the time of a frame, in s since midnight."""
    return (frame - 1) / FPS


def hours_minutes(time: float) -> str:
    """Return a time in s since midnight as text, such as 07:05."""
    return f"{int(time // 3600):02d}:{int(time // 60 % 60):02d}"


def lasting(seconds: float) -> str:
    """Return a duration as text in hours and minutes, such as 1 h 05 min."""
    minutes = round(seconds / 60)
    if minutes < 1:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def calendar_number(first: date) -> int:
    """Return the number on which the noise of a date depends: its day number modulo `CYCLE`.

    So a date has the same noise in each run.
    """
    return day_number(first) % CYCLE


def clock_of_day(number: int) -> Clock:
    """Return the clock of day `number`, in frames of that day.

    Sensor updates have the same numbers and times as in one long run. That run begins `LEAD_S`
    before the midnight of day 0.
    """
    return Clock(frame_at(-LEAD_S) - round(number * DAY_S) * FPS, FPS)


def stretches(spans: Array, first: float, last: float, most: float) -> list[float]:
    """Return times at which to cut a day into shorter parts, in s.

    Where possible, cuts are in the middle of times without movement.

    Parameters
    ----------
    spans : array, shape (k, 2)
        The start and end of each movement, s, sorted.
    first, last : float
        Start and end of the day, s.
    most : float
        The longest time with movement in a part, s.
    """
    cuts: list[float] = []
    moved = 0.0
    # The last rest, and the time with movement before it.
    rest: tuple[float, float] | None = None
    for number, (start, end) in enumerate(spans.tolist()):
        while moved + end - start > most:
            if rest is not None:
                cuts.append(rest[0])
                moved, rest = moved - rest[1], None
                continue
            # Without a rest, cut during the movement.
            start += most - moved
            cuts.append(start)
            moved = 0.0
        moved += end - start
        until = spans[number + 1, 0] if number + 1 < len(spans) else last
        if until - end > REST:
            rest = (end + until) / 2, moved
    return [cut for cut in cuts if first < cut < last]
