# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays of the preview of light: what they meet first, and how much light gets along them.

What the still solids do to a bundle of rays is remembered; each update asks the moving ones only.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..instances import Uid
from ..rays.caster import NOTHING, RayCaster
from ..rays.solids import Solids
from .surfaces import Surfaces

Array = NDArray[np.float64]
MOST_PASSED = 16
# Goes on this far behind a surface that lets light pass, in Blender units.
STEP = 1e-4
SLACK = 1.0 + 1e-5
NO_SLOTS = np.empty(0, np.int32)


@dataclass
class _Known:
    """A bundle of rays (n): what they meet among the still solids, and, for those that were asked
    for, the normal and the material there."""

    rays: tuple[Array, Array, Array]
    ranges: Array
    met: NDArray[np.int64]
    places: dict[int, tuple[Array, int]] = field(default_factory=dict)

    def fits(self, *rays: Array) -> bool:
        return all(np.array_equal(a, b) for a, b in zip(self.rays, rays, strict=True))


class LightRays:
    """Casts rays that pass the housings of light sensors, at one state of the solids after the
    other. `surfaces`: facts of materials, at the present state."""

    def __init__(self, solids: Solids) -> None:
        self.solids = solids
        self.surfaces = Surfaces()
        self._caster = RayCaster(solids)
        self._depsgraph: Any = None
        self._state = (-1, -1)
        self._still = np.empty(0, np.intp)
        self._moving = np.empty(0, np.intp)
        self._by_number: dict[int, Any] = {}
        self._known: dict[Hashable, _Known] = {}
        self._slots: dict[int, tuple[Any, list[int], NDArray[np.int32]]] = {}

    def update(self, depsgraph: Any, housings: frozenset[Uid]) -> None:
        """To be called once an update, after `solids.sync`; `housings`: what tells the light
        sensors, whose own solids and children do not count."""
        self._depsgraph = depsgraph
        self.surfaces = Surfaces()
        state = self.solids.listing, len(self.solids.gone)
        if state == self._state:
            return
        self._state = state
        self._known.clear()
        counts = np.fromiter(
            (not (s.owners & housings) for s in self.solids.solids), bool, len(self.solids.solids)
        )
        self._still = np.flatnonzero(counts & ~self.solids.moving)
        self._moving = np.flatnonzero(counts & self.solids.moving)
        self._by_number = {solid.number: solid for solid in self.solids.solids}
        self._slots.clear()

    def nearest(self, bundle: Hashable, starts: Array, ways: Array, lengths: Array) -> Hits:
        """What rays along unit vectors meet within their lengths."""
        known = self._known.get(bundle)
        if known is None or not known.fits(starts, ways, lengths):
            found = self._caster.first_met(self._depsgraph, self._still, starts, ways, lengths)
            known = self._known[bundle] = _Known((starts, ways, lengths), *found)
        if not len(self._moving):
            return Hits(self, known, known.ranges, known.met)
        ranges, met = self._caster.first_met(
            self._depsgraph, self._moving, starts, ways, known.ranges
        )
        return Hits(self, known, ranges, np.where(met == NOTHING, known.met, met))

    def place(self, number: int, start: Array, way: Array, length: float) -> tuple[Array, int]:
        """Of the solid `number`, which a ray meets within a length: normal (3,) and the session uid
        of the material."""
        solid = self._by_number[number]
        tree = solid.geometry.tree(self._depsgraph)
        inverse = self.solids.inverse[solid.row]
        turned = inverse[:3, :3] @ way
        begin = inverse[:3, :3] @ start + inverse[:3, 3] - solid.geometry.pivot
        limit = length * math.sqrt(float(turned @ turned)) * SLACK
        _, normal, face, _ = tree.ray_cast(begin.tolist(), turned.tolist(), limit)
        if normal is None:
            # At the very limit of single precision.
            return -way, 0
        outward = inverse[:3, :3].T @ np.array(normal, np.float64)
        size = math.sqrt(float(outward @ outward))
        # A face without an area looks at whoever meets it.
        return outward / size if size > 0.0 else -way, self._material(solid, face)

    def passed(self, bundle: Hashable, starts: Array, ends: Array, short: Array) -> Array:
        """Share (n, 3) of the light that gets from starts (n, 3) to as far as `short` (n,) before
        ends (n, 3)."""
        ways = ends - starts
        lengths = np.linalg.norm(ways, axis=1)
        ways = ways / np.maximum(lengths, STEP)[:, None]
        left = lengths - short - STEP
        share = np.ones((len(starts), 3))
        on = np.flatnonzero(left > 0.0)
        begins = starts.copy()
        for turn in range(MOST_PASSED):
            if not len(on):
                return share
            hits = self.nearest((bundle, turn), begins[on], ways[on], left[on])
            going = []
            for ray in hits.some:
                clear, i = hits.surface(ray)[2], int(on[ray])
                share[i] *= clear
                if clear.any():
                    gone = float(hits.ranges[ray]) + STEP
                    begins[i] += ways[i] * gone
                    left[i] -= gone
                    if left[i] > 0.0:
                        going.append(i)
            on = np.array(going, np.intp)
        share[on] = 0.0
        return share

    def _material(self, solid: Any, face: int) -> int:
        """The session uid of the material of a face of a solid; 0 where it has none."""
        geometry = solid.geometry
        known = self._slots.get(solid.number)
        if known is None or known[0] is not geometry.state:
            materials = geometry.materials(self._depsgraph)
            # Of one material, it does not matter which face.
            several = len(set(materials)) > 1
            slots = geometry.material_slots(self._depsgraph) if several else NO_SLOTS
            known = self._slots[solid.number] = geometry.state, materials, slots
        _, materials, slots = known
        slot = int(slots[face]) if face < len(slots) else 0
        # As Blender does, which takes the last where a face names a slot that is not there.
        return materials[max(0, min(slot, len(materials) - 1))] if materials else 0


class Hits:
    """What each of a bundle's rays meets: `ranges` (n,), `met` (n,) the numbers of solids or
    NOTHING; `some`: the rays that meet one."""

    def __init__(
        self, rays: LightRays, known: _Known, ranges: Array, met: NDArray[np.int64]
    ) -> None:
        self._rays = rays
        self._known = known
        self.ranges = ranges
        self.met = met
        self.some: list[int] = np.flatnonzero(met != NOTHING).tolist()

    def surface(self, ray: int) -> tuple[Array, Array, Array]:
        """Where a ray meets a solid: normal, reflectance and transmittance, (3,) each."""
        normal, material = self._place(ray)
        return normal, *self._rays.surfaces.of(material)

    def is_clear(self, ray: int) -> bool:
        """Whether what a ray meets can let light pass."""
        return self._rays.surfaces.are_clear(self._place(ray)[1])

    def _place(self, ray: int) -> tuple[Array, int]:
        """The normal there, and the session uid of the material."""
        known, number = self._known, int(self.met[ray])
        starts, ways, _ = known.rays
        asked = number, starts[ray], ways[ray], float(self.ranges[ray])
        if number != known.met[ray]:
            return self._rays.place(*asked)
        if ray not in known.places:
            known.places[ray] = self._rays.place(*asked)
        return known.places[ray]
