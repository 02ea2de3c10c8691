# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface and centre of mass of animated bodies and loose pads at one frame.

`ParallelRays` measures the distances from a surface down to other surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.forces import underside
from ....sensor_logic.forces.world import Support
from ....sensor_logic.model import Array
from ..rays.solids import Solid, Solids
from .bodies import ContactBody

Indices = NDArray[np.intp]
# A ray beside a triangle by at most this fraction of its size still hits it: edges have no gaps.
RIM = 1e-9
# Cells of the grid for each ray.
CELLS = 4.0
MOST_CELLS = 1000


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles with their bounds, in metres.

    Attributes
    ----------
    corners
        Corners (m, 3, 3).
    lo, hi
        Bounds (m, 3) of each triangle.
    """

    corners: Array
    lo: Array
    hi: Array


def with_bounds(corners: Array) -> Triangles:
    """Return `Triangles` from corners (m, 3, 3), in m."""
    one, two, three = corners[:, 0], corners[:, 1], corners[:, 2]
    lo = np.minimum(np.minimum(one, two), three)
    return Triangles(corners, lo, np.maximum(np.maximum(one, two), three))


class WorldTriangles:
    """The triangles of solids in world space.

    The triangles of a solid are stored until it changes. Otherwise each pad would transform every
    floor again at each frame.

    Attributes
    ----------
    gaps
        The results of `MissingMass._gap_between`, each with the state of both solids. Keys are the
        numbers of the pad's solid and of the other solid.
    """

    def __init__(self, solids: Solids) -> None:
        self._solids = solids
        self._listing = -1
        self._known: dict[int, tuple[int, float, Triangles]] = {}
        self._facing: dict[int, tuple[Triangles, float]] = {}
        self.gaps: dict[tuple[int, int], tuple[Any, float | None]] = {}

    def of(self, depsgraph: Any, solid: Solid, metres: float) -> Triangles:
        """Return the triangles of a solid at the present frame, in m."""
        if self._listing != self._solids.listing:
            self._listing = self._solids.listing
            self._known.clear()
            self._facing.clear()
        version = int(self._solids.version[solid.row])
        known = self._known.get(solid.number)
        if known is None or known[:2] != (version, metres):
            matrix = self._solids.matrix[solid.row]
            world = solid.geometry.vertices @ matrix[:3, :3].T + matrix[:3, 3]
            corners = world[solid.geometry.triangles(depsgraph)] * metres
            known = version, metres, with_bounds(corners)
            self._known[solid.number] = known
        return known[2]

    def facing(self, depsgraph: Any, solid: Solid, metres: float) -> float:
        """Return where the normals of a solid's triangles point.

        The result is 1 for a closed surface whose normals point outwards, −1 for one whose normals
        point inwards, and 0 for an open surface, such as a sheet.
        """
        triangles = self.of(depsgraph, solid, metres)
        known = self._facing.get(solid.number)
        if known is None or known[0] is not triangles:
            sign = 0.0
            if underside.is_closed(solid.geometry.triangles(depsgraph)):
                sign = float(np.sign(underside.enclosed_volume(triangles.corners)))
            known = self._facing[solid.number] = triangles, sign
        return known[1]


def hit_distances(triangles: Triangles, starts: Array, direction: Array, length: Array) -> Array:
    """Return the distances in m from points to the nearest triangle along one direction.

    Parameters
    ----------
    triangles
        The triangles.
    starts
        Points (n, 3), in m.
    direction
        Unit vector (3,).
    length
        Largest distances (n,), in m.

    Returns
    -------
    Array
        Distances (n,); inf if there is no triangle within the largest distance.
    """
    return ParallelRays(starts, direction, length).hit_distances(triangles)


class ParallelRays:
    """Rays with the same direction, for casting at many surfaces.

    In the plane perpendicular to the direction, a ray is a point and a surface is a set of flat
    triangles. A grid finds the pairs of a point and a triangle that may overlap, and numpy tests
    all pairs together. One grid serves all surfaces.

    Parameters
    ----------
    starts
        Origins (n, 3) of the rays.
    direction
        Their direction, a unit vector (3,).
    length
        Their lengths (n,).
    """

    def __init__(self, starts: Array, direction: Array, length: Array) -> None:
        self.starts, self.length = starts, length
        self._axes = _perpendicular_axes(*direction.tolist())
        both = np.concatenate([starts, starts + length[:, None] * direction]).T.copy()
        self._lo, self._hi = both.min(axis=1), both.max(axis=1)

    @cached_property
    def _projected(self) -> Array:
        return np.ascontiguousarray((self.starts @ self._axes.T).T)

    @cached_property
    def _grid(self) -> _Grid:
        return _Grid(self._projected[0], self._projected[1])

    def hit_distances(self, triangles: Triangles) -> Array:
        """Return the distances (n,) to the nearest triangle; inf for a ray that hits none."""
        far = np.full(len(self.starts), np.inf)
        ray, reach, _ = self.hits(triangles)
        # The nearest hit of a ray is written last.
        last = np.argsort(-reach, kind="stable")
        far[ray[last]] = reach[last]
        return far

    def hits(self, triangles: Triangles) -> tuple[Indices, Array, Array]:
        """Return all k hits: the index of the ray (k,), the distance (k,), and the facing (k,).

        The facing is positive if the triangle's normal points along the ray, as where the ray
        leaves a closed surface, else negative.
        """
        near = (triangles.lo <= self._hi) & (triangles.hi >= self._lo)
        corners = triangles.corners[near.all(axis=1)]
        nothing = np.empty(0, np.intp), np.empty(0), np.empty(0)
        if not len(corners):
            return nothing
        flat = corners.reshape(-1, 3) @ self._axes.T
        x, y, depth = (flat[:, i].reshape(-1, 3) for i in range(3))
        of, ray = self._grid.pairs(x, y)
        if not len(of):
            return nothing
        seen, length = self._projected, self.length
        ax, ay, ad = x[:, 0], y[:, 0], depth[:, 0]
        one = x[:, 1] - ax, y[:, 1] - ay, depth[:, 1] - ad
        two = x[:, 2] - ax, y[:, 2] - ay, depth[:, 2] - ad
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # A triangle seen edge-on has no area across the rays, and no hit.
            inverse = 1.0 / (one[0] * two[1] - one[1] * two[0])
            across, along = seen[0][ray] - ax[of], seen[1][ray] - ay[of]
            u = (across * (two[1] * inverse)[of]) - (along * (two[0] * inverse)[of])
            v = (along * (one[0] * inverse)[of]) - (across * (one[1] * inverse)[of])
            inside = np.flatnonzero((u >= -RIM) & (v >= -RIM) & (u + v <= 1.0 + RIM))
            of, ray, u, v = of[inside], ray[inside], u[inside], v[inside]
            reach = ad[of] + u * one[2][of] + v * two[2][of] - seen[2][ray]
            hit = np.flatnonzero((reach >= 0.0) & (reach <= length[ray]))
        return ray[hit], reach[hit], inverse[of[hit]]


# The last 16 directions; without this cache each `ParallelRays` takes 40 µs more.
@lru_cache(maxsize=16)
def _perpendicular_axes(*parts: float) -> Array:
    """Return unit vectors as rows (3, 3): two perpendicular to a direction, and the direction.

    `parts` are the three components of the direction.
    """
    direction = np.array(parts)
    one = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    one /= np.linalg.norm(one)
    return np.stack([one, np.cross(direction, one), direction])


class _Grid:
    """Points in a plane, sorted into the square cells of a grid.

    Parameters
    ----------
    at_x, at_y
        Coordinates (n,) of the points.
    """

    def __init__(self, at_x: Array, at_y: Array) -> None:
        self._count = min(MOST_CELLS, 1 + int(np.sqrt(CELLS * len(at_x))))
        self._x, self._y = _Axis(at_x, self._count), _Axis(at_y, self._count)
        cell = self._y.cells_of(at_y) * self._count + self._x.cells_of(at_x)
        self._order = np.argsort(cell, kind="stable")
        # Points in neighbouring cells of a row are neighbours in the order.
        filled = np.bincount(cell, minlength=self._count * self._count)
        self._begin = np.concatenate([[0], np.cumsum(filled)])

    def pairs(self, x: Array, y: Array) -> tuple[Indices, Indices]:
        """Return pairs of a triangle and a point that may lie in it, as indices (p,) of both.

        `x` and `y` (m, 3) are the coordinates of the triangles' corners.
        """
        first_x, last_x = self._x.spans(x)
        first_y, last_y = self._y.spans(y)
        of, row = _repeated_indices(last_y - first_y + 1)
        row += first_y[of]
        start = self._begin[row * self._count + first_x[of]]
        which, place = _repeated_indices(self._begin[row * self._count + last_x[of] + 1] - start)
        return of[which], self._order[start[which] + place]


class _Axis:
    """The grid cells along one axis, from the least coordinate of the points to the greatest."""

    def __init__(self, points: Array, count: int) -> None:
        self._count = count
        self._low = float(points.min())
        extent = float(points.max()) - self._low
        self._size = extent / count + 1e-9 + 1e-12 * abs(self._low)

    def cells_of(self, points: Array) -> Indices:
        return np.minimum(((points - self._low) / self._size).astype(np.intp), self._count - 1)

    def spans(self, corners: Array) -> tuple[Indices, Indices]:
        """Return the indices (m,) of the first and the last cell that each triangle overlaps.

        `corners` (m, 3) are coordinates. If a triangle is beside all points, the last index is less
        than the first.
        """
        low, size, count = self._low, self._size, self._count
        slack = RIM * size
        least = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
        most = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
        first = np.clip(np.floor((least - slack - low) / size), 0, count).astype(np.intp)
        last = np.clip(np.floor((most + slack - low) / size), -1, count - 1).astype(np.intp)
        return first, last


def _repeated_indices(counts: Indices) -> tuple[Indices, Indices]:
    """Repeat each index of `counts` as often as its count, such as 0, 0, 2 for the counts 2, 0, 1.

    Return these indices, and for each a number that counts the repetitions from 0.
    """
    counts = np.maximum(counts, 0)
    of = np.repeat(np.arange(len(counts)), counts)
    return of, np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)


@dataclass(frozen=True, eq=False)
class PosedPart:
    """A solid of a body at one frame.

    Attributes
    ----------
    state
        The surface: the same Python object as long as the surface has not changed.
    vertices
        Vertices (n, 3), in the solid's own space.
    corners
        Vertex indices (m, 3) of the triangles.
    matrix
        The matrix (4, 4) to the world.
    """

    state: Any
    vertices: np.typing.NDArray[np.float32]
    corners: np.typing.NDArray[np.int32]
    matrix: Array


class PosedBody:
    """The surface of a body at one frame, with stored results of the search for its supports.

    A body that does not move has the same `PosedBody` at all frames. Each result is stored with the
    values that it depends on. So a person who sits still costs less than one who walks.

    Attributes
    ----------
    parts
        The solids of the body.
    closed
        Whether all surfaces enclose a volume.
    lo, hi
        Bounds (3,) in metres.
    supports
        The supports of the body.
    underside
        Samples of the underside, and how far the body extends above each sample.
    down
        The rays that start inside the body above the samples, and go down.
    gaps
        The distances that these rays go down to each solid, by number of the solid.
    """

    def __init__(
        self, parts: list[PosedPart], closed: bool, metres: float, lo: Array, hi: Array
    ) -> None:
        self.parts = parts
        self.closed = closed
        self.lo, self.hi = lo, hi
        self.supports: tuple[list[Any], list[Support]] | None = None
        self.underside: tuple[list[Any], underside.Samples, Array] | None = None
        self.gaps: dict[int, tuple[tuple[int, float], Array]] = {}
        self.down: tuple[float, ParallelRays] | None = None
        self._metres = metres

    @cached_property
    def triangles(self) -> Array:
        """The triangles (n, 3, 3) in the world, in metres."""
        found = []
        for part in self.parts:
            world = part.vertices @ part.matrix[:3, :3].T + part.matrix[:3, 3]
            triangles = world[part.corners] * self._metres
            mirrored = np.linalg.det(part.matrix[:3, :3]) < 0.0
            found.append(triangles[:, ::-1] if mirrored else triangles)
        triangles = np.concatenate(found)
        if np.isfinite(triangles.sum()):
            return triangles
        return triangles[np.isfinite(triangles).all(axis=(1, 2))]

    @cached_property
    def centre(self) -> Array:
        """The centre of mass (3,) in m, for uniform density."""
        return underside.centre_of_mass(self.triangles, self.closed)


def posed_body(
    depsgraph: Any, body: ContactBody, solids: Solids, metres: float, last: PosedBody | None
) -> PosedBody | None:
    """Return the `PosedBody` of a body at the present frame; None if the body has no surface.

    `last` is the result at the previous frame. It is returned again if nothing has changed.
    """
    now = [value for solid in body.solids for value in surface_state(solid, solids)]
    if last is not None:
        before = [value for part in last.parts for value in (part.state, part.matrix)]
        if unchanged(before, now):
            return last
    rows = [solid.row for solid in body.solids]
    if not rows:
        return None
    lo, hi = solids.lo[rows].min(axis=0) * metres, solids.hi[rows].max(axis=0) * metres
    if not (lo <= hi).all():
        return None
    parts = []
    for solid in body.solids:
        corners = solid.geometry.triangles(depsgraph)
        state, matrix = surface_state(solid, solids)
        parts.append(PosedPart(state, solid.geometry.vertices, corners, matrix))
    return PosedBody(parts, body.is_closed([part.corners for part in parts]), metres, lo, hi)


def surface_state(solid: Solid, solids: Solids) -> list[Any]:
    """Return the surface and the matrix of a solid, for comparison by `unchanged`."""
    return [solid.geometry.state, solids.matrix[solid.row].copy()]


def unchanged(one: list[Any], two: list[Any]) -> bool:
    """Return whether two lists have the same items: equal arrays, or identical objects."""
    return len(one) == len(two) and all(
        a is b or (isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and bool((a == b).all()))
        for a, b in zip(one, two, strict=True)
    )
