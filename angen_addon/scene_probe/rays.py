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

from .solids import Solids

Array = NDArray[np.float64]
# A box test of more pairs of boxes and rays than this is split, to bound its memory.
PAIRS_AT_ONCE = 200_000
# The limit handed to the tree is in single precision: let it pass what is at the limit exactly.
LIMIT_SLACK = 1.0 + 1e-6
NOTHING = 0


@dataclass
class _Still:
    """What a bundle of rays meets among the still solids: ranges (n,), solid numbers met (n,)."""

    origins: Array
    directions: Array
    length: Array
    own: frozenset[int]
    ranges: Array
    met: NDArray[np.int64]
    gone_seen: int


class RayCaster:
    """Ranges in Blender units of rays through the solids, without the sensor's own objects."""

    def __init__(self) -> None:
        self.solids = Solids()
        self._still: dict[tuple[int, int], _Still] = {}
        self._own: dict[int, tuple[int, NDArray[np.bool_], frozenset[int]]] = {}
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
        own_mask, own = self._own_solids(sensor)
        still = self._still_ranges(sensor, bundle, origins, directions, length, own_mask, own)
        ranges, met = still.ranges.copy(), still.met.copy()
        movers = np.flatnonzero(self.solids.moving & ~own_mask)
        self._meet(movers, origins, directions, ranges, met)
        return ranges

    def _own_solids(self, sensor: int) -> tuple[NDArray[np.bool_], frozenset[int]]:
        known = self._own.get(sensor)
        if known is None or known[0] != self.solids.listing:
            mask = self.solids.owned_by(sensor)
            numbers = frozenset(self.solids.solids[i].number for i in np.flatnonzero(mask))
            known = self._own[sensor] = (self.solids.listing, mask, numbers)
        return known[1], known[2]

    def _still_ranges(
        self,
        sensor: int,
        bundle: int,
        origins: Array,
        directions: Array,
        length: Array,
        own_mask: NDArray[np.bool_],
        own: frozenset[int],
    ) -> _Still:
        gone = self.solids.gone
        known = self._still.get((sensor, bundle))
        if (
            known is None
            or known.own != own
            or not np.array_equal(known.origins, origins)
            or not np.array_equal(known.directions, directions)
            or not np.array_equal(known.length, length)
        ):
            met = np.full(len(length), NOTHING, np.int64)
            known = _Still(origins, directions, length, own, length.copy(), met, len(gone))
            self._still[sensor, bundle] = known
            again = np.arange(len(length))
        elif known.gone_seen < len(gone):
            again = np.flatnonzero(np.isin(known.met, gone[known.gone_seen :]))
            known.gone_seen = len(gone)
        else:
            return known
        if len(again):
            ranges, met = length[again].copy(), np.full(len(again), NOTHING, np.int64)
            rows = np.flatnonzero(~self.solids.moving & ~own_mask)
            self._meet(rows, origins[again], directions[again], ranges, met)
            known.ranges[again], known.met[again] = ranges, met
        return known

    def _meet(
        self,
        rows: NDArray[np.intp],
        origins: Array,
        directions: Array,
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        """Shortens `ranges` in place to the nearest of the solids `rows`; `met` says which."""
        if not len(rows):
            return
        ends = origins + directions * ranges[:, None]
        lo = np.minimum(origins, ends).min(axis=0)
        hi = np.maximum(origins, ends).max(axis=0)
        near = (self.solids.lo[rows] <= hi).all(axis=1) & (self.solids.hi[rows] >= lo).all(axis=1)
        rows = rows[near]
        at_once = max(1, PAIRS_AT_ONCE // len(ranges))
        for start in range(0, len(rows), at_once):
            self._meet_some(rows[start : start + at_once], origins, directions, ranges, met)

    def _meet_some(
        self,
        rows: NDArray[np.intp],
        origins: Array,
        directions: Array,
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        enter, leave = _slabs(self.solids.lo[rows], self.solids.hi[rows], origins, directions)
        crossed = (leave >= enter) & (enter <= ranges)
        hit_rows = np.flatnonzero(crossed.any(axis=1))
        nearest_first = np.argsort(np.where(crossed, enter, np.inf)[hit_rows].min(axis=1))
        for i in hit_rows[nearest_first].tolist():
            rays = np.flatnonzero(crossed[i] & (enter[i] <= ranges))
            if len(rays):
                self._meet_one(int(rows[i]), rays, origins, directions, ranges, met)

    def _meet_one(
        self,
        row: int,
        rays: NDArray[np.intp],
        origins: Array,
        directions: Array,
        ranges: Array,
        met: NDArray[np.int64],
    ) -> None:
        solid = self.solids.solids[row]
        ray_cast = solid.geometry.tree(self._depsgraph).ray_cast
        inverse = self.solids.inverse[row]
        turn = inverse[:3, :3].T
        starts = origins[rays] @ turn + (inverse[:3, 3] - solid.geometry.pivot)
        ways = directions[rays] @ turn
        scale = np.linalg.norm(ways, axis=1)
        limits = ranges[rays] * scale * LIMIT_SLACK
        for ray, start, way, limit, size in zip(
            rays.tolist(),
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
