# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the signs of sensors on the screen, and names and readings where there is room."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.logs.wording import NOTHING
from ...appearance.reading_text import ACTIVE, IDLE, UNKNOWN, ReadingText
from ..gizmos import pixels_of_handles
from .picture import LOOKS, DrawnSensors, SensorRow, disc

# A point in pixels.
Point = tuple[float, float]
# Left, low, right and high, in pixels.
Rect = tuple[float, float, float, float]

# A label is at least this many times as far from other signs as from its own.
APART = 2.0
# The signs of wanted labels have a ring, so that these labels are this many times as far away.
BESIDE_RING = 1.5
# Directions (sideways, upwards) from a marker to its label, in the order in which they are tried.
SIDES = ((1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1), (0, -1))
DIAGONAL = 0.7


def arrange(
    markers: Sequence[Point],
    sizes: Sequence[Point],
    order: Iterable[int],
    wanted: frozenset[int],
    free: Rect,
    covered: Sequence[Rect],
    off: float,
    first: frozenset[int] = frozenset(),
) -> dict[int, Rect]:
    """Find positions for labels beside their markers, so that one sees which belong together.

    A marker is the point of a sensor's sign. A label lies within `free`. It covers nothing in
    `covered` and no other label, and is not near the marker of another label.

    Parameters
    ----------
    markers
        The markers (2,) in pixels.
    sizes
        Width and height (2,) of the label of each marker, in pixels.
    order
        The numbers of the markers that may have a label, in the order in which labels are placed.
    wanted
        The numbers of the labels to place before all others. They may overlap other labels, and
        where nothing else is free what is `covered` too.
    free
        The part of the region for labels.
    covered
        The parts of the region that other things cover.
    off
        The distance between a marker and its label, in pixels. A `wanted` label is `BESIDE_RING`
        times as far away.
    first
        The numbers of the labels to place after the `wanted` ones and before the rest. They may be
        near other markers.

    Returns
    -------
    dict of int to Rect
        The rectangles of the labels that fit, by number of the marker.
    """
    placed: dict[int, Rect] = {}
    points = np.array(markers, np.float64).reshape(-1, 2)
    turns = list(order)
    for number in sorted(turns, key=lambda n: 0 if n in wanted else 1 if n in first else 2):
        taken = [*covered, *placed.values()]
        away = off * BESIDE_RING if number in wanted else off
        plates = _plates_beside(markers[number], sizes[number], away)
        inside = [plate for plate in plates if _contains(free, plate)]
        found = [p for p in inside if not any(_overlaps(p, other) for other in taken)]
        if number in wanted:
            # The handles of a small sensor can be all around its sign.
            over = {p: sum(_overlaps(p, one) for one in covered) for p in inside}
            found = found or [p for p in inside if over[p] == min(over.values())]
        counts = _count_other_markers(found, points, number, APART * off)
        best = min(range(len(found)), key=counts.__getitem__, default=None)
        if best is not None and (number in wanted | first or not counts[best]):
            placed[number] = found[best]
    return placed


def _count_other_markers(
    plates: list[Rect], points: NDArray[np.float64], own: int, distance: float
) -> list[int]:
    """Return for each label how many markers, except the one `own`, are nearer than `distance`.

    `points` (n, 2) are the markers, and `plates` the rectangles of labels, all in pixels.
    """
    if not plates:
        return []
    edges = np.array(plates)[:, None]
    away = np.maximum(np.maximum(edges[..., :2] - points, points - edges[..., 2:]), 0.0)
    near = (away * away).sum(axis=2) < distance * distance
    near[:, own] = False
    counts: list[int] = near.sum(axis=1).tolist()
    return counts


def _plates_beside(marker: Point, size: Point, off: float) -> list[Rect]:
    """Return the possible rectangles of a label at distance `off` from its marker."""
    (x, y), (width, height) = marker, size
    found = []
    for aside, up in SIDES:
        away = off * DIAGONAL if aside and up else off
        left = x - width / 2 if not aside else x + away if aside > 0 else x - away - width
        low = y - height / 2 if not up else y + away if up > 0 else y - away - height
        found.append((left, low, left + width, low + height))
    return found


def _contains(free: Rect, plate: Rect) -> bool:
    return (
        free[0] <= plate[0] and free[1] <= plate[1] and plate[2] <= free[2] and plate[3] <= free[3]
    )


def _overlaps(one: Rect, two: Rect) -> bool:
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


