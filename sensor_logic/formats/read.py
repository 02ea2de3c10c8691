# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of the formats' readers: changes with dates."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime, timedelta, tzinfo
from itertools import pairwise

from ..kinds import KINDS
from ..log.event_log import Event, Time
from .local_time import in_zone, since

EPOCH = datetime(1970, 1, 1)


@dataclass
class ParsedLog:
    """A file's changes in time order, and rooms by sensor. `has_states`: the first change of each
    field is its initial state. `has_activities`: the file also has activities, which readers
    ignore. `in_utc`: times without a zone are UTC, not the home's. `undated`: how many changes at
    the begin are initial states that have the time of the first row. `notes`: a sentence for each
    thing that was mended or left out. `end`: the local time until which the sensors were watched;
    None: unknown."""

    changes: list[Event[datetime]]
    rooms: dict[str, str] = field(default_factory=dict)
    has_states: bool = True
    has_activities: bool = False
    in_utc: bool = False
    undated: int = 0
    notes: list[str] = field(default_factory=list)
    end: datetime | None = None

    def sort(self) -> None:
        """Sorts the changes as `sort_rows` does."""
        states, changes = self.changes[: self.undated], self.changes[self.undated :]
        changes, note = sort_rows(changes)
        self.changes = [state.at(changes[0].time) for state in states] + changes
        self.notes.append(note)


def since_epoch(microseconds: int) -> datetime:
    """The UTC time without a zone, as writers store the times of a log without a zone."""
    return EPOCH + timedelta(microseconds=microseconds)


def field_of(quantity: str) -> tuple[str, str]:
    """The first kind of sensor, by number, with a boolean field of this quantity, and the field.
    Raises ValueError."""
    for kind in KINDS.values():
        for published in kind.events:
            if published.type is bool and published.quantity == quantity:
                return kind.identifier, published.name
    raise ValueError(f"no kind of sensor publishes {quantity}")


def events_of(
    read: ParsedLog, start: datetime | None, zone: tzinfo | None = None
) -> tuple[list[Event[float]], datetime | None]:
    """The events in seconds since `start` (None: since the first change), and the start; `zone`:
    the home's, if known. Raises ValueError where times decrease."""
    times = [change.time for change in read.changes]
    if not any(time.utcoffset() for time in times):
        # A start without a time zone was written as UTC.
        times = [time.replace(tzinfo=None) for time in times]
    if zone is not None:
        times = in_zone(times, zone, read.in_utc)
    start = start or (times[0] if times else None)
    found: list[Event[float]] = []
    last: datetime | None = None
    for time, change in zip(times, read.changes, strict=True):
        assert start is not None
        # A start without a time zone is a local time of the home.
        clock = time.replace(tzinfo=None) if start.tzinfo is None else time
        seconds = since(start, clock) / 1e6
        if found and seconds < found[-1].time:
            raise ValueError(
                f"{at_line(change.line)}out of order: {change.time} comes after {last}; `convert "
                "--sort` sorts it, or where clocks were put back, convert it with --timezone"
            )
        found.append(change.at(seconds))
        last = change.time
    return found, start


def at_line(number: int) -> str:
    """The begin of a message about a line; empty where there are no lines."""
    return f"line {number}: " if number else ""


def sort_rows(rows: Iterable[Event[Time]]) -> tuple[list[Event[Time]], str]:
    """The rows by time, exact repeats once, and a note on what changed; rows of one time keep their
    order. Raises TypeError where only some times have a zone."""
    given = list(rows)
    late = sum(after.time < before.time for before, after in pairwise(given))
    kept = list(dict.fromkeys(sorted(given, key=lambda row: row.time)))
    repeated = len(given) - len(kept)
    note = f"sorted by time, which went back {late} ×; repeated rows left out: {repeated}"
    return kept, note
