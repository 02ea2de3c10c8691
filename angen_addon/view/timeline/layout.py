# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert a recording into the history of its sensors, and the history into shapes in pixels.

This module draws nothing. Each state has its own shape: active is solid, not valid is hatched, off
is dotted, and idle is a thin line.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kinds import KINDS
from ....sensor_logic.model import Array
from ....sensor_logic.palette import KIND_COLOURS, rgba
from ....sensor_logic.recording.events import Indices, event_rows, log_indices, shown_rows
from ....sensor_logic.recording.tracks import Recording, Track
from ....sensor_logic.report.svg import shortened
from ...scene.instances import Uid
from ...scene.memory import forgets_at_load
from ...translations.interface import translated

IDLE, ACTIVE, INVALID, OFF = 0, 1, 2, 3
# A sensor counts as off between two updates that are more than this many usual intervals apart.
GAP = 1.5


@dataclass(frozen=True)
class Spans:
    """The states (n,) of a sensor, each from frame `starts` (n,) to `ends` (n,), without gaps."""

    starts: Array
    ends: Array
    states: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class HistoryRow:
    """The history of one sensor, drawn as one row of the timeline.

    Attributes
    ----------
    name, room, kind
        The name, the room and the kind of the sensor.
    uid
        Session uid of the sensor's object.
    spans
        The states of the sensor with their frames.
    frames, values
        The curve of a sensor that measures a quantity; empty for all others.
    full
        The value that is drawn as high as the row.
    log
        The indices of the updates with a row in the event log.
    events
        For each event, the index of its update.
    states
        The indices of the updates at which a state changed, from `shown_rows` in
        `sensor_logic/recording/events.py`.
    """

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
    states: Indices = field(default_factory=lambda: np.empty(0, np.intp))


@dataclass(frozen=True)
class History:
    """The history of all sensors from frame `start` to frame `end`, exclusive.

    The rows, one for each sensor, are sorted by room, kind and name.
    """

    rows: tuple[HistoryRow, ...]
    start: float
    end: float

    def only(self, uids: frozenset[Uid]) -> History:
        """Return a history with only the sensors of these session uids."""
        return replace(self, rows=tuple(row for row in self.rows if row.uid in uids))

    def row_of(self, uid: Uid) -> HistoryRow | None:
        """Return the row of a sensor; None if it has none."""
        return next((row for row in self.rows if row.uid == uid), None)


def history_of(recording: Recording, sensors: Iterable[Any]) -> History:
    """Return the history of sensors; a sensor without a recording is shown as off."""
    start, end = float(recording.frame_start), float(recording.frame_end + 1)
    rows = [_row(recording.track_of(sensor.uid), sensor, start, end) for sensor in sensors]
    # Sensors without a room come last.
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
        _full_scale(track, sensor) if curve else 1.0,
        log_indices(track),
        event_rows(track),
        shown_rows(track, values=False),
    )


def _full_scale(track: Track, sensor: Any) -> float:
    """Return the value that is drawn as high as the row.

    For a reading in percent, this is 100. For others, it is the greater of the threshold and the
    greatest recorded value.
    """
    if track.reading_at(0).unit == "%":
        return 100.0
    threshold = float(getattr(sensor.parameters, "threshold", 0.0))
    return max(float(np.nanmax(np.array(track.value), initial=0.0)), threshold)


def spans_of(track: Track, start: float, end: float) -> Spans:
    """Return the states of a track that has at least one update, from frame `start` to `end`.

    A state lasts from its first update to the first update of the next state.
    """
    frames = np.array(track.frames, np.float64)
    states = np.array(track.active, np.int8)
    states[track.invalid()] = INVALID
    following = np.append(frames[1:], end)
    usual = float(np.median(np.diff(frames))) if len(frames) > 1 else end - start
    late = following - frames > usual * GAP + 1.0
    until = np.where(late, frames + np.ceil(usual), following)
    # The sensor was off in the gap between the end of one update and the next one.
    starts = np.concatenate([[start], np.stack([frames, until], axis=1).ravel()])
    ends = np.concatenate([starts[1:], [end]])
    found = np.concatenate([[OFF], np.stack([states, np.full_like(states, OFF)], axis=1).ravel()])
    some = ends > starts
    starts, ends, found = starts[some], ends[some], found[some]
    first = np.flatnonzero(np.append(True, found[1:] != found[:-1]))
    return Spans(
        starts[first], np.append(starts[first][1:], ends[-1:]), found[first].astype(np.int8)
    )


