# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the temperature and the emissivity of the surfaces that rays hit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kind import WARMTH
from ....sensor_logic.model import Array, Emission, Index
from ....sensor_logic.physics import insulated_share
from ....sensor_logic.wording import ZERO_CELSIUS
from ..animation import is_animated
from ..rays.caster import NOTHING, RayCaster, RayHits
from ..rays.solids import Solid, Solids
from .probe import MetSurfaces

# Temperatures.
#
# A temperature is set on a material, an object or a collection. The first of these counts, and of
# collections the nearest. A solid without one has the scene's ambient temperature. Where an
# insulation covers it, the surface is between that temperature and the ambient one.

ANIMATED = tuple(f"angen_warmth.{name}" for name in ("temperature", "emissivity", "insulation"))
DEFAULT_EMISSIVITY = 0.95


class OwnWarmth(NamedTuple):
    """The temperature settings of an object, a collection or a material.

    Attributes
    ----------
    temperature
        The temperature in K, beneath the insulation.
    emissivity
        The emissivity of the surface.
    share
        The share by which the surface follows the ambient temperature because it is insulated.
    """

    temperature: float
    emissivity: float
    share: float

    def surface(self, ambient: float) -> float:
        """Return the temperature of the surface in K; `ambient` is that of the room in K."""
        return self.temperature + self.share * (ambient - self.temperature)


# The settings of a solid without a temperature.
AMBIENT = OwnWarmth(np.nan, DEFAULT_EMISSIVITY, 0.0)


@dataclass
class _Patches:
    """A solid whose faces have several temperatures.

    Attributes
    ----------
    solid
        The solid: a visible object or instance.
    values
        The values (slots, 3) of `OwnWarmth` for each material slot.
    slots
        The material slot of each face; None until it is read.
    corners
        The face corners of the mesh for which `slots` is valid.
    """

    solid: Solid
    values: Array
    slots: NDArray[np.int32] | None = None
    corners: Any = None


class Warmth(MetSurfaces):
    """Reads the temperature and emissivity of the surfaces that rays hit, as `Emission`."""

    need = WARMTH

    @staticmethod
    def changes_by_itself(scene: Any) -> bool:
        """Return whether any temperature is animated, also the scene's ambient temperature."""
        owners = *bpy.data.objects, *bpy.data.materials
        return scene.animation_data is not None or any(map(_is_animated, owners))

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        # The values (solids, 3) of `OwnWarmth` by the solid's number.
        self._values = np.empty((0, 3))
        self._patches: dict[int, _Patches] = {}
        self._changing: list[Solid] = []

    @property
    def _solids(self) -> Solids:
        return self._rays.solids

    def _values_at(self, depsgraph: Any, seen: RayHits) -> Emission:
        ambient = kelvin(depsgraph.scene_eval.angen_ambient_temperature)
        values = self._values[seen.met]
        for number in np.unique(seen.met).tolist() if self._patches else ():
            patches = self._patches.get(number)
            if patches is not None:
                which = np.flatnonzero(seen.met == number)
                slot = self._slots(depsgraph, patches, seen.faces[which])
                values[which] = patches.values[slot]
        temperature, emissivity, share = values.T
        surface = temperature + share * (ambient - temperature)
        return Emission(np.where(np.isnan(surface), ambient, surface), emissivity, ambient)

    def _slots(self, depsgraph: Any, patches: _Patches, faces: Index) -> Index:
        geometry = patches.solid.geometry
        # A modifier may change the faces.
        corners = geometry.state.corners
        if patches.slots is None or not np.array_equal(patches.corners, corners):
            patches.slots, patches.corners = geometry.material_slots(depsgraph), corners
        found: Index = np.clip(
            patches.slots[np.clip(faces, 0, len(patches.slots) - 1)],
            0,
            len(patches.values) - 1,
        )
        return found

    def _update(self, depsgraph: Any) -> None:
        """Read all temperatures if the scene was edited, and otherwise only the animated ones."""
        solids = self._solids
        if self._listing == solids.listing:
            if self._changing:
                by_uid, parents = _by_uid(), collection_parents()
                for solid in self._changing:
                    self._read(depsgraph, solid, by_uid, parents)
            return
        self._listing = solids.listing
        size = max((solid.number for solid in solids.solids), default=NOTHING) + 1
        self._values = np.tile(AMBIENT, (size, 1))
        self._patches.clear()
        by_uid, parents = _by_uid(), collection_parents()
        self._changing = [s for s in solids.solids if self._read(depsgraph, s, by_uid, parents)]

    def _read(
        self, depsgraph: Any, solid: Solid, by_uid: dict[int, Any], parents: dict[Any, list[Any]]
    ) -> bool:
        """Store the temperature of a solid; return whether it is animated.

        `by_uid` has the objects and materials of the file by session uid, and `parents` the direct
        parents of each collection.
        """
        original = by_uid[solid.key[0]]
        whole = own_warmth(original.evaluated_get(depsgraph))
        if whole is None:
            inherited = inherited_warmth(original, parents)
            whole = AMBIENT if inherited is None else inherited
        self._values[solid.number] = whole
        animated = _is_animated(original)
        materials = [by_uid.get(uid) for uid in solid.geometry.materials(depsgraph)]
        each = [own_warmth(m.evaluated_get(depsgraph)) if m else None for m in materials]
        animated |= any(_is_animated(m) for m in materials if m)
        if any(warmth is not None for warmth in each):
            values = np.array([whole if warmth is None else warmth for warmth in each])
            self._patches.setdefault(solid.number, _Patches(solid, values)).values = values
        else:
            self._patches.pop(solid.number, None)
        return animated


def kelvin(celsius: float) -> float:
    """Return a temperature in K, without the rounding errors of single precision."""
    return float(f"{celsius:.7g}") + ZERO_CELSIUS


def own_warmth(owner: Any) -> OwnWarmth | None:
    """Return the temperature settings of an object, collection or material itself.

    Return None if no temperature is set.
    """
    settings = owner.angen_warmth
    if not settings.use_temperature:
        return None
    share = insulated_share(float(f"{settings.insulation:.7g}"))
    return OwnWarmth(kelvin(settings.temperature), float(f"{settings.emissivity:.7g}"), share)


def inherited_warmth(obj: Any, parents: dict[Any, list[Any]]) -> OwnWarmth | None:
    """Return the temperature settings of the nearest collection that has a temperature.

    Return None if no collection has one. Of equally near collections, the first by name counts.
    `parents` is as `collection_parents` returns it.
    """
    level = sorted(obj.users_collection, key=lambda c: c.name_full)
    seen = set(level)
    while level:
        found = next((w for w in map(own_warmth, level) if w is not None), None)
        if found is not None:
            return found
        above = {p for collection in level for p in parents.get(collection, ())} - seen
        seen |= above
        level = sorted(above, key=lambda c: c.name_full)
    return None


def collection_parents() -> dict[Any, list[Any]]:
    """Return, for each collection, the collections that directly contain it."""
    found: dict[Any, list[Any]] = {}
    tops = [scene.collection for scene in bpy.data.scenes]
    for collection in [*tops, *bpy.data.collections]:
        for child in collection.children:
            found.setdefault(child, []).append(collection)
    return found


def _by_uid() -> dict[int, Any]:
    return {owner.session_uid: owner for owner in (*bpy.data.objects, *bpy.data.materials)}


def _is_animated(owner: Any) -> bool:
    return any(is_animated(owner, path) for path in ANIMATED)


PROBE = Warmth
