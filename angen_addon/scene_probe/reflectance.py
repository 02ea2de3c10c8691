# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of the light that falls on them the things throw back that rays meet: the luminance of
the colours of their materials."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...sensor_logic.model import Answers, Array, Index
from ...sensor_logic.photometry import luminance
from ..animation import all_animated
from ..instances import Uid
from .light.surfaces import Surfaces
from .rays import NOTHING, RayCaster
from .reference_rays import SceneRayCaster
from .solids import Solid

NO_MATERIAL = 0
COLOURED = (bpy.types.Material, bpy.types.ShaderNodeTree)


class Reflectance:
    """The reflectance of the solids of a ray caster."""

    def __init__(self, caster: RayCaster | SceneRayCaster) -> None:
        # Blender's own ray_cast serves as a reference for ranges; here the fast rays are as good.
        self._reference = not isinstance(caster, RayCaster)
        self._rays = caster if isinstance(caster, RayCaster) else RayCaster(caster.solids)
        self._listing = -1
        self._surfaces = Surfaces()
        # Whether materials are animated.
        self._changing = False
        self._solids: dict[int, Solid] = {}

    def see(
        self,
        depsgraph: Any,
        sensor: Uid,
        bundle: int,
        origins: Array,
        directions: Array,
        length: Array,
    ) -> Array:
        """(n,) from 0 to 1 where a sensor's rays end, in Blender units, after the caster was
        brought up to date; arguments as of `RayCaster.cast`. 0 where a ray meets nothing."""
        if self._reference:
            self._rays.update(depsgraph)
        solids = self._rays.solids
        if self._listing != solids.listing:
            self._listing, self._surfaces = solids.listing, Surfaces()
            self._changing = any(isinstance(owner, COLOURED) for owner in all_animated())
            self._solids = {solid.number: solid for solid in solids.solids}
        if self._changing:
            self._surfaces = Surfaces()
        ranges, met = self._rays.cast_met(sensor, bundle, origins, directions, length)
        found = np.zeros(len(met))
        for number in np.unique(met[met != NOTHING]).tolist():
            which = np.flatnonzero(met == number)
            rays = origins[which], directions[which], ranges[which]
            found[which] = self._of(depsgraph, self._solids[number], *rays)
        return found

    def see_at(
        self,
        depsgraph: Any,
        sensor: Uid,
        bundle: int,
        origins: Array,
        directions: Array,
        length: Array,
        frames: Index,
    ) -> Answers:
        """The same at each of the frames (m,) that are kept."""
        seen = self.see(depsgraph, sensor, bundle, origins, directions, length)
        return Answers(seen[None], np.zeros(len(frames), np.intp))

    def _of(
        self, depsgraph: Any, solid: Solid, origins: Array, directions: Array, ranges: Array
    ) -> Array:
        """(n,) where these rays meet a solid."""
        materials = solid.geometry.materials(depsgraph) or [NO_MATERIAL]
        each = np.array([luminance(self._surfaces.of(uid)[0]) for uid in materials], np.float64)
        if np.ptp(each) == 0.0:
            return np.full(len(ranges), each[0])
        slots = solid.geometry.material_slots(depsgraph)
        faces = self._rays.faces_met(solid, origins, directions, ranges)
        slot = slots[np.clip(faces, 0, len(slots) - 1)]
        found: Array = each[np.clip(slot, 0, len(each) - 1)]
        return found
