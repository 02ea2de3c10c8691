# SPDX-License-Identifier: GPL-3.0-or-later
"""A bounding volume hierarchy of triangles that finds those near a moving ray.

While its two ends move in straight lines, a ray stays within the convex hull of their four end
points. A box that a plane separates from this hull cannot contain a crossing. The tests use the
planes perpendicular to the world axes, to the ray, to its motion, and to both (separating axes).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model import Array

Index = NDArray[np.intp]
# Children of a box: 4 is as fast, 16 and 32 are slower.
WITHIN = 8
# Pairs of rays and boxes compared at once, to bound the memory.
PAIRS_AT_ONCE = 50_000
# Neighbouring rays that descend the hierarchy as one bundle; larger bundles overlap more boxes.
TOGETHER = 8
# Up to this many pairs of rays and triangles the hierarchy costs more than it saves.
FEW = 200
# Boxes are enlarged by this share of the largest coordinate, far more than rounding errors.
ROUNDING = 1e-9
# Cells of the Morton curve per side: 2^21, because three cell numbers fit into 64 bits.
CELLS = 2.0**21 - 1.0
# SPREAD[n] has the bits of n at every third place; a cell number is looked up in two halves.
HALF = 11
LOW = 2**HALF - 1
SPREAD = np.zeros(2**HALF, np.int64)
for bit in range(HALF):
    SPREAD |= (np.arange(2**HALF) >> bit & 1) << 3 * bit


@dataclass(frozen=True)
class Boxes:
    """Axis-aligned boxes (n,): `centre` (n, 3) and half of their size, `half` (n, 3)."""

    centre: Array
    half: Array

    def overlap(self, rows: Index, others: Boxes, which: Index, room: float) -> NDArray[np.bool_]:
        """Whether the pairs (q,) of these boxes `rows` and the others `which` are less than `room`
        apart along each axis."""
        apart = np.abs(others.centre[which] - self.centre[rows])
        return _all_three(apart <= others.half[which] + self.half[rows] + room)

    def around(self) -> Boxes:
        """The boxes around every WITHIN consecutive boxes."""
        starts = np.arange(0, len(self.centre), WITHIN)
        lo = np.minimum.reduceat(self.centre - self.half, starts)
        hi = np.maximum.reduceat(self.centre + self.half, starts)
        return Boxes((lo + hi) / 2.0, (hi - lo) / 2.0)


class SweptBundles:
    """Bounds of n bundles of k moving rays, whose ends are `before` and `after` (n, k, 2, 3)."""

    def __init__(self, before: Array, after: Array) -> None:
        points = np.concatenate([before, after], axis=1).reshape(len(before), -1, 3)
        self.box = _boxes(points)
        along = points[:, 1::2].sum(axis=1) - points[:, ::2].sum(axis=1)
        motion = (after - before).reshape(len(before), -1, 3)
        farthest = np.argmax((motion * motion).sum(axis=2), axis=1)
        across = np.cross(along, motion[np.arange(len(motion)), farthest])
        # A ray at rest, or moving along itself, has no motion across: any perpendicular will do.
        still = np.abs(across).max(axis=1) <= ROUNDING * np.abs(along).max(axis=1) ** 2
        thinnest = np.eye(3)[np.argmin(np.abs(along[still]), axis=1)]
        across[still] = np.cross(along[still], thinnest)
        axes = np.stack([along, across, np.cross(across, along)], axis=1)
        # An axis of length zero separates nothing.
        sizes = np.linalg.norm(axes, axis=2, keepdims=True)
        self.axes = np.divide(axes, sizes, out=np.zeros_like(axes), where=sizes > 0.0)
        self.turned = _boxes(points @ self.axes.swapaxes(1, 2))
        self.turned_axes = np.abs(self.axes)

    def overlap(self, rows: Index, boxes: Boxes, which: Index, room: float) -> NDArray[np.bool_]:
        """Whether no tested plane separates the pairs (q,) of the bundles `rows` and the boxes
        `which` by more than `room`."""
        near = self.box.overlap(rows, boxes, which, room)
        left = np.flatnonzero(near)
        rows, which = rows[left], which[left]
        apart = np.einsum("qac,qc->qa", self.axes[rows], boxes.centre[which])
        apart -= self.turned.centre[rows]
        reach = np.einsum("qac,qc->qa", self.turned_axes[rows], boxes.half[which])
        reach += self.turned.half[rows] + room
        near[left] = _all_three(np.abs(apart) <= reach)
        return near


class TriangleTree:
    """Triangles (m, 3, 3) in a hierarchy of boxes; those with a NaN or infinite corner are left
    out."""

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
        """Candidates for crossings in batches: piece (q,), ray (q,) and triangle (q,). They include
        all crossings. `before` and `after` (n, k, 2, 3): the ends of k neighbouring rays at the
        begin and the end of n pieces of their paths, in which they move in straight lines."""
        if not len(self._numbers) or not before.size:
            return
        both = np.stack([before, after]).reshape(1, -1, 3)
        room = ROUNDING * max(self._largest, float(np.abs(both).max()))
        first = np.zeros(1, np.intp)
        if not _boxes(both).overlap(first, self._levels[-1], first, room).any():
            return
        pieces, rays = before.shape[:2]
        if pieces * rays * len(self._numbers) <= FEW:
            piece, ray, which = np.indices((pieces, rays, len(self._numbers))).reshape(3, -1)
            yield piece, ray, self._numbers[which]
            return
        bundles = -(-rays // TOGETHER)
        size = -(-rays // bundles)
        # The last bundle is filled up with the last ray.
        bundled = np.minimum(np.arange(bundles * size), rays - 1)
        swept = SweptBundles(
            *(at[:, bundled].reshape(pieces * bundles, size, 2, 3) for at in (before, after))
        )
        rows, top = np.arange(pieces * bundles), len(self._levels) - 1
        for row, which in self._descend(swept, room, top, rows, np.zeros_like(rows)):
            piece, bundle = np.divmod(row, bundles)
            if size == 1:
                yield piece, bundle, self._numbers[which]
                continue
            at_once = max(1, PAIRS_AT_ONCE // size)
            for part in (slice(i, i + at_once) for i in range(0, len(row), at_once)):
                some = bundle[part, None] * size + np.arange(size)
                there = some < rays
                single = (piece[part, None] * rays + some)[there]
                triangle = np.broadcast_to(which[part, None], some.shape)[there]
                near = self._rays_near(before, after, room, single, triangle)
                yield *np.divmod(single[near], rays), self._numbers[triangle[near]]

    def _rays_near(
        self, before: Array, after: Array, room: float, single: Index, which: Index
    ) -> NDArray[np.bool_]:
        """Whether the pairs (q,) of a single ray and a triangle are near each other."""
        known, place = np.unique(single, return_inverse=True)
        swept = SweptBundles(*(at.reshape(-1, 1, 2, 3)[known] for at in (before, after)))
        return swept.overlap(place, self._levels[0], which, room)

    def _descend(
        self, swept: SweptBundles, room: float, level: int, rows: Index, which: Index
    ) -> Iterator[tuple[Index, Index]]:
        """Pairs of a bundle and a leaf box that overlap, below the pairs (q,) of a bundle and a box
        of a level."""
        boxes = self._levels[level]
        for start in range(0, len(rows), PAIRS_AT_ONCE):
            some = slice(start, start + PAIRS_AT_ONCE)
            near = swept.overlap(rows[some], boxes, which[some], room)
            left, found = rows[some][near], which[some][near]
            if not len(left):
                continue
            if level == 0:
                yield left, found
                continue
            below = found[:, None] * WITHIN + np.arange(WITHIN)
            there = below < len(self._levels[level - 1].centre)
            left = np.broadcast_to(left[:, None], below.shape)
            yield from self._descend(swept, room, level - 1, left[there], below[there])


def _all_three(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """`mask.all(axis=1)` (n,) of a mask (n, 3), three times as fast."""
    return np.asarray(mask[:, 0] & mask[:, 1] & mask[:, 2])


def _boxes(points: Array) -> Boxes:
    """The boxes (n,) around points (n, m, 3)."""
    if points.shape[1] > 4:
        lo, hi = points.min(axis=1), points.max(axis=1)
    else:
        # numpy's reductions are slow along such a short axis.
        one_by_one = [points[:, i] for i in range(points.shape[1])]
        lo, hi = reduce(np.minimum, one_by_one), reduce(np.maximum, one_by_one)
    return Boxes((lo + hi) / 2.0, (hi - lo) / 2.0)


def morton_codes(points: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
    """The positions (n,) of points (n, 3) on a Morton curve, along which neighbours are mostly
    near; that of a point with NaN or infinite coordinates is arbitrary."""
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
