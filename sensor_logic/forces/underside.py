# SPDX-License-Identifier: GPL-3.0-or-later
"""The underside of a body and its centre of mass, from its triangles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import Array

# In m. A larger triangle is sampled at several points, with at most MOST_SAMPLES in all.
SPACING = 0.02
MOST_SAMPLES = 2000
# The least cosine between a face's normal and the vertical; a steeper face carries nothing.
STEEPEST = 0.1
# The cells per side of the grid that merges a body's contact points with one other body.
CELLS = 8
# Up to this many grid cells per point, a table of all cells is faster than sorting.
TABLE = 30
# A closed surface with a smaller share of its bounds' volume counts as having no volume.
LEAST_VOLUME = 1e-6


@dataclass(frozen=True)
class Samples:
    """Sample points (n, 3) of a body's underside, and their areas (n,) in m² as seen from below."""

    points: Array
    areas: Array


def centre_of_mass(triangles: Array, closed: bool) -> Array:
    """Return the centroid (3,) of triangles (n, 3, 3).

    It is the centroid of the enclosed volume if the triangles are `closed`, else the centroid of
    the surface. For the volume, tetrahedra between each triangle and a common point are added up
    (divergence theorem).
    """
    places = _by_axis(triangles)
    origin: Array = places.mean(axis=(0, 2))
    about = places - origin[:, None]
    volumes = _dot(about[0], _cross(about[1], about[2])) / 6.0
    extent = about.max(axis=(0, 2)) - about.min(axis=(0, 2))
    if closed and abs(volumes.sum()) > LEAST_VOLUME * float(extent.prod()):
        weights, share = volumes, 4.0
    else:
        sides = _cross(about[1] - about[0], about[2] - about[0])
        weights, share = np.sqrt(_dot(sides, sides)) / 2.0, 3.0
    total = float(weights.sum())
    if total == 0.0:
        return origin
    centre: Array = origin + (about.sum(axis=0) @ weights) / (share * total)
    return centre


def is_closed(corners: npt.NDArray[np.integer[Any]]) -> bool:
    """Return whether triangles, given by vertex indices (n, 3), enclose a volume.

    They do if every edge is used once in each direction.
    """
    starts = corners.ravel().astype(np.int64)
    ends = corners[:, [1, 2, 0]].ravel().astype(np.int64)
    count = int(corners.max(initial=0)) + 1
    forth, back = starts * count + ends, ends * count + starts
    return bool(np.array_equal(np.sort(forth), np.sort(back)))


def _by_axis(triangles: Array) -> Array:
    """Return triangles as an array (3 corners, 3 axes, n), with which numpy is fastest."""
    return np.ascontiguousarray(triangles.transpose(1, 2, 0))


def _cross(one: Array, two: Array) -> Array:
    """Return cross products (3, n) of vectors (3, n)."""
    return np.stack(
        [
            one[1] * two[2] - one[2] * two[1],
            one[2] * two[0] - one[0] * two[2],
            one[0] * two[1] - one[1] * two[0],
        ]
    )


def _dot(one: Array, two: Array) -> Array:
    """Return scalar products (n,) of vectors (3, n)."""
    products: Array = one[0] * two[0] + one[1] * two[1] + one[2] * two[2]
    return products


def underside(triangles: Array, closed: bool, up: Array, lo: Array, hi: Array) -> Samples:
    """Return samples of the faces that point down and are within the box from `lo` to `hi`.

    Triangles (n, 3, 3) run counter-clockwise as seen from outside. If the surface is not `closed`,
    the orientation of triangles does not matter.
    """
    places = _by_axis(triangles)
    normals = _cross(places[1] - places[0], places[2] - places[0]) / 2.0
    sizes = np.sqrt(_dot(normals, normals))
    facing = -(up @ normals)
    if not closed:
        facing = np.abs(facing)
    elif _six_volumes(places) < 0.0:
        facing = -facing
    near = (places.min(axis=0) <= hi[:, None]) & (places.max(axis=0) >= lo[:, None])
    chosen = near.all(axis=0) & (facing > STEEPEST * sizes)
    triangles, places, facing = triangles[chosen], places[:, :, chosen], facing[chosen]
    if not len(triangles):
        return Samples(np.empty((0, 3)), np.empty(0))
    spacing = max(SPACING, float(np.sqrt(2.0 * facing.sum() / MOST_SAMPLES)))
    edges = [places[i] - places[i - 1] for i in range(3)]
    longest = np.sqrt(np.max([_dot(edge, edge) for edge in edges], axis=0))
    parts = np.clip(np.ceil(longest / spacing).astype(int), 1, 200)
    points, areas = [], []
    for count in np.unique(parts).tolist():
        some = parts == count
        weights = _centroids(count)
        corners = triangles[some][:, None]
        sampled = weights[:, 0, None] * corners[:, :, 0]
        sampled += weights[:, 1, None] * corners[:, :, 1]
        sampled += weights[:, 2, None] * corners[:, :, 2]
        points.append(sampled.reshape(-1, 3))
        areas.append(np.repeat(facing[some] / len(weights), len(weights)))
    found, share = np.concatenate(points), np.concatenate(areas)
    within = [(low <= x) & (x <= high) for low, high, x in zip(lo, hi, found.T, strict=True)]
    inside = within[0] & within[1] & within[2]
    if not inside.any():
        return Samples(np.empty((0, 3)), np.empty(0))
    return Samples(*gathered(found[inside], share[inside], spacing))


