# SPDX-License-Identifier: GPL-3.0-or-later
"""A diary: a CSV `start,end,person,activity` of what was done, to be acted out as it stands."""

from __future__ import annotations

import csv
import io
from datetime import date, datetime, time

from ..error import InputError
from .routine import Segment

COLUMNS = ("start", "end", "person", "activity")
# What is done where the diary says nothing.
OTHER = "Other"


def read(content: str, name: str) -> tuple[date, list[Segment]]:
    """The date at whose midnight 0 s is, and for each person segments in order, with OTHER between
    them where the diary has gaps. Raises InputError."""
    rows = csv.DictReader(io.StringIO(content))
    missing = [column for column in COLUMNS if column not in (rows.fieldnames or ())]
    if missing:
        raise InputError(f"{name}, line 1: the column {missing[0]!r} is missing")
    read_rows = [(rows.line_num, *_row(row, f"{name}, line {rows.line_num}")) for row in rows]
    if not read_rows:
        raise InputError(f"{name}: there is no row")
    first = min(start for _, start, *_ in read_rows).date()
    midnight = datetime.combine(first, time())
    found: dict[str, list[Segment]] = {}
    for line, start, end, person, activity in sorted(read_rows, key=lambda row: row[1:3]):
        segments = found.setdefault(person, [])
        begins, ends = ((moment - midnight).total_seconds() for moment in (start, end))
        before = segments[-1].end if segments else 0.0
        if begins < before:
            raise InputError(
                f"{name}, line {line}: {person!r} cannot do two things at once: "
                f"{segments[-1].activity!r} ends after this begins"
            )
        if begins > before:
            segments.append(Segment(before, begins, person, OTHER))
        where = f"{name}, line {line}"
        segments.append(Segment(begins, ends, person, activity, where))
    return first, [segment for segments in found.values() for segment in segments]


def _row(row: dict[str, str], where: str) -> tuple[datetime, datetime, str, str]:
    try:
        start, end = (datetime.fromisoformat((row[key] or "").strip()) for key in ("start", "end"))
    except ValueError as error:
        raise InputError(f"{where}: {error}") from None
    person, activity = ((row[key] or "").strip() for key in ("person", "activity"))
    if start.tzinfo is not None or end.tzinfo is not None:
        raise InputError(f"{where}: times are local, without a time zone")
    if end <= start:
        raise InputError(f"{where}: the end is not after the start")
    if not person or not activity:
        raise InputError(f"{where}: person and activity must be named")
    return start, end, person, activity
