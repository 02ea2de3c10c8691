# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface and centre of mass of animated bodies, and of loose pads, at one frame; and how far
such a surface is above what is below it."""

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

# Casts many parallel rays at once: how far an underside is above what is below.
#
# In the plane across the rays, each ray is a point and each surface a set of flat triangles. A
# grid finds the pairs of a point and a triangle that may meet, and numpy tests all of them
# together.

Indices = NDArray[np.intp]
# A ray beside a triangle by this share of it still hits it, so that no gap opens along an edge.
RIM = 1e-9
# Cells of the grid for each ray.
CELLS = 4.0
MOST_CELLS = 1000


@dataclass(frozen=True, eq=False)
class Triangles:
    """Corners (m, 3, 3) and bounds (m, 3), (m, 3) in metres."""

    corners: Array
    lo: Array
    hi: Array


def with_bounds(corners: Array) -> Triangles:
    one, two, three = corners[:, 0], corners[:, 1], corners[:, 2]
    lo = np.minimum(np.minimum(one, two), three)
    return Triangles(corners, lo, np.maximum(np.maximum(one, two), three))


class WorldTriangles:
    """The triangles of solids in world space.

    Keeps those of a solid until it changes: without it each pad would transform every floor anew at
    each frame. `gaps`: how far a pad is below an object without a mass that lies on it (None: it
    does not), by the numbers of both, and the state of both for which this holds.
    """

    def __init__(self, solids: Solids) -> None:
        self._solids = solids
        self._listing = -1
        self._known: dict[int, tuple[int, float, Triangles]] = {}
        self.gaps: dict[tuple[int, int], tuple[Any, float | None]] = {}

    def of(self, depsgraph: Any, solid: Solid, metres: float) -> Triangles:
        """The triangles of a solid as it is now."""
        if self._listing != self._solids.listing:
            self._listing = self._solids.listing
            self._known.clear()
        version = int(self._solids.version[solid.row])
        known = self._known.get(solid.number)
        if known is None or known[:2] != (version, metres):
            matrix = self._solids.matrix[solid.row]
            world = solid.geometry.vertices @ matrix[:3, :3].T + matrix[:3, 3]
            corners = world[solid.geometry.triangles(depsgraph)] * metres
            known = version, metres, with_bounds(corners)
            self._known[solid.number] = known
        return known[2]


def hit_distances(triangles: Triangles, starts: Array, direction: Array, length: Array) -> Array:
    """Distances (n,) from `starts` (n, 3) along the unit vector `direction` (3,) to the nearest
    triangle; inf where there is none within `length` (n,)."""
    return ParallelRays(starts, direction, length).hit_distances(triangles)


class ParallelRays:
    """Rays from `starts` (n, 3) along the unit vector `direction` (3,), `length` (n,) long. One
    grid of them serves all surfaces."""

    def __init__(self, starts: Array, direction: Array, length: Array) -> None:
        self.starts, self.length = starts, length
        self._axes = _across(*direction.tolist())
        both = np.concatenate([starts, starts + length[:, None] * direction]).T.copy()
        self._lo, self._hi = both.min(axis=1), both.max(axis=1)

    @cached_property
    def _projected(self) -> Array:
        """(3, n): the starts in the axes of the rays, the last of which is along them."""
        return np.ascontiguousarray((self.starts @ self._axes.T).T)

    @cached_property
    def _grid(self) -> _Grid:
        return _Grid(self._projected[0], self._projected[1])

    def hit_distances(self, triangles: Triangles) -> Array:
        """Distances (n,) to the nearest triangle; inf where there is none within their length."""
        far = np.full(len(self.starts), np.inf)
        near = (triangles.lo <= self._hi) & (triangles.hi >= self._lo)
        corners = triangles.corners[near.all(axis=1)]
        if not len(corners):
            return far
        flat = corners.reshape(-1, 3) @ self._axes.T
        x, y, depth = (flat[:, i].reshape(-1, 3) for i in range(3))
        of, ray = self._grid.pairs(x, y)
        if not len(of):
            return far
        seen, length = self._projected, self.length
        ax, ay, ad = x[:, 0], y[:, 0], depth[:, 0]
        one = x[:, 1] - ax, y[:, 1] - ay, depth[:, 1] - ad
        two = x[:, 2] - ax, y[:, 2] - ay, depth[:, 2] - ad
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # No ray hits a triangle edge on: it has no area.
            inverse = 1.0 / (one[0] * two[1] - one[1] * two[0])
            across, along = seen[0][ray] - ax[of], seen[1][ray] - ay[of]
            u = (across * (two[1] * inverse)[of]) - (along * (two[0] * inverse)[of])
            v = (along * (one[0] * inverse)[of]) - (across * (one[1] * inverse)[of])
            inside = np.flatnonzero((u >= -RIM) & (v >= -RIM) & (u + v <= 1.0 + RIM))
            of, ray, u, v = of[inside], ray[inside], u[inside], v[inside]
            reach = ad[of] + u * one[2][of] + v * two[2][of] - seen[2][ray]
            hit = np.flatnonzero((reach >= 0.0) & (reach <= length[ray]))
        # The nearest is written last, and stays.
        hit = hit[np.argsort(-reach[hit], kind="stable")]
        far[ray[hit]] = reach[hit]
        return far


# The last 16 directions; without it 40 µs more for each bundle of rays that is made.
@lru_cache(maxsize=16)
def _across(*parts: float) -> Array:
    """(3, 3): rows are two unit vectors across a direction, and the direction itself."""
    direction = np.array(parts)
    one = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    one /= np.linalg.norm(one)
    return np.stack([one, np.cross(direction, one), direction])


class _Grid:
    """Points of a plane, x (n,) and y (n,), sorted into square cells, `count` along each axis."""

    def __init__(self, at_x: Array, at_y: Array) -> None:
        self._count = min(MOST_CELLS, 1 + int(np.sqrt(CELLS * len(at_x))))
        self._x, self._y = _Axis(at_x, self._count), _Axis(at_y, self._count)
        cell = self._y.cells_of(at_y) * self._count + self._x.cells_of(at_x)
        self._order = np.argsort(cell, kind="stable")
        # Points of a row's neighbouring cells follow each other.
        filled = np.bincount(cell, minlength=self._count * self._count)
        self._begin = np.concatenate([[0], np.cumsum(filled)])

    def pairs(self, x: Array, y: Array) -> tuple[Indices, Indices]:
        """Pairs of a triangle, with corners x, y (m, 3), and a point that may lie in it."""
        first_x, last_x = self._x.spans(x)
        first_y, last_y = self._y.spans(y)
        of, row = _spread(last_y - first_y + 1)
        row += first_y[of]
        start = self._begin[row * self._count + first_x[of]]
        which, place = _spread(self._begin[row * self._count + last_x[of] + 1] - start)
        return of[which], self._order[start[which] + place]


class _Axis:
    """The cells along one axis, which hold all its points (n,)."""

    def __init__(self, points: Array, count: int) -> None:
        self._count = count
        self._low = float(points.min())
        extent = float(points.max()) - self._low
        self._size = extent / count + 1e-9 + 1e-12 * abs(self._low)

    def cells_of(self, points: Array) -> Indices:
        """The cell of each point."""
        return np.minimum(((points - self._low) / self._size).astype(np.intp), self._count - 1)

    def spans(self, corners: Array) -> tuple[Indices, Indices]:
        """First and last cell (m,) of triangles with corners (m, 3); last < first where a triangle
        is beside all points."""
        low, size, count = self._low, self._size, self._count
        slack = RIM * size
        least = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
        most = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
        first = np.clip(np.floor((least - slack - low) / size), 0, count).astype(np.intp)
        last = np.clip(np.floor((most + slack - low) / size), -1, count - 1).astype(np.intp)
        return first, last


def _spread(counts: Indices) -> tuple[Indices, Indices]:
    """Each index as often as its count says, and a running number with each."""
    counts = np.maximum(counts, 0)
    of = np.repeat(np.arange(len(counts)), counts)
    return of, np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)


@dataclass(frozen=True, eq=False)
class PosedPart:
    """A solid of a body: vertices (n, 3) and triangles (m, 3) in its own space, and its matrix;
    `state`: the same object for as long as its surface is the same."""

    state: Any
    vertices: np.typing.NDArray[np.float32]
    corners: np.typing.NDArray[np.int32]
    matrix: Array


class PosedBody:
    """A body as it is at one frame; `lo`, `hi` (3,) are its bounds in metres.

    While it does not move it stays the same object from frame to frame, and keeps the results of
    the search for its supports, each with what it depends on: `supports`; samples of the
    `underside` and the room above each; `down`: the rays from there; `gaps`: how far below each
    solid is, by number. Without them a person who sits still costs as much as one who walks.
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
        """(n, 3, 3) in metres."""
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
        """(3,) m: its centre of mass, for an even density."""
        return underside.centre_of_mass(self.triangles, self.closed)


def posed_body(
    depsgraph: Any, body: ContactBody, solids: Solids, metres: float, last: PosedBody | None
) -> PosedBody | None:
    """The body as the solids are now: `last` where nothing changed; None without a surface."""
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
    """A solid's surface and matrix, to be compared by `unchanged`."""
    return [solid.geometry.state, solids.matrix[solid.row].copy()]


def unchanged(one: list[Any], two: list[Any]) -> bool:
    """Whether two lists hold equal arrays, and otherwise the very same objects."""
    return len(one) == len(two) and all(
        a is b or (isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and bool((a == b).all()))
        for a, b in zip(one, two, strict=True)
    )
