# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts rays against the solids: exact, and only where something can have changed.

Still solids are met once for each bundle of rays and remembered; at each update only the solids
that move are tested, and of those only where a ray crosses their box. A ray is met in the solid's
own space, where single precision is accurate wherever in the world the solid stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .solids import Solid, Solids

Array = NDArray[np.float64]
# A box test of more pairs of boxes and rays than this is split, to bound its memory.
PAIRS_AT_ONCE = 200_000
# The limit handed to the tree is in single precision: let it pass what is at the limit exactly.
LIMIT_SLACK = 1.0 + 1e-6
NOTHING = 0


@dataclass
class _Rays:
    """A bundle: origins (n, 3), unit directions (n, 3), how far they reach (n,)."""

    origins: Array
    directions: Array
    length: Array

    def same(self, other: _Rays) -> bool:
        return all(
            a is b or np.array_equal(a, b)
            for a, b in (
                (self.origins, other.origins),
                (self.directions, other.directions),
                (self.length, other.length),
            )
        )

    def box(self, ranges: Array) -> tuple[Array, Array]:
        """Bounds (3,), (3,) of the rays as far as `ranges`."""
        ends = self.origins + self.directions * ranges[:, None]
        both = np.concatenate([self.origins, ends])
        return both.min(axis=0), both.max(axis=0)