def _near(plate: Rect, point: Point, distance: float) -> bool:
    """Return whether a point is less than `distance` pixels away from the label `plate`."""
    x = max(plate[0] - point[0], 0.0, point[0] - plate[2])
    y = max(plate[1] - point[1], 0.0, point[1] - plate[3])
    return x * x + y * y < distance * distance


# Pixels at an interface scale of 1: the margin around the axes that turn the view, the buttons
# below them, and Blender's texts at the upper left.
ROUND_AXES, AXES_ONLY, BUTTON, BUTTONS = 26.0, 60.0, 34.0, 4
TEXT_WIDTH, TEXT_HEIGHT, STATISTICS = 230.0, 46.0, 150.0


def covered_rects(area: Any, region: Any, space: Any, preferences: Any) -> list[Rect]:
    """Return the rectangles of a 3D view's main region that Blender's interface covers."""
    scale = preferences.system.ui_scale
    found = [rect for other in area.regions if (rect := _overlap_with(other, region)) is not None]
    left, right, top = 0.0, float(region.width), float(region.height)
    for rect in found:
        if rect[2] - rect[0] > 0.6 * region.width:
            top = min(top, rect[1]) if rect[1] > region.height / 2 else top
        elif rect[0] <= 0.0:
            left = max(left, rect[2])
        elif rect[2] >= region.width:
            right = min(right, rect[0])
    if space.show_gizmo and space.show_gizmo_navigate:
        found += _navigation_rects(right, top, preferences.view, scale)
    if space.overlay.show_overlays and space.overlay.show_text:
        height = TEXT_HEIGHT + (STATISTICS if space.overlay.show_stats else 0.0)
        found.append((left, top - height * scale, left + TEXT_WIDTH * scale, top))
    return found


def _overlap_with(other: Any, region: Any) -> Rect | None:
    """Return the rectangle in which another region overlaps this one; None without overlap."""
    if other.type == "WINDOW" or other.width <= 1 or other.height <= 1:
        return None
    left, low = float(other.x - region.x), float(other.y - region.y)
    right, high = left + other.width, low + other.height
    if right <= 0.0 or high <= 0.0 or left >= region.width or low >= region.height:
        return None
    return left, low, right, high


def _navigation_rects(right: float, top: float, view: Any, scale: float) -> list[Rect]:
    """Return the rectangles of Blender's navigation axes and of the buttons below them."""
    size = AXES_ONLY
    if view.mini_axis_type == "GIZMO":
        size = view.gizmo_size_navigate_v3d + ROUND_AXES
    size *= scale
    low = top - size
    found = [(right - size, low, right, top)]
    if view.show_navigate_ui:
        found.append((right - BUTTON * 1.4 * scale, low - BUTTONS * BUTTON * scale, right, low))
    return found


# Pixels at an interface scale of 1. HANDLE is half of the room for a handle.
HANDLE = 12.0
SIGN, FONT, GAP, PADDING = 5.0, 11.0, 6.0, 3.0
# A sensor has no label if it is so far away that a metre there is shorter than this (pixels).
LEAST_PIXELS_A_METRE = 22.0
# Radius of the dark disc behind a sign, in radii of the sign.
BACK = 1.7
# Radius of the ring around a selected or hovered sign, in radii of the sign.
RING = 2.1
# At most this many sensors have labels: those nearest to the viewer.
MOST_LABELS = 100
PLATE = (0.06, 0.07, 0.08, 0.72)
NAME = (0.95, 0.95, 0.95, 1.0)
NAME_COLOUR, PLATE_COLOUR = np.array(NAME, np.float32), np.array(PLATE, np.float32)
NO_CORNERS, NO_COLOURS = np.empty((0, 2), np.float32), np.empty((0, 4), np.float32)
TEXT_SIZE_FONT = 0


class Word(NamedTuple):
    """A text with its position in pixels and its colour."""

    x: float
    y: float
    text: str
    colour: tuple[float, ...]


class RegionLabels:
    """The signs and labels of one region, kept from redraw to redraw.

    Attributes
    ----------
    markers, plates
        The points of signs and the rectangles of labels, by uid of the sensor.
    rooms
        The largest rectangle available for each label, by row. A label can be narrower.
    words, batches
        The texts, and the GPU batches of signs and labels.
    projected
        The last view and matrices that were projected, and the resulting pixels.
    places
        The markers, sizes, wanted labels and covered parts from which `rooms` was computed.
    widths, first
        The widths of the labels and the active sensors from which `rooms` was computed.
    picture
        The input from which `words` and `batches` were made.
    """

    def __init__(self) -> None:
        self.projected: tuple[Any, Any] = None, None
        self.places: Any = None
        self.picture: Any = None
        self.markers: dict[int, Point] = {}
        self.plates: dict[int, Rect] = {}
        self.widths: list[float] = []
        self.first: frozenset[int] = frozenset()
        self.rooms: dict[int, Rect] = {}
        self.words: list[Word] = []
        self.batches: list[tuple[str, Any]] = []


