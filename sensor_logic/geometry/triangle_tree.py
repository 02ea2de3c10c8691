# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles in nested boxes, so that what looks for those near a moving ray asks only few.

Between two straight ways of its ends a ray stays within the convex hull of its four end points.
What a plane parts from them it cannot meet; asked are the planes across the axes of space, and
those across the ray, across the way that it goes, and along both: the hull is thinnest there.
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
# How many boxes are within one: 4 is as fast, 16 and 32 are slower.
WITHIN = 8
# Pairs of rays and boxes compared at once, to bound the memory.
PAIRS_AT_ONCE = 50_000
# Rays side by side that go down the boxes together; together they are thicker than one is.
TOGETHER = 8
# So few pairs of rays and triangles are asked sooner than sorted out.
FEW = 200
# Boxes are larger by this share of the largest coordinate: far more than rounding makes of it.
ROUNDING = 1e-9
# Cells of the curve along which triangles are sorted, to a side: 2^21, which is as much as three
# numbers have room for in one of 64 bits.
CELLS = 2.0**21 - 1.0
# A cell's number is looked up in halves: of each half number its bits, moved apart to every third
# place.
HALF = 11
LOW = 2**HALF - 1
APART = np.zeros(2**HALF, np.int64)
for bit in range(HALF):
    APART |= (np.arange(2**HALF) >> bit & 1) << 3 * bit


@dataclass(frozen=True)
class Boxes:
    """Boxes (n,) along the axes of space: `centre` (n, 3) and `half` (n, 3) of their size."""

    centre: Array
    half: Array

    def meet(self, rows: Index, others: Boxes, which: Index, room: float) -> NDArray[np.bool_]:
        """Of pairs (q,) of one of them and another, those less than `room` apart along each
        axis."""
        apart = np.abs(others.centre[which] - self.centre[rows])
        return _all_three(apart <= others.half[which] + self.half[rows] + room)

    def around(self) -> Boxes:
        """The boxes around each WITHIN of them."""
        starts = np.arange(0, len(self.centre), WITHIN)
        lo = np.minimum.reduceat(self.centre - self.half, starts)
        hi = np.maximum.reduceat(self.centre + self.half, starts)
        return Boxes((lo + hi) / 2.0, (hi - lo) / 2.0)


class Strips:
    """What n bundles of k rays sweep: `before` and `after` (n, k, 2, 3) are their ends."""

    def __init__(self, before: Array, after: Array) -> None:
        points = np.concatenate([before, after], axis=1).reshape(len(before), -1, 3)
        self.box = _boxes(points)
        along = points[:, 1::2].sum(axis=1) - points[:, ::2].sum(axis=1)
        ways = (after - before).reshape(len(before), -1, 3)
        farthest = np.argmax((ways * ways).sum(axis=2), axis=1)
        across = np.cross(along, ways[np.arange(len(ways)), farthest])
        # One that stands, or goes along itself, is thin whichever way one looks.
        still = np.abs(across).max(axis=1) <= ROUNDING * np.abs(along).max(axis=1) ** 2
        thinnest = np.eye(3)[np.argmin(np.abs(along[still]), axis=1)]
        across[still] = np.cross(along[still], thinnest)
        axes = np.stack([along, across, np.cross(across, along)], axis=1)
        # An axis without a length parts nothing.
        sizes = np.linalg.norm(axes, axis=2, keepdims=True)
        self.axes = np.divide(axes, sizes, out=np.zeros_like(axes), where=sizes > 0.0)
        self.turned = _boxes(points @ self.axes.swapaxes(1, 2))
        self.turned_axes = np.abs(self.axes)

    def meet(self, rows: Index, boxes: Boxes, which: Index, room: float) -> NDArray[np.bool_]:
        """Of pairs (q,) of a strip and a box, those that no plane parts by more than `room`."""
        near = self.box.meet(rows, boxes, which, room)
        left = np.flatnonzero(near)
        rows, which = rows[left], which[left]
        apart = np.einsum("qac,qc->qa", self.axes[rows], boxes.centre[which])
        apart -= self.turned.centre[rows]
        reach = np.einsum("qac,qc->qa", self.turned_axes[rows], boxes.half[which])
        reach += self.turned.half[rows] + room
        near[left] = _all_three(np.abs(apart) <= reach)
        return near


