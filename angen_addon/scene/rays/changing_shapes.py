# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against the triangles of a surface that changes shape from frame to frame.

A hierarchy of it would be built anew for a few rays. Instead, triangles and rays are seen from
where the rays come from, as in a picture: most triangles of a person lie between the rays of a
sensor, and a grid of cells with rays and without leaves them out at once. What is left is met
exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array

Index = NDArray[np.intp]
# A ray this little beside a triangle, as share of it, meets it: no gap opens along an edge, and one
# that goes through the edge itself is not lost to the rounding of single precision.
RIM = 1e-7
# Cells along an axis of the picture; how near, in cells, to an edge is on both sides of it; the
# least size of the picture of the rays, as share of 1; by how much a triangle is larger; and up to
# which size in cells it is told whether a square holds a ray.
CELLS = 128
EVERY_CELL = np.arange(CELLS * CELLS + 1)
EDGE = 0.01
LEAST_SIZE = 1e-2
BORDER = 1e-6
SQUARES = 3
# Cosine: rays within this of their middle are in one picture, others in several.
WIDE = 0.35
# Share of the largest size there is: nearer than this to the picture's eye nothing is drawn.
TOO_NEAR = 1e-6
# Lines this near to a point, as share of 1 and of how far away that is, go through it.
THROUGH = 1e-9


def apex_of(origins: Array, directions: Array) -> Array | None:
    """The point (3,) through which the lines of rays (n, 3) all go; None where there is none, or
    they are all parallel."""
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    total = across.sum(axis=0)
    if np.linalg.cond(total) > 1e8:
        return None if len(origins) > 1 and np.ptp(origins, axis=0).any() else origins[0]
    middle = origins.mean(axis=0)
    point = np.linalg.solve(total, np.einsum("nij,nj->i", across, origins - middle))
    aside = np.einsum("nij,nj->ni", across, point + middle - origins)
    size = 1.0 + float(np.abs(origins - middle).max())
    found: Array = point + middle
    return found if float(np.abs(aside).max()) <= THROUGH * size else None


@dataclass(frozen=True)
class FrameHits:
    """The hits (p,) of some rays at some frames, in the order of the frames: the `frame`, the
    `ray`, how `far` it goes, in lengths of its direction, and to which `triangle`."""

    frame: Index
    ray: Index
    far: Array
    triangle: Index

    def at(self, which: Any) -> FrameHits:
        return FrameHits(self.frame[which], self.ray[which], self.far[which], self.triangle[which])


def meet(
    points: Any,
    corners: Index,
    matrix: Array,
    inverse: Array,
    pictures: Sequence[RayPicture],
    origins: Array,
    directions: Array,
    asked: NDArray[np.bool_],
) -> FrameHits:
    """The nearest of the triangles `corners` (3, m) that rays (n) meet at each of some frames (k):
    their `points` (k, 3, v) are in the space of a solid whose matrices (k, 4, 4) and their inverses
    are given. The rays have `origins` and `directions` (n, 3), and `pictures` in which they are
    seen; `asked` (k, n): which of them may meet it."""
    found = []
    for picture in pictures:
        frame, ray, triangle = picture.pairs(points, corners, matrix)
        some = np.flatnonzero(asked[frame, ray])
        frame, ray, triangle = frame[some], ray[some], triangle[some]
        back = inverse[frame]
        starts = turned(origins[ray], back) + back[:, :3, 3]
        ways = turned(directions[ray], back)
        far = _lengths(points, frame, corners[:, triangle], starts, ways)
        hit = np.flatnonzero(far < np.inf)
        found.append(FrameHits(frame[hit], ray[hit], far[hit], triangle[hit]))
    hits = found[0]
    if len(found) > 1:
        hits = FrameHits(
            *(np.concatenate([getattr(h, f.name) for h in found]) for f in fields(FrameHits))
        )
    hits = hits.at(np.lexsort((hits.triangle, hits.far, hits.ray, hits.frame)))
    which = hits.frame * len(origins) + hits.ray
    return hits.at(np.flatnonzero(which != np.concatenate([[-1], which[:-1]])))


def turned(vectors: Array, matrix: Array) -> Array:
    """Vectors (n, 3), turned by a matrix, or each by its own (n, 4, 4); each the same to the bit
    whatever others there are."""
    x, y, z = (vectors[:, i : i + 1] for i in range(3))
    result: Array = x * matrix[..., :3, 0] + y * matrix[..., :3, 1] + z * matrix[..., :3, 2]
    return result


def pictures_of(origins: Array, ways: Array, apex: Array | None) -> list[RayPicture]:
    """Pictures in which all rays from `origins` (n, 3) along unit vectors (n, 3) are seen; `apex`
    (3,): where their lines all meet, if they do. Rays that go towards it, as those to a lamp do,
    are looked back along too."""
    every = np.arange(len(origins))
    if apex is None:
        return [RayPicture(every[i : i + 1], ways[i : i + 1], origins[i]) for i in every.tolist()]
    ahead = ((origins - apex) * ways).sum(axis=1)
    behind = bool((ahead < -THROUGH * float(np.abs(ahead).max(initial=0.0))).any())
    found = []
    for looks in (ways, -ways) if behind else (ways,):
        found += [RayPicture(which, looks[which], apex) for which in _narrow(looks)]
    return found


