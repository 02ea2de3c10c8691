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

import numpy as np
from numpy.typing import NDArray

from .logs.error import InputError, replaced
from .logs.fields import Field
from .recording.columns import Column
from .recording.tracks import Recording, Track

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


def events(recording: Recording) -> list[Event[float]]:
    """Return all events of a recording, in the order of the log."""
    return sorted(event for track in recording.tracks.values() for event in track_events(track))


def track_events(track: Track) -> Iterable[Event[float]]:
    """Yield the events of one sensor, field by field; the first value of each field is an event."""
    for published in track.kind.events:
        for index in event_updates(track, published):
            yield _event(track, published, index)


def _event(track: Track, published: Field, index: int) -> Event[float]:
    return Event(
        track.times[index],
        track.sensor,
        published.name,
        track.frames[index],
        track.kind_name,
        as_logged(published.type(track.columns[published.name][index])),
    )


def event_updates(track: Track, published: Field) -> list[int]:
    """Return the indices of the updates at which a new value of a field is an event."""
    column, step = track.columns[published.name], track.steps.get(published.name, 0.0)
    found, last = [], None
    for index in column.changes().tolist():
        value = column[index]
        if _is_event(value, last, step):
            last = as_logged(value)
            found.append(index)
    return found


class NewEvents:
    """The events of a recording in progress; each event is returned once."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._begin: dict[str, int] = {}
        self._last: dict[tuple[str, str], Any] = {}

    def take(self) -> list[Event[float]]:
        """Return the events of all sensors since the last call, in the order of the log."""
        return sorted(event for name in self._recording.tracks for event in self.take_of(name))

    def take_of(self, sensor: str) -> list[Event[float]]:
        """Return the events of one sensor since the last call, in the order of the log."""
        found: list[Event[float]] = []
        track = self._recording.tracks[sensor]
        begin, self._begin[sensor] = self._begin.get(sensor, 0), len(track)
        for published in track.kind.events:
            key, step = (sensor, published.name), track.steps.get(published.name, 0.0)
            column, last = track.columns[published.name], self._last.get(key)
            for index in column.changes(begin).tolist():
                value = column[index]
                if value != last and _is_event(value, last, step):
                    self._last[key] = last = as_logged(value)
                    found.append(_event(track, published, index))
        return sorted(found)


def as_logged(value: Any) -> Any:
    """Return a value as the log has it: a float is rounded to nine significant digits."""
    return float(format_value(value) or "nan") if isinstance(value, float) else value


def _is_event(value: Any, last: Any, step: float) -> bool:
    """Return whether a new value of a field belongs in the event log.

    `last` is the field's previous value in the log, None if there is none. A number must differ
    from it by at least `step`.
    """
    if isinstance(value, float):
        if not math.isfinite(value):
            return False
        if last is not None and step > 0.0:
            return bool(abs(value - last) >= step)
    return last is None or format_value(value) != format_value(last)


def to_csv(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return CSV by RFC 4180: comma, CRLF, quotes where needed."""
    return rows_of([header, *rows])


def rows_of(rows: Iterable[Iterable[str]]) -> str:
    """Return the rows as CSV, without a header."""
    out = io.StringIO()
    csv.writer(out).writerows(rows)
    return out.getvalue()


def for_spreadsheets(text: str) -> str:
    """Return CSV in which spreadsheets read no cell as a formula.

    A cell that begins with = + - or @ gets an apostrophe in front. Numbers stay as they are.
    """
    rows = csv.reader(io.StringIO(text, newline=""))
    return rows_of([_no_formula(cell) for cell in row] for row in rows)


def _no_formula(cell: str) -> str:
    if not cell.startswith(("=", "+", "-", "@", "\t", "\r")):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def events_csv(recording: Recording, start: datetime | None = None) -> str:
    """Return the event log of a recording as CSV.

    `start` is the date and time of t = 0. If it is given, a last column has dates and times.
    """
    return rows_csv(events(recording), start)


def rows_csv(found: Iterable[Event[float]], start: datetime | None = None) -> str:
    """Return the event log with the events `found` as CSV, in their order.

    `start` is the date and time of t = 0. If it is given, a last column has dates and times.
    """
    if start is None:
        return to_csv(HEADER, (event.row for event in found))
    return to_csv((*HEADER, COLUMN), ((*e.row, iso_time(start, e.time)) for e in found))


def samples_csv(track: Track, start: datetime | None = None) -> Iterator[str]:
    """Yield the sample file of one sensor as CSV, some thousand rows at a time.

    The columns are time_s, frame and the fields of the sensor's kind. `start` is the date and time
    of t = 0. If it is given, a last column has dates and times.
    """
    fields, last = sampled_fields(track), [COLUMN] if start else []
    yield to_csv(("time_s", "frame", *(f.name for f in fields), *last), ())
    columns = [track.times, track.frames, *(track.columns[f.name] for f in fields)]
    for parts in zip(*(column.parts() for column in columns), strict=True):
        times, frames, *values = (part.tolist() for _, part in parts)
        shown: list[Iterable[str]] = [map(format_time, times), map(format_frame, frames)]
        shown += [map(format_value, part) for part in values]
        shown += [(iso_time(start, time) for time in times)] if start else []
        yield rows_of(zip(*shown, strict=True))


def sampled_fields(track: Track) -> list[Field]:
    """Return the fields in the samples of a sensor, without optional ones that have no value."""
    return [f for f in track.kind.samples if not (f.optional and _is_empty(track.columns[f.name]))]


def _is_empty(column: Column) -> bool:
    """Return whether no row of a column of texts or floats has a value."""
    if column.type is str:
        return not any(column.texts)
    return all(np.isnan(part).all() for _, part in column.parts())


def read_events(path: Path) -> list[Event[float]]:
    """Return the events in an event log.

    Raise InputError if a line is not valid, or OSError if the file cannot be read.
    """
    # "-sig" skips the byte order mark that spreadsheets write.
    with open(path, newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file)
        try:
            header = tuple(next(reader, ()))
            dated = header == (*HEADER, COLUMN)
            if dated:
                header = HEADER
            rows = reader if header == HEADER else ()
            found = [_read_event(row, dated, reader.line_num) for row in rows]
        except UnicodeDecodeError:
            raise InputError(f"{path} is not a text file in UTF-8") from None
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


# The updates of a track that have rows in the event log.

Indices = NDArray[np.intp]


def log_indices(track: Track) -> Indices:
    """Return the indices of the updates that have rows in the log, in ascending order."""
    found = (event_updates(track, published) for published in track.kind.events)
    return np.array(sorted(set().union(*found)), np.intp)


def event_rows(track: Track, values: bool = True) -> Indices:
    """Return the update index of each event after the first update, in ascending order.

    An update at which several fields changed is repeated. If `values` is false, only changes of
    states count, not changes of measured numbers.
    """
    fields = (f for f in track.kind.events if values or f.type in (bool, str))
    found = (index for f in fields for index in event_updates(track, f) if index)
    return np.array(sorted(found), np.intp)


def shown_rows(track: Track, values: bool) -> Indices:
    """Return the indices of the updates whose events the timeline marks.

    These are the updates of `event_rows`. If `values` is false and no state ever changed, changes
    of numbers count too.
    """
    found = event_rows(track, values)
    return found if len(found) else event_rows(track)
