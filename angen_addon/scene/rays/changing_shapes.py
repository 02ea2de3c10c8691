# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against the triangles of a surface that changes shape from frame to frame.

A hierarchy of it would be built anew for a few rays. Instead, triangles and rays are seen from
where the rays come from, as in a picture: most triangles of a person lie between the rays of a
sensor, and a grid of cells with rays and without leaves them out at once. What is left is met
exactly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]
# A ray this little beside a triangle, as share of it, meets it: no gap opens along an edge, and one
# that goes through the edge itself is not lost to the rounding of single precision.
RIM = 1e-7
# Cells along an axis of the picture; how near, in cells, to an edge is on both sides of it; the
# least size of the picture of the rays, as share of 1; by how much a triangle is larger; and up to
# which size in cells it is told whether a square holds a ray.
CELLS = 64
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


def meet(
    points: Array, corners: Index, origins: Array, ways: Array, apex: Array | None
) -> tuple[Array, Index]:
    """How far (n,), in lengths of their `ways` (n, 3), rays from `origins` (n, 3) go to the nearest
    of the triangles `corners` (3, m) of `points` (3, k), inf where they meet none; and the triangle
    (n,) that each meets. `apex` (3,): where the rays' lines all meet, if they do."""
    far, face = np.full(len(origins), np.inf), np.zeros(len(origins), np.intp)
    for which, looks, eye in _pictures(origins, ways, apex):
        ray, triangle = _together(points, corners, looks, eye)
        ray = which[ray]
        length = _lengths(points, corners[:, triangle], origins[ray], ways[ray])
        hit = np.flatnonzero(length < np.inf)
        ray, triangle, length = ray[hit], triangle[hit], length[hit]
        order = np.lexsort((triangle, length, ray))
        ray = ray[order]
        first = np.flatnonzero(ray != np.concatenate([[-1], ray[:-1]]))
        ray, first = ray[first], order[first]
        nearer = length[first] < far[ray]
        ray, first = ray[nearer], first[nearer]
        far[ray], face[ray] = length[first], triangle[first]
    return far, face


def _pictures(origins: Array, ways: Array, apex: Array | None) -> list[tuple[Index, Array, Array]]:
    """Which rays are seen in one picture, the ways in which each is looked along, and the picture's
    eye (3,). Rays that go towards their apex, as those to a lamp do, are looked back along too."""
    every = np.arange(len(origins))
    if apex is None:
        return [(every[i : i + 1], ways[i : i + 1], origins[i]) for i in every.tolist()]
    ahead = ((origins - apex) * ways).sum(axis=1)
    behind = bool((ahead < -THROUGH * float(np.abs(ahead).max(initial=0.0))).any())
    found = []
    for looks in (ways, -ways) if behind else (ways,):
        found += [(which, looks[which], apex) for which in _narrow(looks)]
    return found


def _narrow(ways: Array) -> list[Index]:
    """Which of some ways (n, 3) fit into one picture."""
    every = np.arange(len(ways))
    units = ways / np.linalg.norm(ways, axis=1)[:, None]
    middle = units.mean(axis=0)
    if float((units @ middle).min()) > WIDE * float(np.linalg.norm(middle)) > 0.0:
        return [every]
    # One picture for each side of a cube about the eye.
    axis = np.abs(units).argmax(axis=1)
    side = 2 * axis + (units[every, axis] > 0.0)
    return [np.flatnonzero(side == one) for one in np.unique(side).tolist()]


def _together(points: Array, corners: Index, ways: Array, eye: Array) -> tuple[Index, Index]:
    """Rays and triangles (p,) that lie in one place of the picture: no fewer than meet."""
    axes = _axes(ways)
    there = axes @ ways.T
    rays = there[:2] / there[2]
    # By single axes numpy is quickest.
    seen = axes @ points.astype(np.float64) - (axes @ eye)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = seen[0] / seen[2], seen[1] / seen[2]
    grid = Grid(rays)
    columns, rows = grid.cells(x, 0)[corners], grid.cells(y, 1)[corners]
    (left, right), (below, above) = _bounds(columns), _bounds(rows)
    close = TOO_NEAR * float(np.abs(seen[2]).max(initial=0.0))
    if float(seen[2].min(initial=np.inf)) <= close:
        # What reaches beside the eye or behind it has no place in the picture: it may be anywhere.
        depth = seen[2][corners]
        beside = np.flatnonzero((depth <= close).any(axis=0))
        left[beside] = below[beside] = 0
        right[beside] = above[beside] = np.where(depth[:, beside].max(axis=0) > 0.0, CELLS - 1, 0)
        x, y = x.copy(), y.copy()
        x[seen[2] <= close] = y[seen[2] <= close] = np.nan
    near = grid.may_hold(left, right, below, above)
    triangle, ray = grid.pairs(near, left[near], right[near], below[near], above[near])
    inside = np.ones(len(ray), bool)
    with np.errstate(invalid="ignore"):
        for place, at in ((x, rays[0][ray]), (y, rays[1][ray])):
            least, most = _bounds(place[corners[:, triangle]])
            slack = BORDER * (1.0 + np.abs(at))
            inside &= ~((least > at + slack) | (most < at - slack))
    return ray[inside], triangle[inside]


def _bounds(ends: Any) -> tuple[Any, Any]:
    """Least and greatest (m,) of three arrays (3, m): numpy is slow to find them along an axis."""
    one, two, three = ends
    return np.minimum(np.minimum(one, two), three), np.maximum(np.maximum(one, two), three)


def _axes(ways: Array) -> Array:
    """Right, up and ahead (3, 3) of a picture with these rays in it."""
    ahead = (ways / np.linalg.norm(ways, axis=1)[:, None]).sum(axis=0)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, np.eye(3)[int(np.argmin(np.abs(ahead)))])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(ahead, right), ahead])


class Grid:
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

    def may_hold(self, left: Index, right: Index, below: Index, above: Index) -> Index:
        """Which rectangles (m,) of cells may hold a ray."""
        size = np.minimum(np.maximum(right - left, above - below), SQUARES).astype(np.intp)
        return np.flatnonzero(self._held.ravel().take((size * CELLS + left) * CELLS + below))

    def pairs(
        self, triangle: Index, left: Index, right: Index, below: Index, above: Index
    ) -> tuple[Index, Index]:
        """Triangles, each with a ray (p,) that is in its rectangle of cells."""
        left = left.astype(np.intp)
        which, column = _spread(left, right.astype(np.intp) + 1)
        first = self._start[column * CELLS + below[which]]
        end = self._start[column * CELLS + above[which] + 1]
        of, at = _spread(first, end)
        return triangle[which[of]], self._ray[at]


def _spread(first: Index, end: Index) -> tuple[Index, Index]:
    """Of ranges (m,) every member (p,), and which range it is of."""
    counts = end - first
    which = np.repeat(np.arange(len(first)), counts)
    start = first - (np.cumsum(counts) - counts)
    return which, np.arange(len(which)) + start[which]


def _lengths(points: Array, corners: Index, origins: Array, ways: Array) -> Array:
    """How far (p,) each ray goes to its triangle, in lengths of its way; inf where it misses it:
    Möller and Trumbore's test, about the ray's origin."""
    corner, one, two = (points[:, at].astype(np.float64).T for at in corners)
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
