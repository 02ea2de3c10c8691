# SPDX-License-Identifier: GPL-3.0-or-later
"""Two bounding volume hierarchies of triangles: `TriangleTree` and `RayTree`.

`TriangleTree` finds the triangles near a moving ray. `RayTree` casts many rays at once against a
surface of very many triangles, in little memory.

To build its BVH, Blender takes 120 bytes and a microsecond per triangle. `RayTree` takes 8 bytes
and a quarter of a microsecond. It sorts the triangles along a Morton curve. It then stores boxes
around every eight triangles, around every eight of these boxes, and so on. A ray takes about 20
times as long as with Blender's BVH. So `RayTree` is for surfaces with many more triangles than
rays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import Array

# `TriangleTree`: the triangles near a moving ray.
#
# A ray whose two ends move in straight lines stays within the convex hull of the four end points. A
# box that a plane separates from this hull cannot contain a crossing. The tested planes are
# perpendicular to the world axes, to the ray, to its motion, and to both (separating axes).

Index = NDArray[np.intp]
# The number of children of a box: 4 is as fast, 16 and 32 are slower.
WITHIN = 8
# The most pairs of rays and boxes compared at once, to bound the memory.
PAIRS_AT_ONCE = 50_000
# Rays in a bundle, which descends the hierarchy as one; larger bundles overlap more boxes.
TOGETHER = 8
# Up to this many pairs of rays and triangles, the hierarchy costs more than it saves.
FEW = 200
# Boxes are enlarged by this share of the largest coordinate, far more than rounding errors.
ROUNDING = 1e-9
# Cells of the Morton curve per side: 2^21, because three cell numbers fit into 64 bits.
CELLS = 2.0**21 - 1.0
# SPREAD[n] has the bits of n at every third place. A cell number is looked up in two halves.
HALF = 11
LOW = 2**HALF - 1
SPREAD = np.zeros(2**HALF, np.int64)
for bit in range(HALF):
    SPREAD |= (np.arange(2**HALF) >> bit & 1) << 3 * bit


@dataclass(frozen=True)
class Boxes:
    """n axis-aligned boxes: `centre` (n, 3), and half of their sizes as `half` (n, 3)."""

    centre: Array
    half: Array

    def overlap(self, rows: Index, others: Boxes, which: Index, margin: float) -> NDArray[np.bool_]:
        """Return a mask (q,) of the pairs of boxes that are at most `margin` apart along each axis.

        A pair has the box `rows` (q,) of this object, and the box `which` (q,) of `others`.
        """
        apart = np.abs(others.centre[which] - self.centre[rows])
        return _all_three(apart <= others.half[which] + self.half[rows] + margin)

    def around(self) -> Boxes:
        """Return a box around each group of WITHIN successive boxes: the next level of a tree."""
        starts = np.arange(0, len(self.centre), WITHIN)
        lo = np.minimum.reduceat(self.centre - self.half, starts)
        hi = np.maximum.reduceat(self.centre + self.half, starts)
        return Boxes((lo + hi) / 2.0, (hi - lo) / 2.0)


class SweptBundles:
    """The space that each of n bundles of k moving rays passes through.

    `before` and `after` (n, k, 2, 3) are the ends of the rays at the begin and the end of the
    motion. The space is bounded by an axis-aligned box, and by a box aligned with rays and motion.
    """

    def __init__(self, before: Array, after: Array) -> None:
        points = np.concatenate([before, after], axis=1).reshape(len(before), -1, 3)
        self.box = _boxes(points)
        along = points[:, 1::2].sum(axis=1) - points[:, ::2].sum(axis=1)
        motion = (after - before).reshape(len(before), -1, 3)
        farthest = np.argmax((motion * motion).sum(axis=2), axis=1)
        across = np.cross(along, motion[np.arange(len(motion)), farthest])
        # A ray at rest, or moving along itself, has no motion across: use any perpendicular.
        still = np.abs(across).max(axis=1) <= ROUNDING * np.abs(along).max(axis=1) ** 2
        thinnest = np.eye(3)[np.argmin(np.abs(along[still]), axis=1)]
        across[still] = np.cross(along[still], thinnest)
        axes = np.stack([along, across, np.cross(across, along)], axis=1)
        # An axis of length zero separates nothing.
        sizes = np.linalg.norm(axes, axis=2, keepdims=True)
        self.axes = np.divide(axes, sizes, out=np.zeros_like(axes), where=sizes > 0.0)
        self.turned = _boxes(points @ self.axes.swapaxes(1, 2))
        self.turned_axes = np.abs(self.axes)

    def overlap(self, rows: Index, boxes: Boxes, which: Index, margin: float) -> NDArray[np.bool_]:
        """Return a mask (q,) of the pairs of a bundle and a box that can overlap.

        A pair has the bundle `rows` (q,) and the box `which` (q,). They cannot overlap if a face of
        the bundle's bounding boxes separates them by more than `margin`.
        """
        near = self.box.overlap(rows, boxes, which, margin)
        left = np.flatnonzero(near)
        rows, which = rows[left], which[left]
        apart = np.einsum("qac,qc->qa", self.axes[rows], boxes.centre[which])
        apart -= self.turned.centre[rows]
        reach = np.einsum("qac,qc->qa", self.turned_axes[rows], boxes.half[which])
        reach += self.turned.half[rows] + margin
        near[left] = _all_three(np.abs(apart) <= reach)
        return near


class TriangleTree:
    """A bounding volume hierarchy, which finds the triangles (m, 3, 3) near moving rays.

    Triangles with a NaN or infinite corner are left out.
    """

    def __init__(self, corners: Array) -> None:
        self.corners = corners
        finite = np.flatnonzero(np.isfinite(corners).all(axis=(1, 2)))
        boxes = _boxes(corners[finite])
        order = np.argsort(morton_codes(boxes.centre), kind="stable")
        # The triangles' numbers in the order of the leaf boxes.
        self._numbers = finite[order]
        self._levels = [Boxes(boxes.centre[order], boxes.half[order])]
        while len(self._levels[-1].centre) > 1:
            self._levels.append(self._levels[-1].around())
        self._largest = float(np.abs(corners[finite]).max(initial=0.0))

    def near(self, before: Array, after: Array) -> Iterator[tuple[Index, Index, Index]]:
        """Yield pairs of a moving ray and a triangle that can cross, in batches of q pairs.

        A batch has the indices (q,) of the piece of motion, the ray and the triangle of each pair.
        It may also have pairs that do not cross, but no crossing is missing.

        Parameters
        ----------
        before, after
            The ends (n, k, 2, 3) of k neighbouring rays at the begin and the end of n pieces of
            their motion. Within a piece, the ends move in straight lines.
        """
        if not len(self._numbers) or not before.size:
            return
        both = np.stack([before, after]).reshape(1, -1, 3)
        margin = ROUNDING * max(self._largest, float(np.abs(both).max()))
        first = np.zeros(1, np.intp)
        if not _boxes(both).overlap(first, self._levels[-1], first, margin).any():
            return
        pieces, rays = before.shape[:2]
        if pieces * rays * len(self._numbers) <= FEW:
            piece, ray, which = np.indices((pieces, rays, len(self._numbers))).reshape(3, -1)
            yield piece, ray, self._numbers[which]
            return
        bundles = -(-rays // TOGETHER)
        size = -(-rays // bundles)
        # The last bundle is padded with the last ray.
        bundled = np.minimum(np.arange(bundles * size), rays - 1)
        swept = SweptBundles(
            *(at[:, bundled].reshape(pieces * bundles, size, 2, 3) for at in (before, after))
        )
        rows, top = np.arange(pieces * bundles), len(self._levels) - 1
        for row, which in self._descend(swept, margin, top, rows, np.zeros_like(rows)):
            piece, bundle = np.divmod(row, bundles)
            if size == 1:
                yield piece, bundle, self._numbers[which]
                continue
            at_once = max(1, PAIRS_AT_ONCE // size)
            for part in (slice(i, i + at_once) for i in range(0, len(row), at_once)):
                some = bundle[part, None] * size + np.arange(size)
                exists = some < rays
                single = (piece[part, None] * rays + some)[exists]
                triangle = np.broadcast_to(which[part, None], some.shape)[exists]
                near = self._rays_near(before, after, margin, single, triangle)
                yield *np.divmod(single[near], rays), self._numbers[triangle[near]]

    def _rays_near(
        self, before: Array, after: Array, margin: float, rows: Index, which: Index
    ) -> NDArray[np.bool_]:
        """Return a mask (q,) of the pairs of a ray and a triangle within `margin` of each other.

        Some pairs in the mask may be farther apart. `before` and `after` (n, k, 2, 3) are as for
        `near`. Ray i of piece j has the number j·k + i: `rows` (q,) has these numbers. `which` (q,)
        has the positions of the triangles in the lowest level of the hierarchy.
        """
        known, place = np.unique(rows, return_inverse=True)
        swept = SweptBundles(*(at.reshape(-1, 1, 2, 3)[known] for at in (before, after)))
        return swept.overlap(place, self._levels[0], which, margin)

    def _descend(
        self, swept: SweptBundles, margin: float, level: int, rows: Index, which: Index
    ) -> Iterator[tuple[Index, Index]]:
        """Yield pairs of a bundle of rays and a box of the lowest level that can overlap.

        The search starts at q pairs: the bundles `rows` (q,) and the boxes `which` (q,) of the
        given level.
        """
        boxes = self._levels[level]
        for start in range(0, len(rows), PAIRS_AT_ONCE):
            some = slice(start, start + PAIRS_AT_ONCE)
            near = swept.overlap(rows[some], boxes, which[some], margin)
            left, found = rows[some][near], which[some][near]
            if not len(left):
                continue
            if level == 0:
                yield left, found
                continue
            below = found[:, None] * WITHIN + np.arange(WITHIN)
            exists = below < len(self._levels[level - 1].centre)
            left = np.broadcast_to(left[:, None], below.shape)
            yield from self._descend(swept, margin, level - 1, left[exists], below[exists])


def _all_three(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return `mask.all(axis=1)` (n,) of a mask (n, 3), three times as fast."""
    return np.asarray(mask[:, 0] & mask[:, 1] & mask[:, 2])


