# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts rays against the solids: exact, and only where something can have changed.

Still solids are met once for each bundle of rays and remembered; of those that move, only what has
changed since the bundle was last cast is tested, and only where a ray crosses its box. A ray is met
in the solid's own space, where single precision is accurate wherever in the world the solid stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Answers, Index
from ..instances import Uid
from . import sections
from .bundles import Bundle, Moving, Rays, Watch
from .solids import Solid, Solids

Array = NDArray[np.float64]
# A box test of more pairs of boxes and rays than this is split, to bound its memory.
PAIRS_AT_ONCE = 200_000
# The limit handed to the tree is in single precision: let it pass what is at the limit exactly.
LIMIT_SLACK = 1.0 + 1e-6
NOTHING = 0


@dataclass
class _Own:
    """The solids of one sensor, which its rays pass through: numbers; and the rows of the others,
    still and moving. Valid for one state of the list of solids."""

    state: tuple[int, int]
    numbers: frozenset[int]
    still: NDArray[np.intp]
    moving: NDArray[np.intp]


class RayCaster:
    """Ranges in Blender units of rays through the solids, without the sensor's own objects."""

    def __init__(self, solids: Solids | None = None) -> None:
        self.solids = solids or Solids()
        self._bundles: dict[tuple[Uid, int], Bundle] = {}
        self._watch = Watch(self.solids)
        self._own: dict[Uid, _Own] = {}
        self._depsgraph: Any = None

    def update(self, depsgraph: Any) -> None:
        """To be called once after each evaluation, before rays are cast."""
        self._depsgraph = depsgraph
        self.solids.sync(depsgraph)

    def cast(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Ranges (n,) of rays from origins (n, 3) along unit vectors (n, 3), at most length (n,).

        `sensor` is the session uid, or path, of the object whose own solids the rays pass through.
        """
        return self.cast_met(sensor, bundle, origins, directions, length)[0]

    def cast_at(
        self,
        sensor: Uid,
        bundle: int,
        origins: Array,
        directions: Array,
        length: Array,
        frames: Index,
    ) -> Answers:
        """The ranges (k, n) at each of the frames (m,) that are kept."""
        ranges = self.cast(sensor, bundle, origins, directions, length)
        return Answers(ranges[None], np.zeros(len(frames), np.intp))

    def cast_met(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> tuple[Array, NDArray[np.int64]]:
        """The same ranges, and the number (n,) of the solid that each ray meets, or NOTHING.

        Both are the same arrays, not to be written to, as long as nothing changes.
        """
        own = self._own_solids(sensor)
        known = self._bundles.get((sensor, bundle))
        if (
            known is None
            or known.moving is None
            or known.moving.rows is not own.moving
            or not known.rays.are(origins, directions, length)
            or self._watch.is_stale(known)
        ):
            known = self._meet_still(sensor, bundle, Rays(origins, directions, length), own)
            self._meet_moving(known, own.moving)
            self._watch.cast(known)
        assert known.moving is not None
        return known.moving.ranges, known.moving.met

    def faces_met(
        self, solid: Solid, origins: Array, directions: Array, ranges: Array
    ) -> NDArray[np.intp]:
        """The face (n,) of `solid`, as its tree counts them, that each of these rays meets at its
        range."""
        starts, ways, scale = self._into(solid, origins, directions)
        limits = ranges * scale * LIMIT_SLACK
        return np.maximum(solid.geometry.meet(self._depsgraph, starts, ways, limits)[1], 0)

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
        rays = Rays(origins, directions, length)
        ranges, met = length.copy(), np.full(len(length), NOTHING, np.int64)
        if len(ranges):
            self._meet(rows, rays, rays.box(ranges), ranges, met)
        return ranges, met

    def _own_solids(self, sensor: Uid) -> _Own:
        state = self.solids.listing, len(self.solids.gone)
        known = self._own.get(sensor)
        if known is None or known.state != state:
            mask = self.solids.owned_by(sensor)
            numbers = frozenset(self.solids.solids[i].number for i in np.flatnonzero(mask))
            moving = self.solids.moving
            known = _Own(
                state, numbers, np.flatnonzero(~moving & ~mask), np.flatnonzero(moving & ~mask)
            )
            self._own[sensor] = known
        return known

    def _meet_still(self, sensor: Uid, bundle: int, rays: Rays, own: _Own) -> Bundle:
        """What is known of the bundle, made anew where solids that it met are gone."""
        gone = self.solids.gone
        known = self._bundles.get((sensor, bundle))
        if known is None or known.own != own.numbers or not known.rays.same(rays):
            met = np.full(len(rays.length), NOTHING, np.int64)
            ranges = rays.length.copy()
            place = known.place if known is not None else self._watch.add()
            box = rays.box(ranges)
            known = Bundle(rays, own.numbers, ranges, met, box, len(gone), place)
            self._bundles[sensor, bundle] = known
            again = np.arange(len(ranges))
        elif known.gone_seen < len(gone):
            again = np.flatnonzero(np.isin(known.met, gone[known.gone_seen :]))
            known.gone_seen = len(gone)
            known.moving = None
        else:
            return known
        if len(again):
            part = Rays(rays.origins[again], rays.directions[again], rays.length[again])
            ranges, met = part.length.copy(), np.full(len(again), NOTHING, np.int64)
            self._meet(own.still, part, part.box(ranges), ranges, met)
            known.ranges[again], known.met[again] = ranges, met
            known.box = rays.box(known.ranges)
        return known

    def _meet_moving(self, bundle: Bundle, rows: NDArray[np.intp]) -> None:
        """What the bundle meets now, looked for anew where a solid has changed since the last."""
        versions = self.solids.version[rows]
        known = bundle.moving
        if known is not None and known.rows is rows:
            changed = rows[versions != known.versions]
            before = len(known.hits)
            hits = {row: hit for row, hit in known.hits.items() if row not in changed}
            dropped = len(hits) < before
        else:
            changed, hits, dropped = rows, {}, True
        found = self._hits(changed, bundle) if len(changed) else {}
        if known is not None and not found and not dropped:
            known.versions = versions
            return
        hits.update(found)
        ranges, met = bundle.ranges.copy(), bundle.met.copy()
        for row, (which, far) in hits.items():
            self._shorten(row, which, far, ranges, met)
        ranges.flags.writeable = met.flags.writeable = False
        bundle.moving = Moving(rows, versions, hits, ranges, met)

    def _hits(
        self, rows: NDArray[np.intp], bundle: Bundle
    ) -> dict[int, tuple[NDArray[np.intp], Array]]:
        """By row of those of the solids that a bundle meets: which of its rays do, and how far
        they go."""
        found = {}
        for part in self._near(rows, bundle.rays, bundle.box):
            crossed = self._crossed(part, bundle.rays, bundle.ranges)[1]
            for i in np.flatnonzero(crossed.any(axis=1)).tolist():
                which = np.flatnonzero(crossed[i])
                row = int(part[i])
                far = self._far(row, which, bundle.rays, bundle.ranges[which])
                nearer = far < bundle.ranges[which]
                if nearer.any():
                    found[row] = which[nearer], far[nearer]
        return found

    def _near(
        self, rows: NDArray[np.intp], rays: Rays, box: tuple[Array, Array]
    ) -> list[NDArray[np.intp]]:
        """Those of the solids `rows` whose bounds meet the box of the rays, so many at once as one
        may compare with each ray."""
        near = (self.solids.lo[rows] <= box[1]) & (self.solids.hi[rows] >= box[0])
        rows = rows[near.all(axis=1)]
        at_once = max(1, PAIRS_AT_ONCE // len(rays.length))
        return [rows[start : start + at_once] for start in range(0, len(rows), at_once)]

    def _crossed(
        self, rows: NDArray[np.intp], rays: Rays, ranges: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Where each ray enters the box of each solid, and whether it does within its range; both
        (rows, rays)."""
        enter, leave = _slabs(self.solids.lo[rows], self.solids.hi[rows], rays)
        return enter, (leave >= enter) & (enter <= ranges)

    def _meet(
        self,
        rows: NDArray[np.intp],
        rays: Rays,
        box: tuple[Array, Array],
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        """Shortens `ranges` in place to the nearest of the solids `rows`; `met` says which."""
        for part in self._near(rows, rays, box):
            enter, crossed = self._crossed(part, rays, ranges)
            hit_rows = np.flatnonzero(crossed.any(axis=1))
            nearest_first = np.argsort(np.where(crossed, enter, np.inf)[hit_rows].min(axis=1))
            for i in hit_rows[nearest_first].tolist():
                which = np.flatnonzero(crossed[i] & (enter[i] <= ranges))
                if len(which):
                    row = int(part[i])
                    far = self._far(row, which, rays, ranges[which])
                    self._shorten(row, which, far, ranges, met)

    def _shorten(
        self,
        row: int,
        which: NDArray[np.intp],
        far: Array,
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        nearer = far < ranges[which]
        which = which[nearer]
        ranges[which] = far[nearer]
        met[which] = self.solids.solids[row].number

    def _far(self, row: int, which: NDArray[np.intp], rays: Rays, limits: Array) -> Array:
        """How far (k,) the rays `which` (k,) go to a solid; inf where that is beyond the limits."""
        solid = self.solids.solids[row]
        geometry = solid.geometry
        origins, directions = rays.origins[which], rays.directions[which]
        if geometry.deforms and not geometry.has_tree:
            # Who changes shape at each update is met a few times only: a hierarchy would cost more.
            corners = geometry.plain_triangles()
            if corners is not None and rays.plane is not None:
                return self._far_in_plane(solid, corners, rays.plane, origins, directions)
        starts, ways, scale = self._into(solid, origins, directions)
        return geometry.meet(self._depsgraph, starts, ways, limits * scale * LIMIT_SLACK)[0] / scale

    def _far_in_plane(
        self,
        solid: Solid,
        corners: NDArray[np.intp],
        plane: tuple[Array, Array],
        origins: Array,
        directions: Array,
    ) -> Array:
        """How far (k,) rays that all lie in one plane go to a solid, inf where they miss it."""
        point, normal = plane
        matrix, inverse = self.solids.matrix[solid.row], self.solids.inverse[solid.row]
        offset = float(normal @ (point - matrix[:3, 3]))
        vertices = solid.geometry.vertices
        faces = sections.cut(vertices, corners, normal @ matrix[:3, :3], offset)
        triangles = vertices[corners[:, faces].T].astype(np.float64)
        turn = inverse[:3, :3].T
        return sections.meet(triangles, origins @ turn + inverse[:3, 3], directions @ turn)

    def _into(self, solid: Solid, origins: Array, directions: Array) -> tuple[Array, Array, Array]:
        """Starts and ways (n, 3) of rays in the space of a solid's tree; lengths of the ways."""
        # Building the tree sets its pivot.
        solid.geometry.tree(self._depsgraph)
        inverse = self.solids.inverse[solid.row]
        turn = inverse[:3, :3].T
        starts = origins @ turn + (inverse[:3, 3] - solid.geometry.pivot)
        ways = directions @ turn
        return starts, ways, np.linalg.norm(ways, axis=1)


def _slabs(lo: Array, hi: Array, rays: Rays) -> tuple[Array, Array]:
    """Where rays (n) enter and leave boxes (m): two arrays (m, n); it misses if leave < enter."""
    enter, leave = np.zeros((len(lo), len(rays.length))), np.full((1, 1), np.inf)
    with np.errstate(invalid="ignore"):
        for start, inverse, low, high in zip(rays.starts, rays.inverse, lo.T, hi.T, strict=True):
            one, two = (low[:, None] - start) * inverse, (high[:, None] - start) * inverse
            # fmin and fmax pass over the NaN of a ray that runs in the plane of a face.
            enter = np.fmax(enter, np.fmin(one, two))
            leave = np.fmin(leave, np.fmax(one, two))
    return enter, leave
