# SPDX-License-Identifier: GPL-3.0-or-later
"""Cast rays against the triangles of a surface that changes shape from frame to frame.

A tree would have to be built again at each frame for a few rays. Instead, triangles and rays are
projected onto a picture as seen from the origin of the rays. Most triangles of a person lie between
the rays of a sensor. A grid over the picture discards all triangles without a ray near them. The
remaining pairs of a ray and a triangle are tested exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array

Index = NDArray[np.intp]
# A ray beside a triangle by at most this fraction of the triangle's size still hits it. So no ray
# is lost between two triangles, or on an edge, by rounding.
RIM = 1e-7
# Cells along an axis of the picture.
CELLS = 128
EVERY_CELL = np.arange(CELLS * CELLS + 1)
# A ray nearer to the edge of a cell than this, in cells, is in both cells.
EDGE = 0.01
# The least size of a picture, relative to the largest coordinate plus 1.
LEAST_SIZE = 1e-2
# Triangles are widened by this fraction in the picture.
BORDER = 1e-6
# For squares of up to this many cells, a table says whether they contain a ray.
SQUARES = 3
# Rays fit into one picture if the cosine of their angle to the mean direction exceeds this.
WIDE = 0.2
# Points with a depth of less than this fraction of the largest depth have no place in the picture.
TOO_NEAR = 1e-6
# A line this near to a point, relative to 1 plus the point's distance, goes through the point.
THROUGH = 1e-9


def apex_of(origins: Array, directions: Array) -> Array | None:
    """Return the point (3,) where the lines of all rays meet.

    Return None if there is no such point, or if parallel rays start at different points.
    """
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
    """The p hits of rays at several frames, sorted by frame.

    Attributes
    ----------
    frame
        Indices (p,) of the frames.
    ray
        Indices (p,) of the rays.
    far
        Ranges (p,), in multiples of the length of the ray's direction.
    triangle
        Indices (p,) of the hit triangles.
    """

    frame: Index
    ray: Index
    far: Array
    triangle: Index

    def at(self, which: Any) -> FrameHits:
        """Return the hits that the index array or mask `which` selects."""
        return FrameHits(self.frame[which], self.ray[which], self.far[which], self.triangle[which])


def nearest_hits(
    points: Any,
    corners: Index,
    matrix: Array,
    inverse: Array,
    pictures: Sequence[RayPicture],
    origins: Array,
    directions: Array,
    may_hit: NDArray[np.bool_],
) -> FrameHits:
    """Return the nearest hits of rays on a mesh that changes shape, at each of k frames.

    Parameters
    ----------
    points
        Points (k, 3, v) of the mesh at each frame, in the solid's space.
    corners
        Point indices (3, m) of the triangles.
    matrix, inverse
        Matrices (k, 4, 4) of the solid to the world, and their inverses.
    pictures
        Projections that together hold all rays, as `pictures_of` returns them.
    origins, directions
        Origins (n, 3) and directions (n, 3) of the rays, in the world.
    may_hit
        Mask (k, n) of the rays that may hit the solid.

    Returns
    -------
    FrameHits
        At most one hit for each frame and ray.

    References
    ----------
    Möller and Trumbore's test of a ray and a triangle.
    """
    found = []
    for picture in pictures:
        frame, ray, triangle = picture.pairs(points, corners, matrix)
        some = np.flatnonzero(may_hit[frame, ray])
        frame, ray, triangle = frame[some], ray[some], triangle[some]
        back = inverse[frame]
        starts = rotated(origins[ray], back) + back[:, :3, 3]
        ways = rotated(directions[ray], back)
        far = _hit_distances(points, frame, corners[:, triangle], starts, ways)
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


def rotated(vectors: Array, matrix: Array) -> Array:
    """Return vectors (n, 3) rotated by one matrix, or each by its own (n, 4, 4).

    The result for a vector has the same bits whatever other vectors are passed.
    """
    x, y, z = (vectors[:, i : i + 1] for i in range(3))
    result: Array = x * matrix[..., :3, 0] + y * matrix[..., :3, 1] + z * matrix[..., :3, 2]
    return result


def pictures_of(origins: Array, ways: Array, apex: Array | None) -> list[RayPicture]:
    """Return projections (`RayPicture`) that together hold all rays.

    Rays that point towards the apex, as those to a lamp do, also get a picture of the opposite
    direction.

    Parameters
    ----------
    origins
        Origins (n, 3).
    ways
        Unit directions (n, 3).
    apex
        The point (3,) where the lines of the rays meet; None if there is none.
    """
    every = np.arange(len(origins))
    if apex is None:
        return [RayPicture(every[i : i + 1], ways[i : i + 1], origins[i]) for i in every.tolist()]
    ahead = ((origins - apex) * ways).sum(axis=1)
    behind = bool((ahead < -THROUGH * float(np.abs(ahead).max(initial=0.0))).any())
    found = []
    for looks in (ways, -ways) if behind else (ways,):
        found += [RayPicture(which, looks[which], apex) for which in _groups_by_direction(looks)]
    return found


def _groups_by_direction(directions: Array) -> list[Index]:
    """Return the indices of groups of unit vectors (n, 3) that each fit into one picture."""
    every = np.arange(len(directions))
    middle = directions.mean(axis=0)
    if float((directions @ middle).min()) > WIDE * float(np.linalg.norm(middle)) > 0.0:
        return [every]
    # One picture for each side of a cube about the eye.
    axis = np.abs(directions).argmax(axis=1)
    side = 2 * axis + (directions[every, axis] > 0.0)
    return [np.flatnonzero(side == one) for one in np.unique(side).tolist()]


class RayPicture:
    """A perspective projection of n rays of a bundle, with a grid to find rays by position.

    Parameters
    ----------
    rays
        Indices (n,) of the rays in the bundle.
    ways
        Unit directions (n, 3) in which the rays are seen from `eye`.
    eye
        The centre (3,) of the projection.
    """

    def __init__(self, rays: Index, ways: Array, eye: Array) -> None:
        self._rays, self._eye = rays, eye
        self._axes = _picture_axes(ways)
        projected = self._axes @ ways.T
        self._places = projected[:2] / projected[2]
        self._grid = RayCells(self._places)

    def pairs(self, points: Any, corners: Index, matrix: Array) -> tuple[Index, Index, Index]:
        """Return frames (p,), rays (p,) and triangles (p,) that overlap in the picture.

        Every hit is among these triples, but not every triple is a hit. The parameters are as for
        `nearest_hits`.
        """
        turn = self._axes @ matrix[:, :3, :3]
        shift = (matrix[:, :3, 3] - self._eye) @ self._axes.T
        seen = turn @ points.astype(np.float64) + shift[:, :, None]
        depth = seen[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = seen[:, 0] / depth, seen[:, 1] / depth
        rows = self._grid.cells(y, 1)
        below, above = _min_and_max(rows[:, own] for own in corners)
        close = TOO_NEAR * np.abs(depth).max(axis=1)
        beside = []
        for frame in np.flatnonzero(depth.min(axis=1) <= close).tolist():
            # A triangle that reaches beside or behind the eye may be anywhere in the picture.
            off = depth[frame] <= close[frame]
            which = np.flatnonzero(off[corners].any(axis=0))
            ahead = ~off[corners[:, which]].all(axis=0) & self._reached(seen[frame], corners, which)
            below[frame, which], above[frame, which] = 0, np.where(ahead, CELLS - 1, 0)
            beside.append(frame * corners.shape[1] + which[ahead])
            x[frame, off] = y[frame, off] = np.nan
        # A fan of rays lies in one row of the picture, and most triangles in others.
        near = self._grid.rows_hold(below, above)
        frame, triangle = np.divmod(near, corners.shape[1])
        left, right = _min_and_max(self._grid.cells(x[frame, own[triangle]], 0) for own in corners)
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
                least, most = _min_and_max(places[frame, own] for own in corners[:, triangle])
                slack = BORDER * (1.0 + np.abs(at))
                inside &= ~((least > at + slack) | (most < at - slack))
        return frame[inside], self._rays[ray[inside]], triangle[inside]

    def _reached(self, seen: Array, corners: Index, which: Index) -> NDArray[np.bool_]:
        """Return which triangles (k,) are not wholly beside the pyramid that holds all rays.

        `seen` (3, v) has the points in the axes of the picture, and `which` (k,) the triangles.
        Otherwise each ray would be compared with a person beside a detector: 40 times slower.
        """
        ends = seen[:, corners[:, which]]
        found = np.ones(len(which), bool)
        for i, places in enumerate(self._places):
            slack = BORDER * (1.0 + np.abs(places).max())
            found &= ~(ends[i] > (places.max() + slack) * ends[2]).all(axis=0)
            found &= ~(ends[i] < (places.min() - slack) * ends[2]).all(axis=0)
        return found


def _min_and_max(ends: Iterable[Any]) -> tuple[Any, Any]:
    """Return the elementwise minimum and maximum of three arrays, faster than numpy on a stack."""
    one, two, three = ends
    return np.minimum(np.minimum(one, two), three), np.maximum(np.maximum(one, two), three)


def _picture_axes(directions: Array) -> Array:
    """Return the axes (3, 3) of a picture of rays: unit vectors right, up and ahead.

    Right is the direction in which the rays spread most, so that a fan of rays lies in one row of
    cells.
    """
    ahead = (directions / np.linalg.norm(directions, axis=1)[:, None]).sum(axis=0)
    ahead /= np.linalg.norm(ahead)
    aside = directions - (directions @ ahead)[:, None] * ahead
    spread, axes = np.linalg.eigh(aside.T @ aside)
    right = axes[:, 2] if spread[2] > THROUGH else np.eye(3)[int(np.argmin(np.abs(ahead)))]
    up = np.cross(ahead, right)
    up /= np.linalg.norm(up)
    return np.stack([np.cross(up, ahead), up, ahead])


class RayCells:
    """A grid of cells over the positions of n rays in a picture.

    Parameters
    ----------
    rays
        Coordinates (2, n) of the positions in the picture.
    """

    def __init__(self, rays: Array) -> None:
        lo, hi = rays.min(axis=1), rays.max(axis=1)
        size = np.maximum(hi - lo, LEAST_SIZE * (1.0 + np.abs(rays).max()))
        # A ring of cells without rays takes up all that is outside.
        self._scale = (CELLS - 2) * (1.0 - 4.0 * EDGE / CELLS) / size
        self._lo = (lo + hi) / 2.0 - CELLS / 2.0 / self._scale
        self._sort_into_cells(rays)

    def _sort_into_cells(self, rays: Array) -> None:
        """Put each ray into its cell. A ray near the edge of the cell is also in the neighbour."""
        ray = np.arange(rays.shape[1])
        edge = np.array([-EDGE, EDGE])[:, None] / self._scale[:, None, None]
        moved = [self.cells(rays[axis] + edge[axis], axis).astype(np.intp) for axis in (0, 1)]
        cells = [moved[0][i] * CELLS + moved[1][j] for i in (0, 1) for j in (0, 1)]
        also = [np.flatnonzero(cell != cells[0]) for cell in cells]
        cell = np.concatenate([cells[0], *(c[which] for c, which in zip(cells, also, strict=True))])
        order = np.argsort(cell, kind="stable")
        self._ray = np.concatenate([ray, *also])[order]
        self._start = np.searchsorted(cell[order], EVERY_CELL)
        self._next_row = _next_filled(np.isin(np.arange(CELLS), cell % CELLS))
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
        """Return the grid's column (axis 0) or row (axis 1) at each picture coordinate (k,)."""
        at = (places - self._lo[axis]) * self._scale[axis]
        with np.errstate(invalid="ignore"):
            return np.fmax(np.fmin(at, CELLS - 1), 0.0).astype(np.uint8)

    def rows_hold(self, below: Index, above: Index) -> Index:
        """Return the indices of the row ranges, from `below` to `above`, that contain a ray."""
        return np.flatnonzero(self._next_row.take(below) <= above)

    def may_hold(self, left: Index, right: Index, below: Index, above: Index) -> Index:
        """Return the indices of the rectangles of cells that may contain a ray.

        Parameters
        ----------
        left, right
            First and last column (m,) of each rectangle.
        below, above
            First and last row (m,) of each rectangle.
        """
        size = np.minimum(np.maximum(right - left, above - below), SQUARES).astype(np.intp)
        return np.flatnonzero(self._held.ravel().take((size * CELLS + left) * CELLS + below))

    def pairs(self, left: Index, right: Index, below: Index, above: Index) -> tuple[Index, Index]:
        """Return pairs of a rectangle of cells and a ray in it, as indices (p,) of both.

        The parameters are as for `may_hold`.
        """
        which, column = _expanded_ranges(left.astype(np.intp), right.astype(np.intp) + 1)
        first = self._start[column * CELLS + below[which]]
        end = self._start[column * CELLS + above[which] + 1]
        of, at = _expanded_ranges(first, end)
        return which[of], self._ray[at]


