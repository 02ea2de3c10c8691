# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts many rays at once against a surface of very many triangles, in little memory.

Blender's BVH takes 120 bytes and a microsecond per triangle before the first ray. This one sorts
the triangles along a Morton curve and stores boxes around every eight of them, around every eight
of those boxes, and so on: 8 bytes per triangle and a quarter of the time. A ray then costs some 20
times as much, so it is for surfaces with many more triangles than rays are cast.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from .triangle_tree import ROUNDING, WITHIN, Index, morton_codes

# Down to this level (boxes of 512 triangles) all boxes that a ray crosses are found; below it they
# are opened from the nearest on.
MIDDLE = 2
# The most boxes that a ray opens at once; their number doubles up to this.
MOST_OPENED = 16
# Triangles, and rays, in one batch, to bound the memory.
TRIANGLES_AT_ONCE = 1 << 17
RAYS_AT_ONCE = 1024


@dataclass(frozen=True)
class _Rays:
    """Rays (k,): origins and unit directions (k, 3), two perpendicular directions (k, 3), the
    reciprocals of the directions (k, 3), and the lengths (k,)."""

    origins: Array
    directions: Array
    across: Array
    up: Array
    inverse: Array
    limits: Array

    def of(self, which: Index | slice) -> _Rays:
        return _Rays(*(part[which] for part in vars(self).values()))