class Histories:
    """A cache of the history of the last recording.

    It saves 5 ms per redraw for the sample home.
    """

    def __init__(self) -> None:
        self._recording: weakref.ref[Recording] | None = None
        self._history: History | None = None
        self._names: tuple[Any, ...] = ()

    def get(self, recording: Recording, sensors: list[Any]) -> History:
        """Return the history of the recording.

        Compute it anew if the recording, the sensors, their names or their rooms have changed.
        """
        names = tuple((s.uid, s.name, s.room) for s in sensors)
        known = self._recording() if self._recording is not None else None
        if self._history is None or known is not recording or names != self._names:
            self._recording, self._names = weakref.ref(recording), names
            self._history = history_of(recording, sensors)
        return self._history

    def clear(self) -> None:
        self._recording, self._history, self._names = None, None, ()


HISTORIES = Histories()
forgets_at_load(HISTORIES.clear)


Colour = tuple[float, float, float, float]
# Colours by number of the kind, as in reports on dark ground.
COLOURS: tuple[Colour, ...] = tuple(rgba(dark) for _, dark in KIND_COLOURS)
GROUND: Colour = (0.10, 0.10, 0.10, 0.80)
CHOSEN: Colour = (1.0, 1.0, 1.0, 0.10)
RULE: Colour = (1.0, 1.0, 1.0, 0.22)
FAINT: Colour = (0.72, 0.72, 0.72, 0.55)
CHIP: Colour = (0.10, 0.10, 0.10, 0.72)
WORD: Colour = (0.92, 0.92, 0.92, 1.0)
BRIGHT: Colour = (1.0, 1.0, 1.0, 1.0)
DIM: Colour = (0.72, 0.72, 0.72, 1.0)
# Pixels at an interface scale of 1.
MOST_HIGH, LEAST_HIGH, LEAST_NAMED = 17.0, 4.0, 10.0
BETWEEN_ROOMS = 3.0
HATCH = 5
DOT, DOTS = 2, 7
LETTER = 11.0
# The area of a lit or pressed sensor is at least this share of the height of its row.
LEAST_AREA = 0.2


class TimelineRegion(NamedTuple):
    """The size of a region in pixels, the frames that it shows, and the interface's scale.

    `left` and `right` are the frames at its edges. `bottom` and `top` are the pixels between which
    rows are drawn.
    """

    width: int
    bottom: float
    top: float
    scale: float
    left: float
    right: float

    def x(self, frame: Array) -> Array:
        """Return the horizontal positions of frames (n,) in pixels, not rounded."""
        return (frame - self.left) / (self.right - self.left) * self.width


class TimelineText(NamedTuple):
    """A text to draw in the timeline; `size` is the height of its letters in pixels.

    `x` and `y` are its lower left corner, or its lower right corner if `to_the_left` is true.
    """

    x: float
    y: float
    text: str
    size: float
    colour: Colour
    to_the_left: bool = False


@dataclass
class TimelinePicture:
    """Shapes in pixels, with their colours.

    `quads` are rectangles (x0, y0, x1, y1, colour). `lines` go from (x0, y0) to (x1, y1), as (x0,
    y0, x1, y1, colour). `words` are texts, each drawn on a dark ground.
    """

    quads: list[tuple[float, float, float, float, Colour]] = field(default_factory=list)
    lines: list[tuple[float, float, float, float, Colour]] = field(default_factory=list)
    words: list[TimelineText] = field(default_factory=list)