class TriangleTree:
    """Triangles (m, 3, 3), and the boxes around them; those with a corner nowhere are left out."""

    def __init__(self, corners: Array) -> None:
        self.corners = corners
        somewhere = np.flatnonzero(np.isfinite(corners).all(axis=(1, 2)))
        boxes = _boxes(corners[somewhere])
        order = np.argsort(along_a_curve(boxes.centre), kind="stable")
        # Numbers of the triangles, as the smallest boxes are sorted.
        self._numbers = somewhere[order]
        self._levels = [Boxes(boxes.centre[order], boxes.half[order])]
        while len(self._levels[-1].centre) > 1:
            self._levels.append(self._levels[-1].around())
        self._largest = float(np.abs(corners[somewhere]).max(initial=0.0))

    def near(self, before: Array, after: Array) -> Iterator[tuple[Index, Index, Index]]:
        """Some at a time, the piece (q,), the ray (q,) and a triangle (q,) that this may meet then;
        among them are all that meet. `before` and `after` (n, k, 2, 3): the ends of k rays, side by
        side, at both ends of n pieces of their ways, between which they go straight."""
        if not len(self._numbers) or not before.size:
            return
        both = np.stack([before, after]).reshape(1, -1, 3)
        room = ROUNDING * max(self._largest, float(np.abs(both).max()))
        first = np.zeros(1, np.intp)
        if not _boxes(both).meet(first, self._levels[-1], first, room).any():
            return
        pieces, rays = before.shape[:2]
        if pieces * rays * len(self._numbers) <= FEW:
            piece, ray, which = np.indices((pieces, rays, len(self._numbers))).reshape(3, -1)
            yield piece, ray, self._numbers[which]
            return
        bundles = -(-rays // TOGETHER)
        size = -(-rays // bundles)
        # The last ray may be there several times.
        bundled = np.minimum(np.arange(bundles * size), rays - 1)
        strips = Strips(
            *(at[:, bundled].reshape(pieces * bundles, size, 2, 3) for at in (before, after))
        )
        rows, top = np.arange(pieces * bundles), len(self._levels) - 1
        for row, which in self._down(strips, room, top, rows, np.zeros_like(rows)):
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
        """Of pairs (q,) of a single ray and a triangle, those that are near one another."""
        known, place = np.unique(single, return_inverse=True)
        strips = Strips(*(at.reshape(-1, 1, 2, 3)[known] for at in (before, after)))
        return strips.meet(place, self._levels[0], which, room)

    def _down(
        self, strips: Strips, room: float, level: int, rows: Index, which: Index
    ) -> Iterator[tuple[Index, Index]]:
        """What pairs (q,) of a strip and a box of a level lead to."""
        boxes = self._levels[level]
        for start in range(0, len(rows), PAIRS_AT_ONCE):
            some = slice(start, start + PAIRS_AT_ONCE)
            near = strips.meet(rows[some], boxes, which[some], room)
            left, found = rows[some][near], which[some][near]
            if not len(left):
                continue
            if level == 0:
                yield left, found
                continue
            below = found[:, None] * WITHIN + np.arange(WITHIN)
            there = below < len(self._levels[level - 1].centre)
            left = np.broadcast_to(left[:, None], below.shape)
            yield from self._down(strips, room, level - 1, left[there], below[there])


def _all_three(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows (n,) of a mask (n, 3) that hold throughout; `all` takes three times as long."""
    return np.asarray(mask[:, 0] & mask[:, 1] & mask[:, 2])


def _boxes(points: Array) -> Boxes:
    """Around points (n, m, 3)."""
    if points.shape[1] > 4:
        lo, hi = points.min(axis=1), points.max(axis=1)
    else:
        # Along so short an axis numpy is slow.
        one_by_one = [points[:, i] for i in range(points.shape[1])]
        lo, hi = reduce(np.minimum, one_by_one), reduce(np.maximum, one_by_one)
    return Boxes((lo + hi) / 2.0, (hi - lo) / 2.0)


def along_a_curve(points: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
    """Where points (n, 3) are on Morton's curve, on which neighbours are mostly near; what is
    nowhere is anywhere on it."""
    found = np.zeros(len(points), np.int64)
    somewhere = points[np.isfinite(points).all(axis=1)]
    if not len(somewhere):
        return found
    lo = somewhere.min(axis=0)
    size = float((somewhere.max(axis=0) - lo).max())
    scale = CELLS / size if size > 0.0 else 0.0
    for axis in range(3):
        with np.errstate(invalid="ignore"):
            cells = ((points[:, axis] - lo[axis]) * scale).astype(np.int64)
        found |= (APART[cells & LOW] | APART[cells >> HALF & LOW] << 3 * HALF) << axis
    return found