def sign_at(board: RegionLabels, place: Point, reach: float) -> int | None:
    """Return the uid of the sensor whose sign is nearest to `place` and within `reach` pixels.

    If no sign is within reach, return the uid of the sensor whose label is at `place`, or None.
    `board` has the signs and labels of the region.
    """
    found = nearest(board.markers, place, reach)
    if found is not None:
        return found
    return next((uid for uid, plate in board.plates.items() if _near(plate, place, 1.0)), None)


def nearest(markers: dict[int, Point], place: Any, reach: float) -> int | None:
    """Return the uid whose marker is nearest to `place` and within `reach` pixels, or None."""
    apart = {uid: (x - place[0]) ** 2 + (y - place[1]) ** 2 for uid, (x, y) in markers.items()}
    uid = min(apart, key=lambda u: apart[u], default=None)
    return uid if uid is not None and apart[uid] < reach * reach else None


def to_screen(
    points: NDArray[np.float64], matrix: NDArray[np.float64], width: int, height: int
) -> NDArray[np.float64]:
    """Project points to pixels.

    Parameters
    ----------
    points
        Points (n, 3) in the world, in Blender units.
    matrix
        The perspective matrix (4, 4) of the view.
    width, height
        Size of the region in pixels.

    Returns
    -------
    (n, 2) array
        Pixels; NaN for points behind the viewer.
    """
    clip = np.c_[points, np.ones(len(points))] @ matrix.T
    depth = np.where(clip[:, 3] > 1e-6, clip[:, 3], np.nan)
    return (clip[:, :2] / depth[:, None] + 1.0) / 2.0 * (width, height)


def draw(context: Any, drawn: DrawnSensors, shown: list[SensorRow]) -> None:
    """Draw the signs and labels of all sensors that the view shows.

    `drawn` are all drawn sensors of the scene. `shown` are the sensors of this view with their
    readings.
    """
    board = drawn.boards.setdefault(context.region.as_pointer(), RegionLabels())
    rows, markers, sizes = _visible_rows(context, board, drawn, shown)
    board.markers = {row.seen.uid: m for row, m in zip(rows, markers, strict=True)}
    wanted = frozenset(
        n for n, row in enumerate(rows) if row.selected or row.seen.uid == drawn.hovered
    )
    texts = [
        _texts(context, row.seen.sensor.name, row.shown, n in wanted) for n, row in enumerate(rows)
    ]
    widths = [_plate_width(context, words) for words in texts]
    active = frozenset(n for n, row in enumerate(rows) if row.shown.icon == ACTIVE)
    _place_labels(context, board, markers, sizes, widths, wanted, active)
    picture = board.places, board.widths, texts, [row.shown.icon for row in rows]
    if picture != board.picture:
        board.picture = picture
        plates = {n: _plate(room, markers[n], widths[n]) for n, room in board.rooms.items()}
        board.words = [
            word
            for n, plate in plates.items()
            for word in _words(context, plate, texts[n], rows[n].shown)
        ]
        board.plates = {rows[n].seen.uid: plate for n, plate in plates.items()}
        marked = [markers[n] for n in plates if n in wanted]
        sign = SIGN * context.preferences.system.ui_scale
        board.batches = _batches(list(plates.values()), rows, markers, marked, sign)
    _draw(context, board)


def _visible_rows(
    context: Any, board: RegionLabels, drawn: DrawnSensors, shown: list[SensorRow]
) -> tuple[list[SensorRow], list[Point], list[float]]:
    """Return the sensors in the region, the pixels of their signs, and the pixels of a metre.

    The length of a metre is measured at the depth of each sensor.
    """
    region, view = context.region, context.region_data
    rows = [row for row in shown if row.seen.matrix is not None]
    window = region.width, region.height
    key = view.perspective_matrix.copy(), window, drawn.metres, [row.seen.matrix for row in rows]
    if board.projected[0] != key:
        where = np.array([row.seen.matrix.translation for row in rows], np.float64).reshape(-1, 3)
        matrix = np.array(view.perspective_matrix, np.float64)
        up = np.array(view.view_matrix, np.float64)[1, :3] / drawn.metres
        both = to_screen(np.concatenate([where, where + up]), matrix, *window)
        at, above = both[: len(rows)], both[len(rows) :]
        size = np.linalg.norm(above - at, axis=1)
        inside = np.flatnonzero(((at > 0.0) & (at < window)).all(axis=1))
        markers: list[Point] = [(x, y) for x, y in at[inside].tolist()]
        board.projected = key, (inside.tolist(), markers, size[inside].tolist())
    inside, markers, sizes = board.projected[1]
    return [rows[n] for n in inside], markers, sizes