def _narrow(ways: Array) -> list[Index]:
    """Which of some unit vectors (n, 3) fit into one picture."""
    every = np.arange(len(ways))
    middle = ways.mean(axis=0)
    if float((ways @ middle).min()) > WIDE * float(np.linalg.norm(middle)) > 0.0:
        return [every]
    # One picture for each side of a cube about the eye.
    axis = np.abs(ways).argmax(axis=1)
    side = 2 * axis + (ways[every, axis] > 0.0)
    return [np.flatnonzero(side == one) for one in np.unique(side).tolist()]


class RayPicture:
    """The `rays` (n,) of a bundle that one picture holds: their directions `ways` (n, 3) from an
    `eye` (3,), and the grid of the cells that they are in."""

    def __init__(self, rays: Index, ways: Array, eye: Array) -> None:
        self._rays, self._eye = rays, eye
        self._axes = _axes(ways)
        there = self._axes @ ways.T
        self._places = there[:2] / there[2]
        self._grid = RayCells(self._places)

    def pairs(self, points: Any, corners: Index, matrix: Array) -> tuple[Index, Index, Index]:
        """Frames, and rays and triangles (p,) that lie in one place of the picture there: no fewer
        than meet."""
        turn = self._axes @ matrix[:, :3, :3]
        shift = (matrix[:, :3, 3] - self._eye) @ self._axes.T
        seen = turn @ points.astype(np.float64) + shift[:, :, None]
        depth = seen[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = seen[:, 0] / depth, seen[:, 1] / depth
        rows = self._grid.cells(y, 1)
        below, above = _bounds(rows[:, own] for own in corners)
        close = TOO_NEAR * np.abs(depth).max(axis=1)
        beside = []
        for frame in np.flatnonzero(depth.min(axis=1) <= close).tolist():
            # What reaches beside the eye or behind it has no place in the picture: it may be
            # anywhere.
            off = depth[frame] <= close[frame]
            which = np.flatnonzero(off[corners].any(axis=0))
            ahead = ~off[corners[:, which]].all(axis=0)
            below[frame, which], above[frame, which] = 0, np.where(ahead, CELLS - 1, 0)
            beside.append(frame * corners.shape[1] + which[ahead])
            x[frame, off] = y[frame, off] = np.nan
        # A fan of rays lies in one row of the picture, and most triangles in others.
        near = self._grid.rows_hold(below, above)
        frame, triangle = np.divmod(near, corners.shape[1])
        left, right = _bounds(self._grid.cells(x[frame, own[triangle]], 0) for own in corners)
        if beside:
            anywhere = np.isin(near, np.concatenate(beside))
            left[anywhere], right[anywhere] = 0, CELLS - 1
        bounds = left, right, below.ravel()[near], above.ravel()[near]
        some = self._grid.may_hold(*bounds)
        near, bounds = near[some], tuple(edge[some] for edge in bounds)
        of, ray = self._grid.pairs(*bounds)
        frame, triangle = np.divmod(near[of], corners.shape[1])
        inside = np.ones(len(ray), bool)
        with np.errstate(invalid="ignore"):
            for places, at in ((x, self._places[0][ray]), (y, self._places[1][ray])):
                least, most = _bounds(places[frame, own] for own in corners[:, triangle])
                slack = BORDER * (1.0 + np.abs(at))
                inside &= ~((least > at + slack) | (most < at - slack))
        return frame[inside], self._rays[ray[inside]], triangle[inside]


def _bounds(ends: Iterable[Any]) -> tuple[Any, Any]:
    """Least and greatest of three arrays: numpy is slow to find them along an axis."""
    one, two, three = ends
    return np.minimum(np.minimum(one, two), three), np.maximum(np.maximum(one, two), three)


def _axes(ways: Array) -> Array:
    """Right, up and ahead (3, 3) of a picture with these rays in it: a fan lies from left to
    right."""
    ahead = (ways / np.linalg.norm(ways, axis=1)[:, None]).sum(axis=0)
    ahead /= np.linalg.norm(ahead)
    aside = ways - (ways @ ahead)[:, None] * ahead
    spread, axes = np.linalg.eigh(aside.T @ aside)
    right = axes[:, 2] if spread[2] > THROUGH else np.eye(3)[int(np.argmin(np.abs(ahead)))]
    up = np.cross(ahead, right)
    up /= np.linalg.norm(up)
    return np.stack([np.cross(up, ahead), up, ahead])


class RayCells:
    """The places `rays` (2, n) of rays in a picture, by cells of it."""

    def __init__(self, rays: Array) -> None:
        lo, hi = rays.min(axis=1), rays.max(axis=1)
        size = np.maximum(hi - lo, LEAST_SIZE * (1.0 + np.abs(rays).max()))
        # A ring of cells without rays takes up all that is outside.
        self._scale = (CELLS - 2) * (1.0 - 4.0 * EDGE / CELLS) / size
        self._lo = (lo + hi) / 2.0 - CELLS / 2.0 / self._scale
        self._put(rays)

    def _put(self, rays: Array) -> None:
        """Puts each ray into its cell; one near the edge of a cell into both."""
        ray = np.arange(rays.shape[1])
        edge = np.array([-EDGE, EDGE])[:, None] / self._scale[:, None, None]
        moved = [self.cells(rays[axis] + edge[axis], axis).astype(np.intp) for axis in (0, 1)]
        cells = [moved[0][i] * CELLS + moved[1][j] for i in (0, 1) for j in (0, 1)]
        also = [np.flatnonzero(cell != cells[0]) for cell in cells]
        cell = np.concatenate([cells[0], *(c[which] for c, which in zip(cells, also, strict=True))])
        order = np.argsort(cell, kind="stable")
        self._ray = np.concatenate([ray, *also])[order]
        self._start = np.searchsorted(cell[order], EVERY_CELL)
        self._next_row = _next(np.isin(np.arange(CELLS), cell % CELLS))
        held = np.zeros((CELLS, CELLS), bool)
        held.ravel()[cell] = True
        self._held = np.ones((SQUARES + 1, CELLS, CELLS), bool)
        for size in range(SQUARES):
            self._held[size] = held
            wider = held.copy()
            wider[:-1] |= held[1:]
            held = wider.copy()
            held[:, :-1] |= wider[:, 1:]

    def cells(self, places: Array, axis: int) -> NDArray[np.uint8]:
        """The column or row (k,) of places (k,)."""
        at = (places - self._lo[axis]) * self._scale[axis]
        with np.errstate(invalid="ignore"):
            return np.fmax(np.fmin(at, CELLS - 1), 0.0).astype(np.uint8)

    def rows_hold(self, below: Index, above: Index) -> Index:
        """Which ranges of rows, in all, hold a ray."""
        return np.flatnonzero(self._next_row.take(below) <= above)

    def may_hold(self, left: Index, right: Index, below: Index, above: Index) -> Index:
        """Which rectangles of cells, in all, may hold a ray."""
        size = np.minimum(np.maximum(right - left, above - below), SQUARES).astype(np.intp)
        return np.flatnonzero(self._held.ravel().take((size * CELLS + left) * CELLS + below))

    def pairs(self, left: Index, right: Index, below: Index, above: Index) -> tuple[Index, Index]:
        """Rectangles of cells, each with a ray (p,) that is in it."""
        which, column = _spread(left.astype(np.intp), right.astype(np.intp) + 1)
        first = self._start[column * CELLS + below[which]]
        end = self._start[column * CELLS + above[which] + 1]
        of, at = _spread(first, end)
        return which[of], self._ray[at]


def _next(held: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Of each row, and of those above it, the first (CELLS,) that is held; CELLS: there is none."""
    found = np.where(held, np.arange(CELLS), CELLS)
    return np.minimum.accumulate(found[::-1])[::-1].astype(np.uint8)


def _spread(first: Index, end: Index) -> tuple[Index, Index]:
    """All members (p,) of ranges (m,), and for each the number of its range."""
    counts = end - first
    which = np.repeat(np.arange(len(first)), counts)
    start = first - (np.cumsum(counts) - counts)
    return which, np.arange(len(which)) + start[which]


def _lengths(points: Any, frame: Index, corners: Index, origins: Array, ways: Array) -> Array:
    """How far (p,) each ray goes to its triangle, in lengths of its way; inf where it misses it:
    Möller and Trumbore's test, about the ray's origin."""
    corner, one, two = (points[frame, :, at].astype(np.float64) for at in corners)
    one, two, start = one - corner, two - corner, origins - corner
    across, turned = _cross(ways, two), _cross(start, one)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / _dot(one, across)
        u, v = _dot(start, across) * inverse, _dot(ways, turned) * inverse
        far = _dot(two, turned) * inverse
        met = (u >= -RIM) & (v >= -RIM) & (u + v <= 1.0 + RIM) & (far >= 0.0)
    result: Array = np.where(met, far, np.inf)
    return result


def _dot(one: Array, two: Array) -> Array:
    product = one * two
    result: Array = product[:, 0] + product[:, 1] + product[:, 2]
    return result


def _cross(one: Array, two: Array) -> Array:
    """Vector products along the last axis; numpy's own takes several times as long on few."""
    a, b, c = one[:, 0], one[:, 1], one[:, 2]
    x, y, z = two[:, 0], two[:, 1], two[:, 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)
