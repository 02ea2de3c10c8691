# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts rays against the solids: exact, and only where something can have changed.

Still solids are met once for each bundle of rays and remembered; of those that move, only what has
changed since the bundle was last cast is tested, for all frames that are kept at once, and only
where a ray crosses its box. A ray is met in the solid's own space, where single precision is
accurate wherever in the world the solid stands.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Answers, Array
from ..instances import Uid
from . import changing_shapes
from .changing_shapes import RayPicture, apex_of, pictures_of, turned
from .frames import Frames
from .geometry import Geometry
from .solids import Solids, inverted

# Bundles of rays, and what each met when it was last cast.

Index = NDArray[np.intp]
# Origins (n, 3), unit directions (n, 3) and how far they reach (n,).
Rays = tuple[Array, Array, Array]


@dataclass
class RayBundle:
    """A bundle: origins (n, 3), unit directions (n, 3), how far they reach (n,)."""

    origins: Array
    directions: Array
    length: Array

    @property
    def starts(self) -> Array:
        """(3, n): by axis, as numpy is quick with."""
        return np.ascontiguousarray(self.origins.T)

    # These are made once a bundle, which lasts while its sensor rests. Without them, of 600 rays,
    # 6 µs (inverse), 0.1 ms (apex) and 2 ms (pictures) more for each batch of frames.
    @cached_property
    def inverse(self) -> Array:
        """(3, n): one over the directions."""
        with np.errstate(divide="ignore"):
            return 1.0 / np.ascontiguousarray(self.directions.T)

    @cached_property
    def apex(self) -> Array | None:
        """The point (3,) that the lines of all of them go through, if they do."""
        return apex_of(self.origins, self.directions)

    @cached_property
    def pictures(self) -> list[RayPicture]:
        """The pictures in which the bundle sees shapes that change."""
        return pictures_of(self.origins, self.directions, self.apex)

    def same(self, other: RayBundle) -> bool:
        """Whether another is equal."""
        own = self.origins, self.directions, self.length
        return all(map(np.array_equal, own, (other.origins, other.directions, other.length)))

    def box(self, ranges: Array) -> tuple[Array, Array]:
        """Bounds (3,), (3,) of the rays as far as `ranges`."""
        ends = self.origins + self.directions * ranges[:, None]
        both = np.concatenate([self.origins, ends])
        return both.min(axis=0), both.max(axis=0)


@dataclass
class RayHits:
    """What rays meet: ranges (n,), the number of the solid met (n,), and which face of it (n,)."""

    ranges: Array
    met: NDArray[np.int64]
    faces: Index

    def copy(self) -> RayHits:
        return RayHits(self.ranges.copy(), self.met.copy(), self.faces.copy())

    def shorten(self, number: int, which: Index, far: Array, faces: Index) -> None:
        """The rays `which` (k,) get to the solid of this number, where that is nearer."""
        nearer = far < self.ranges[which]
        which = which[nearer]
        self.ranges[which], self.met[which] = far[nearer], number
        self.faces[which] = faces[nearer]


@dataclass
class CastBundle:
    """What a bundle meets among the still solids, and the box of the rays up to there. `gone_seen`:
    how much of `Solids.gone` is dealt with. Of the moving solids, in that `state` of the list: the
    versions (m,) when it was cast last, 0 for one that is away from it; by row those that it met:
    which rays, how far they go and to which face; and with these what it `seen` last, which nobody
    may write to."""

    rays: RayBundle
    own: frozenset[int]
    still: RayHits
    box: tuple[Array, Array]
    gone_seen: int
    state: tuple[int, int] | None = None
    versions: Index = field(default_factory=lambda: np.zeros(0, np.intp))
    hits: dict[int, tuple[Index, Array, Index]] = field(default_factory=dict)
    seen: RayHits | None = None


