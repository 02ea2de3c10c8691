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

Lines = NDArray[np.float32]
# m: lines on a surface stand this far before it, so that it does not hide them.
OFF_SURFACE = 0.01
# m: half of the cross that stands for a sensor without rays.
CROSS = 0.05
# Points this near to the way between their neighbours are left out, as on a flat wall: as a share
# of that way; and as far as ranges are exact, m.
STRAIGHT, EXACT = 2e-4, 2e-5
DASHES = 9
DASHES_AT = np.linspace(0.0, 1.0, 2 * DASHES)[:, None]
ROUND = 24
# Of a picture, in turn.
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclass
class Figure:
    """`lines`: by their meaning, (n, 2, 3); `fills`: triangles by theirs, (n, 3, 3); `drawn`: what
    the GPU was given of it, which only draw.py knows."""

    lines: dict[str, Lines] = field(default_factory=dict)
    fills: dict[str, Lines] = field(default_factory=dict)
    drawn: Any = field(default=None, compare=False)

    def add(self, meaning: str, *parts: Any) -> None:
        """More lines, each part (…, 2, 3)."""
        _append(self.lines, meaning, [np.asarray(part).reshape(-1, 2, 3) for part in parts])

    def fill(self, meaning: str, *parts: Any) -> None:
        """More triangles, each part (…, 3, 3)."""
        _append(self.fills, meaning, [np.asarray(part).reshape(-1, 3, 3) for part in parts])


def _append(into: dict[str, Lines], meaning: str, parts: list[Any]) -> None:
    known = [into[meaning]] if meaning in into else []
    into[meaning] = np.concatenate(known + parts).astype(np.float32)


def ends_of(
    seen: Any, metres: float, rows: Any = slice(None)
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Where the rays, or those of some rows, start and end, (rows, n, 3), and which of them met
    something, (rows, n)."""
    rays = seen.rays

    def of_rows(values: Array) -> Array:
        found: Array = values.reshape(rays.rows, -1, *values.shape[1:])[rows]
        return found

    starts, ranges = of_rows(rays.origins), of_rows(seen.ranges)
    met = ranges < of_rows(rays.reach)
    off = np.minimum(OFF_SURFACE / metres, ranges / 2) * met
    return starts, starts + of_rows(rays.directions) * (ranges - off)[..., None], met


def straight(
    points: Array, drawn: NDArray[np.bool_], metres: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Of the steps (rows, n − 1) between points (rows, n, 3) that are drawn, those that begin and
    those that end a straight line."""
    way, middle = points[:, 2:] - points[:, :-2], points[:, 1:-1] - points[:, :-2]
    length = np.maximum(np.linalg.norm(way, axis=2), 1e-12)
    off = np.linalg.norm(np.cross(middle, way), axis=2) / length
    on = drawn[:, :-1] & drawn[:, 1:] & (off < np.maximum(STRAIGHT * length, EXACT / metres))
    on &= (middle * way).sum(axis=2) > 0.0
    first, last = drawn.copy(), drawn.copy()
    first[:, 1:] &= ~on
    last[:, :-1] &= ~on
    return first, last


def plain_figure(seen: Any, metres: float) -> Figure:
    """Its rays to what they meet; of what casts none a cross."""
    if len(seen.rays.reach):
        return beams(seen, metres)
    figure, axes = Figure(), seen.pose.axes.T * CROSS
    figure.add("axis", pairs(seen.pose.origin - axes, seen.pose.origin + axes) / metres)
    return figure


def beams(seen: Any, metres: float) -> Figure:
    """Each ray to where it ends."""
    figure = Figure()
    starts, ends, _ = ends_of(seen, metres)
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
