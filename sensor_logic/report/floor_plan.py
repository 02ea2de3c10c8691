# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the plan of a storey: cut walls, furniture from above, sensors and the areas they cover."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..model import Array
from .facts import PlanShape, PlanStorey, SensorInPlan
from .sections import Line, joined, simplified
from .svg import coordinate, hue, mark, shown_number, spread, ticks

WIDTH = 880.0
LEFT, TOP, RIGHT, BOTTOM = 40.0, 8.0, 12.0, 62.0
TALLEST = 720.0
# In px: the tolerance for simplifying lines, and the size below which a shape is left out.
TOLERANCE, SMALLEST = 0.3, 3.0
# The most points of furniture in a plan; the smallest shapes are left out first.
MOST_POINTS = 15_000
# The order of painting: cut solids cover lower solids.
LAYERS = ("floor", "low", "solid", "moving", "wall")
# A viewing direction that is shorter than this, seen from above, is not drawn.
NO_BEARING = 0.15
MARK_SIZE = (22.0, 18.0)
# In m: the largest thickness of a wall, and the largest gap in its cut that is closed.
THIN_M, GAP_M = 0.7, 0.5
BEARING = 20.0


class Frame:
    """The transformation from positions in the plan (m, y upwards) to pixels in the drawing."""

    def __init__(self, view: Array) -> None:
        size = np.maximum(view[1] - view[0], 1e-6)
        self.view = view
        self.scale = float(min((WIDTH - LEFT - RIGHT) / size[0], TALLEST / size[1]))
        self.width, self.height = float(size[0]) * self.scale, float(size[1]) * self.scale
        self.left = LEFT + (WIDTH - LEFT - RIGHT - self.width) / 2
        self.bottom = TOP + self.height

    def px(self, points: Array) -> Array:
        """Return the positions in pixels (n, 2) of points (n, 2) in m.

        Points far outside the frame are moved nearer to it.
        """
        off = np.clip((points - self.view[0]) * self.scale, -1e4, 1e4)
        return np.stack([self.left + off[..., 0], self.bottom - off[..., 1]], axis=-1)


def floor_plan(
    storey: PlanStorey, numbers: Mapping[str, int], kinds: Mapping[str, str], name: str
) -> tuple[str, float]:
    """Return the drawing of a storey as SVG, and its height in px.

    `numbers` and `kinds` have the number and the kind of each sensor by its name. All ids in the
    SVG begin with `name`.
    """
    frame = Frame(storey.view)
    outline = (
        f'x="{coordinate(frame.left)}" y="{TOP:g}" width="{coordinate(frame.width)}" '
        f'height="{coordinate(frame.height)}"'
    )
    parts = [f'<defs><clipPath id="{name}-frame"><rect {outline}/></clipPath></defs>']
    parts += _axes(frame)
    parts.append(f'<g clip-path="url(#{name}-frame)">')
    parts += _shapes(frame, storey.shapes)
    parts.append('<g class="fields">')
    for placed in storey.sensors:
        parts += _fans(frame, placed, hue(kinds[placed.name]))
    parts.append("</g>")
    for placed in storey.sensors:
        parts += _lines(frame, placed, hue(kinds[placed.name]))
    parts.append("</g>")
    parts.append(f'<rect class="rule" {outline}/>')
    parts += _marks(frame, storey.sensors, numbers, kinds)
    parts.append(_scale_bar(frame))
    return "\n".join(parts), frame.bottom + BOTTOM


def _axes(frame: Frame) -> list[str]:
    """Return the SVG elements of the x and y axes, with ticks in metres."""
    parts = []
    low, high = frame.view
    for axis, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        for tick in [t for t in ticks(*ends, 10) if ends[0] <= t <= ends[1]]:
            at = frame.px(np.where(np.arange(2) == axis, tick, low))
            x, y = coordinate(float(at[0])), coordinate(float(at[1]))
            label = shown_number(tick)
            if axis == 0:
                top = coordinate(TOP)
                parts.append(f'<path class="grid" d="M{x} {top}V{coordinate(frame.bottom + 4)}"/>')
                y = coordinate(frame.bottom + 15)
                parts.append(f'<text class="small quiet mid" x="{x}" y="{y}">{label}</text>')
            else:
                right = coordinate(frame.left + frame.width)
                parts.append(
                    f'<path class="grid" d="M{coordinate(frame.left - 4)} {y}H{right}"/>'
                    f'<text class="small quiet end" x="{coordinate(frame.left - 7)}" '
                    f'y="{coordinate(float(at[1]) + 3.6)}">{label}</text>'
                )
    y = coordinate(frame.bottom + 30)
    right = coordinate(frame.left + frame.width)
    parts.append(f'<text class="small quiet end" x="{right}" y="{y}">x and y in m</text>')
    return parts


def _scale_bar(frame: Frame) -> str:
    """Return a scale bar in two halves, at least an eighth as long as the drawing is wide."""
    length = ticks(0.0, frame.width / frame.scale / 4, 2)[1]
    x, y, size = frame.left, frame.bottom + 40, length * frame.scale
    half = f"{coordinate(x + size / 2)}"
    return (
        f'<path class="scale" d="M{coordinate(x)} {y - 4:.1f}v8M{half} {y - 2.5:.1f}v5'
        f'M{coordinate(x + size)} {y - 4:.1f}v8M{coordinate(x)} {y:.1f}h{coordinate(size)}"/>'
        f'<text class="small" x="{coordinate(x + size + 8)}" y="{y + 4:.1f}">'
        f"{shown_number(length)} m</text>"
    )