def looks_up(triangles: Array, up: Array) -> npt.NDArray[np.bool_]:
    """Return which (n,) of the triangles (n, 3, 3) of a closed surface do not point down.

    Other bodies can lie only on such triangles. Normals point outwards if the enclosed volume is
    positive, else inwards.
    """
    places = _by_axis(triangles)
    facing = up @ _cross(places[1] - places[0], places[2] - places[0])
    upward: npt.NDArray[np.bool_] = facing >= 0.0 if _six_volumes(places) >= 0.0 else facing <= 0.0
    return upward


def enclosed_volume(triangles: Array) -> float:
    """Return the volume in m³ that triangles (n, 3, 3) enclose.

    It is negative if the normals point inwards.
    """
    return _six_volumes(_by_axis(triangles)) / 6.0


def _six_volumes(corners: Array) -> float:
    """Return six times the volume that triangles enclose; `corners` is the result of `_by_axis`."""
    about = corners - corners.mean(axis=(0, 2))[:, None]
    return float(_dot(about[0], _cross(about[1], about[2])).sum())


# Keyed by the number of parts: without the cache, a call takes 10 µs (3 parts) to 90 µs (16) more.
@lru_cache(maxsize=256)
def _centroids(count: int) -> Array:
    """Return the barycentric coordinates (count², 3) of points that sample a triangle evenly.

    They are the centroids of the count² equal parts of the triangle.
    """
    upright = [(i, j) for i in range(count) for j in range(count - i)]
    inverted = [(i, j) for i in range(count - 1) for j in range(count - 1 - i)]
    found = [((i + 1 / 3) / count, (j + 1 / 3) / count) for i, j in upright]
    found += [((i + 2 / 3) / count, (j + 2 / 3) / count) for i, j in inverted]
    two = np.array(found)
    return np.column_stack([1.0 - two.sum(axis=1), two])


def clustered(points: Array, areas: Array) -> tuple[Array, Array]:
    """Return points and areas, merged into a grid of about CELLS cells per side."""
    extent = float(np.ptp(points, axis=0).max())
    return gathered(points, areas, max(extent / CELLS, SPACING / 2.0))


def gathered(points: Array, areas: Array, cell: float) -> tuple[Array, Array]:
    """Merge all points in the same cell of a grid into one, and add up their areas.

    Returns
    -------
    places
        The centroids (k, 3) of the merged points, weighted by area.
    areas
        The sums (k,) of the areas.
    """
    axes = np.ascontiguousarray(points.T)
    grid = np.floor((axes - axes.min(axis=1)[:, None]) / cell).astype(np.int64)
    size = grid.max(axis=1) + 1
    flat = grid[0] + size[0] * (grid[1] + size[1] * grid[2])
    of, count = _numbered(flat, int(size[0]) * int(size[1]) * int(size[2]))
    total = np.bincount(of, areas, count).astype(np.float64)
    sums = np.stack([np.bincount(of, areas * x, count) for x in axes], axis=1)
    return sums / total[:, None], total


def _numbered(cells: npt.NDArray[np.int64], count: int) -> tuple[npt.NDArray[np.intp], int]:
    """Return the rank (n,) of each cell among the distinct cells, and the number of distinct cells.

    `cells` (n,) has a cell number below `count` for each point.
    """
    if count > TABLE * len(cells):
        found, of = np.unique(cells, return_inverse=True)
        return of.ravel(), len(found)
    # For few distinct cells, a table is faster than sorting.
    filled = np.zeros(count, bool)
    filled[cells] = True
    numbers = np.cumsum(filled)
    return numbers[cells] - 1, int(numbers[-1])


def firmness(gaps: npt.ArrayLike, tolerance: float) -> Array:
    """Return the relative stiffness (n,) of contact points with gaps (n,) in m.

    As in an elastic layer, the stiffness is 1 at a gap of 0 and falls linearly to 0 at a gap of
    `tolerance`. A negative gap is a penetration, with a stiffness above 1.
    """
    return np.maximum(0.0, 1.0 - np.asarray(gaps, np.float64) / tolerance)