@dataclass
class _Still:
    """What a bundle meets among the still solids: ranges (n,), the numbers of the solids met (n,),
    and the box of the rays up to there. `gone_seen`: how much of `Solids.gone` is dealt with."""

    rays: _Rays
    own: frozenset[int]
    ranges: Array
    met: NDArray[np.int64]
    box: tuple[Array, Array]
    gone_seen: int


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
        self._still: dict[tuple[int, int], _Still] = {}
        self._own: dict[int, _Own] = {}
        self._depsgraph: Any = None

    def update(self, depsgraph: Any) -> None:
        """To be called once after each evaluation, before rays are cast."""
        self._depsgraph = depsgraph
        self.solids.sync(depsgraph)

    def cast(
        self, sensor: int, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Ranges (n,) of rays from origins (n, 3) along unit vectors (n, 3), at most length (n,).

        `sensor` is the session uid of the object whose own solids the rays pass through.
        """
        return self.cast_met(sensor, bundle, origins, directions, length)[0]

    def cast_met(
        self, sensor: int, bundle: int, origins: Array, directions: Array, length: Array
    ) -> tuple[Array, NDArray[np.int64]]:
        """The same ranges, and the number (n,) of the solid that each ray meets, or NOTHING."""
        rays = _Rays(origins, directions, length)
        own = self._own_solids(sensor)
        still = self._meet_still(sensor, bundle, rays, own)
        ranges, met = still.ranges.copy(), still.met.copy()
        self._meet(own.moving, rays, still.box, ranges, met)
        return ranges, met

    def faces_met(
        self, solid: Solid, origins: Array, directions: Array, ranges: Array
    ) -> NDArray[np.intp]:
        """The face (n,) of `solid`, as its tree counts them, that each of these rays meets at its
        range."""
        starts, ways, scale = self._into(solid, origins, directions)
        ray_cast = solid.geometry.tree(self._depsgraph).ray_cast
        limits = ranges * scale * LIMIT_SLACK
        rays = zip(starts.tolist(), ways.tolist(), limits.tolist(), strict=True)
        found = (ray_cast(start, way, limit)[2] for start, way, limit in rays)
        return np.array([0 if face is None else face for face in found], np.intp)

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
        rays = _Rays(origins, directions, length)
        ranges, met = length.copy(), np.full(len(length), NOTHING, np.int64)
        if len(ranges):
            self._meet(rows, rays, rays.box(ranges), ranges, met)
        return ranges, met

    def _own_solids(self, sensor: int) -> _Own:
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

    def _meet_still(self, sensor: int, bundle: int, rays: _Rays, own: _Own) -> _Still:
        """What is known of the bundle, made anew where solids that it met are gone."""
        gone = self.solids.gone
        known = self._still.get((sensor, bundle))
        if known is None or known.own != own.numbers or not known.rays.same(rays):
            met = np.full(len(rays.length), NOTHING, np.int64)
            ranges = rays.length.copy()
            known = _Still(rays, own.numbers, ranges, met, rays.box(ranges), len(gone))
            self._still[sensor, bundle] = known
            again = np.arange(len(ranges))
        elif known.gone_seen < len(gone):
            again = np.flatnonzero(np.isin(known.met, gone[known.gone_seen :]))
            known.gone_seen = len(gone)
        else:
            return known
        if len(again):
            part = _Rays(rays.origins[again], rays.directions[again], rays.length[again])
            ranges, met = part.length.copy(), np.full(len(again), NOTHING, np.int64)
            self._meet(own.still, part, part.box(ranges), ranges, met)
            known.ranges[again], known.met[again] = ranges, met
            known.box = rays.box(known.ranges)
        return known

    def _meet(
        self,
        rows: NDArray[np.intp],
        rays: _Rays,
        box: tuple[Array, Array],
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        """Shortens `ranges` in place to the nearest of the solids `rows`; `met` says which."""
        near = (self.solids.lo[rows] <= box[1]) & (self.solids.hi[rows] >= box[0])
        rows = rows[near.all(axis=1)]
        at_once = max(1, PAIRS_AT_ONCE // len(ranges))
        for start in range(0, len(rows), at_once):
            self._meet_some(rows[start : start + at_once], rays, ranges, met)

    def _meet_some(
        self,
        rows: NDArray[np.intp],
        rays: _Rays,
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        lo, hi = self.solids.lo[rows], self.solids.hi[rows]
        enter, leave = _slabs(lo, hi, rays.origins, rays.directions)
        crossed = (leave >= enter) & (enter <= ranges)
        hit_rows = np.flatnonzero(crossed.any(axis=1))
        nearest_first = np.argsort(np.where(crossed, enter, np.inf)[hit_rows].min(axis=1))
        for i in hit_rows[nearest_first].tolist():
            which = np.flatnonzero(crossed[i] & (enter[i] <= ranges))
            if len(which):
                self._meet_one(int(rows[i]), which, rays, ranges, met)

    def _meet_one(
        self,
        row: int,
        which: NDArray[np.intp],
        rays: _Rays,
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        solid = self.solids.solids[row]
        starts, ways, scale = self._into(solid, rays.origins[which], rays.directions[which])
        ray_cast = solid.geometry.tree(self._depsgraph).ray_cast
        limits = ranges[which] * scale * LIMIT_SLACK
        for ray, start, way, limit, size in zip(
            which.tolist(),
            starts.tolist(),
            ways.tolist(),
            limits.tolist(),
            scale.tolist(),
            strict=True,
        ):
            distance = ray_cast(start, way, limit)[3]
            if distance is not None and distance / size < ranges[ray]:
                ranges[ray] = distance / size
                met[ray] = solid.number

    def _into(self, solid: Solid, origins: Array, directions: Array) -> tuple[Array, Array, Array]:
        """Starts and ways (n, 3) of rays in the space of a solid's tree; lengths of the ways."""
        # Building the tree sets its pivot.
        solid.geometry.tree(self._depsgraph)
        inverse = self.solids.inverse[solid.row]
        turn = inverse[:3, :3].T
        starts = origins @ turn + (inverse[:3, 3] - solid.geometry.pivot)
        ways = directions @ turn
        return starts, ways, np.linalg.norm(ways, axis=1)


def _slabs(lo: Array, hi: Array, origins: Array, directions: Array) -> tuple[Array, Array]:
    """Where rays (n) enter and leave boxes (m): two arrays (m, n); it misses if leave < enter."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / directions
        one = (lo[:, None, :] - origins) * inverse
        two = (hi[:, None, :] - origins) * inverse
    # fmin and fmax pass over the NaN of a ray that runs in the plane of a face.
    enter = np.fmax.reduce(np.fmin(one, two), axis=2)
    leave = np.fmin.reduce(np.fmax(one, two), axis=2)
    return np.maximum(enter, 0.0), leave
