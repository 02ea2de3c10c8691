# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare what sensors report on simulated days with what residents did."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import pandas

from ..residents.days.rows import DayRows
from ..residents.days.truth import DAY_S
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.log import format_value

# Quantities of the fields that show people by being on.
PRESENCE_QUANTITIES = ("motion", "opening", "occupancy", "proximity")


class CausedEvent(NamedTuple):
    """An event of a sensor, with the person and the object that caused it: a row of events.csv.

    `time_s` is the time since the first midnight, `because` the object.
    """

    time_s: float
    sensor: str
    kind: str
    field: str
    value: str
    person: str
    because: str


class Activity(NamedTuple):
    """A row of activities.csv: what a person did in a room, from `start_s` to `end_s`.

    The times are in seconds since the first midnight.
    """

    start_s: float
    end_s: float
    person: str
    activity: str
    room: str


class Where(NamedTuple):
    """A row of people.csv: the room and posture of a person from the time `time_s` on.

    The room is "" while the person is away.
    """

    time_s: float
    person: str
    room: str
    posture: str


@dataclass(frozen=True)
class Truth:
    """What people did, and where they were: the argument `truth` of a user's own function."""

    activities: tuple[Activity, ...]
    people: tuple[Where, ...]


@dataclass(frozen=True)
class StudyDays:
    """The sensor events of `days` whole days, and what people did on them.

    For runs with a routine, it is the argument `recording` of a user's own function.
    """

    events: tuple[CausedEvent, ...]
    truth: Truth
    days: int


def days_from_rows(rows: DayRows, days: int) -> StudyDays:
    """Return the sensor events of `days` whole days, and what people did on them.

    Times are cut to milliseconds, as in the CSV files.
    """
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
    return StudyDays(tuple(events), Truth(tuple(done), tuple(where)), days)


def _seconds(time: int) -> float:
    """Return a time in µs as seconds, cut to whole milliseconds."""
    return time // 1000 / 1000


def scores(
    recording: StudyDays, rooms: Mapping[str, str], empty_for: float
) -> dict[str, float | None]:
    """Return measures of how well sensors detect the activities of people.

    A value is None if there is nothing to measure.

    Parameters
    ----------
    recording : StudyDays
        Events and truth.
    rooms : mapping of str to str
        The room of each sensor.
    empty_for : float
        A sensor that switches on gives a false alarm if its room is empty from this long before
        until this long after, s.

    Returns
    -------
    noticed
        Share of the activities at home during which a sensor in the same room is on.
    missed_per_day
        Number of the activities at home that are not noticed, per day.
    delay_s
        Mean time from the start of a noticed activity until a sensor in the room is on.
    false_alarms_per_day
        Number of false alarms, per day.
    activities_per_day
        Number of activities at home, per day.
    """
    on = on_spans(recording)
    room = on["by"].map(lambda sensor: rooms.get(sensor, ""))
    begins = on["start"] > 0.0
    start = on["start"][begins]
    alarms = _make_windows(room[begins], start - empty_for, start + empty_for)
    right = _next_span(alarms, _occupied(recording), touching=True)
    at_home = [activity for activity in recording.truth.activities if activity.room]
    done = pandas.DataFrame(at_home, columns=Activity._fields)
    activities = _make_windows(done["room"], done["start_s"], done["end_s"])
    sensed = _next_span(activities, _merge_spans(room, on["start"], on["end"]), touching=False)
    delays = (sensed["start"] - sensed["since"]).clip(lower=0.0)
    return {
        "noticed": len(delays) / len(done) if at_home else None,
        "missed_per_day": (len(done) - len(delays)) / recording.days,
        "delay_s": float(delays.mean()) if len(delays) else None,
        "false_alarms_per_day": (len(alarms) - len(right)) / recording.days,
        "activities_per_day": len(done) / recording.days,
    }


def on_spans(recording: StudyDays) -> pandas.DataFrame:
    """Return the time spans in which each sensor was on.

    Only fields that show people, such as motion, count. The columns are `by` (the sensor's name),
    `start` and `end` in s. Spans of a sensor that touch or overlap are joined into one.
    """
    presence_fields = {
        (kind.identifier, field.name)
        for kind in KINDS.values()
        for field in kind.events
        if field.type is bool and field.quantity in PRESENCE_QUANTITIES
    }
    rows = [event for event in recording.events if (event.kind, event.field) in presence_fields]
    table = pandas.DataFrame(rows, columns=CausedEvent._fields)
    table["on"] = table["value"] == "1"
    # Sensors are off before their first row.
    before = table.groupby(["sensor", "field"])["on"].shift(fill_value=False)
    changes = table[table["on"] != before]
    ends = changes.groupby(["sensor", "field"])["time_s"].shift(-1).fillna(recording.days * DAY_S)
    begins = changes["on"]
    return _merge_spans(changes["sensor"][begins], changes["time_s"][begins], ends[begins])


def _occupied(recording: StudyDays) -> pandas.DataFrame:
    """Return the time spans in which each room was occupied, with the room in the column `by`."""
    table = pandas.DataFrame(list(recording.truth.people), columns=Where._fields)
    ends = table.groupby("person")["time_s"].shift(-1).fillna(recording.days * DAY_S)
    at_home = table["room"] != ""
    return _merge_spans(table["room"][at_home], table["time_s"][at_home], ends[at_home])


def _merge_spans(
    by: Iterable[str], start: Iterable[float], end: Iterable[float]
) -> pandas.DataFrame:
    """Return the time spans sorted; spans with the same `by` that touch or overlap become one."""
    spans = _typed(by=by, start=start, end=end).sort_values(["by", "start", "end"])
    ended = spans.groupby("by")["end"].cummax().groupby(spans["by"]).shift(fill_value=-math.inf)
    number = (spans["start"] > ended).cumsum()
    return spans.groupby(number).agg(by=("by", "first"), start=("start", "min"), end=("end", "max"))


def _make_windows(
    by: Iterable[str], since: Iterable[float], until: Iterable[float]
) -> pandas.DataFrame:
    """Return a table of time windows, sorted by their start `since`."""
    return _typed(by=by, since=since, until=until).sort_values("since")


def _typed(by: Iterable[str], **seconds: Iterable[float]) -> pandas.DataFrame:
    """Return a table with the text column `by` and a float column for each of `seconds`."""
    times = {name: pandas.Series(list(column), dtype=float) for name, column in seconds.items()}
    return pandas.DataFrame({"by": pandas.Series(list(by), dtype=object), **times})


def _next_span(
    windows: pandas.DataFrame, spans: pandas.DataFrame, touching: bool
) -> pandas.DataFrame:
    """Return each window that overlaps a span with the same `by`, with the first such span.

    If `touching`, a span that only touches the window counts too.
    """
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