def _boxes(points: Array) -> Boxes:
    """Return the boxes (n,) around points (n, m, 3)."""
    if points.shape[1] > 4:
        lo, hi = points.min(axis=1), points.max(axis=1)
    else:
        # numpy's reductions are slow along such a short axis.
        one_by_one = [points[:, i] for i in range(points.shape[1])]
        lo, hi = reduce(np.minimum, one_by_one), reduce(np.maximum, one_by_one)
    return Boxes((lo + hi) / 2.0, (hi - lo) / 2.0)


def morton_codes(points: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
    """Return the positions (n,) of points (n, 3) along a Morton curve.

    Points that are neighbours on the curve are mostly near each other in space. A point with NaN or
    infinite coordinates has an arbitrary position.
    """
    found = np.zeros(len(points), np.int64)
    finite = points[np.isfinite(points).all(axis=1)]
    if not len(finite):
        return found
    lo = finite.min(axis=0)
    size = float((finite.max(axis=0) - lo).max())
    scale = CELLS / size if size > 0.0 else 0.0
    for axis in range(3):
        with np.errstate(invalid="ignore"):
            cells = ((points[:, axis] - lo[axis]) * scale).astype(np.int64)
        found |= (SPREAD[cells & LOW] | SPREAD[cells >> HALF & LOW] << 3 * HALF) << axis
    return found


# `RayTree`: rays against very many triangles.

# All boxes of this level (512 triangles) that a ray crosses are found first. Then they are opened,
# the nearest first.
MIDDLE = 2
# The most boxes that a ray opens at once; their number doubles up to this one.
MOST_OPENED = 16
# The most triangles, and the most rays, in one batch, to bound the memory.
TRIANGLES_AT_ONCE = 1 << 17
RAYS_AT_ONCE = 1024


@dataclass(frozen=True)
class _Rays:
    """k rays, with vectors that are computed once for each ray.

    Attributes
    ----------
    origins, directions
        The origins (k, 3) and the unit directions (k, 3).
    across, up
        Unit vectors (k, 3) perpendicular to the directions.
    inverse
        The reciprocals (k, 3) of the directions' components.
    limits
        The lengths (k,).
    """

    origins: Array
    directions: Array
    across: Array
    up: Array
    inverse: Array
    limits: Array

    def of(self, which: Index | slice) -> _Rays:
        """Return the rays with these indices."""
        return _Rays(*(part[which] for part in vars(self).values()))


class RayTree:
    """A bounding volume hierarchy, which casts rays against very many triangles.

    The triangles (m, 3) are given by indices into `points` (n, 3). The arrays are not copied.
    Triangles with a NaN or infinite corner are never hit.
    """

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
        self._margin = ROUNDING * size

    def meet(self, origins: Array, directions: Array, limits: Array) -> tuple[Array, Index]:
        """Cast rays, and return the distance (k,) and the triangle (k,) of each ray's nearest hit.

        A ray without a hit has distance inf and triangle -1.

        Parameters
        ----------
        origins, directions
            The rays (k, 3). Directions can have any length.
        limits
            The distances (k,) up to which hits count.
        """
        far, hit_triangle = np.full(len(origins), np.inf), np.full(len(origins), -1, np.intp)
        for part in _parts(len(origins), RAYS_AT_ONCE):
            rays = _rays(*(np.asarray(a[part], float) for a in (origins, directions, limits)))
            far[part], hit_triangle[part] = self._meet(rays)
        return far, hit_triangle

    def ray_cast(
        self, origin: Array, direction: Array, distance: float = np.inf
    ) -> tuple[Array, Array, int, float] | tuple[None, None, None, None]:
        """Cast a single ray, and return point, normal, triangle and distance of the nearest hit.

        Without a hit, return four times None. The result has the form of Blender's
        `BVHTree.ray_cast`.
        """
        start, way = np.asarray(origin, float), np.asarray(direction, float)
        far, hit_triangle = self.meet(start[None], way[None], np.array([distance]))
        if hit_triangle[0] < 0:
            return None, None, None, None
        corners = self._points[self._triangles[hit_triangle[0]]].astype(float)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        size = float(np.linalg.norm(normal))
        point = start + way / np.linalg.norm(way) * far[0]
        return point, normal / size if size else normal, int(hit_triangle[0]), float(far[0])

    def _meet(self, rays: _Rays) -> tuple[Array, Index]:
        best, hit_triangle = rays.limits.copy(), np.full(len(rays.limits), -1, np.intp)
        middle = min(MIDDLE, len(self._levels) - 1)
        ray, box, enter = self._descend(rays, len(self._levels), middle, *_all_pairs(0, 0))
        nearest = np.lexsort((enter, ray))
        ray, box, enter = ray[nearest], box[nearest], enter[nearest]
        following = np.searchsorted(ray, np.arange(len(best)))
        ends = np.searchsorted(ray, np.arange(len(best)), side="right")
        open_now = 1
        while True:
            # The next boxes of each ray, except boxes behind a triangle that the ray already hit.
            next_ones = following[:, None] + np.arange(open_now)
            exists = next_ones < ends[:, None]
            pairs = next_ones[exists]
            pairs = pairs[enter[pairs] <= best[ray[pairs]]]
            if not len(pairs):
                return np.where(hit_triangle >= 0, best, np.inf), hit_triangle
            following += open_now
            limited = replace(rays, limits=best)
            leaf_ray, leaf, _ = self._descend(limited, middle, 0, ray[pairs], box[pairs])
            for part in _parts(len(leaf), TRIANGLES_AT_ONCE // WITHIN):
                self._hit_triangles(rays, leaf_ray[part], leaf[part], best, hit_triangle)
            open_now = min(2 * open_now, MOST_OPENED)

    def _descend(
        self, rays: _Rays, level: int, last: int, ray: Index, box: Index
    ) -> tuple[Index, Index, Array]:
        """Return ray, box and distance of entry for all boxes of level `last` that a ray enters.

        Only boxes inside the given boxes of `level` are searched. If `level` is above the top
        level, all boxes are.
        """
        if level == len(self._levels):
            ray, box = _all_pairs(len(rays.limits), len(self._levels[-1][0]))
            ray, box, enter = self._entered(rays, len(self._levels) - 1, ray, box)
            level -= 1
        else:
            enter = np.zeros(len(ray))
        while level > last:
            level -= 1
            below = box[:, None] * WITHIN + np.arange(WITHIN)
            exists = below < len(self._levels[level][0])
            each = np.broadcast_to(ray[:, None], below.shape)[exists]
            ray, box, enter = self._entered(rays, level, each, below[exists])
        return ray, box, enter

    def _entered(
        self, rays: _Rays, level: int, ray: Index, box: Index
    ) -> tuple[Index, Index, Array]:
        """Return ray, box and distance of entry of those pairs whose ray enters the box."""
        lo, hi = self._levels[level]
        enter, leave = np.zeros(len(ray)), rays.limits[ray]
        with np.errstate(invalid="ignore", over="ignore"):
            for axis in range(3):
                start, inverse = rays.origins[ray, axis], rays.inverse[ray, axis]
                # The margin comes last, because single precision would lose it.
                one = (lo[box, axis] - start - self._margin) * inverse
                two = (hi[box, axis] - start + self._margin) * inverse
                # fmin and fmax ignore the NaN of a ray that runs in the plane of a face.
                enter = np.fmax(enter, np.fmin(one, two))
                leave = np.fmin(leave, np.fmax(one, two))
        crossed = np.flatnonzero(enter <= leave)
        return ray[crossed], box[crossed], enter[crossed]

    def _hit_triangles(
        self, rays: _Rays, ray: Index, leaf: Index, best: Array, hit_triangle: Index
    ) -> None:
        """Test rays against the triangles in leaf boxes; update `best` and `hit_triangle` in place.

        `best` has the distance of each ray's nearest hit, `hit_triangle` its triangle or -1.
        """
        places = leaf[:, None] * WITHIN + np.arange(WITHIN)
        exists = places < len(self._order)
        ray = np.broadcast_to(ray[:, None], places.shape)[exists]
        triangle = self._order[places[exists]]
        some = rays.of(ray)
        x, y, z = [], [], []
        for corner in range(3):
            point = self._points[self._triangles[triangle, corner]] - some.origins
            x.append(_dot(point, some.across))
            y.append(_dot(point, some.up))
            z.append(_dot(point, some.directions))
        # Triangles use the same numbers for a common edge: no ray slips through between them.
        sides = [x[i] * y[j] - y[i] * x[j] for i, j in ((1, 2), (2, 0), (0, 1))]
        inside = np.logical_and.reduce([side >= 0.0 for side in sides])
        inside |= np.logical_and.reduce([side <= 0.0 for side in sides])
        whole = sides[0] + sides[1] + sides[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (sides[0] * z[0] + sides[1] * z[1] + sides[2] * z[2]) / whole
            hits = np.flatnonzero(inside & (far >= 0.0) & (far <= best[ray]))
        # The nearest hit of each ray; at equal distances, the triangle with the lower number.
        hits = hits[np.lexsort((triangle[hits], far[hits], ray[hits]))]
        _, first = np.unique(ray[hits], return_index=True)
        hits = hits[first]
        row = ray[hits]
        nearer = (
            (far[hits] < best[row]) | (hit_triangle[row] < 0) | (triangle[hits] < hit_triangle[row])
        )
        best[row[nearer]], hit_triangle[row[nearer]] = far[hits[nearer]], triangle[hits[nearer]]


def _rays(origins: Array, directions: Array, limits: Array) -> _Rays:
    ways = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    # The axis that is least along the ray is farthest from being parallel to it.
    other = np.eye(3)[np.argmin(np.abs(ways), axis=1)]
    across = np.cross(ways, other)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        return _Rays(origins, ways, across, np.cross(ways, across), 1.0 / ways, limits)


def _dot(one: Array, two: Array) -> Array:
    """Return the scalar products (k,) of vectors (k, 3)."""
    # Written out, so that rounding does not depend on the position of a vector in the array.
    found: Array = one[:, 0] * two[:, 0] + one[:, 1] * two[:, 1] + one[:, 2] * two[:, 2]
    return found


def _all_pairs(rays: int, boxes: int) -> tuple[Index, Index]:
    return np.repeat(np.arange(rays), boxes), np.tile(np.arange(boxes), rays)


def _around(rows: NDArray[np.float32], extreme: np.ufunc) -> NDArray[np.float32]:
    """Return the least or greatest coordinates of each group of WITHIN successive rows (n, 3)."""
    # numpy's own reduction takes five times as long along so short an axis.
    missing = -len(rows) % WITHIN
    found = np.concatenate([rows, np.repeat(rows[-1:], missing, axis=0)]).reshape(-1, WITHIN, 3)
    while found.shape[1] > 1:
        half = found.shape[1] // 2
        found = extreme(found[:, :half], found[:, half:])
    return np.asarray(found[:, 0])


def _parts(count: int, size: int = TRIANGLES_AT_ONCE) -> Iterator[slice]:
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))
