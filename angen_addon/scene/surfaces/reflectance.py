# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the reflectance of the surfaces that rays hit: the luminance of their materials' colours."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ....sensor_logic.kind import REFLECTANCE
from ....sensor_logic.model import Array, Index
from ....sensor_logic.physics import luminance
from ..animation import all_animated
from ..light.materials import Surfaces
from ..rays.caster import NOTHING, RayCaster, RayHits
from ..rays.solids import Solid
from .probe import HitSurfaces

NO_MATERIAL = 0
COLOURED = (bpy.types.Material, bpy.types.ShaderNodeTree)


class Reflectance(HitSurfaces):
    """Reads the reflectance (n,) of hit solids, from 0 to 1; 0 for a ray that hits nothing."""

    need = REFLECTANCE
    reads_shading = True

    @staticmethod
    def changes_by_itself(scene: Any) -> bool:
        """Return whether any material or its nodes are animated, so that its colour may change."""
        return any(isinstance(owner, COLOURED) for owner in all_animated())

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        self._surfaces = Surfaces()
        # Whether materials are animated.
        self._changing = False
        self._solids: dict[int, Solid] = {}

    def _update(self) -> None:
        solids = self._rays.solids
        if self._listing != solids.listing:
            self._listing, self._surfaces = solids.listing, Surfaces()
            self._changing = self.changes_by_itself(self._depsgraph.scene)
            self._solids = {solid.number: solid for solid in solids.solids}
        if self._changing:
            self._surfaces = Surfaces()

    def _values_at(self, seen: RayHits) -> Array:
        found = np.zeros(len(seen.solids))
        for number in np.unique(seen.solids[seen.solids != NOTHING]).tolist():
            which, geometry = np.flatnonzero(seen.solids == number), self._solids[number].geometry
            materials = geometry.materials(self._depsgraph) or [NO_MATERIAL]
            each = np.array(
                [luminance(self._surfaces.reflectance(uid)) for uid in materials], np.float64
            )
            slot: Index = np.zeros(len(which), np.intp)
            if np.ptp(each) > 0.0:
                slots = geometry.material_slots(self._depsgraph)
                slot = slots[np.clip(seen.faces[which], 0, len(slots) - 1)].astype(np.intp)
            found[which] = each[np.clip(slot, 0, len(each) - 1)]
        return found


PROBE = Reflectance
