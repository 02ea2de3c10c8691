# SPDX-License-Identifier: GPL-3.0-or-later
"""The events of a recording, as an event log has them, and the samples of its sensors as CSV."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..logs.fields import Field
from ..logs.formats.log import LoggedSamples
from ..logs.log import (
    COLUMN,
    Event,
    as_logged,
    format_frame,
    format_time,
    format_value,
    iso_time,
    rows_csv,
    rows_of,
    to_csv,
)
from .columns import Column
from .tracks import Recording, Track


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
                logged = as_event(value, last, step)
                if logged is not None:
                    self._last[key] = last = logged
                    found.append(_event(track, published, index))
        return sorted(found)


def as_event(value: Any, last: Any, step: float) -> Any:
    """Return a new value of a field as it is logged; None if it is no event.

    `last` is the field's previous value in the log, None if there is none. A number must differ
    from it by at least `step`.
    """
    return as_logged(value) if value != last and _is_event(value, last, step) else None


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


def events_csv(recording: Recording, start: datetime | None = None) -> str:
    """Return the event log of a recording as CSV.

    `start` is the date and time of t = 0. If it is given, a last column has dates and times.
    """
    return rows_csv(events(recording), start)


def samples_of(recording: Recording) -> tuple[LoggedSamples, ...]:
    """Return all updates of each sensor, for a `Log`."""
    return tuple(
        LoggedSamples(track.sensor, track.kind_name, track.times, track.frames, track.columns)
        for track in recording.tracks.values()
    )


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
