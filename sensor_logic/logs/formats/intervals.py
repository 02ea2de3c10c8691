# SPDX-License-Identifier: GPL-3.0-or-later
"""Read logs of intervals: a row for each time that a sensor was on, as Ordonez and Kasteren have.

A row is start, end and sensor, and optionally its type and room, with tabs or several spaces
between them: `2012-11-11 21:14:21  2012-11-12 00:21:49  Seat  Pressure  Living`. Kasteren has the
number of the sensor and a value, `25-Feb-2008 00:20:14  25-Feb-2008 00:22:57  24  1`. Instead of
two times, there can be the start in seconds since 1970 and the duration in seconds.

Of a table, the columns are `start`, `end` and `sensor`, and optionally `type` and `room`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

from ..error import decoded, explained
from ..log import Event
from .activities import ABOVE, ENDS, INTERVAL, LENGTH, STARTS, parsed_time, plain
from .source import EPOCH, ParsedLog, RowTally, field_of

# The first bytes of a file in this format, after lines above the data. A table begins with the
# names of its columns.
BEGINS = (
    rb"(?:[A-Za-z][^\n\d]*\r?\n|-[-\s]*\r?\n)*[ \t]*"
    rb"(?:(?:(?:\d{4}-\d\d-\d\d|\d\d?-[A-Za-z]{3}-\d{4})[ T]\d\d?:\d\d(?::\d\d(?:\.\d+)?)?\s+){2}\S"
    rb"|\d{9,10}[ \t]+\d{1,7}[ \t]+\S)"
    rb"|(?i:start(?:[ _]?time)?,end(?:[ _]?time)?,(?:sensor|device)\b)"
)
SENSORS, TYPES, ROOMS = ("sensor", "device"), ("type",), ("room", "place")
# The quantity that sensors of a type measure, by a word in the type or the name.
WORDS = (
    ("motion", ("pir", "motion")),
    ("opening", ("magnetic", "contact", "door", "reed", "fridge", "cupboard", "freezer", "window")),
    ("flow", ("flush", "float")),
    ("operation", ("electric", "plug")),
    ("occupancy", ("pressure", "mat", "bed", "seat", "item")),
)


class _Row(NamedTuple):
    """A row: its line, start and end, and the sensor's name, type and room."""

    line: int
    start: datetime
    end: datetime
    name: str
    type: str
    room: str


def read(path: Path) -> ParsedLog:
    """Read a log of intervals; each becomes a change to on and one to off.

    The kinds of sensors are guessed from their types and names. Raise ValueError for an invalid
    line; the text names it.
    """
    with decoded(path):
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    found = ParsedLog([], has_states=False)
    left_out = RowTally("row", "left out")
    rows: list[_Row] = []
    for row in _rows(lines):
        if row.end < row.start:
            left_out.add(row.line, "it ends before it begins")
        else:
            rows.append(row)
    rooms = {(row.name, row.room) for row in rows}
    names = [name for name, _ in rooms]
    on: dict[str, list[_Row]] = {}
    for row in sorted(rows, key=lambda row: (row.start, row.end)):
        # Ordonez has a door in several rooms.
        name = f"{row.name} {row.room}".strip() if names.count(row.name) > 1 else row.name
        spans = on.setdefault(name, [])
        if spans and row.start <= spans[-1].end:
            spans[-1] = spans[-1]._replace(end=max(row.end, spans[-1].end))
        else:
            spans.append(row)
    for name, spans in on.items():
        kind, field = field_of(_quantity(spans[0].type) or _quantity(name) or "motion")
        if spans[0].room:
            found.rooms[name] = spans[0].room
        for row in spans:
            for time, value in ((row.start, True), (row.end, False)):
                found.changes.append(Event(time, name, field, 0.0, kind, value, row.line))
    found.changes.sort(key=lambda change: (change.time, bool(change.value)))
    found.notes += [left_out.text] if left_out.count else []
    return found


def _quantity(words: str) -> str:
    """Return the quantity that a sensor measures, by the words of its type or name, or ""."""
    lower = words.lower()
    found = (quantity for quantity, known in WORDS if any(word in lower for word in known))
    return next(found, "")


def _rows(lines: Sequence[str]) -> Iterator[_Row]:
    header = [plain(name) for name in lines[0].split(",")] if lines else []
    if {"sensor", "device"} & set(header):
        yield from _of_table(header, lines)
        return
    for number, line in enumerate(lines, start=1):
        if found := INTERVAL.fullmatch(line):
            with explained(f"line {number}", ValueError, raised=ValueError):
                start = parsed_time(f"{found[1]} {found[2]}")
                end = parsed_time(f"{found[3]} {found[4]}")
            columns = re.split(r"\t+\s*|\s{2,}", found[5])
        elif found := LENGTH.fullmatch(line):
            start = EPOCH + timedelta(seconds=int(found[1]))
            end = start + timedelta(seconds=int(found[2]))
            columns = [found[3]]
        elif ABOVE.fullmatch(line):
            continue
        else:
            raise ValueError(f"line {number} is not start, end and sensor")
        # Kasteren's value is 1.
        name, sort, room = (*columns, "", "")[:3]
        yield _Row(number, start, end, name, "" if sort == "1" else sort, room)


def _of_table(header: list[str], lines: Sequence[str]) -> Iterator[_Row]:
    def place(names: Sequence[str]) -> int:
        return next((header.index(name) for name in names if name in header), -1)

    start, end, name, sort, room = map(place, (STARTS, ENDS, SENSORS, TYPES, ROOMS))
    rows = csv.reader(lines)
    next(rows)
    for row in rows:
        if not any(row):
            continue
        with explained(f"line {rows.line_num}", ValueError, IndexError, raised=ValueError):
            times = parsed_time(row[start]), parsed_time(row[end])
            texts = (row[name].strip(), *(row[n].strip() if n >= 0 else "" for n in (sort, room)))
        yield _Row(rows.line_num, *times, *texts)
