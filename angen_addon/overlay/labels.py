# SPDX-License-Identifier: GPL-3.0-or-later
"""Signs, names and readings beside the sensors, on the screen."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...panels.readings import UNKNOWN, Shown
from .looks import LOOKS, disc

# Pixels at a scale of 1.
SIGN, FONT, GAP, PADDING = 5.0, 11.0, 6.0, 3.0
# Farther away than this many pixels a metre, a sensor has a sign only.
LEAST_PIXELS_A_METRE = 22.0
# Of the dark disc behind a sign, in radii of the sign.
BACK = 1.7
PLATE = (0.06, 0.07, 0.08, 0.72)
LEADER = (0.75, 0.75, 0.75, 0.6)
NAME = (0.95, 0.95, 0.95, 1.0)
TEXT_SIZE_FONT = 0


def to_screen(
    points: NDArray[np.float64], matrix: NDArray[np.float64], width: int, height: int
) -> NDArray[np.float64]:
    """Pixels (n, 2) of points (n, 3) seen through a 4 × 4 matrix; NaN behind the eye."""
    clip = np.c_[points, np.ones(len(points))] @ matrix.T
    depth = np.where(clip[:, 3] > 1e-6, clip[:, 3], np.nan)
    return (clip[:, :2] / depth[:, None] + 1.0) / 2.0 * (width, height)


def place(wanted: NDArray[np.float64], sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lower left corners (n, 2) for plates of these sizes (n, 2), the highest first: each where it
    is wanted or, if others are there, below them."""
    placed: list[tuple[float, float, float, float]] = []
    found = np.array(wanted, np.float64)
    for index in np.argsort(-found[:, 1], kind="stable").tolist():
        (x, y), (width, height) = found[index].tolist(), sizes[index].tolist()
        # From the top downwards, so that one pass is enough.
        for left, low, right, high in placed:
            if left < x + width and x < right and low < y + height and y < high:
                y = low - height
        found[index, 1] = y
        placed.append((x, y, x + width, y + height))
        placed.sort(key=_low_edge, reverse=True)
    return found


def _low_edge(plate: tuple[float, float, float, float]) -> float:
    return plate[1]


def draw(context: Any, field: Any, states: list[Shown | None]) -> None:
    """Of every sensor that the view shows."""
    region, view = context.region, context.region_data
    chosen = [
        (seen, one)
        for seen, one in zip(field.seen, states, strict=True)
        if one is not None and seen.matrix is not None
    ]
    if not chosen:
        return
    where = np.array([seen.matrix.translation for seen, _ in chosen], np.float64)
    matrix = np.array(view.perspective_matrix, np.float64)
    up = np.array(view.view_matrix, np.float64)[1, :3] / field.metres
    at = to_screen(where, matrix, region.width, region.height)
    scale = np.linalg.norm(to_screen(where + up, matrix, region.width, region.height) - at, axis=1)
    inside = (at > 0.0) & (at < (region.width, region.height))
    near = [
        (seen, one, at[n], bool(scale[n] >= LEAST_PIXELS_A_METRE) or seen.selected)
        for n, (seen, one) in enumerate(chosen)
        if inside[n].all()
    ]
    if near:
        _draw(context, near)


def _draw(context: Any, near: list[tuple[Any, Shown, Any, bool]]) -> None:
    import blf
    import gpu

    scale = context.preferences.system.ui_scale
    settings = context.scene.angen_overlay
    blf.size(TEXT_SIZE_FONT, FONT * scale)
    blf.disable(TEXT_SIZE_FONT, blf.SHADOW)
    height = FONT * scale + 2 * PADDING * scale
    texts = []
    for seen, one, at, close in near:
        name = seen.sensor.name if settings.names and close else ""
        value = _reading(seen, one) if settings.values and close else ""
        widths = [_width(text, FONT * scale) for text in (name, value)]
        texts.append((at, name, value, widths))
    gap, sign = GAP * scale, SIGN * scale
    corners = np.array([at + (sign + gap / 2, sign) for at, *_ in texts])
    sizes = np.array(
        [
            (sum(w) + (gap if n and v else 0.0) + 2 * PADDING * scale if n or v else 0.0, height)
            for _, n, v, w in texts
        ]
    )
    shown = [n for n, size in enumerate(sizes) if size[0] > 0.0]
    wanted = corners.copy()
    corners[shown] = place(corners[shown], sizes[shown])
    signs = [(one.icon, at) for _, one, at, _ in near]
    gpu.state.blend_set("ALPHA")
    # A plate that had to give way is joined to its sign.
    strayed = [n for n in shown if wanted[n, 1] - corners[n, 1] > sizes[n, 1] / 2]
    _leaders([(texts[n][0], corners[n] + (0.0, sizes[n, 1] / 2)) for n in strayed])
    _plates([(corners[n], sizes[n]) for n in shown])
    _signs(signs, sign)
    gpu.state.blend_set("NONE")
    for n in shown:
        _, name, value, widths = texts[n]
        look, base = LOOKS[near[n][1].icon], corners[n] + (PADDING * scale, 1.35 * PADDING * scale)
        if name:
            _write(base, name, NAME)
        if value:
            _write(base + ((widths[0] + gap if name else 0.0), 0.0), value, (*look.colour, 1.0))


