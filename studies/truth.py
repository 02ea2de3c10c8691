# SPDX-License-Identifier: GPL-3.0-or-later
"""Judges what sensors reported of days by what people did."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import pandas

from ..residents.days.rows import DayRows
from ..residents.days.truth import DAY_S
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.log import format_value

# Fields of other quantities than these do not show people by being on.
TELLING = ("motion", "opening", "occupancy", "proximity")


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
    """What these rows of `days` whole days say, to the milliseconds that their tables have."""
    events = (
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
    return Lived(tuple(events), Truth(tuple(done), tuple(where)), days)


def _seconds(time: int) -> float:
    """Whole milliseconds of µs."""
    return time // 1000 / 1000


def judged(lived: Lived, rooms: Mapping[str, str], empty_for: float) -> dict[str, float | None]:
    """How well the sensors, whose `rooms` these are, show what people did.

    `noticed`: the share of activities (those away from home apart) during which some sensor of
    their room is on; `missed_per_day`: the others; `delay_s`: from an activity's start to the first
    of them, on average over those noticed; `false_alarms_per_day`: times that a sensor goes on
    while nobody is in its room from `empty_for` seconds before until as long after. None: there is
    nothing to measure.
    """
    on = when_on(lived)
    room = on["by"].map(lambda sensor: rooms.get(sensor, ""))
    begins = on["start"] > 0.0
    start = on["start"][begins]
    alarms = _windows(room[begins], start - empty_for, start + empty_for)
    right = _next_span(alarms, _occupied(lived), touching=True)
    at_home = [activity for activity in lived.truth.activities if activity.room]
    done = pandas.DataFrame(at_home, columns=Activity._fields)
    activities = _windows(done["room"], done["start_s"], done["end_s"])
    sensed = _next_span(activities, _merged(room, on["start"], on["end"]), touching=False)
    delays = (sensed["start"] - sensed["since"]).clip(lower=0.0)
    return {
        "noticed": len(delays) / len(done) if at_home else None,
        "missed_per_day": (len(done) - len(delays)) / lived.days,
        "delay_s": float(delays.mean()) if len(delays) else None,
        "false_alarms_per_day": (len(alarms) - len(right)) / lived.days,
        "activities_per_day": len(done) / lived.days,
    }


def when_on(lived: Lived) -> pandas.DataFrame:
    """When each sensor was on (s), by any of its telling fields: `by` (its name), `start`, `end`,
    where those of a sensor do not meet."""
    telling = {
        (kind.identifier, field.name)
        for kind in KINDS.values()
        for field in kind.events
        if field.type is bool and field.quantity in TELLING
    }
    rows = [event for event in lived.events if (event.kind, event.field) in telling]
    table = pandas.DataFrame(rows, columns=CausedEvent._fields)
    table["on"] = table["value"] == "1"
    # A sensor is off before its first row.
    before = table.groupby(["sensor", "field"])["on"].shift(fill_value=False)
    changes = table[table["on"] != before]
    ends = changes.groupby(["sensor", "field"])["time_s"].shift(-1).fillna(lived.days * DAY_S)
    begins = changes["on"]
    return _merged(changes["sensor"][begins], changes["time_s"][begins], ends[begins])


def _occupied(lived: Lived) -> pandas.DataFrame:
    """When somebody was in each room, as `when_on`."""
    table = pandas.DataFrame(list(lived.truth.people), columns=Where._fields)
    ends = table.groupby("person")["time_s"].shift(-1).fillna(lived.days * DAY_S)
    at_home = table["room"] != ""
    return _merged(table["room"][at_home], table["time_s"][at_home], ends[at_home])


def _merged(by: Iterable[str], start: Iterable[float], end: Iterable[float]) -> pandas.DataFrame:
    """The spans in order, those of one `by` that meet as one."""
    spans = _typed(by=by, start=start, end=end).sort_values(["by", "start", "end"])
    ended = spans.groupby("by")["end"].cummax().groupby(spans["by"]).shift(fill_value=-math.inf)
    number = (spans["start"] > ended).cumsum()
    return spans.groupby(number).agg(by=("by", "first"), start=("start", "min"), end=("end", "max"))


def _windows(by: Iterable[str], since: Iterable[float], until: Iterable[float]) -> pandas.DataFrame:
    return _typed(by=by, since=since, until=until).sort_values("since")


def _typed(by: Iterable[str], **seconds: Iterable[float]) -> pandas.DataFrame:
    """A table whose columns have the same types with rows and without."""
    times = {name: pandas.Series(list(column), dtype=float) for name, column in seconds.items()}
    return pandas.DataFrame({"by": pandas.Series(list(by), dtype=object), **times})


def _next_span(
    windows: pandas.DataFrame, spans: pandas.DataFrame, touching: bool
) -> pandas.DataFrame:
    """The windows that a span of the same `by` overlaps, each with the first such span; `touching`:
    whether it is enough that they meet."""
    found = pandas.merge_asof(
        windows,
        spans.sort_values("end"),
        left_on="since",
        right_on="end",
        by="by",
        direction="forward",
        allow_exact_matches=touching,
    )
    meets = found["start"] <= found["until"] if touching else found["start"] < found["until"]
    return found[meets]
