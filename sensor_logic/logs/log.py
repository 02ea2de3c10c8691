# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log: a row for each change of a published field, as CSV (UTF-8, RFC 4180).

An `Event` is a row of the log. The rows of a sensor's first update are its initial state. They are
not counted when events are counted.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Any, Generic, TypeVar

from .error import InputError, decoded, replaced

# The name of the column with dates and times.
COLUMN = "time"
# Limits for the start, so that all dates of a log are within the years 1 to 9999 in any time zone.
EARLIEST, LATEST = datetime(1, 1, 3), datetime(9890, 1, 1)


def parse_date(text: str) -> date:
    """Return the date in a text that a user typed. Raise InputError if it is not a date."""
    with replaced(f"'{text}' is not a date such as 2026-03-02", ValueError):
        return date.fromisoformat(text)


def parse_start(text: str) -> datetime | None:
    """Return the date and time in an ISO 8601 text that a user typed; None for an empty text.

    Raise InputError if the text is not a date and time.
    """
    if not text.strip():
        return None
    wrong = f"'{text}' is not a date and time in ISO 8601, such as 2026-03-01T08:00"
    with replaced(wrong, ValueError):
        start = datetime.fromisoformat(text.strip())
    if not EARLIEST <= start.replace(tzinfo=None) <= LATEST:
        raise InputError(
            f"'{text}': a start must lie between {EARLIEST.date()} and {LATEST.date()}"
        )
    return start


def moment(start: datetime, elapsed: timedelta) -> datetime:
    """Return the time `elapsed` after `start`, in the time zone of `start` if it has one."""
    if start.tzinfo is None:
        return start + elapsed
    # Added in UTC, because the elapsed time does not change when clocks go forward or back.
    return (start.astimezone(UTC) + elapsed).astimezone(start.tzinfo)


def iso_time(start: datetime, seconds: float) -> str:
    """Return the date and time in ISO 8601, `seconds` after `start`, with milliseconds."""
    return moment(start, timedelta(seconds=seconds)).isoformat(timespec="milliseconds")


HEADER = ("time_s", "frame", "sensor", "kind", "field", "value")


Value = bool | float | str
# Seconds of a run or a log, microseconds of a day, or a date and time from another file format.
Time = TypeVar("Time", float, int, datetime)


@dataclass(frozen=True, order=True)
class Event(Generic[Time]):
    """A row of the event log: a new value of a field. Events sort by time, sensor, and field.

    Attributes
    ----------
    time
        The time in s since the start, or a date and time.
    value
        A float is rounded to nine digits, as in the log. The value of an event from a file can be
        text.
    line
        The line in the file; 0 if the event is not from a file with lines.
    person, because
        For an event of a simulated day: the resident who caused it, and the cause.
    """

    time: Time
    sensor: str
    field: str
    frame: float
    kind: str
    value: Value
    line: int = dataclasses.field(default=0, compare=False, repr=False)
    person: str = ""
    because: str = ""

    def at(self, time: Any) -> Event[Any]:
        """Return the same event with another time."""
        return dataclasses.replace(self, time=time)

    @property
    def row(self: Event[float]) -> tuple[str, ...]:
        """The cells of the event's row in the log."""
        time, frame = format_time(self.time), format_frame(self.frame)
        return (time, frame, self.sensor, self.kind, self.field, format_value(self.value))


def format_time(seconds: float) -> str:
    """Return a time as text with six decimals."""
    return f"{seconds:.6f}"


def format_frame(frame: float) -> str:
    """Return a frame number as text, without trailing zeros."""
    return f"{frame:.6f}".rstrip("0").rstrip(".")


def format_value(value: Any) -> str:
    """Return a value as text: booleans as 0 or 1, floats with nine significant digits.

    NaN gives an empty text.
    """
    if isinstance(value, float):
        # Adding zero turns a negative zero into zero.
        return "" if math.isnan(value) else f"{value + 0.0:.9g}"
    return str(int(value)) if isinstance(value, (bool, int)) else str(value)


def as_logged(value: Any) -> Any:
    """Return a value as the log has it: a float is rounded to nine significant digits."""
    return float(format_value(value) or "nan") if isinstance(value, float) else value


