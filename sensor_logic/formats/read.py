# SPDX-License-Identifier: GPL-3.0-or-later
"""What the readers of formats give: changes with their dates."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import NamedTuple

from ..kinds import KINDS
from ..log.event_log import Event, format_value
from .source import since

EPOCH = datetime(1970, 1, 1)


class DatedChange(NamedTuple):
    """A field's new value, as text, as the event log has it."""

    time: datetime
    sensor: str
    kind: str
    field: str
    value: str


@dataclass
class Read:
    """A file's changes in time order, and rooms by sensor. `has_states`: the first change of each
    field is the state in which the log begins. `has_activities`: it tells of what people did too,
    which readers pass over."""

    changes: list[DatedChange]
    rooms: dict[str, str] = field(default_factory=dict)
    has_states: bool = True
    has_activities: bool = False


def since_epoch(microseconds: int) -> datetime:
    """UTC without a zone, as starts without one are written."""
    return EPOCH + timedelta(microseconds=microseconds)


def value_text(value: bool | float | str) -> str:
    """A value as the event log has it, where numbers are floats."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return format_value(float(value)) if is_number else format_value(value)


def field_of(quantity: str) -> tuple[str, str]:
    """The first kind of sensor, by number, with an output that measures this, and the output's
    name. Raises ValueError."""
    for kind in KINDS.values():
        for published in kind.events:
            if published.type is bool and published.quantity == quantity:
                return kind.identifier, published.name
    raise ValueError(f"no kind of sensor tells {quantity}")


def events_of(read: Read, start: datetime | None) -> tuple[list[Event], datetime | None]:
    """Events in seconds since `start` (else since the first change), and that. Raises ValueError
    where times run backwards."""
    times = [change.time for change in read.changes]
    if not any(time.utcoffset() for time in times):
        # A start without a time zone was written as UTC.
        times = [time.replace(tzinfo=None) for time in times]
    start = start or (times[0] if times else None)
    found: list[Event] = []
    for time, change in zip(times, read.changes, strict=True):
        assert start is not None
        # A start without a time zone is what the clock in the home showed.
        clock = time.replace(tzinfo=None) if start.tzinfo is None else time
        seconds = since(start, clock) / 1e6
        if found and seconds < found[-1].time:
            raise ValueError(f"out of order: {time} comes after a later time; sort it by time")
        found.append(Event(seconds, change.sensor, change.field, 0.0, change.kind, change.value))
    return found, start
