# SPDX-License-Identifier: GPL-3.0-or-later
"""Cast rays at solids, and use earlier hits again where nothing has changed.

Solids are the visible objects and instances that rays can hit. A *bundle* is a set of rays that a
sensor casts together. The hits of a bundle on still solids are stored and used again. Of the moving
solids, the caster tests those that have changed since the bundle was last cast. It tests all frames
of a batch (`frames.Frames`) together, and a ray only if it crosses the bounds of the solid. Rays
are transformed into the space of the solid, so that single precision is accurate at any distance
from the world origin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.arrays import are_equal
from ....sensor_logic.model import Answers, Array
from ..capture import Capture, Frames
from ..instances import Uid
from . import changing_shapes
from .changing_shapes import RayPicture, apex_of, pictures_of, rotated
from .geometry import Geometry
from .solids import Solids, inverted

Index = NDArray[np.intp]
# Origins (n, 3), unit directions (n, 3) and maximum ranges (n,).
Rays = tuple[Array, Array, Array]


@dataclass
class RayBundle:
    """A set of n rays that a sensor casts together.

    Attributes
    ----------
    origins
        Origins (n, 3).
    directions
        Unit directions (n, 3).
    length
        Maximum ranges (n,).
    """

    origins: Array
    directions: Array
    length: Array

    @property
    def starts(self) -> Array:
        """The origins as an array (3, n), which is the faster layout for numpy."""
        return np.ascontiguousarray(self.origins.T)

    # Cached while the sensor does not move. Without the caches, each batch of frames takes longer
    # with 600 rays: 6 µs (inverse), 0.1 ms (apex) and 2 ms (pictures).
    @cached_property
    def inverse(self) -> Array:
        """One divided by the directions, shape (3, n)."""
        with np.errstate(divide="ignore"):
            return 1.0 / np.ascontiguousarray(self.directions.T)

    @cached_property
    def apex(self) -> Array | None:
        """The point (3,) where the lines of all rays meet; None if there is no such point."""
        return apex_of(self.origins, self.directions)

    @cached_property
    def pictures(self) -> list[RayPicture]:
        """Projections of the rays, for the tests against meshes that change shape."""
        return pictures_of(self.origins, self.directions, self.apex)

    def same(self, other: RayBundle) -> bool:
        """Return whether another bundle has equal rays."""
        own = self.origins, self.directions, self.length
        return are_equal(own, (other.origins, other.directions, other.length))

    def box(self, ranges: Array) -> tuple[Array, Array]:
        """Return the bounds (3,), (3,) of the rays, each cut off at its range in `ranges` (n,)."""
        ends = self.origins + self.directions * ranges[:, None]
        both = np.concatenate([self.origins, ends])
        return both.min(axis=0), both.max(axis=0)


@dataclass
class RayHits:
    """The hits of n rays.

    Attributes
    ----------
    ranges
        Ranges (n,); the maximum range for a miss.
    solids
        Numbers (n,) of the hit solids, NOTHING for a miss.
    faces
        Indices (n,) of the hit faces.
    """

    ranges: Array
    solids: NDArray[np.int64]
    faces: Index

    def copy(self) -> RayHits:
        """Return a copy."""
        return RayHits(self.ranges.copy(), self.solids.copy(), self.faces.copy())

    def shorten(self, number: int, which: Index, far: Array, faces: Index) -> None:
        """Replace hits by nearer hits on another solid.

        Parameters
        ----------
        number
            Number of the other solid.
        which
            Indices (k,) of the rays that hit the other solid.
        far
            Their ranges (k,) to the other solid, in Blender units.
        faces
            Indices (k,) of the hit faces.
        """
        nearer = far < self.ranges[which]
        which = which[nearer]
        self.ranges[which], self.solids[which] = far[nearer], number
        self.faces[which] = faces[nearer]


@dataclass
class CastBundle:
    """A bundle of rays with its latest hits.

    Attributes
    ----------
    rays
        The rays.
    own
        Numbers of the sensor's own solids, which its rays pass through.
    still
        The nearest hits (n,) of the n rays on solids that have never moved or changed shape.
    box
        The bounds of the rays, each up to its hit in `still`.
    gone_seen
        The length of `Solids.gone`, the list of former still solids, at the last update of `still`.
    state
        The values of `Solids.listing` and `len(Solids.gone)` for which the attributes below hold.
        If these values have changed, `see_at` computes the attributes anew.
    versions
        `Solids.version` of each of the m moving solids at the last cast; AWAY if outside `box`.
    hits
        The hits on moving solids: indices, ranges and faces of the rays that hit a solid. The key
        is the row of the solid in `Solids`.
    seen
        The nearest hits of all rays, still solids included. Do not write to it.
    """

    rays: RayBundle
    own: frozenset[int]
    still: RayHits
    box: tuple[Array, Array]
    gone_seen: int
    state: tuple[int, int] | None = None
    versions: Index = field(default_factory=lambda: np.zeros(0, np.intp))
    hits: dict[int, tuple[Index, Array, Index]] = field(default_factory=dict)
    seen: RayHits | None = None


# A test of more pairs of boxes and rays than this is split, to limit its memory.
PAIRS_AT_ONCE = 200_000
# Points of a changing mesh, over all frames, that are tested together.
POINTS_AT_ONCE = 1 << 16
# The tree has limits in single precision. This factor keeps hits exactly at the limit.
LIMIT_SLACK = 1.0 + 1e-6
# The number for no solid, and the version of a solid whose bounds are away from a bundle.
NOTHING = 0
AWAY = 0


@dataclass
class _SensorSolids:
    """The solids, sorted for one sensor: its own, still ones and moving ones.

    Attributes
    ----------
    state
        The state of the list of solids for which the other attributes are valid.
    numbers
        Numbers of the sensor's own solids, which its rays pass through.
    still
        Rows of the other solids that have never moved.
    moving
        Rows of the other solids that have moved.
    columns
        The index in `Frames` of each of `moving`.
    """

    state: tuple[int, int]
    numbers: frozenset[int]
    still: Index
    moving: Index
    columns: Index


class RayCaster:
    """Casts rays at the solids of a scene: its visible objects and instances.

    Lengths are in Blender units. The rays of a sensor pass through the sensor's own solids.
    """

    def __init__(self, solids: Solids | None = None) -> None:
        self.solids = solids or Solids()
        self.capture = Capture(self.solids)
        self.frames = Frames.unchanged(self.solids)
        # The latest return value of `see_at`.
        self.seen = Answers([], np.zeros(0, np.intp))
        self._bundles: dict[tuple[Uid, int], CastBundle] = {}
        self._own: dict[Uid, _SensorSolids] = {}

    def update(self, depsgraph: Any) -> None:
        """Read the changes of the scene. Call this after each evaluation, before casting rays."""
        self.show(self.capture.read(depsgraph))

    def show(self, frames: Frames) -> None:
        """Set the batch of frames at which later calls cast rays."""
        self.frames = frames

    def cast(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Return the ranges of rays at the last frame of the batch.

        Parameters
        ----------
        sensor
            Session uid or path of the sensor; rays pass through the sensor's own solids.
        bundle
            Number of the bundle: hits are stored for each sensor and bundle.
        origins
            Origins (n, 3), in Blender units.
        directions
            Unit vectors (n, 3).
        length
            Maximum ranges (n,), in Blender units.

        Returns
        -------
        Array
            Ranges (n,), in Blender units; the maximum range where a ray hits nothing.
        """
        return self.cast_solids(sensor, bundle, origins, directions, length)[0]

    def cast_solids(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> tuple[Array, NDArray[np.int64]]:
        """Return the ranges (n,), and the numbers (n,) of the hit solids (NOTHING for a miss).

        Frame and parameters are as for `cast`.
        """
        last = np.array([len(self.frames) - 1])
        rays = origins, directions, length
        seen: RayHits = self.see_at(sensor, bundle, rays, last)[0]
        return seen.ranges, seen.solids

    def cast_at(self, sensor: Uid, bundle: int, rays: Rays, frames: Index) -> Answers:
        """Return the ranges of rays at several frames.

        Parameters
        ----------
        sensor, bundle
            As for `cast`.
        rays
            Origins (n, 3), unit directions (n, 3) and maximum ranges (n,), in Blender units.
        frames
            Indices (k,) of the frames in the batch, in order of time.

        Returns
        -------
        Answers
            A read-only array of ranges (n,) for each frame.
        """
        found = self.see_at(sensor, bundle, rays, frames)
        for seen in found.table:
            seen.ranges.flags.writeable = False
        return Answers([seen.ranges for seen in found.table], found.rows)

    def see_at(self, sensor: Uid, bundle: int, rays: Rays, frames: Index) -> Answers:
        """Return the hits of rays at several frames.

        The parameters are as for `cast_at`. The answers hold a read-only `RayHits` for each frame.
        """
        own = self._own_solids(sensor)
        known = self._hits_on_still(sensor, bundle, RayBundle(*rays), own)
        if known.state != own.state or known.seen is None:
            known.state, known.hits, known.seen = own.state, {}, known.still
            known.versions = np.full(len(own.moving), AWAY)
        at, moving = self.frames, (frames[:, None], own.columns)
        near = ((at.lo[moving] <= known.box[1]) & (at.hi[moving] >= known.box[0])).all(axis=2)
        versions = np.where(near, at.version[moving], AWAY)
        changed = versions != np.concatenate([known.versions[None], versions[:-1]])
        table, rows = [known.seen], np.zeros(len(frames), np.intp)
        if changed.any():
            known.versions = versions[-1]
            when, which = np.nonzero(changed & (versions != AWAY))
            hits = self._hits(known, frames[when], own.columns[which])
            for i in np.flatnonzero(changed.any(axis=1)).tolist():
                if self._update_hits(known, own.moving[changed[i]].tolist(), hits, int(frames[i])):
                    table.append(known.seen)
                rows[i:] = len(table) - 1
        self.seen = Answers(table, rows)
        return self.seen

    def last_ranges(self, sensor: Uid, bundle: int) -> Array:
        """Return the ranges (n,) of a bundle of rays at the last frame for which it was cast."""
        seen = self._bundles[sensor, bundle].seen
        assert seen is not None
        return seen.ranges

    def _update_hits(
        self,
        bundle: CastBundle,
        rows: list[int],
        hits: dict[tuple[int, int], tuple[Index, Array, Index]],
        frame: int,
    ) -> bool:
        """Replace a bundle's hits on the changed solids `rows`; return whether any hit may differ.

        `hits` has the indices, ranges and faces of rays, by frame and row of the hit solid. `frame`
        is the frame's index in the batch.
        """
        dropped = [row for row in rows if bundle.hits.pop(row, None) is not None]
        found = {row: hit for row in rows if (hit := hits.get((frame, row))) is not None}
        if not found and not dropped:
            return False
        bundle.hits.update(found)
        seen = bundle.still.copy()
        for row in sorted(bundle.hits):
            seen.shorten(self.solids.solids[row].number, *bundle.hits[row])
        bundle.seen = seen
        return True

    def first_hits(
        self,
        rows: NDArray[np.intp],
        origins: Array,
        directions: Array,
        length: Array,
    ) -> tuple[Array, NDArray[np.int64]]:
        """Cast rays at some solids; return the ranges and the numbers of the hit solids.

        The hits are not stored.

        Parameters
        ----------
        rows
            Rows of the solids at which rays are cast.
        origins
            Origins (n, 3), in Blender units.
        directions
            Unit vectors (n, 3).
        length
            Maximum ranges (n,), in Blender units.

        Returns
        -------
        tuple
            Ranges (n,) in Blender units, and numbers (n,) of the hit solids (NOTHING for a miss).
        """
        seen = self._no_hits(length)
        if len(length):
            rays = RayBundle(origins, directions, length)
            self._hit_solids(rows, rays, rays.box(length), seen, by_trees=True)
        return seen.ranges, seen.solids

    def _passes(self, sensor: Uid) -> NDArray[np.bool_]:
        """Return the mask (n,) of the solids that the rays of a sensor pass through."""
        return self.solids.passed_by(sensor)

    def _no_hits(self, length: Array) -> RayHits:
        count = len(length)
        solids = np.full(count, NOTHING, np.int64)
        return RayHits(length.copy(), solids, np.zeros(count, np.intp))

    def _own_solids(self, sensor: Uid) -> _SensorSolids:
        state = self.solids.listing, len(self.solids.gone)
        known = self._own.get(sensor)
        if known is None or known.state != state:
            mask = self._passes(sensor)
            numbers = frozenset(self.solids.solids[i].number for i in np.flatnonzero(mask))
            moving = self.solids.moving
            columns = np.flatnonzero(~mask[self.frames.rows])
            rows = self.frames.rows[columns]
            known = _SensorSolids(state, numbers, np.flatnonzero(~moving & ~mask), rows, columns)
            self._own[sensor] = known
        return known

    def _hits_on_still(
        self, sensor: Uid, bundle: int, rays: RayBundle, own: _SensorSolids
    ) -> CastBundle:
        """Return a bundle with its hits on still solids.

        If a hit solid is gone or has moved, the rays that hit it are cast again.
        """
        gone = self.solids.gone
        known = self._bundles.get((sensor, bundle))
        if known is None or known.own != own.numbers or not known.rays.same(rays):
            still = self._no_hits(rays.length)
            known = CastBundle(rays, own.numbers, still, rays.box(rays.length), len(gone))
            self._bundles[sensor, bundle] = known
            again = np.arange(len(rays.length))
        elif known.gone_seen < len(gone):
            again = np.flatnonzero(np.isin(known.still.solids, gone[known.gone_seen :]))
            known.gone_seen, known.state = len(gone), None
        else:
            return known
        if len(again):
            part = RayBundle(rays.origins[again], rays.directions[again], rays.length[again])
            seen = self._no_hits(part.length)
            self._hit_solids(own.still, part, part.box(part.length), seen)
            # Callers may still hold the earlier hits: change a copy.
            known.still = still = known.still.copy()
            still.ranges[again], still.solids[again] = seen.ranges, seen.solids
            still.faces[again] = seen.faces
            known.box = rays.box(still.ranges)
        return known

    def _hits(
        self, bundle: CastBundle, frames: Index, columns: Index
    ) -> dict[tuple[int, int], tuple[Index, Array, Index]]:
        """Return the hits of a bundle for p pairs of a frame and a solid.

        The result has indices, ranges and faces of the rays that hit, by frame and row of the
        solid.

        Parameters
        ----------
        bundle
            The bundle.
        frames
            The frame (p,) of each pair.
        columns
            The index (p,) of each pair's solid in `Frames`.
        """
        at, found = self.frames, {}
        rays, limits = bundle.rays, bundle.still.ranges
        size = max(1, PAIRS_AT_ONCE // len(rays.length))
        for start in range(0, len(frames), size):
            frame, column = frames[start : start + size], columns[start : start + size]
            enter, leave = _slabs(at.lo[frame, column], at.hi[frame, column], rays)
            crossed = (leave >= enter) & (enter <= limits)
            some = np.flatnonzero(crossed.any(axis=1))
            for own in np.unique(column[some]).tolist():
                which, row = some[column[some] == own], int(at.rows[own])
                whens, matrix = frame[which].tolist(), at.matrix[frame[which], own]
                surfaces = [at.surface(self.solids, row, when) for when in whens]
                shape = self.solids.solids[row].geometry, surfaces, matrix
                inverse = inverted(matrix)
                for i, hit in self._hits_on_solid(*shape, inverse, rays, limits, crossed[which]):
                    found[whens[i], row] = hit
        return found

    def _hits_on_solid(
        self,
        geometry: Geometry,
        surfaces: list[Any],
        matrix: Array,
        inverse: Array,
        rays: RayBundle,
        limits: Array,
        crossed: NDArray[np.bool_],
        by_trees: bool = False,
    ) -> Iterator[tuple[int, tuple[Index, Array, Index]]]:
        """Yield the hits of a bundle on one solid, for each frame with hits.

        Parameters
        ----------
        geometry
            The geometry of the solid.
        surfaces
            The surface of the solid at each of k frames.
        matrix, inverse
            The matrices (k, 4, 4) of the solid to the world, and their inverses.
        rays
            The bundle of n rays.
        limits
            Ranges (n,) within which a hit counts.
        crossed
            Mask (k, n) of the rays that cross the bounds of the solid.
        by_trees
            Whether to build a BVH tree even for a mesh that changes shape.

        Yields
        ------
        tuple
            Index of the frame; and indices, ranges and faces of the rays that hit.
        """
        if geometry.deforms and not by_trees and not surfaces[0].large:
            yield from _hits_on_changing_solid(surfaces, matrix, inverse, rays, limits, crossed)
            return
        for i, surface in enumerate(surfaces):
            which = np.flatnonzero(crossed[i])
            far, faces = self._distances(geometry, surface, which, rays, limits[which], inverse[i])
            nearer = far < limits[which]
            if nearer.any():
                yield i, (which[nearer], far[nearer], faces[nearer])

    def _overlapping(self, rows: Index, rays: RayBundle, box: tuple[Array, Array]) -> list[Index]:
        """Return the rows of the solids whose bounds overlap `box`, split to limit memory."""
        near = (self.solids.lo[rows] <= box[1]) & (self.solids.hi[rows] >= box[0])
        rows = rows[near.all(axis=1)]
        at_once = max(1, PAIRS_AT_ONCE // len(rays.length))
        return [rows[start : start + at_once] for start in range(0, len(rows), at_once)]

    def _hit_solids(
        self,
        rows: Index,
        rays: RayBundle,
        box: tuple[Array, Array],
        seen: RayHits,
        by_trees: bool = False,
    ) -> None:
        """Replace `seen` by nearer hits on the solids `rows`, at the present frame.

        If `by_trees` is True, meshes that change shape get BVH trees too. A tree pays off if many
        bundles are cast at the same frame.
        """
        for part in self._overlapping(rows, rays, box):
            enter, leave = _slabs(self.solids.lo[part], self.solids.hi[part], rays)
            crossed = (leave >= enter) & (enter <= seen.ranges)
            hit_rows = np.flatnonzero(crossed.any(axis=1))
            nearest_first = np.argsort(np.where(crossed, enter, np.inf)[hit_rows].min(axis=1))
            for i in hit_rows[nearest_first].tolist():
                may_hit = crossed[i] & (enter[i] <= seen.ranges)
                if may_hit.any():
                    row = int(part[i])
                    solid, matrix = self.solids.solids[row], self.solids.matrix[row][None]
                    shape = solid.geometry, [solid.geometry.state], matrix
                    for _, hit in self._hits_on_solid(
                        *shape,
                        self.solids.inverse[row][None],
                        rays,
                        seen.ranges,
                        may_hit[None],
                        by_trees,
                    ):
                        seen.shorten(solid.number, *hit)

    def _distances(
        self,
        geometry: Geometry,
        surface: Any,
        which: Index,
        rays: RayBundle,
        limits: Array,
        inverse: Array,
    ) -> tuple[Array, Index]:
        """Return the ranges (k,) of the rays `which` to a surface, and the hit faces (k,).

        The range of a miss, or of a hit beyond the limits (k,), is inf.
        """
        origins, ways = rays.origins[which], rotated(rays.directions[which], inverse)
        if geometry.deforms and surface.large:
            return surface.meet(rotated(origins, inverse) + inverse[:3, 3], ways)
        # Building the tree sets its pivot.
        geometry.tree(self.frames.depsgraph)
        starts = rotated(origins, inverse) + (inverse[:3, 3] - geometry.pivot)
        scale = np.linalg.norm(ways, axis=1)
        limits = limits * scale * LIMIT_SLACK
        far, faces = geometry.meet(self.frames.depsgraph, starts, ways, limits)
        return far / scale, faces


def _hits_on_changing_solid(
    surfaces: list[Any],
    matrix: Array,
    inverse: Array,
    rays: RayBundle,
    limits: Array,
    crossed: NDArray[np.bool_],
) -> Iterator[tuple[int, tuple[Index, Array, Index]]]:
    """Yield the hits on a solid that changes shape, as `RayCaster._hits_on_solid` does."""
    for part in _runs_of_same_triangles(surfaces):
        points = np.stack([surface.points for surface in surfaces[part]])
        corners, face = surfaces[part.start].triangles
        may_hit = crossed[part]
        seen = rays.pictures, rays.origins, rays.directions
        hits = changing_shapes.nearest_hits(
            points, corners, matrix[part], inverse[part], *seen, may_hit
        )
        hits = hits.at(hits.far < limits[hits.ray])
        for same in np.split(np.arange(len(hits.frame)), np.flatnonzero(np.diff(hits.frame)) + 1):
            if len(same):
                yield (
                    part.start + int(hits.frame[same[0]]),
                    (
                        hits.ray[same],
                        hits.far[same],
                        face[hits.triangle[same]],
                    ),
                )


def _runs_of_same_triangles(surfaces: list[Any]) -> Iterator[slice]:
    """Yield slices of consecutive surfaces that have the same triangles.

    The points of a slice fit into the processor's caches.
    """
    most = max(1, POINTS_AT_ONCE // max(1, surfaces[0].points.shape[1]))
    start = 0
    for end in range(1, len(surfaces) + 1):
        if (
            end == len(surfaces)
            or end - start == most
            or not np.array_equal(surfaces[end].triangles[0], surfaces[start].triangles[0])
        ):
            yield slice(start, end)
            start = end


def _slabs(lo: Array, hi: Array, rays: RayBundle) -> tuple[Array, Array]:
    """Return the ranges (m, n) at which n rays enter and leave m boxes, by the slab method.

    A ray misses a box if it leaves before it enters.
    """
    enter, leave = np.zeros((len(lo), len(rays.length))), np.full((1, 1), np.inf)
    with np.errstate(invalid="ignore"):
        for start, inverse, low, high in zip(rays.starts, rays.inverse, lo.T, hi.T, strict=True):
            one, two = (low[:, None] - start) * inverse, (high[:, None] - start) * inverse
            # fmin and fmax ignore the NaN of a ray that runs in the plane of a face.
            enter = np.fmax(enter, np.fmin(one, two))
            leave = np.fmin(leave, np.fmax(one, two))
    return enter, leave
