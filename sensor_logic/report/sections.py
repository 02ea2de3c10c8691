# SPDX-License-Identifier: GPL-3.0-or-later
"""The lines of a floor plan, computed from triangles.

The lines are where a horizontal plane cuts the triangles, or the outlines from above. Both are
polylines in x and y. Corners closer than a tenth of a millimetre are welded. So lines also close
for meshes whose faces do not share vertices.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Triangles = NDArray[np.int64] | NDArray[np.int32]
WELD_M = 1e-4
# The number of grid cells per side on which corners are numbered.
CELLS = 2**20
# A face points up if the z of its unit normal is above this value.
RISING = 1e-6
MOST_LOOSE = 200


@dataclass(frozen=True)
class Line:
    """A polyline with points (n, 2) in m; a closed line does not repeat its first point.

    A closed line around a solid is counter-clockwise if the solid's normals point outwards.
    """

    points: Array
    closed: bool

    @property
    def area(self) -> float:
        """The area in m², negative for clockwise lines; 0 for an open line."""
        if not self.closed:
            return 0.0
        x, y = (self.points - self.points[0]).T
        return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0

    @property
    def length(self) -> float:
        """The length in m, which is the perimeter for a closed line."""
        ends = np.roll(self.points, -1, axis=0) if self.closed else self.points[1:]
        return float(np.linalg.norm(ends - self.points[: len(ends)], axis=1).sum())


def cut(points: Array, triangles: Triangles, height: float) -> list[Line]:
    """Return the lines where the plane z = `height` cuts triangles.

    The triangles (m, 3) are given by indices into `points` (n, 3). Lengths are in m.
    """
    points, corners = weld(points, _near(points, triangles, height))
    above: Mask = np.asarray(points[:, 2] >= height)
    crossing = corners[above[corners].any(axis=1) & ~above[corners].all(axis=1)]
    if not len(crossing):
        return []
    after = np.roll(crossing, -1, axis=1)
    leaves = above[crossing] & ~above[after]
    enters = ~above[crossing] & above[after]
    # One edge of each triangle goes down through the plane, and one goes up.
    down = np.sort(np.stack([crossing[leaves], after[leaves]], axis=1), axis=1)
    up = np.sort(np.stack([crossing[enters], after[enters]], axis=1), axis=1)
    edges, nodes = np.unique(np.concatenate([down, up]), axis=0, return_inverse=True)
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    share = (height - a[:, 2]) / (b[:, 2] - a[:, 2])
    places = a[:, :2] + share[:, None] * (b - a)[:, :2]
    # Two edges can cross the plane at the same place, if a face ends in the middle of another edge.
    first, same = _same_places(places)
    return _chained(places[first], same[nodes.reshape(2, -1).T])


def from_above(points: Array, triangles: Triangles) -> list[Line]:
    """Return the outlines of the faces that point up, as seen from above.

    The triangles (m, 3) are given by indices into `points` (n, 3), in m.
    """
    points, corners = weld(points, triangles)
    a, b, c = (points[corners[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    rising = corners[normal[:, 2] > RISING * np.maximum(size, 1e-30)]
    if not len(rising):
        return []
    edges = np.stack([rising, np.roll(rising, -1, axis=1)], axis=2).reshape(-1, 2)
    # Edges are encoded as single numbers, because numpy sorts rows many times slower.
    key = edges.min(axis=1) * len(points) + edges.max(axis=1)
    _, which, count = np.unique(key, return_index=True, return_counts=True)
    return _chained(points[:, :2], edges[which[count % 2 == 1]])


def _near(points: Array, triangles: Triangles, height: float) -> Triangles:
    """Return the triangles that the plane can cut, with a margin for welding."""
    levels = points[:, 2][triangles]
    reach = np.abs(points[np.isfinite(points)]).max(initial=0.0)
    margin = 10 * WELD_M + 4 * reach / CELLS
    low, high = levels.min(axis=1, initial=np.inf), levels.max(axis=1, initial=-np.inf)
    near: Triangles = triangles[(low <= height + margin) & (high >= height - margin)]
    return near


def weld(points: Array, triangles: Triangles) -> tuple[Array, Indices]:
    """Merge points that are closer than a tenth of a millimetre.

    Return the remaining points, and the triangles as indices into these. Triangles of zero area are
    left out, and triangles with a NaN or infinite corner.
    """
    finite: Mask = np.asarray(np.isfinite(points).all(axis=1))
    used, inverse = np.unique(triangles[finite[triangles].all(axis=1)], return_inverse=True)
    if not len(used):
        return np.empty((0, points.shape[1])), np.empty((0, 3), np.int64)
    first, same = _same_places(points[used])
    a, b, c = (corners := same[inverse.reshape(-1, 3)]).T
    return points[used[first]], corners[(a != b) & (b != c) & (c != a)]


def _same_places(points: Array) -> tuple[Indices, Indices]:
    """Return the distinct positions among points (n, 2 or 3).

    The first result has the index of the first point at each position. The second has, for each
    point (n,), the index of its position in the first result.
    """
    low = points.min(axis=0)
    cell = max(WELD_M, float((points.max(axis=0) - low).max()) / (CELLS - 1))
    key = np.zeros(len(points), np.int64)
    for column in np.round((points - low) / cell).astype(np.int64).T:
        key = key * CELLS + column
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    return first, inverse.reshape(-1)


def _chained(places: Array, segments: Indices) -> list[Line]:
    """Return polylines made of directed segments.

    `segments` (n, 2) has, for each segment, the indices of its start and its end in `places`. Each
    polyline is as long as possible. It has the direction of most of its segments.
    """
    at: dict[int, list[int]] = defaultdict(list)
    ends = segments[segments[:, 0] != segments[:, 1]].tolist()
    for i, (start, end) in enumerate(ends):
        at[start].append(i)
        at[end].append(i)
    used = [False] * len(ends)
    # Open lines come first, from one of their ends; the remaining segments form loops.
    loose = [n for n, (start, end) in enumerate(ends) if len(at[start]) == 1 or len(at[end]) == 1]
    lines = []
    for first in [*loose, *range(len(ends))]:
        if used[first]:
            continue
        start, end = ends[first]
        backward = len(at[end]) == 1 and len(at[start]) != 1
        node = end if backward else start
        chain, forward = [node], 0
        number: int | None = first
        while number is not None:
            used[number] = True
            start, end = ends[number]
            forward += 1 if node == start else -1
            node = end if node == start else start
            chain.append(node)
            number = next((n for n in at[node] if not used[n]), None)
            if node == chain[0]:
                break
        closed = chain[0] == chain[-1] and len(chain) > 3
        points = places[chain[:-1] if closed else chain]
        lines.append(Line(points if forward >= 0 else points[::-1], closed))
    return lines


def joined(lines: list[Line], gap: float) -> list[Line]:
    """Return the lines, with open lines joined if their ends are at most `gap` (m) apart.

    The nearest ends are joined first. Walls that adjoin are often modelled without faces between
    them, so their outlines are open there.
    """
    closed = [line for line in lines if line.closed]
    loose = [line.points for line in lines if not line.closed]
    # Comparing all pairs of ends is too slow for the fragments of a scanned mesh.
    while 0 < len(loose) <= MOST_LOOSE:
        ends = np.array([(points[0], points[-1]) for points in loose]).reshape(-1, 2)
        distance = np.linalg.norm(ends[:, None] - ends[None], axis=2)
        distance[np.tril_indices(len(ends))] = np.inf
        one, other = (int(i) for i in np.unravel_index(int(np.argmin(distance)), distance.shape))
        if distance[one, other] > gap:
            break
        if one // 2 == other // 2:
            points = loose.pop(one // 2)
            if len(points) > 2:
                closed.append(Line(points, True))
            continue
        second, first = loose.pop(other // 2), loose.pop(one // 2)
        first = first if one % 2 else first[::-1]
        loose.append(np.concatenate([first, second[::-1] if other % 2 else second]))
    return closed + [Line(points, False) for points in loose]


def simplified(points: Array, tolerance: float, closed: bool = False) -> Array:
    """Return a polyline (n, 2) without points that hardly change its shape.

    All points that are left out are within `tolerance` of the remaining line.

    References
    ----------
    The algorithm of Ramer, Douglas and Peucker.
    """
    if closed and len(points) > 3:
        # Split at the point farthest from the first point.
        far = int(np.argmax(np.linalg.norm(points - points[0], axis=1)))
        one = simplified(points[: far + 1], tolerance)
        two = simplified(np.concatenate([points[far:], points[:1]]), tolerance)
        return np.concatenate([one, two[1:-1]])
    keep = np.zeros(len(points), bool)
    keep[[0, -1]] = True
    parts = [(0, len(points) - 1)]
    while parts:
        first, last = parts.pop()
        if last - first < 2:
            continue
        way = points[last] - points[first]
        off = points[first + 1 : last] - points[first]
        along = np.clip(off @ way / max(float(way @ way), 1e-30), 0.0, 1.0)
        distance = np.linalg.norm(off - along[:, None] * way, axis=1)
        worst = int(np.argmax(distance))
        if distance[worst] > tolerance:
            middle = first + 1 + worst
            keep[middle] = True
            parts += [(first, middle), (middle, last)]
    kept: Array = points[keep]
    return kept
