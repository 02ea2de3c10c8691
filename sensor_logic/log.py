# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log: a row for each change of a published field. CSV, UTF-8, RFC 4180.

An event is such a row. The rows of a sensor's first update, from which the changes start, are not
counted as events.
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

from .error import InputError, replaced
from .kind import Field
from .recording.columns import Column
from .recording.tracks import Recording, Track

# The date and time of a log's t = 0.

COLUMN = "time"
# Dates must stay within the years 1 to 9999 in any time zone, and for a scene of any length.
EARLIEST, LATEST = datetime(1, 1, 3), datetime(9890, 1, 1)


def parse_date(text: str) -> date:
    """The date that a user typed. Raises InputError."""
    with replaced(f"'{text}' is not a date such as 2026-03-02", ValueError):
        return date.fromisoformat(text)


def parse_start(text: str) -> datetime | None:
    """The date and time that a user typed in ISO 8601; None for an empty text. Raises InputError,
    which quotes the text."""
    if not text.strip():
        return None
    wrong = f"'{text}' is no date and time in ISO 8601, such as 2026-03-01T08:00"
    with replaced(wrong, ValueError):
        start = datetime.fromisoformat(text.strip())
    if not EARLIEST <= start.replace(tzinfo=None) <= LATEST:
        raise InputError(f"'{text}': a start lies between {EARLIEST.date()} and {LATEST.date()}")
    return start


def moment(start: datetime, elapsed: timedelta) -> datetime:
    """The time so long after the start, in the start's time zone if it has one."""
    if start.tzinfo is None:
        return start + elapsed
    # Added in UTC: daylight saving moves the clock, not the elapsed time.
    return (start.astimezone(UTC) + elapsed).astimezone(start.tzinfo)


def iso_time(start: datetime, seconds: float) -> str:
    """The time `seconds` after the start in ISO 8601 with milliseconds, in the start's time zone if
    it has one."""
    return moment(start, timedelta(seconds=seconds)).isoformat(timespec="milliseconds")


HEADER = ("time_s", "frame", "sensor", "kind", "field", "value")


Value = bool | float | str
# Seconds of a run or a log, µs of a day, or a date and time in what another format's reader gives.
Time = TypeVar("Time", float, int, datetime)


@dataclass(frozen=True, order=True)
class Event(Generic[Time]):
    """A field's new value; ordered by time, then sensor, then field. `value`: a float has the 9
    digits that the log tells; one from a file may still be its text. `line`: where a file has it; 0
    where there is no line. `person`, `because`: of an event of a day, who and what made it."""

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
        """The same at another time."""
        return dataclasses.replace(self, time=time)

    @property
    def row(self: Event[float]) -> tuple[str, ...]:
        time, frame = format_time(self.time), format_frame(self.frame)
        return (time, frame, self.sensor, self.kind, self.field, format_value(self.value))


def format_time(seconds: float) -> str:
    return f"{seconds:.6f}"


def format_frame(frame: float) -> str:
    return f"{frame:.6f}".rstrip("0").rstrip(".")


def format_value(value: Any) -> str:
    """Booleans as 0/1, floats with 9 significant digits, text unchanged; NaN is empty."""
    if isinstance(value, float):
        # Adding zero turns a negative zero into zero.
        return "" if math.isnan(value) else f"{value + 0.0:.9g}"
    return str(int(value)) if isinstance(value, (bool, int)) else str(value)


def events(recording: Recording) -> list[Event[float]]:
    """All events of a recording in log order."""
    return sorted(event for track in recording.tracks.values() for event in track_events(track))


def track_events(track: Track) -> Iterable[Event[float]]:
    """Each published field's first value, and its value whenever that changes (by its step)."""
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
        told(published.type(track.columns[published.name][index])),
    )


def event_updates(track: Track, published: Field) -> list[int]:
    """The updates at which a field's value is an event."""
    column, step = track.columns[published.name], track.steps.get(published.name, 0.0)
    found, last = [], None
    for index in column.changes().tolist():
        value = column[index]
        if _is_event(value, last, step):
            last = told(value)
            found.append(index)
    return found