def _reading(seen: Any, one: Shown) -> str:
    """In full for what is selected; of a sensor without a reading the sign tells enough."""
    if one.icon == UNKNOWN:
        return ""
    return one.text if seen.selected else one.short


@lru_cache(maxsize=1024)
def _width(text: str, size: float) -> float:
    """Pixels of a text in the font of this size, which is chosen."""
    import blf

    return float(blf.dimensions(TEXT_SIZE_FONT, text)[0]) if text else 0.0


def _write(at: Any, text: str, colour: tuple[float, ...]) -> None:
    import blf

    blf.color(TEXT_SIZE_FONT, *colour)
    blf.position(TEXT_SIZE_FONT, float(at[0]), float(at[1]), 0.0)
    blf.draw(TEXT_SIZE_FONT, text)


def _leaders(lines: list[tuple[Any, Any]]) -> None:
    if lines:
        points = np.array(lines, np.float32).reshape(-1, 2)
        _fill(points, np.broadcast_to(np.array(LEADER, np.float32), (len(points), 4)), "LINES")


def _plates(plates: list[tuple[Any, Any]]) -> None:
    if not plates:
        return
    lower = np.array([corner for corner, _ in plates], np.float32)
    upper = lower + np.array([size for _, size in plates], np.float32)
    x0, y0, x1, y1 = lower[:, 0], lower[:, 1], upper[:, 0], upper[:, 1]
    corners = np.stack([x0, y0, x1, y0, x1, y1, x0, y0, x1, y1, x0, y1], axis=1).reshape(-1, 2)
    _fill(corners, np.broadcast_to(np.array(PLATE, np.float32), (len(corners), 4)))


def _signs(signs: list[tuple[str, Any]], size: float) -> None:
    """Each sign, by its icon, on a dark disc, so that it stands out from what is behind it."""
    shapes = [_shape(icon) for icon, _ in signs]
    places = np.array([at for _, at in signs], np.float32)
    for number, kind in ((0, "TRIS"), (2, "LINES")):
        counts = [len(shape[number]) for shape in shapes]
        points = np.concatenate([shape[number] for shape in shapes])
        points = points * np.float32(size) + np.repeat(places, counts, axis=0)
        _fill(points, np.concatenate([shape[number + 1] for shape in shapes]), kind)


@lru_cache
def _shape(icon: str) -> tuple[Any, Any, Any, Any]:
    """Corners (n, 2) of a sign's triangles with their colours (n, 4), and those of its lines."""
    look = LOOKS[icon]
    colour = np.array([*look.colour, 1.0], np.float32)
    back, front = disc().reshape(-1, 2) * np.float32(BACK), look.faces.reshape(-1, 2)
    lines = look.lines.reshape(-1, 2)
    dark = np.tile(np.array(PLATE, np.float32), (len(back), 1))
    faces = np.concatenate([back, front])
    colours = np.concatenate([dark, np.tile(colour, (len(front), 1))])
    return faces, colours, lines, np.tile(colour, (len(lines), 1))


def _fill(points: Any, colours: Any, kind: str = "TRIS") -> None:
    import bpy
    import gpu

    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type="F32", len=3, fetch_mode="FLOAT")
    layout.attr_add(id="color", comp_type="F32", len=4, fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(points))
    flat = np.zeros((len(points), 3), np.float32)
    flat[:, :2] = points
    buffer.attr_fill("pos", flat)
    buffer.attr_fill("color", np.ascontiguousarray(colours, np.float32))
    batch = gpu.types.GPUBatch(type=kind, buf=buffer)
    if kind == "TRIS":
        batch.draw(gpu.shader.from_builtin("SMOOTH_COLOR"))
        return
    shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", 1.6 * bpy.context.preferences.system.ui_scale)
    batch.draw(shader)