def runs(starts: Array, ends: Array, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the columns of pixels that spans touch, as merged runs of neighbouring columns.

    A span that is narrower than a column has one column. There are at most as many runs as columns.

    Parameters
    ----------
    starts, ends
        Spans (n,) in pixels.
    width
        Number of columns.

    Returns
    -------
    first, end : array of int
        The first column of each run, and the column after its last one.
    """
    seen = (ends > 0.0) & (starts < width)
    first = np.clip(np.floor(starts[seen] + 0.5), 0, width - 1).astype(np.int64)
    last = np.clip(np.floor(ends[seen] + 0.5), first + 1, width).astype(np.int64)
    edges = np.zeros(width + 1, np.int64)
    np.add.at(edges, first, 1)
    np.add.at(edges, last, -1)
    covered = np.concatenate([[0], (np.cumsum(edges)[:width] > 0).astype(np.int64), [0]])
    turns = np.diff(covered)
    return np.flatnonzero(turns == 1), np.flatnonzero(turns == -1)


class PlacedRow(NamedTuple):
    """A row of the timeline with its lower edge and its height in pixels."""

    row: HistoryRow
    y: float
    high: float


def place(rows: tuple[HistoryRow, ...], view: TimelineRegion) -> list[PlacedRow]:
    """Return the rows that fit into the region `view`, from the top down, all of the same height.

    The last row is at the bottom of the region.
    """
    if not rows:
        return []
    gap = BETWEEN_ROOMS * view.scale
    rooms = len({row.room for row in rows})
    room_for = view.top - view.bottom - (rooms - 1) * gap
    high = math.floor(min(MOST_HIGH * view.scale, room_for / len(rows)))
    high = max(high, math.ceil(LEAST_HIGH * view.scale))
    shown = rows[: max(0, int(room_for // high))]
    if not shown:
        return []
    y = view.bottom + len(shown) * high + (len({row.room for row in shown}) - 1) * gap
    placed: list[PlacedRow] = []
    for row in shown:
        if placed and row.room != placed[-1].row.room:
            y -= gap
        y -= high
        placed.append(PlacedRow(row, y, high))
    return placed


def strips(history: History, view: TimelineRegion, chosen: frozenset[Uid]) -> TimelinePicture:
    """Return the picture of the states and curves in all rows, with the names of the rooms.

    `chosen` are the session uids of highlighted sensors.
    """
    picture = TimelinePicture()
    placed = place(history.rows, view)
    if view.right <= view.left:
        return picture
    _draw_ground(picture, placed, view, chosen)
    for row, y, high in placed:
        _draw_strip(picture, view, row, y + 1, high - 2)
    for room in dict.fromkeys(p.row.room for p in placed):
        inside = [p for p in placed if p.row.room == room]
        _draw_room(picture, view, room, inside[-1].y, inside[0].y + inside[0].high, inside[0].high)
    left_out = len(history.rows) - len(placed)
    # The text is on the lowest row, because the frame numbers are above the highest one.
    size, low = LETTER * view.scale, placed[-1].y if placed else view.bottom
    if left_out and (placed or view.top - low >= 2 * size):
        text = (
            f"{left_out} more not shown: make this editor higher"
            if placed
            else f"{left_out} sensors not shown: make this editor higher"
        )
        text = translated(text)
        picture.words.append(TimelineText(6 * view.scale, low + size / 2, text, size, DIM))
    return picture


def labels(
    history: History, view: TimelineRegion, chosen: frozenset[Uid], ground: bool
) -> TimelinePicture:
    """Return the picture of the rows' names; empty if the rows are too low for letters.

    If `ground` is True, the picture also has the dark ground of the rows. `chosen` are the session
    uids of highlighted sensors.
    """
    picture = TimelinePicture()
    placed = place(history.rows, view)
    if ground:
        _draw_ground(picture, placed, view, chosen)
    for row, y, high in placed:
        if high >= LEAST_NAMED * view.scale:
            size = min(LETTER * view.scale, high - 3)
            colour = BRIGHT if row.uid in chosen else WORD
            left = 4 * view.scale
            name = shortened(row.name, view.width - 2 * left, size)
            picture.words.append(TimelineText(left, y + high / 2, name, size, colour))
    return picture


def _draw_ground(
    picture: TimelinePicture, placed: list[PlacedRow], view: TimelineRegion, chosen: frozenset[Uid]
) -> None:
    if not placed:
        return
    width = float(view.width)
    top = placed[0].y + placed[0].high
    picture.quads.append((0.0, placed[-1].y - 2, width, top + 2, GROUND))
    above = None
    for row, y, high in placed:
        if above is not None and row.room != above:
            middle = y + high + BETWEEN_ROOMS * view.scale / 2
            picture.lines.append((0.0, middle, width, middle, RULE))
        above = row.room
        if row.uid in chosen:
            picture.quads.append((0.0, y, width, y + high, CHOSEN))


def _draw_room(
    picture: TimelinePicture,
    view: TimelineRegion,
    room: str,
    bottom: float,
    top: float,
    high: float,
) -> None:
    size = min(LETTER * view.scale, max(top - bottom, high) - 1)
    if room and size >= 7 * view.scale:
        middle = (bottom + top) / 2
        word = TimelineText(view.width - 6 * view.scale, middle, room, size, DIM, to_the_left=True)
        picture.words.append(word)


def _draw_strip(
    picture: TimelinePicture, view: TimelineRegion, row: HistoryRow, y: float, high: float
) -> None:
    colour = COLOURS[(KINDS[row.kind].number - 1) % len(COLOURS)]
    spans = row.spans
    x0, x1 = view.x(spans.starts), view.x(spans.ends)
    columns = {
        state: runs(x0[spans.states == state], x1[spans.states == state], view.width)
        for state in (IDLE, ACTIVE, INVALID, OFF)
    }
    middle = y + high / 2
    for a, b in zip(*columns[OFF], strict=True):
        for x in range(int(a) - int(a) % DOTS + DOTS, int(b), DOTS):
            picture.quads.append((x, middle - 1, min(x + DOT, b), middle + 1, FAINT))
    for a, b in zip(*columns[IDLE], strict=True):
        base = y if len(row.frames) else middle
        picture.lines.append((float(a), base, float(b), base, (*colour[:3], 0.45)))
    if len(row.frames):
        _draw_curve(picture, view, row, y, high, colour, columns[ACTIVE])
    else:
        for a, b in zip(*columns[ACTIVE], strict=True):
            picture.quads.append((float(a), y, float(b), y + high, colour))
    for a, b in zip(*columns[INVALID], strict=True):
        _draw_hatch(picture, float(a), y, float(b), y + high, colour)


def _draw_curve(
    picture: TimelinePicture,
    view: TimelineRegion,
    row: HistoryRow,
    y: float,
    high: float,
    colour: Colour,
    active: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> None:
    """Draw the greatest value in each column of pixels, filled where the sensor is active.

    `y` is the lower edge of the row, and `high` its height.
    """
    columns = np.arange(view.width + 1, dtype=np.float64)
    frames = view.left + columns / view.width * (view.right - view.left)
    # A value holds until the next one. A column shows the greatest of the value at its left edge
    # and of all values within it.
    at = np.searchsorted(row.frames, frames, side="right") - 1
    lo, hi = np.maximum(at[:-1], 0), np.maximum(at[1:], 0)
    padded = np.append(row.values, 0.0)
    bounds = np.stack([lo, hi + 1], axis=1).ravel()
    peaks = np.maximum.reduceat(padded, bounds)[::2]
    known = (at[1:] >= 0) & (frames[:-1] < row.spans.ends[-1])
    heights = np.clip(peaks / max(row.full, 1e-9), 0.0, 1.0) * high
    filled = np.zeros(view.width, bool)
    for a, b in zip(*active, strict=True):
        filled[a:b] = True
    heights[filled] = np.maximum(heights[filled], LEAST_AREA * high)
    heights = np.round(heights)
    change = np.flatnonzero(
        (heights[1:] != heights[:-1]) | (filled[1:] != filled[:-1]) | (known[1:] != known[:-1])
    )
    starts = np.concatenate([[0], change + 1])
    ends = np.append(starts[1:], view.width)
    last: float | None = None
    for a, b in zip(starts.tolist(), ends.tolist(), strict=True):
        if not known[a]:
            last = None
            continue
        level = y + float(heights[a])
        if filled[a]:
            picture.quads.append((a, y, b, level, colour))
        elif level > y:
            picture.lines.append((a, level, b, level, colour))
        if last is not None and not filled[a] and last != level:
            picture.lines.append((a, last, a, level, colour))
        last = level


def _draw_hatch(
    picture: TimelinePicture, x0: float, y0: float, x1: float, y1: float, colour: Colour
) -> None:
    """Draw diagonal lines in a rectangle; in neighbouring rectangles they form one pattern."""
    high = y1 - y0
    begin = math.floor((x0 - high) / HATCH) * HATCH
    for c in range(int(begin), math.ceil(x1), HATCH):
        a, b = max(float(c), x0), min(c + high, x1)
        if b > a:
            picture.lines.append((a, y0 + a - c, b, y0 + b - c, colour))
    for y in (y0, y1):
        picture.lines.append((x0, y, x1, y, colour))