def to_csv(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return CSV by RFC 4180: comma, CRLF, quotes where needed."""
    return rows_of([header, *rows])


def rows_of(rows: Iterable[Iterable[str]], separator: str = ",") -> str:
    """Return the rows as CSV, without a header."""
    out = io.StringIO()
    csv.writer(out, delimiter=separator).writerows(rows)
    return out.getvalue()


def for_spreadsheets(pieces: Iterable[str], decimal_comma: bool = False) -> Iterator[str]:
    """Yield a CSV file, given in pieces of whole rows, as a spreadsheet opens it by a double click.

    A byte order mark says that the text is UTF-8. A cell that begins with = + - or @ and is no
    number gets an apostrophe in front, so that it is not read as a formula.

    Parameters
    ----------
    pieces
        The CSV file.
    decimal_comma
        Whether to write 0,5 for 0.5 and separate cells by semicolons, as a spreadsheet in German
        or Swedish expects. A line `sep=,` would make Excel ignore the byte order mark.
    """
    yield "\ufeff"
    separator = ";" if decimal_comma else ","
    for piece in pieces:
        rows = csv.reader(io.StringIO(piece, newline=""))
        yield rows_of(([_sheet_cell(c, decimal_comma) for c in row] for row in rows), separator)


def _sheet_cell(cell: str, decimal_comma: bool) -> str:
    try:
        float(cell)
    except ValueError:
        return f"'{cell}" if cell.startswith(("=", "+", "-", "@", "\t", "\r")) else cell
    return cell.replace(".", ",") if decimal_comma else cell


def rows_csv(found: Iterable[Event[float]], start: datetime | None = None) -> str:
    """Return the event log with the events `found` as CSV, in their order.

    `start` is the date and time of t = 0. If it is given, a last column has dates and times.
    """
    if start is None:
        return to_csv(HEADER, (event.row for event in found))
    return to_csv((*HEADER, COLUMN), ((*e.row, iso_time(start, e.time)) for e in found))


def read_events(path: Path) -> list[Event[float]]:
    """Return the events in an event log.

    Raise InputError if a line is not valid, or OSError if the file cannot be read.
    """
    # "-sig" skips the byte order mark that spreadsheets write.
    with decoded(path), open(path, newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file)
        try:
            header = tuple(next(reader, ()))
            dated = header == (*HEADER, COLUMN)
            if dated:
                header = HEADER
            rows = reader if header == HEADER else ()
            found = [_read_event(row, dated, reader.line_num) for row in rows]
        except UnicodeDecodeError:
            raise
        except (ValueError, csv.Error):
            raise InputError(f"{path}: line {reader.line_num} is not an event") from None
    if header != HEADER:
        raise InputError(f"{path}: line 1 is not the header {','.join(HEADER)}")
    return found


def _read_event(row: list[str], dated: bool, line: int) -> Event[float]:
    time, frame, sensor, kind, name, value = row[:-1] if dated else row
    if not (math.isfinite(float(time)) and math.isfinite(float(frame))):
        raise ValueError
    return Event(float(time), sensor, name, float(frame), kind, value, line)


def differences(
    expected: Iterable[Event[float]],
    actual: Iterable[Event[float]],
    value_tolerance: float,
    time_tolerance: float,
) -> list[str]:
    """Return the differences between two logs, one line each.

    For each field of a sensor, the events of both logs are compared in order. Two events whose
    times agree are a pair. A line reports an event without a pair (missing or unexpected), or a
    pair with different values.

    Parameters
    ----------
    value_tolerance
        The largest difference between two numbers that count as equal.
    time_tolerance
        The largest difference in s between two times that count as equal.
    """
    sides: dict[tuple[str, str], tuple[list[Event[float]], list[Event[float]]]] = defaultdict(
        lambda: ([], [])
    )
    for side, source in enumerate((expected, actual)):
        for event in source:
            sides[event.sensor, event.field][side].append(event)
    found: list[tuple[float, str]] = []
    for wanted, got in sides.values():
        found += _compare(sorted(wanted), sorted(got), value_tolerance, time_tolerance)
    return [line for _, line in sorted(found)]


def _compare(
    wanted: list[Event[float]],
    got: list[Event[float]],
    value_tolerance: float,
    time_tolerance: float,
) -> Iterable[tuple[float, str]]:
    # Times are written with 6 decimals.
    slack = time_tolerance + 1e-6
    i = j = 0
    while i < len(wanted) or j < len(got):
        if j == len(got) or (i < len(wanted) and wanted[i].time < got[j].time - slack):
            yield wanted[i].time, f"missing:    {','.join(wanted[i].row)}"
            i += 1
        elif i == len(wanted) or got[j].time < wanted[i].time - slack:
            yield got[j].time, f"unexpected: {','.join(got[j].row)}"
            j += 1
        else:
            if not _same(wanted[i].value, got[j].value, value_tolerance):
                row = ",".join(got[j].row)
                expected = format_value(wanted[i].value)
                yield wanted[i].time, f"different:  {row} (expected {expected})"
            i, j = i + 1, j + 1


def _same(a: Value, b: Value, tolerance: float) -> bool:
    if a == b:
        return True
    try:
        return abs(float(a) - float(b)) <= tolerance
    except ValueError:
        return False
