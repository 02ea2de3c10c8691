# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth file: lists what faults changed in a log, so that `undo` can restore the log.

It has one row for each row of the log that is missing (without `row`), has another time (with both
numbers) or was added (without `true_row`). The row shows the event as in the log without faults, an
added one as in the faulty log. Rows are counted from 1, the first after the header. What was drawn
for a sensor, such as the time at which its battery dies, has neither number.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from ..error import InputError
from ..log.event_log import HEADER, Event, format_time, to_csv
from .make import DrawnFault, FaultyLog

TRUTH_HEADER = ("faults", "row", "true_row", *HEADER)


def truth_csv(faulty: FaultyLog) -> str:
    """The truth file of a faulty log, sorted by time."""
    found = [(drawn.time, _drawn_row(drawn)) for drawn in faulty.drawn]
    numbered = [(str(number), row) for number, row in enumerate(faulty.log.changes, start=1)]
    for number, row in [*numbered, *(("", row) for row in faulty.missing)]:
        if row.faults:
            change = row if row.origin is None else faulty.clean.changes[row.origin]
            true_row = "" if row.origin is None else str(row.origin + 1)
            cells = (";".join(row.faults), number, true_row, *change.event.row)
            found.append((change.time, cells))
    return to_csv(TRUTH_HEADER, (cells for _, cells in sorted(found, key=lambda pair: pair[0])))


def _drawn_row(drawn: DrawnFault) -> tuple[str, ...]:
    time = format_time(drawn.time / 1e6)
    return (drawn.fault, "", "", time, "", drawn.sensor.name, drawn.sensor.kind, "", drawn.text)


def undo(faulty: Sequence[Event[float]], truth: Path) -> list[Event[float]]:
    """The events without faults, in their order.

    Raises InputError where the file is no truth file or belongs to another log, or OSError.
    """
    left: dict[int, Event[float]] = dict(enumerate(faulty, start=1))
    put: dict[int, Event[float]] = {}
    for line, cells in _rows(truth):
        row, true_row, event = _read(truth, line, cells)
        there = left.pop(row, None) if row else None
        if row and (there is None or not _is_same(there, event, with_time=not true_row)):
            raise InputError(f"{truth}: line {line} does not fit the log: it is of another one")
        if true_row:
            put[true_row] = event
    rest = iter(left.values())
    try:
        return [put.get(number) or next(rest) for number in range(1, len(left) + len(put) + 1)]
    except StopIteration:
        raise InputError(f"{truth} does not fit the log: it has rows that are not there") from None


def _is_same(there: Event[float], event: Event[float], with_time: bool) -> bool:
    """Whether two events are equal; `with_time`: also in time."""
    return there.row[1 - with_time :] == event.row[1 - with_time :]


def _rows(truth: Path) -> list[tuple[int, list[str]]]:
    with open(truth, newline="", encoding="utf-8-sig") as file:
        try:
            rows = csv.reader(file)
            if tuple(next(rows, ())) != TRUTH_HEADER:
                raise InputError(f"{truth}: line 1 is not {','.join(TRUTH_HEADER)}")
            # Rows of what was drawn have neither number.
            return [
                (rows.line_num, row)
                for row in rows
                if len(row) != len(TRUTH_HEADER) or any(row[1:3])
            ]
        except UnicodeDecodeError:
            raise InputError(f"{truth} is not a text file in UTF-8") from None
        except csv.Error as error:
            raise InputError(f"{truth}: {error}") from None


def _read(truth: Path, line: int, cells: list[str]) -> tuple[int, int, Event[float]]:
    try:
        _faults, row, true_row, time, frame, sensor, kind, field, value = cells
        event = Event(float(time), sensor, field, float(frame), kind, value)
        return int(row or 0), int(true_row or 0), event
    except ValueError:
        raise InputError(f"{truth}: line {line} is not a row of a log") from None