class NewEvents:
    """The events of a growing recording, as they come."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._begin: dict[str, int] = {}
        self._last: dict[tuple[str, str], Any] = {}

    def take(self) -> list[Event[float]]:
        """The events of the updates since the last call, in log order."""
        return sorted(event for name in self._recording.tracks for event in self.take_of(name))

    def take_of(self, sensor: str) -> list[Event[float]]:
        """The events of one sensor since the last call, in log order."""
        found: list[Event[float]] = []
        track = self._recording.tracks[sensor]
        begin, self._begin[sensor] = self._begin.get(sensor, 0), len(track)
        for published in track.kind.events:
            key, step = (sensor, published.name), track.steps.get(published.name, 0.0)
            column, last = track.columns[published.name], self._last.get(key)
            for index in column.changes(begin).tolist():
                value = column[index]
                if value != last and _is_event(value, last, step):
                    self._last[key] = last = told(value)
                    found.append(_event(track, published, index))
        return sorted(found)


def told(value: Any) -> Any:
    """A value as the log tells it: floats with 9 significant digits."""
    return float(format_value(value) or "nan") if isinstance(value, float) else value


def _is_event(value: Any, last: Any, step: float) -> bool:
    """Whether a field's value is an event; `last` is the value of its previous event."""
    if isinstance(value, float):
        if not math.isfinite(value):
            return False
        if last is not None and step > 0.0:
            return bool(abs(value - last) >= step)
    return last is None or format_value(value) != format_value(last)


def to_csv(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """CSV by RFC 4180: comma, CRLF, quotes where needed."""
    return rows_of([header, *rows])


def rows_of(rows: Iterable[Iterable[str]]) -> str:
    out = io.StringIO()
    csv.writer(out).writerows(rows)
    return out.getvalue()


def for_spreadsheets(text: str) -> str:
    """The CSV for spreadsheets, which read texts that begin with = + - or @ as formulas: such texts
    get an apostrophe in front; numbers do not."""
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
    """The log of a recording; with a `start`, the date and time of t = 0, it has a last column with
    dates and times."""
    return rows_csv(events(recording), start)


def rows_csv(found: Iterable[Event[float]], start: datetime | None = None) -> str:
    """The log of these events, in their order."""
    if start is None:
        return to_csv(HEADER, (event.row for event in found))
    return to_csv((*HEADER, COLUMN), ((*e.row, iso_time(start, e.time)) for e in found))


def samples_csv(track: Track, start: datetime | None = None) -> Iterator[str]:
    """All updates of one sensor, some thousand rows at a time: time_s, frame and the fields of its
    kind; with a `start`, the date and time of t = 0, also a last column with dates and times."""
    fields = [
        f for f in track.kind.samples if not (f.optional and _is_empty(track.columns[f.name]))
    ]
    last = [COLUMN] if start else []
    yield to_csv(("time_s", "frame", *(f.name for f in fields), *last), ())
    columns = [track.times, track.frames, *(track.columns[f.name] for f in fields)]
    for parts in zip(*(column.parts() for column in columns), strict=True):
        times, frames, *values = (part.tolist() for _, part in parts)
        shown: list[Iterable[str]] = [map(format_time, times), map(format_frame, frames)]
        shown += [map(format_value, part) for part in values]
        shown += [(iso_time(start, time) for time in times)] if start else []
        yield rows_of(zip(*shown, strict=True))


def _is_empty(column: Column) -> bool:
    """Whether a column of floats holds no number."""
    return all(np.isnan(part).all() for _, part in column.parts())


def read_events(path: Path) -> list[Event[float]]:
    """The events of a file. Raises InputError, which names the first invalid line, or OSError."""
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
    """The differences, a line each: missing and unexpected events, and different values.

    Events of one field of one sensor are paired in order where their times agree within
    `time_tolerance` seconds; numbers may differ by `value_tolerance`.
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


# Finds the updates of a track at which something happened: the rows of the event log.

Indices = NDArray[np.intp]


def log_indices(track: Track) -> Indices:
    """The updates that have rows in the event log, in order; the first update is one of them."""
    found = (event_updates(track, published) for published in track.kind.events)
    return np.array(sorted(set().union(*found)), np.intp)


def event_rows(track: Track, values: bool = True) -> Indices:
    """The update of each event, in order: an update has as many as fields changed. Without `values`
    those of states alone, not of measured values."""
    fields = (f for f in track.kind.events if values or f.type is not float)
    found = (index for f in fields for index in event_updates(track, f) if index)
    return np.array(sorted(found), np.intp)


def shown_rows(track: Track, values: bool) -> Indices:
    """The same of the events to jump to and to mark: with `values`, or where no state ever changed,
    all of them."""
    found = event_rows(track, values)
    return found if len(found) else event_rows(track)
