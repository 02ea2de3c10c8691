# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines and surfaces that show the rays and zones of a sensor, in world space and Blender units.

Each part of a figure has a meaning, such as "edge" or "ray". `picture.py` decides how each meaning
is drawn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array, Pose
from ..runtime.trace import CAST, CastRays

Lines = NDArray[np.float32]
# m. Lines on a surface are drawn this far in front of it, so that the surface does not hide them.
OFF_SURFACE = 0.01
# m. Half of the size of the cross that stands for a sensor without rays.
CROSS = 0.05
# A point is left out if it is nearly on the line between its neighbours, as on a flat wall. The
# greatest distance from that line, relative to the length of the line, and in m.
STRAIGHT, EXACT = 2e-4, 2e-5
# The hits of a zone lie in no plane if one is off it by more than this fraction of its range. The
# length of an edge then follows from this many rays beside it.
FLAT, BESIDE = 0.03, 3
DASHES = 9
DASHES_AT = np.linspace(0.0, 1.0, 2 * DASHES)[:, None]
ROUND = 24
# Corners of a rectangle, in turn.
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclass(eq=False)
class Figure:
    """A figure in world space, as lines (n, 2, 3) and triangles `fills` (n, 3, 3) by meaning.

    `colours` has the colours (n, 4) of the triangles of some meanings. All others have the colour
    of the sensor's state.
    """

    lines: dict[str, Lines] = field(default_factory=dict)
    fills: dict[str, Lines] = field(default_factory=dict)
    colours: dict[str, Lines] = field(default_factory=dict)
    # The last look of the figure, and the primitives that picture.py made for it.
    pictured: Any = None

    def add(self, meaning: str, *parts: Any) -> None:
        """Add lines with this meaning, each part of shape (…, 2, 3)."""
        _append(self.lines, meaning, [np.asarray(part).reshape(-1, 2, 3) for part in parts])

    def fill(self, meaning: str, *parts: Any) -> None:
        """Add triangles with this meaning, each part of shape (…, 3, 3)."""
        _append(self.fills, meaning, [np.asarray(part).reshape(-1, 3, 3) for part in parts])

    def colour(self, meaning: str, colours: Any) -> None:
        """Set the colours (n, 4) of all triangles with this meaning, as sRGB from 0 to 1.

        The last of the four numbers is a factor of the meaning's opacity.
        """
        self.colours[meaning] = np.asarray(colours, np.float32)


def _append(into: dict[str, Lines], meaning: str, parts: list[Any]) -> None:
    known = [into[meaning]] if meaning in into else []
    into[meaning] = np.concatenate(known + parts).astype(np.float32)


def around_edge(pose: Pose, count: int = 25) -> tuple[Array, Array] | None:
    """Return points around the edge of a square from −1 to 1, if a sensor looks steeply up or down.

    A level fan of such a sensor's rays is a line in the floor plan; a fan around the edge of its
    field of view is an area. `count` is the number of points of a side, to the right (n,) and up
    (n,). The last point is the first one again. Return None for any other direction.
    """
    if abs(pose.axes[2, 2]) < math.sqrt(0.5):
        return None
    side, end = np.linspace(-1.0, 1.0, count), np.ones(count)
    return np.concatenate([side, end, -side, -end]), np.concatenate([end, -side, -end, side])