def _shapes(frame: Frame, shapes: Sequence[PlanShape]) -> list[str]:
    drawn: list[tuple[int, float, float, int, str]] = []
    for shape in shapes:
        for style, lines in _styles(shape):
            path, points, size = _path(frame, lines)
            if path:
                layer = LAYERS.index(shape.role)
                path = f'<path class="{style}" d="{path}"/>'
                drawn.append((layer, shape.top, size, points, path))
    left_out = _smallest(drawn)
    drawn = [d for i, d in enumerate(drawn) if i not in left_out]
    drawn.sort(key=lambda d: (d[0], d[1], -d[2], d[4]))
    return [d[4] for d in drawn]


def _smallest(drawn: Sequence[tuple[int, float, float, int, str]]) -> set[int]:
    """Return the indices of the smallest shapes; without them at most MOST_POINTS points remain."""
    points, found = sum(d[3] for d in drawn), set()
    for i in sorted(range(len(drawn)), key=lambda i: (drawn[i][2], drawn[i][4])):
        if points <= MOST_POINTS:
            break
        found.add(i)
        points -= drawn[i][3]
    return found


def _styles(shape: PlanShape) -> list[tuple[str, Sequence[Line]]]:
    """Return pairs of a style and the lines that are drawn in it; only closed lines are filled."""
    if shape.role != "wall":
        closed = [line for line in shape.lines if line.closed]
        return [(shape.role, closed), ("hollow", [li for li in shape.lines if not li.closed])]
    lines = joined(list(shape.lines), GAP_M)
    closed = [line for line in lines if line.closed]
    style = "wall" if _is_thin(closed) else "hollow"
    return [(style, closed), ("hollow", [line for line in lines if not line.closed])]


def _is_thin(lines: Sequence[Line]) -> bool:
    """Return whether the outlines of a cut solid enclose something as thin as a wall."""
    # Not thin: the surface of a whole room or of a sky. Holes have a negative area.
    area = abs(sum(line.area for line in lines))
    return 2 * area <= THIN_M * sum(line.length for line in lines)


def _path(frame: Frame, lines: Sequence[Line]) -> tuple[str, int, float]:
    """Return the visible lines as an SVG path, the number of its points, and its size in px."""
    path, points, largest = [], 0, 0.0
    low = np.array([frame.left, TOP])
    high = np.array([frame.left + frame.width, frame.bottom])
    for line in lines:
        drawn = frame.px(line.points)
        least, most = drawn.min(axis=0), drawn.max(axis=0)
        size = float((most - least).max())
        if size < SMALLEST or (most < low).any() or (least > high).any():
            continue
        drawn = simplified(drawn, TOLERANCE, line.closed)
        largest = max(largest, size)
        points += len(drawn)
        path.append(polyline(drawn) + ("Z" if line.closed else ""))
    return "".join(path), points, largest


def polyline(points: Array) -> str:
    """Return the SVG path `M…L…` through points (n, 2), which are in px."""
    return "M" + "L".join(f"{coordinate(x)} {coordinate(y)}" for x, y in points.tolist())


def _fans(frame: Frame, placed: SensorInPlan, colour: int) -> list[str]:
    """Return the areas that a sensor's fans of rays cover, as polygons that can overlap."""
    parts = []
    origin = frame.px(placed.at[None])
    for i, ends in enumerate(placed.fans):
        drawn = simplified(frame.px(ends), TOLERANCE)
        path = polyline(np.concatenate([origin, drawn]))
        style = f"fan{colour}" if i else f"fan{colour} first"
        parts.append(f'<path class="{style}" d="{path}Z"/>')
    return parts


def _lines(frame: Frame, placed: SensorInPlan, colour: int) -> list[str]:
    """Return a sensor's beams and pad as SVG elements; without rays, its viewing direction."""
    parts = []
    origin = frame.px(placed.at[None])
    if placed.beams:
        path = "".join(polyline(frame.px(beam)) for beam in placed.beams)
        parts.append(f'<path class="beam{colour}" d="{path}"/>')
    if not placed.fans and not placed.beams and np.hypot(*placed.looks) > NO_BEARING:
        tip = origin[0] + placed.looks * np.array([1.0, -1.0]) * BEARING
        path = polyline(np.stack([origin[0], tip]))
        parts.append(f'<path class="beam{colour}" d="{path}"/>')
    if placed.pad is not None:
        parts.append(f'<path class="pad{colour}" d="{polyline(frame.px(placed.pad))}Z"/>')
    return parts


def _marks(
    frame: Frame,
    sensors: Sequence[SensorInPlan],
    numbers: Mapping[str, int],
    kinds: Mapping[str, str],
) -> list[str]:
    """Return the numbered marks as SVG, with a line from a displaced mark to its sensor."""
    if not sensors:
        return []
    shown = sorted(sensors, key=lambda placed: numbers[placed.name])
    places = frame.px(np.stack([placed.at for placed in shown]))
    box = (frame.left, TOP, frame.left + frame.width, frame.bottom)
    spots = spread(places, MARK_SIZE, box)
    lines, marks = [], []
    for placed, place, spot in zip(shown, places, spots, strict=True):
        kind, number = kinds[placed.name], numbers[placed.name]
        x, y = float(place[0]), float(place[1])
        if math.hypot(*(spot - place).tolist()) > 1.0:
            lines.append(
                f'<path class="lead" d="{polyline(np.stack([place, spot]))}"/>'
                f'<circle class="fill{hue(kind)}" cx="{coordinate(x)}" cy="{coordinate(y)}" '
                f'r="2.2"/>'
            )
        about = f"{number} {placed.name}, {placed.height:.2f} m above the floor"
        marks.append(mark(kind, float(spot[0]), float(spot[1]), str(number), about))
    return lines + marks
