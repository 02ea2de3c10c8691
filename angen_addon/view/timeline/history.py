# SPDX-License-Identifier: GPL-3.0-or-later
"""What a recording says of each sensor over time: spans of states, a curve, and events."""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kinds import KINDS
from ....sensor_logic.log.event_indices import Indices, event_indices, log_indices
from ....sensor_logic.model import Array
from ....sensor_logic.recording.tracks import Recording, Track
from ...scene.instances import Uid

IDLE, ACTIVE, INVALID, OFF = 0, 1, 2, 3
# A sensor was off where its next update comes later than this many of its usual times between two.
GAP = 1.5


@dataclass(frozen=True)
class Spans:
    """States (n,) that hold from frame `starts` (n,) to `ends` (n,), in order without holes."""

    starts: Array
    ends: Array
    states: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class HistoryRow:
    """One sensor: what it is called and its room; `uid`: session uid of its object. `frames`,
    `values`: its curve, for kinds that measure, and `full`: what is drawn as full height; `log`,
    `events`: see events.py."""

    name: str
    room: str
    uid: Uid
    kind: str
    spans: Spans
    frames: Array
    values: Array
    full: float = 1.0
    log: Indices = field(default_factory=lambda: np.empty(0, np.intp))
    events: Indices = field(default_factory=lambda: np.empty(0, np.intp))


@dataclass(frozen=True)
class History:
    """The rows by room and then by kind and name; frames `start` to `end`, where the last ends."""

    rows: tuple[HistoryRow, ...]
    start: float
    end: float

    def only(self, uids: frozenset[Uid]) -> History:
        """Some of the rows."""
        return replace(self, rows=tuple(row for row in self.rows if row.uid in uids))

    def row_of(self, uid: Uid) -> HistoryRow | None:
        return next((row for row in self.rows if row.uid == uid), None)


def history_of(recording: Recording, sensors: Iterable[Any]) -> History:
    """The history of sensors; those without a track have none, and are shown as off."""
    start, end = float(recording.frame_start), float(recording.frame_end + 1)
    rows = [_row(recording.track_of(sensor.uid), sensor, start, end) for sensor in sensors]
    # What has no room comes last.
    rows.sort(key=lambda row: (not row.room, row.room, KINDS[row.kind].number, row.name))
    return History(tuple(rows), start, end)


def _row(track: Track | None, sensor: Any, start: float, end: float) -> HistoryRow:
    kind = sensor.kind.identifier
    nothing = np.empty(0)
    if track is None or not len(track):
        off = Spans(np.array([start]), np.array([end]), np.array([OFF], np.int8))
        return HistoryRow(sensor.name, sensor.room, sensor.uid, kind, off, nothing, nothing)
    frames = np.array(track.frames, np.float64)
    curve = sensor.kind.has_analog_reading
    return HistoryRow(
        sensor.name,
        sensor.room,
        sensor.uid,
        kind,
        spans_of(track, start, end),
        frames if curve else nothing,
        np.nan_to_num(np.array(track.value, np.float64)) if curve else nothing,
        _full(track, sensor) if curve else 1.0,
        log_indices(track),
        event_indices(track),
    )


def _full(track: Track, sensor: Any) -> float:
    """100 for what is in percent; else the peak, or the threshold where nothing reaches it."""
    if track.reading_at(0).unit == "%":
        return 100.0
    threshold = float(getattr(sensor.parameters, "threshold", 0.0))
    return max(float(np.nanmax(np.array(track.value), initial=0.0)), threshold)


def spans_of(track: Track, start: float, end: float) -> Spans:
    """Each state of a track with at least one update, from its first update to the next state's."""
    frames = np.array(track.frames, np.float64)
    states = np.array(track.active, np.int8)
    if "valid" in track.columns:
        states[np.array(track.columns["valid"], np.int8) == 0] = INVALID
    following = np.append(frames[1:], end)
    usual = float(np.median(np.diff(frames))) if len(frames) > 1 else end - start
    late = following - frames > usual * GAP + 1.0
    until = np.where(late, frames + np.ceil(usual), following)
    # What is between the end of one update and the next one is a hole: the sensor was off.
    starts = np.concatenate([[start], np.stack([frames, until], axis=1).ravel()])
    ends = np.concatenate([starts[1:], [end]])
    told = np.concatenate([[OFF], np.stack([states, np.full_like(states, OFF)], axis=1).ravel()])
    some = ends > starts
    starts, ends, told = starts[some], ends[some], told[some]
    first = np.flatnonzero(np.append(True, told[1:] != told[:-1]))
    return Spans(
        starts[first], np.append(starts[first][1:], ends[-1:]), told[first].astype(np.int8)
    )


class Histories:
    """The history of the recording that was asked for last, until it is cleared; without it each
    redraw of the sample home's timeline takes 5 ms more."""

    def __init__(self) -> None:
        self._of: weakref.ref[Recording] | None = None
        self._made: History | None = None
        self._names: tuple[Any, ...] = ()

    def get(self, recording: Recording, sensors: list[Any]) -> History:
        """Made anew where sensors were added, renamed or given another room since."""
        names = tuple((s.uid, s.name, s.room) for s in sensors)
        known = self._of() if self._of is not None else None
        if self._made is None or known is not recording or names != self._names:
            self._of, self._names = weakref.ref(recording), names
            self._made = history_of(recording, sensors)
        return self._made

    def clear(self) -> None:
        self._of, self._made, self._names = None, None, ()


HISTORIES = Histories()