def ends_of(cast: CastRays, metres: float, rows: int = 1) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the starts and ends of rays, and whether each ray hit something.

    Parameters
    ----------
    cast
        The rays with their ranges.
    metres
        Length of a Blender unit in m.
    rows
        The number of equal rows to divide the rays into.

    Returns
    -------
    starts, ends : (rows, n, 3) array
        In Blender units.
    hit : (rows, n) array of bool
        Whether each ray hit something.
    """
    hit = cast.ranges < cast.reach
    off = np.minimum(OFF_SURFACE, cast.ranges / 2) * hit
    ends = cast.origins + cast.directions * (cast.ranges - off)[:, None]
    starts = cast.origins.reshape(rows, -1, 3) / metres
    return starts, ends.reshape(rows, -1, 3) / metres, hit.reshape(rows, -1)


def corners_of(
    cast: CastRays,
    apex: Array,
    edges: Array,
    metres: float,
    farthest: float = math.inf,
    whole: bool = False,
) -> Array:
    """Return the far ends of the edges of pyramids that have a common apex.

    The edges of a pyramid end on the plane that the rays within it hit. If these hits lie in no
    plane, each edge is as long as the nearest hit of the rays beside it. So no edge goes through a
    wall.

    Parameters
    ----------
    cast
        The rays with their ranges, pyramid by pyramid, with the same number of rays in each.
    apex
        The apex (3,) in m.
    edges
        Unit vectors (z, c, 3) along the c edges of z pyramids.
    metres
        Length of a Blender unit in m.
    farthest
        The greatest length of an edge, in m.
    whole
        Whether a pyramid whose hits lie in no plane ends at its nearest hit, with edges of the same
        length.

    Returns
    -------
    (z, c, 3) array
        In Blender units.
    """
    count = len(edges)
    ends = (cast.origins + cast.directions * cast.ranges[:, None] - apex).reshape(count, -1, 3)
    ranges = np.maximum(np.linalg.norm(ends, axis=-1), 1e-9)
    ways = ends / ranges[..., None]
    hit = ((cast.ranges < cast.reach).reshape(count, -1) & (ranges < farthest)).any(axis=1)
    ranges = np.minimum(ranges, farthest)
    # A ray along a unit vector u meets the plane n·p = 1 at the range 1 / (n·u).
    near = 1.0 / ranges
    plane = np.linalg.pinv(ways, rcond=1e-6) @ near[..., None]
    least, most = ranges.min(axis=1, keepdims=True), ranges.max(axis=1, keepdims=True)
    far = 1.0 / np.clip((edges @ plane)[..., 0], 0.9 / most, 1.1 / least)
    bent = np.abs((ways @ plane)[..., 0] * ranges - 1.0).max(axis=1) > FLAT
    if whole:
        far[bent] = ranges[bent].min(axis=1, keepdims=True)
    elif bent.any():
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
    """Find runs of steps between neighbouring points that form a straight line.

    Parameters
    ----------
    points
        Points (rows, n, 3), with n − 1 steps between them in each row.
    drawn
        Whether to draw each step (rows, n − 1).
    metres
        Length of a Blender unit in m.

    Returns
    -------
    first, last : (rows, n − 1) array of bool
        Whether a straight line begins with each step, and whether one ends with it.
    """
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
    """Return the figure of a sensor that casts no rays: a cross.

    `seen` is the `DrawnSensor`, and `metres` the length of a Blender unit in m.
    """
    figure = Figure()
    if not CAST & seen.sensor.kind.needs.keys():
        axes = seen.pose.axes.T * CROSS
        figure.add("axis", pairs(seen.pose.origin - axes, seen.pose.origin + axes) / metres)
    return figure


def beams(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Return the figure of a bundle of rays: each ray as a line up to its hit or its range.

    `seen` is the `DrawnSensor`, and `number` the number of the bundle. `cast` has the rays with
    their ranges. `metres` is the length of a Blender unit in m.
    """
    figure = Figure()
    starts, ends, _ = ends_of(cast, metres)
    figure.add("beam", pairs(starts, ends))
    return figure


def surface_outline(evaluated: Any, place: Any) -> Array:
    """Return the world positions (4, 3) of the upper corners of an object's bounding box.

    `evaluated` is the evaluated object, and `place` its world matrix.
    """
    corners = np.array(evaluated.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    upper = [(lo[0], lo[1]), (hi[0], lo[1]), (hi[0], hi[1]), (lo[0], hi[1])]
    local = np.array([(a, b, hi[2], 1.0) for a, b in upper])
    matrix = np.array(place, np.float64)
    return (local @ matrix.T)[:, :3]


def pairs(one: Any, two: Any) -> Array:
    """Return lines (…, 2, 3) from the points `one` to the points `two`."""
    return np.stack([one, two], axis=-2)


def triangles(one: Any, two: Any, three: Any) -> Array:
    """Return triangles (…, 3, 3) from the arrays `one`, `two` and `three` of their corners."""
    return np.stack([one, two, three], axis=-2)


def dashes(one: Array, two: Array) -> Array:
    """Return a dashed line from point `one` to point `two`, as lines (DASHES, 2, 3)."""
    return (one + (two - one) * DASHES_AT).reshape(DASHES, 2, 3)


def circle(middle: Array, x: Array, y: Array, radius: float) -> Array:
    """Return points (ROUND, 3) on a circle around `middle`.

    The circle is in the plane of the unit vectors `x` and `y`.
    """
    angles = np.arange(ROUND) * 2 * math.pi / ROUND
    return middle + radius * (np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y))