def _place_labels(
    context: Any,
    board: RegionLabels,
    markers: list[Point],
    near: list[float],
    widths: list[float],
    wanted: frozenset[int],
    active: frozenset[int],
) -> None:
    """Compute the rectangles for labels (`board.rooms`), unless the present ones can be kept.

    Parameters
    ----------
    board
        The labels of the region.
    markers
        The signs in pixels, one for each row. The other lists have the same order.
    near
        The length of a metre at each sign, in pixels: greater for near sensors.
    widths
        The width of each label in pixels; 0 without a text.
    wanted, active
        The rows of selected and hovered sensors, and of active sensors.
    """
    region, scale = context.region, context.preferences.system.ui_scale
    hidden = covered_rects(context.area, region, context.space_data, context.preferences)
    size = HANDLE * scale
    for x, y in pixels_of_handles(context):
        hidden.append((x - size, y - size, x + size, y + size))
    has_text = [wide > 0.0 for wide in widths]
    places = markers, near, has_text, wanted, hidden, region.width, region.height
    if places == board.places:
        # Rectangles are kept while only numbers change, so that labels do not jump.
        is_served = active == board.first or active <= board.rooms.keys()
        if is_served and all(w <= room for w, room in zip(widths, board.widths, strict=True)):
            return
        widths = [max(pair) for pair in zip(widths, board.widths, strict=True)]
    board.places, board.widths, board.first = places, widths, active
    height = (FONT + 2 * PADDING) * scale
    # Sensors near the viewer come first, and equally near ones in the order of the list.
    order = [
        n
        for n in sorted(range(len(near)), key=lambda n: -round(near[n], 3))
        if has_text[n] and (near[n] >= LEAST_PIXELS_A_METRE or n in wanted | active)
    ]
    most = set(sorted(order, key=lambda n: n not in wanted | active)[:MOST_LABELS])
    order = [n for n in order if n in most]
    window = (0.0, 0.0, float(region.width), float(region.height))
    off = (SIGN + GAP / 2) * scale
    sizes = [(wide, height) for wide in widths]
    board.rooms = arrange(markers, sizes, order, wanted, window, hidden, off)
    if any(has_text[n] and n not in board.rooms for n in active):
        board.rooms = arrange(markers, sizes, order, wanted, window, hidden, off, active)


def _plate(room: Rect, marker: Point, wide: float) -> Rect:
    """Return the rectangle of a label of width `wide`, within `room` and next to its marker."""
    left, low, right, high = room
    if right <= marker[0]:
        left = right - wide
    elif left < marker[0]:
        left = (left + right - wide) / 2
    return left, low, left + wide, high


def _texts(context: Any, name: str, reading: ReadingText, full: bool) -> tuple[str, str]:
    """Return the name and the reading to write in a label; an empty text for a part not shown."""
    settings = context.scene.angen_overlay
    is_nothing = reading.icon == UNKNOWN and reading.brief in ("", NOTHING)
    value = "" if is_nothing else reading.text if full else reading.short
    return name if settings.names else "", value if settings.values else ""


def _plate_width(context: Any, texts: tuple[str, str]) -> float:
    if not any(texts):
        return 0.0
    scale = context.preferences.system.ui_scale
    name, value = (_text_width(context, text) for text in texts)
    return name + value + (GAP * scale if all(texts) else 0.0) + 2 * PADDING * scale


def _words(context: Any, plate: Rect, texts: tuple[str, str], one: ReadingText) -> list[Word]:
    scale = context.preferences.system.ui_scale
    x, y = plate[0] + PADDING * scale, plate[1] + 1.35 * PADDING * scale
    found = []
    if texts[0]:
        found.append(Word(x, y, texts[0], NAME))
        x += _text_width(context, texts[0]) + GAP * scale
    if texts[1]:
        found.append(Word(x, y, texts[1], (*LOOKS[one.icon].colour, 1.0)))
    return found