def _next_filled(held: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return, for each row of the grid, the first row at or after it with a ray; CELLS if none."""
    found = np.where(held, np.arange(CELLS), CELLS)
    return np.minimum.accumulate(found[::-1])[::-1].astype(np.uint8)


def _expanded_ranges(first: Index, end: Index) -> tuple[Index, Index]:
    """Return all integers in m integer ranges: the index (p,) of the range, and the integer (p,).

    `first` (m,) are the first integers of the ranges, and `end` (m,) those after the last.
    """
    counts = end - first
    which = np.repeat(np.arange(len(first)), counts)
    start = first - (np.cumsum(counts) - counts)
    return which, np.arange(len(which)) + start[which]


def _hit_distances(
    points: Any, frame: Index, corners: Index, origins: Array, directions: Array
) -> Array:
    """Return the ranges (p,) of p rays, each to its own triangle; inf for a miss.

    `frame` (p,) has the index of the ray's frame in `points`. Ranges are in multiples of the
    direction's length. The test is Möller and Trumbore's, relative to the triangle's first corner.
    """
    corner, one, two = (points[frame, :, at].astype(np.float64) for at in corners)
    one, two, start = one - corner, two - corner, origins - corner
    across, rotated = _cross(directions, two), _cross(start, one)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / _dot(one, across)
        u, v = _dot(start, across) * inverse, _dot(directions, rotated) * inverse
        far = _dot(two, rotated) * inverse
        hit = (u >= -RIM) & (v >= -RIM) & (u + v <= 1.0 + RIM) & (far >= 0.0)
    result: Array = np.where(hit, far, np.inf)
    return result


def _dot(one: Array, two: Array) -> Array:
    product = one * two
    result: Array = product[:, 0] + product[:, 1] + product[:, 2]
    return result


def _cross(one: Array, two: Array) -> Array:
    """Return the cross products of vectors (n, 3), faster than numpy's function for few of them."""
    a, b, c = one[:, 0], one[:, 1], one[:, 2]
    x, y, z = two[:, 0], two[:, 1], two[:, 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=1)