class RayTree:
    """A hierarchy of the triangles (m, 3) of points (n, 3), neither of which it copies. No ray hits
    a triangle with a NaN or infinite corner."""

    def __init__(self, points: NDArray[np.float32], triangles: NDArray[np.int32]) -> None:
        self._points = points
        self._triangles = triangles
        order = np.argsort(morton_codes(points)[triangles[:, 0]], kind="stable").astype(np.int32)
        finite: NDArray[np.bool_] = np.asarray(np.isfinite(points).all(axis=1))
        if not finite.all():
            order = order[np.asarray(finite[triangles].all(axis=1))[order]]
        self._order = order
        boxes = -(-len(order) // WITHIN)
        lo, hi = np.empty((boxes, 3), np.float32), np.empty((boxes, 3), np.float32)
        for part in _parts(boxes, TRIANGLES_AT_ONCE // WITHIN):
            corners = triangles[order[part.start * WITHIN : part.stop * WITHIN]]
            one, two, three = (np.take(points, corners[:, corner], axis=0) for corner in range(3))
            lo[part] = _around(np.minimum(np.minimum(one, two), three), np.minimum)
            hi[part] = _around(np.maximum(np.maximum(one, two), three), np.maximum)
        self._levels = [(lo, hi)]
        while len(lo) > WITHIN:
            lo, hi = _around(lo, np.minimum), _around(hi, np.maximum)
            self._levels.append((lo, hi))
        size = max((float(np.abs(part).max(initial=0.0)) for part in (lo, hi)), default=0.0)
        self._room = ROUNDING * size

    def meet(self, origins: Array, directions: Array, limits: Array) -> tuple[Array, Index]:
        """The distances (k,) from origins (k, 3) along directions (k, 3), of any length, to the
        nearest triangle within the limits (k,), and its number (k,); inf and -1 without one."""
        far, met = np.full(len(origins), np.inf), np.full(len(origins), -1, np.intp)
        for part in _parts(len(origins), RAYS_AT_ONCE):
            rays = _rays(*(np.asarray(a[part], float) for a in (origins, directions, limits)))
            far[part], met[part] = self._meet(rays)
        return far, met

    def ray_cast(
        self, origin: Array, direction: Array, distance: float = np.inf
    ) -> tuple[Array, Array, int, float] | tuple[None, None, None, None]:
        """Point, normal, triangle and distance of a single ray's hit, or four Nones, as Blender's
        `BVHTree.ray_cast`."""
        start, way = np.asarray(origin, float), np.asarray(direction, float)
        far, met = self.meet(start[None], way[None], np.array([distance]))
        if met[0] < 0:
            return None, None, None, None
        corners = self._points[self._triangles[met[0]]].astype(float)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        size = float(np.linalg.norm(normal))
        point = start + way / np.linalg.norm(way) * far[0]
        return point, normal / size if size else normal, int(met[0]), float(far[0])

    def _meet(self, rays: _Rays) -> tuple[Array, Index]:
        best, met = rays.limits.copy(), np.full(len(rays.limits), -1, np.intp)
        middle = min(MIDDLE, len(self._levels) - 1)
        ray, box, enter = self._descend(rays, len(self._levels), middle, *_all_pairs(0, 0))
        nearest = np.lexsort((enter, ray))
        ray, box, enter = ray[nearest], box[nearest], enter[nearest]
        following = np.searchsorted(ray, np.arange(len(best)))
        ends = np.searchsorted(ray, np.arange(len(best)), side="right")
        open_now = 1
        while True:
            # The next boxes of each ray, unless it hit a triangle before them.
            next_ones = following[:, None] + np.arange(open_now)
            there = next_ones < ends[:, None]
            pairs = next_ones[there]
            pairs = pairs[enter[pairs] <= best[ray[pairs]]]
            if not len(pairs):
                return np.where(met >= 0, best, np.inf), met
            following += open_now
            limited = replace(rays, limits=best)
            leaf_ray, leaf, _ = self._descend(limited, middle, 0, ray[pairs], box[pairs])
            for part in _parts(len(leaf), TRIANGLES_AT_ONCE // WITHIN):
                self._hit_triangles(rays, leaf_ray[part], leaf[part], best, met)
            open_now = min(2 * open_now, MOST_OPENED)

    def _descend(
        self, rays: _Rays, level: int, last: int, ray: Index, box: Index
    ) -> tuple[Index, Index, Array]:
        """Pairs of a ray and a box of the level `last` that it enters, and the distances at which
        it does: below the given pairs of `level`, or of all boxes if `level` is above the top."""
        if level == len(self._levels):
            ray, box = _all_pairs(len(rays.limits), len(self._levels[-1][0]))
            ray, box, enter = self._entered(rays, len(self._levels) - 1, ray, box)
            level -= 1
        else:
            enter = np.zeros(len(ray))
        while level > last:
            level -= 1
            below = box[:, None] * WITHIN + np.arange(WITHIN)
            there = below < len(self._levels[level][0])
            each = np.broadcast_to(ray[:, None], below.shape)[there]
            ray, box, enter = self._entered(rays, level, each, below[there])
        return ray, box, enter

    def _entered(
        self, rays: _Rays, level: int, ray: Index, box: Index
    ) -> tuple[Index, Index, Array]:
        """The pairs whose ray enters the box within its limit, and the distances."""
        lo, hi = self._levels[level]
        enter, leave = np.zeros(len(ray)), rays.limits[ray]
        with np.errstate(invalid="ignore", over="ignore"):
            for axis in range(3):
                start, inverse = rays.origins[ray, axis], rays.inverse[ray, axis]
                # In this order, because the margin would be lost in single precision.
                one = (lo[box, axis] - start - self._room) * inverse
                two = (hi[box, axis] - start + self._room) * inverse
                # fmin and fmax pass over the NaN of a ray that runs in the plane of a face.
                enter = np.fmax(enter, np.fmin(one, two))
                leave = np.fmin(leave, np.fmax(one, two))
        crossed = np.flatnonzero(enter <= leave)
        return ray[crossed], box[crossed], enter[crossed]

    def _hit_triangles(self, rays: _Rays, ray: Index, leaf: Index, best: Array, met: Index) -> None:
        """Shortens `best` in place to the nearest triangle in pairs of a ray and a leaf box.

        Two triangles compute the side of a point at their common edge from the same numbers, so no
        ray slips through between them.
        """
        places = leaf[:, None] * WITHIN + np.arange(WITHIN)
        there = places < len(self._order)
        ray = np.broadcast_to(ray[:, None], places.shape)[there]
        triangle = self._order[places[there]]
        some = rays.of(ray)
        x, y, z = [], [], []
        for corner in range(3):
            point = self._points[self._triangles[triangle, corner]] - some.origins
            x.append(_dot(point, some.across))
            y.append(_dot(point, some.up))
            z.append(_dot(point, some.directions))
        sides = [x[i] * y[j] - y[i] * x[j] for i, j in ((1, 2), (2, 0), (0, 1))]
        inside = np.logical_and.reduce([side >= 0.0 for side in sides])
        inside |= np.logical_and.reduce([side <= 0.0 for side in sides])
        whole = sides[0] + sides[1] + sides[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (sides[0] * z[0] + sides[1] * z[1] + sides[2] * z[2]) / whole
            hits = np.flatnonzero(inside & (far >= 0.0) & (far <= best[ray]))
        # The nearest hit of each ray; of two equally near, the triangle of the lower number.
        hits = hits[np.lexsort((triangle[hits], far[hits], ray[hits]))]
        _, first = np.unique(ray[hits], return_index=True)
        hits = hits[first]
        row = ray[hits]
        nearer = (far[hits] < best[row]) | (met[row] < 0) | (triangle[hits] < met[row])
        best[row[nearer]], met[row[nearer]] = far[hits[nearer]], triangle[hits[nearer]]


def _rays(origins: Array, directions: Array, limits: Array) -> _Rays:
    ways = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    # The axis that is least along the ray is farthest from being parallel to it.
    other = np.eye(3)[np.argmin(np.abs(ways), axis=1)]
    across = np.cross(ways, other)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        return _Rays(origins, ways, across, np.cross(ways, across), 1.0 / ways, limits)


def _dot(one: Array, two: Array) -> Array:
    """Products (k,) of vectors (k, 3), each worked out alike wherever it stands in the array."""
    found: Array = one[:, 0] * two[:, 0] + one[:, 1] * two[:, 1] + one[:, 2] * two[:, 2]
    return found


def _all_pairs(rays: int, boxes: int) -> tuple[Index, Index]:
    return np.repeat(np.arange(rays), boxes), np.tile(np.arange(boxes), rays)


def _around(rows: NDArray[np.float32], extreme: np.ufunc) -> NDArray[np.float32]:
    """The least or greatest of each WITHIN rows (n, 3); numpy's own takes five times as long along
    so short an axis."""
    missing = -len(rows) % WITHIN
    found = np.concatenate([rows, np.repeat(rows[-1:], missing, axis=0)]).reshape(-1, WITHIN, 3)
    while found.shape[1] > 1:
        half = found.shape[1] // 2
        found = extreme(found[:, :half], found[:, half:])
    return np.asarray(found[:, 0])


def _parts(count: int, size: int = TRIANGLES_AT_ONCE) -> Iterator[slice]:
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))