# A box test of more pairs of boxes and rays than this is split, to bound its memory.
PAIRS_AT_ONCE = 200_000
# Points of a shape, over frames, that are looked at together.
POINTS_AT_ONCE = 1 << 16
# The limit handed to the tree is in single precision: let it pass what is at the limit exactly.
LIMIT_SLACK = 1.0 + 1e-6
NOTHING = 0
AWAY = 0


@dataclass
class _Own:
    """What a sensor's rays pass through and meet, for one `state` of the list of solids: `numbers`
    of its own solids; rows of all others, `still` and `moving`, and the latter's `columns` in the
    frames."""

    state: tuple[int, int]
    numbers: frozenset[int]
    still: Index
    moving: Index
    columns: Index


class RayCaster:
    """Ranges in Blender units of rays through the solids, without the sensor's own objects."""

    def __init__(self, solids: Solids | None = None) -> None:
        self.solids = solids or Solids()
        self.frames = Frames.present(self.solids)
        # What the rays met that were cast last, as `see_at` has it.
        self.seen = Answers([], np.zeros(0, np.intp))
        self._bundles: dict[tuple[Uid, int], CastBundle] = {}
        self._own: dict[Uid, _Own] = {}
        self._depsgraph: Any = None

    def update(self, depsgraph: Any) -> None:
        """Reads the scene's changes; to be called once after each evaluation, before rays are
        cast."""
        self.solids.sync(depsgraph)
        self.show(depsgraph, Frames.present(self.solids))

    def show(self, depsgraph: Any, frames: Frames) -> None:
        """Sets the frames at which rays are cast from now on."""
        self._depsgraph = depsgraph
        self.frames = frames

    def cast(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Ranges (n,) of rays from origins (n, 3) along unit vectors (n, 3), at most length (n,),
        at the last of the frames.

        `sensor` is the session uid, or path, of the object whose own solids the rays pass through.
        """
        return self.cast_met(sensor, bundle, origins, directions, length)[0]

    def cast_met(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> tuple[Array, NDArray[np.int64]]:
        """The same ranges, and the number (n,) of the solid that each ray meets, or NOTHING."""
        last = np.array([len(self.frames) - 1])
        rays = origins, directions, length
        seen: RayHits = self.see_at(sensor, bundle, rays, last)[0]
        return seen.ranges, seen.met

    def cast_at(self, sensor: Uid, bundle: int, rays: Rays, frames: Index) -> Answers:
        """The ranges (n,) at each of some frames (k,), in order of time, which nobody may write
        to."""
        found = self.see_at(sensor, bundle, rays, frames)
        for seen in found.table:
            seen.ranges.flags.writeable = False
        return Answers([seen.ranges for seen in found.table], found.rows)

    def see_at(self, sensor: Uid, bundle: int, rays: Rays, frames: Index) -> Answers:
        """What the rays meet at each of some frames (k,), in order of time: `RayHits`, which nobody
        may write to."""
        own = self._own_solids(sensor)
        known = self._meet_still(sensor, bundle, RayBundle(*rays), own)
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
                if self._renew(known, own.moving[changed[i]].tolist(), hits, int(frames[i])):
                    table.append(known.seen)
                rows[i:] = len(table) - 1
        self.seen = Answers(table, rows)
        return self.seen

    def last_ranges(self, sensor: Uid, bundle: int) -> Array:
        """Ranges (n,) of a bundle at the last of the frames that it was cast at."""
        seen = self._bundles[sensor, bundle].seen
        assert seen is not None
        return seen.ranges

    def _renew(
        self,
        bundle: CastBundle,
        rows: list[int],
        hits: dict[tuple[int, int], tuple[Index, Array, Index]],
        frame: int,
    ) -> bool:
        """Casts a bundle again where solids have changed; False where it meets the same as
        before."""
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

    def first_met(
        self,
        depsgraph: Any,
        rows: NDArray[np.intp],
        origins: Array,
        directions: Array,
        length: Array,
    ) -> tuple[Array, NDArray[np.int64]]:
        """Ranges (n,) to the nearest of the solids `rows` as last synced, and its number (n,), or
        NOTHING; remembers nothing."""
        self._depsgraph = depsgraph
        seen = self._nothing(length)
        if len(length):
            rays = RayBundle(origins, directions, length)
            self._meet(rows, rays, rays.box(length), seen, by_trees=True)
        return seen.ranges, seen.met

    def _nothing(self, length: Array) -> RayHits:
        count = len(length)
        met = np.full(count, NOTHING, np.int64)
        return RayHits(length.copy(), met, np.zeros(count, np.intp))

    def _own_solids(self, sensor: Uid) -> _Own:
        state = self.solids.listing, len(self.solids.gone)
        known = self._own.get(sensor)
        if known is None or known.state != state:
            mask = self.solids.owned_by(sensor)
            numbers = frozenset(self.solids.solids[i].number for i in np.flatnonzero(mask))
            moving = self.solids.moving
            columns = np.flatnonzero(~mask[self.frames.rows])
            rows = self.frames.rows[columns]
            known = _Own(state, numbers, np.flatnonzero(~moving & ~mask), rows, columns)
            self._own[sensor] = known
        return known

    def _meet_still(self, sensor: Uid, bundle: int, rays: RayBundle, own: _Own) -> CastBundle:
        """The known hits of a bundle on still solids; cast again if solids that it met are gone."""
        gone = self.solids.gone
        known = self._bundles.get((sensor, bundle))
        if known is None or known.own != own.numbers or not known.rays.same(rays):
            still = self._nothing(rays.length)
            known = CastBundle(rays, own.numbers, still, rays.box(rays.length), len(gone))
            self._bundles[sensor, bundle] = known
            again = np.arange(len(rays.length))
        elif known.gone_seen < len(gone):
            again = np.flatnonzero(np.isin(known.still.met, gone[known.gone_seen :]))
            known.gone_seen, known.state = len(gone), None
        else:
            return known
        if len(again):
            part = RayBundle(rays.origins[again], rays.directions[again], rays.length[again])
            seen = self._nothing(part.length)
            self._meet(own.still, part, part.box(part.length), seen)
            # What was seen before may be in other hands.
            known.still = still = known.still.copy()
            still.ranges[again], still.met[again] = seen.ranges, seen.met
            still.faces[again] = seen.faces
            known.box = rays.box(still.ranges)
        return known

    def _hits(
        self, bundle: CastBundle, frames: Index, columns: Index
    ) -> dict[tuple[int, int], tuple[Index, Array, Index]]:
        """The hits on solids that are given by frame (p,) and column (p,), by frame and row: which
        rays of a bundle meet each, how far they go and to which face."""
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
                for i, hit in self._meet_shape(*shape, inverse, rays, limits, crossed[which]):
                    found[whens[i], row] = hit
        return found

    def _meet_shape(
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
        """At those of some frames (k) at which rays meet a solid within their limits (n,): the
        number of the frame, which rays do, how far they go and to which face. It has a surface at
        each, and matrices (k, 4, 4) with their inverses; `crossed` (k, n): which rays may."""
        if geometry.deforms and not by_trees and not surfaces[0].large:
            yield from _meet_changing(surfaces, matrix, inverse, rays, limits, crossed)
            return
        for i, surface in enumerate(surfaces):
            which = np.flatnonzero(crossed[i])
            far, faces = self._far(geometry, surface, which, rays, limits[which], inverse[i])
            nearer = far < limits[which]
            if nearer.any():
                yield i, (which[nearer], far[nearer], faces[nearer])

    def _near(self, rows: Index, rays: RayBundle, box: tuple[Array, Array]) -> list[Index]:
        """The solids among `rows` whose bounds meet the box of the rays, in portions that can be
        compared with each ray."""
        near = (self.solids.lo[rows] <= box[1]) & (self.solids.hi[rows] >= box[0])
        rows = rows[near.all(axis=1)]
        at_once = max(1, PAIRS_AT_ONCE // len(rays.length))
        return [rows[start : start + at_once] for start in range(0, len(rows), at_once)]

    def _meet(
        self,
        rows: Index,
        rays: RayBundle,
        box: tuple[Array, Array],
        seen: RayHits,
        by_trees: bool = False,
    ) -> None:
        """Shortens what is `seen` to the nearest of the solids `rows`, as they are in the list.
        `by_trees`: also those that change, which is worth it where many bundles are cast in turn.
        """
        for part in self._near(rows, rays, box):
            enter, leave = _slabs(self.solids.lo[part], self.solids.hi[part], rays)
            crossed = (leave >= enter) & (enter <= seen.ranges)
            hit_rows = np.flatnonzero(crossed.any(axis=1))
            nearest_first = np.argsort(np.where(crossed, enter, np.inf)[hit_rows].min(axis=1))
            for i in hit_rows[nearest_first].tolist():
                asked = crossed[i] & (enter[i] <= seen.ranges)
                if asked.any():
                    row = int(part[i])
                    solid, matrix = self.solids.solids[row], self.solids.matrix[row][None]
                    shape = solid.geometry, [solid.geometry.state], matrix
                    for _, hit in self._meet_shape(
                        *shape,
                        self.solids.inverse[row][None],
                        rays,
                        seen.ranges,
                        asked[None],
                        by_trees,
                    ):
                        seen.shorten(solid.number, *hit)

    def _far(
        self,
        geometry: Geometry,
        surface: Any,
        which: Index,
        rays: RayBundle,
        limits: Array,
        inverse: Array,
    ) -> tuple[Array, Index]:
        """How far (k,) the rays `which` (k,) go to a shape with this inverse matrix, inf where that
        is beyond the limits, and to which face."""
        origins, ways = rays.origins[which], turned(rays.directions[which], inverse)
        if geometry.deforms and surface.large:
            return surface.meet(turned(origins, inverse) + inverse[:3, 3], ways)
        # Building the tree sets its pivot.
        geometry.tree(self._depsgraph)
        starts = turned(origins, inverse) + (inverse[:3, 3] - geometry.pivot)
        scale = np.linalg.norm(ways, axis=1)
        limits = limits * scale * LIMIT_SLACK
        far, faces = geometry.meet(self._depsgraph, starts, ways, limits)
        return far / scale, faces


def _meet_changing(
    surfaces: list[Any],
    matrix: Array,
    inverse: Array,
    rays: RayBundle,
    limits: Array,
    crossed: NDArray[np.bool_],
) -> Iterator[tuple[int, tuple[Index, Array, Index]]]:
    """As `RayCaster._meet_shape`, for a solid that changes its shape."""
    for part in _of_one_cut(surfaces):
        points = np.stack([surface.points for surface in surfaces[part]])
        corners, face = surfaces[part.start].triangles
        asked = crossed[part]
        seen = rays.pictures, rays.origins, rays.directions
        hits = changing_shapes.meet(points, corners, matrix[part], inverse[part], *seen, asked)
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


def _of_one_cut(surfaces: list[Any]) -> Iterator[slice]:
    """Stretches of surfaces whose faces are cut into the same triangles, so many as fit into
    memory that is quick."""
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
    """The distances at which rays (n) enter and leave boxes (m): two arrays (m, n); leave < enter:
    missed."""
    enter, leave = np.zeros((len(lo), len(rays.length))), np.full((1, 1), np.inf)
    with np.errstate(invalid="ignore"):
        for start, inverse, low, high in zip(rays.starts, rays.inverse, lo.T, hi.T, strict=True):
            one, two = (low[:, None] - start) * inverse, (high[:, None] - start) * inverse
            # fmin and fmax pass over the NaN of a ray that runs in the plane of a face.
            enter = np.fmax(enter, np.fmin(one, two))
            leave = np.fmin(leave, np.fmax(one, two))
    return enter, leave
