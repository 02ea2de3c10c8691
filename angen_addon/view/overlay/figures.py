# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines and surfaces in the world, in Blender units, of what a sensor sees: what all kinds share.

What each part means is named by kinds; how it looks is decided in picture.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from ...runtime.trace import CAST, RaysMet

Lines = NDArray[np.float32]
# m: lines on a surface stand this far before it, so that it does not hide them.
OFF_SURFACE = 0.01
# m: half of the cross that stands for a sensor without rays.
CROSS = 0.05
# Points this near to the way between their neighbours are left out, as on a flat wall: as a share
# of that way; and as far as ranges are exact, m.
STRAIGHT, EXACT = 2e-4, 2e-5
# Of a zone: rays that miss their plane by more than this share of their range met no plane; so
# many rays are beside an edge.
FLAT, BESIDE = 0.03, 3
DASHES = 9
DASHES_AT = np.linspace(0.0, 1.0, 2 * DASHES)[:, None]
ROUND = 24
# Of a picture, in turn.
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclass(eq=False)
class Figure:
    """`lines`: by their meaning, (n, 2, 3); `fills`: triangles by theirs, (n, 3, 3)."""

    lines: dict[str, Lines] = field(default_factory=dict)
    fills: dict[str, Lines] = field(default_factory=dict)
    # By how it looked last, the parts that picture.py made of it.
    pictured: Any = None

    def add(self, meaning: str, *parts: Any) -> None:
        """More lines, each part (…, 2, 3)."""
        _append(self.lines, meaning, [np.asarray(part).reshape(-1, 2, 3) for part in parts])

    def fill(self, meaning: str, *parts: Any) -> None:
        """More triangles, each part (…, 3, 3)."""
        _append(self.fills, meaning, [np.asarray(part).reshape(-1, 3, 3) for part in parts])


def _append(into: dict[str, Lines], meaning: str, parts: list[Any]) -> None:
    known = [into[meaning]] if meaning in into else []
    into[meaning] = np.concatenate(known + parts).astype(np.float32)


def ends_of(met: RaysMet, metres: float, rows: int = 1) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The starts and ends of rays in so many equal rows, (rows, n, 3) in Blender units, and which
    of them met something, (rows, n)."""
    hit = met.ranges < met.reach
    off = np.minimum(OFF_SURFACE, met.ranges / 2) * hit
    ends = met.origins + met.directions * (met.ranges - off)[:, None]
    starts = met.origins.reshape(rows, -1, 3) / metres
    return starts, ends.reshape(rows, -1, 3) / metres, hit.reshape(rows, -1)


def corners_of(
    met: RaysMet, apex: Array, edges: Array, metres: float, farthest: float = math.inf
) -> Array:
    """Where pyramids from an apex (3,) in m end, (z, c, 3) in Blender units, at most `farthest` m
    away: unit vectors `edges` (z, c, 3), as far as the plane that the rays within met, as many in
    each, pyramid after pyramid. Where they met no plane, each edge ends with the nearest hit of the
    rays beside it, so that none goes through a wall."""
    count = len(edges)
    ends = (met.origins + met.directions * met.ranges[:, None] - apex).reshape(count, -1, 3)
    ranges = np.maximum(np.linalg.norm(ends, axis=-1), 1e-9)
    ways = ends / ranges[..., None]
    hit = ((met.ranges < met.reach).reshape(count, -1) & (ranges < farthest)).any(axis=1)
    ranges = np.minimum(ranges, farthest)
    # Along any way within the plane n·p = 1 one goes 1 / (n·way).
    near = 1.0 / ranges
    plane = np.linalg.pinv(ways, rcond=1e-6) @ near[..., None]
    least, most = ranges.min(axis=1, keepdims=True), ranges.max(axis=1, keepdims=True)
    far = 1.0 / np.clip((edges @ plane)[..., 0], 0.9 / most, 1.1 / least)
    bent = np.abs((ways @ plane)[..., 0] * ranges - 1.0).max(axis=1) > FLAT
    if bent.any():
        apart = -edges[bent] @ ways[bent].swapaxes(1, 2)
        beside = np.argsort(apart, axis=-1)[..., :BESIDE]
        far[bent] = np.take_along_axis(ranges[bent, None], beside, axis=-1).min(axis=-1)
    far = np.minimum(far, farthest)
    far -= np.minimum(OFF_SURFACE, far / 2) * hit[:, None]
    found: Array = apex + edges * far[..., None]
    return found / metres


def straight(
    points: Array, drawn: NDArray[np.bool_], metres: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which of the steps (rows, n − 1) between points (rows, n, 3) begin a straight line, and which
    end one; the drawn steps alone count."""
    way, middle = points[:, 2:] - points[:, :-2], points[:, 1:-1] - points[:, :-2]
    square = np.maximum((way * way).sum(axis=2), 1e-24)
    along = (middle * way).sum(axis=2)
    off = (middle * middle).sum(axis=2) - along * along / square
    near = np.maximum(STRAIGHT * np.sqrt(square), EXACT / metres)
    on = drawn[:, :-1] & drawn[:, 1:] & (off < near * near) & (along > 0.0)
    first, last = drawn.copy(), drawn.copy()
    first[:, 1:] &= ~on
    last[:, :-1] &= ~on
    return first, last


def plain_figure(seen: Any, metres: float) -> Figure:
    """A cross where a sensor stands that casts no rays."""
    figure = Figure()
    if not CAST & seen.sensor.kind.needs.keys():
        axes = seen.pose.axes.T * CROSS
        figure.add("axis", pairs(seen.pose.origin - axes, seen.pose.origin + axes) / metres)
    return figure


def beams(seen: Any, number: int, met: RaysMet, metres: float) -> Figure:
    """Each ray to where it ends."""
    figure = Figure()
    starts, ends, _ = ends_of(met, metres)
    figure.add("beam", pairs(starts, ends))
    return figure


def surface_outline(evaluated: Any, place: Any) -> Array:
    """Corners (4, 3) in the world of the upper side of an object's bounds, at a place."""
    corners = np.array(evaluated.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    upper = [(lo[0], lo[1]), (hi[0], lo[1]), (hi[0], hi[1]), (lo[0], hi[1])]
    local = np.array([(a, b, hi[2], 1.0) for a, b in upper])
    matrix = np.array(place, np.float64)
    return (local @ matrix.T)[:, :3]


def pairs(one: Any, two: Any) -> Array:
    return np.stack([one, two], axis=-2)


def triangles(one: Any, two: Any, three: Any) -> Array:
    return np.stack([one, two, three], axis=-2)


def dashes(one: Array, two: Array) -> Array:
    """(DASHES, 2, 3): the way from one point to another in dashes."""
    return (one + (two - one) * DASHES_AT).reshape(DASHES, 2, 3)


def circle(middle: Array, x: Array, y: Array, radius: float) -> Array:
    angles = np.arange(ROUND) * 2 * math.pi / ROUND
    return middle + radius * (np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y))
