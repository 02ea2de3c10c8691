# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log: a row for each change of a published field. CSV, UTF-8, RFC 4180."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from ..kind import Field
from ..recording.columns import Column
from ..recording.tracks import Recording, Track
from .start import COLUMN, iso_time

HEADER = ("time_s", "frame", "sensor", "kind", "field", "value")


@dataclass(frozen=True, order=True)
class Event:
    """A field's new value, as text; ordered by time, then sensor, then field. `line`: where a file
    has it; 0 where there is no line."""

    time: float
    sensor: str
    field: str
    frame: float
    kind: str
    value: str
    line: int = dataclasses.field(default=0, compare=False)

    @property
    def row(self) -> tuple[str, ...]:
        time, frame = format_time(self.time), format_frame(self.frame)
        return (time, frame, self.sensor, self.kind, self.field, self.value)


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


def events(recording: Recording) -> list[Event]:
    """All events of a recording in log order."""
    return sorted(event for track in recording.tracks.values() for event in track_events(track))


def track_events(track: Track) -> Iterable[Event]:
    """Each published field's first value, and its value whenever that changes (by its step)."""
    for published in track.kind.events:
        for index in event_updates(track, published):
            yield _event(track, published, index)


def _event(track: Track, published: Field, index: int) -> Event:
    return Event(
        track.times[index],
        track.sensor,
        published.name,
        track.frames[index],
        track.kind_name,
        format_value(track.columns[published.name][index]),
    )


def event_updates(track: Track, published: Field) -> list[int]:
    """The updates at which a field's value is an event."""
    column, step = track.columns[published.name], track.steps.get(published.name, 0.0)
    found, last = [], None
    for index in column.changes().tolist():
        value = column[index]
        if _is_event(value, last, step):
            last = _told(value)
            found.append(index)
    return found


class NewEvents:
    """The events of a growing recording, as they come."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._begin: dict[str, int] = {}
        self._last: dict[tuple[str, str], Any] = {}

    def has_steps(self, sensor: str) -> bool:
        """Whether a field of it is told only when it changed by a step since its last event; not if
        the sensor is not recorded."""
        track = self._recording.tracks.get(sensor)
        return track is not None and any(step > 0.0 for step in track.steps.values())

    def last_of(self, sensor: str) -> dict[str, Any]:
        """The values of a sensor's last events by field: those to come are told from these."""
        return {field: value for (name, field), value in self._last.items() if name == sensor}

    def begin_at(self, sensor: str, index: int, last: Mapping[str, Any]) -> None:
        """The next events are those from update `index` on, after these last values."""
        self._begin[sensor] = index
        self._last |= {(sensor, field): value for field, value in last.items()}

    def take(self) -> list[Event]:
        """The events of the updates since the last call, in log order."""
        return sorted(event for name in self._recording.tracks for event in self.take_of(name))

    def take_of(self, sensor: str) -> list[Event]:
        """The events of one sensor since the last call, in log order."""
        found: list[Event] = []
        track = self._recording.tracks[sensor]
        begin, self._begin[sensor] = self._begin.get(sensor, 0), len(track)
        for published in track.kind.events:
            key, step = (sensor, published.name), track.steps.get(published.name, 0.0)
            column, last = track.columns[published.name], self._last.get(key)
            for index in column.changes(begin).tolist():
                value = column[index]
                if value != last and _is_event(value, last, step):
                    self._last[key] = last = _told(value)
                    found.append(_event(track, published, index))
        return sorted(found)


def _told(value: Any) -> Any:
    """A value of an event as the log tells it, from which the next changes."""
    return float(format_value(value)) if isinstance(value, float) else value


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


def rows_csv(found: Iterable[Event], start: datetime | None = None) -> str:
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


def read_events(path: Path) -> list[Event]:
    """The events of a file. Raises ValueError, which names the first invalid line, or OSError."""
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
            raise ValueError(f"{path} is not a text file in UTF-8") from None
        except (ValueError, csv.Error):
            raise ValueError(f"{path}: line {reader.line_num} is not an event") from None
    if header != HEADER:
        raise ValueError(f"{path}: line 1 is not the header {','.join(HEADER)}")
    return found


def _read_event(row: list[str], dated: bool, line: int) -> Event:
    time, frame, sensor, kind, name, value = row[:-1] if dated else row
    if not (math.isfinite(float(time)) and math.isfinite(float(frame))):
        raise ValueError
    return Event(float(time), sensor, name, float(frame), kind, value, line)


def differences(
    expected: Iterable[Event],
    actual: Iterable[Event],
    value_tolerance: float,
    time_tolerance: float,
) -> list[str]:
    """The differences, a line each: missing and unexpected events, and different values.

    Events of one field of one sensor are paired in order where their times agree within
    `time_tolerance` seconds; numbers may differ by `value_tolerance`.
    """
    sides: dict[tuple[str, str], tuple[list[Event], list[Event]]] = defaultdict(lambda: ([], []))
    for side, source in enumerate((expected, actual)):
        for event in source:
            sides[event.sensor, event.field][side].append(event)
    found: list[tuple[float, str]] = []
    for wanted, got in sides.values():
        found += _compare(sorted(wanted), sorted(got), value_tolerance, time_tolerance)
    return [line for _, line in sorted(found)]


def _compare(
    wanted: list[Event], got: list[Event], value_tolerance: float, time_tolerance: float
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
                yield wanted[i].time, f"different:  {row} (expected {wanted[i].value})"
            i, j = i + 1, j + 1


def _same(a: str, b: str, tolerance: float) -> bool:
    if a == b:
        return True
    try:
        return abs(float(a) - float(b)) <= tolerance
    except ValueError:
        return False