def _text_width(context: Any, text: str) -> float:
    """Return the width of a text of a label in pixels."""
    preferences = context.preferences
    scale, font = preferences.system.ui_scale, preferences.view.font_path_ui
    return _measured_width(text, FONT * scale, font) if text else 0.0


# Each redraw takes 20 µs longer for each label without the cache.
@lru_cache(maxsize=1024)
def _measured_width(text: str, size: float, _font: str) -> float:
    import blf

    blf.size(TEXT_SIZE_FONT, size)
    return float(blf.dimensions(TEXT_SIZE_FONT, text)[0])


def _draw(context: Any, board: RegionLabels) -> None:
    import blf
    import gpu

    scale = context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    for kind, batch in board.batches:
        if kind == "TRIS":
            batch.draw(gpu.shader.from_builtin("SMOOTH_COLOR"))
        else:
            shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            shader.uniform_float("lineWidth", 1.6 * scale)
            batch.draw(shader)
    gpu.state.blend_set("NONE")
    blf.size(TEXT_SIZE_FONT, FONT * scale)
    blf.disable(TEXT_SIZE_FONT, blf.SHADOW)
    for word in board.words:
        blf.color(TEXT_SIZE_FONT, *word.colour)
        blf.position(TEXT_SIZE_FONT, word.x, word.y, 0.0)
        blf.draw(TEXT_SIZE_FONT, word.text)


def _batches(
    plates: list[Rect],
    rows: list[SensorRow],
    markers: list[Point],
    marked: list[Point],
    sign: float,
) -> list[tuple[str, Any]]:
    """Return the type and the GPU batch of all signs with their rings, and then of labels.

    `marked` are the markers with a ring. `sign` is the radius of a sign in pixels.
    """
    shapes = [_shape(row.shown.icon) for row in rows]
    ring = LOOKS[IDLE].lines.reshape(-1, 2) * np.float32(RING)
    shapes += [(NO_CORNERS, NO_COLOURS, ring, np.tile(NAME_COLOUR, (len(ring), 1)))] * len(marked)
    places = np.array([*markers, *marked], np.float32).reshape(-1, 2)
    found = []
    for kind, points, colours in (("TRIS", 0, 1), ("LINES", 2, 3)):
        corners = [NO_CORNERS, *(shape[points] for shape in shapes)]
        counts = [len(part) for part in corners[1:]]
        at = np.concatenate(corners) * np.float32(sign) + np.repeat(places, counts, axis=0)
        coloured = np.concatenate([NO_COLOURS, *(shape[colours] for shape in shapes)])
        if len(at):
            found.append((kind, _batch(at, coloured, kind)))
    if plates:
        # Above all signs: a sign of another sensor would make the text hard to read.
        ground = np.tile(PLATE_COLOUR, (6 * len(plates), 1))
        found.append(("TRIS", _batch(_quads(plates), ground, "TRIS")))
    return found


def _quads(plates: list[Rect]) -> Any:
    x0, y0, x1, y1 = np.array(plates, np.float32).T
    return np.stack([x0, y0, x1, y0, x1, y1, x0, y0, x1, y1, x0, y1], axis=1).reshape(-1, 2)


# Each redraw takes 30 µs longer for each label without the cache.
@lru_cache
def _shape(icon: str) -> tuple[Any, Any, Any, Any]:
    """Return corners (n, 2) and colours (n, 4) of a sign's triangles, then of its lines."""
    look = LOOKS[icon]
    colour = np.array([*look.colour, 1.0], np.float32)
    back, front = disc().reshape(-1, 2) * np.float32(BACK), look.faces.reshape(-1, 2)
    lines = look.lines.reshape(-1, 2)
    dark = np.tile(PLATE_COLOUR, (len(back), 1))
    faces = np.concatenate([back, front])
    colours = np.concatenate([dark, np.tile(colour, (len(front), 1))])
    return faces, colours, lines, np.tile(colour, (len(lines), 1))


def _batch(points: Any, colours: Any, kind: str) -> Any:
    import gpu

    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type="F32", len=3, fetch_mode="FLOAT")
    layout.attr_add(id="color", comp_type="F32", len=4, fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(points))
    flat = np.zeros((len(points), 3), np.float32)
    flat[:, :2] = points
    buffer.attr_fill("pos", flat)
    buffer.attr_fill("color", np.ascontiguousarray(colours, np.float32))
    return gpu.types.GPUBatch(type=kind, buf=buffer)
