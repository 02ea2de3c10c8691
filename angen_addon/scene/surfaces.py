# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads properties of the surfaces that sensors' rays meet, such as their temperature."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Answers, Array, Emission, Index
from ...sensor_logic.physics import luminance
from ...sensor_logic.wording import ZERO_CELSIUS
from .animation import all_animated, is_animated
from .instances import Uid
from .light.materials import Surfaces
from .rays.caster import NOTHING, RayCaster, RayHits, Rays
from .rays.solids import Solid, Solids


class MetSurfaces(ABC):
    """One property of the solids of a ray caster."""

    def __init__(self, caster: RayCaster) -> None:
        self._rays = caster
        self._listing = -1

    def see(
        self,
        depsgraph: Any,
        sensor: Uid,
        bundle: int,
        rays: Rays,
        frames: Index | None = None,
    ) -> Answers:
        """Casts a sensor's rays at each of the kept frames `frames` (k,), or at the last one, and
        returns what they find there. In Blender units, after the caster was brought up to date; the
        other arguments as of `RayCaster.cast`."""
        self._follow(depsgraph)
        if frames is None:
            frames = np.array([len(self._rays.frames) - 1])
        found = self._rays.see_at(sensor, bundle, rays, frames)
        return Answers([self._found(depsgraph, seen) for seen in found.table], found.rows)

    def ranges(self, sensor: Uid, bundle: int) -> Array:
        """How far (n,) the rays get that `see` was asked about last."""
        return self._rays.last_ranges(sensor, bundle)

    @abstractmethod
    def _follow(self, depsgraph: Any) -> None:
        """Reads what changed since the last look."""

    @abstractmethod
    def _found(self, depsgraph: Any, seen: RayHits) -> Any:
        """The property where rays end."""


# How warm the things are that rays meet.
#
# A temperature is set on a material, an object or a collection: the first of these counts, and of
# collections the nearest. What has none is as warm as the scene's ambient temperature.

TEMPERATURE, EMISSIVITY = "angen_warmth.temperature", "angen_warmth.emissivity"
DEFAULT_EMISSIVITY = 0.95
# Kelvin and emissivity of what has no temperature of its own.
AMBIENT = (np.nan, DEFAULT_EMISSIVITY)


@dataclass
class _Patches:
    """A solid whose faces are not all equally warm: kelvin and emissivity of each material slot,
    and the slot of each face, as long as faces have these `corners` (k,)."""

    solid: Solid
    temperature: Array
    emissivity: Array
    slots: NDArray[np.int32] | None = None
    corners: Any = None


class Warmth(MetSurfaces):
    """The temperatures of the solids of a ray caster, as `Emission`."""

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        self._temperature = np.empty(0)
        self._emissivity = np.empty(0)
        self._patches: dict[int, _Patches] = {}
        self._changing: list[Solid] = []

    @property
    def _solids(self) -> Solids:
        return self._rays.solids

    def _found(self, depsgraph: Any, seen: RayHits) -> Emission:
        ambient = kelvin(depsgraph.scene_eval.angen_ambient_temperature)
        temperature, emissivity = self._temperature[seen.met], self._emissivity[seen.met]
        for number in np.unique(seen.met).tolist() if self._patches else ():
            patches = self._patches.get(number)
            if patches is not None:
                which = np.flatnonzero(seen.met == number)
                slot = self._slots(depsgraph, patches, seen.faces[which])
                temperature[which] = patches.temperature[slot]
                emissivity[which] = patches.emissivity[slot]
        return Emission(np.where(np.isnan(temperature), ambient, temperature), emissivity, ambient)

    def _slots(self, depsgraph: Any, patches: _Patches, faces: Index) -> Index:
        geometry = patches.solid.geometry
        # Faces may come and go with the surface, as under a modifier.
        corners = geometry.state.corners
        if patches.slots is None or not np.array_equal(patches.corners, corners):
            patches.slots, patches.corners = geometry.material_slots(depsgraph), corners
        found: Index = np.clip(
            patches.slots[np.clip(faces, 0, len(patches.slots) - 1)],
            0,
            len(patches.temperature) - 1,
        )
        return found

    def _follow(self, depsgraph: Any) -> None:
        """Reads all again where the scene was edited, else what is animated."""
        solids = self._solids
        if self._listing == solids.listing:
            if self._changing:
                by_uid, parents = _by_uid(), collection_parents()
                for solid in self._changing:
                    self._read(depsgraph, solid, by_uid, parents)
            return
        self._listing = solids.listing
        size = max((solid.number for solid in solids.solids), default=NOTHING) + 1
        self._temperature = np.full(size, AMBIENT[0])
        self._emissivity = np.full(size, AMBIENT[1])
        self._patches.clear()
        by_uid, parents = _by_uid(), collection_parents()
        self._changing = [s for s in solids.solids if self._read(depsgraph, s, by_uid, parents)]

    def _read(
        self, depsgraph: Any, solid: Solid, by_uid: dict[int, Any], parents: dict[Any, list[Any]]
    ) -> bool:
        """Takes down how warm a solid is; whether that is animated."""
        original = by_uid[solid.key[0]]
        whole = own_warmth(original.evaluated_get(depsgraph))
        if whole is None:
            inherited = inherited_warmth(original, parents)
            whole = AMBIENT if inherited is None else inherited
        self._temperature[solid.number], self._emissivity[solid.number] = whole
        animated = _is_animated(original)
        materials = [by_uid.get(uid) for uid in solid.geometry.materials(depsgraph)]
        each = [own_warmth(m.evaluated_get(depsgraph)) if m else None for m in materials]
        animated |= any(_is_animated(m) for m in materials if m)
        if any(warmth is not None for warmth in each):
            values = np.array([whole if warmth is None else warmth for warmth in each])
            known = self._patches.setdefault(
                solid.number, _Patches(solid, values[:, 0], values[:, 1])
            )
            known.temperature, known.emissivity = values[:, 0], values[:, 1]
        else:
            self._patches.pop(solid.number, None)
        return animated


def kelvin(celsius: float) -> float:
    """Single precision, as Blender stores it, is undone."""
    return float(f"{celsius:.7g}") + ZERO_CELSIUS


def own_warmth(owner: Any) -> tuple[float, float] | None:
    """Kelvin and emissivity that are set on an object, collection or material itself."""
    settings = owner.angen_warmth
    if not settings.use_temperature:
        return None
    return kelvin(settings.temperature), float(f"{settings.emissivity:.7g}")


def inherited_warmth(obj: Any, parents: dict[Any, list[Any]]) -> tuple[float, float] | None:
    """Of the nearest collection with a temperature that an object is in, by the collections' names
    where several are equally near."""
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
    """The collections that each collection is directly in."""
    found: dict[Any, list[Any]] = {}
    tops = [scene.collection for scene in bpy.data.scenes]
    for collection in [*tops, *bpy.data.collections]:
        for child in collection.children:
            found.setdefault(child, []).append(collection)
    return found


def _by_uid() -> dict[int, Any]:
    """The objects and materials of the file by their session uids."""
    return {owner.session_uid: owner for owner in (*bpy.data.objects, *bpy.data.materials)}


def _is_animated(owner: Any) -> bool:
    return is_animated(owner, TEMPERATURE) or is_animated(owner, EMISSIVITY)


def changes_by_itself(scene: Any) -> bool:
    """Whether the temperature of anything is animated, or the scene is, which has the ambient."""
    owners = *bpy.data.objects, *bpy.data.materials
    return scene.animation_data is not None or any(map(_is_animated, owners))


# How much of the light that falls on them the things throw back that rays meet: the luminance of
# the colours of their materials.

NO_MATERIAL = 0
COLOURED = (bpy.types.Material, bpy.types.ShaderNodeTree)


class Reflectance(MetSurfaces):
    """The reflectance of the solids of a ray caster, (n,) from 0 to 1; 0 where a ray meets
    nothing."""

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        self._surfaces = Surfaces()
        # Whether materials are animated.
        self._changing = False
        self._solids: dict[int, Solid] = {}

    def _follow(self, depsgraph: Any) -> None:
        solids = self._rays.solids
        if self._listing != solids.listing:
            self._listing, self._surfaces = solids.listing, Surfaces()
            self._changing = colours_change()
            self._solids = {solid.number: solid for solid in solids.solids}
        if self._changing:
            self._surfaces = Surfaces()

    def _found(self, depsgraph: Any, seen: RayHits) -> Array:
        found = np.zeros(len(seen.met))
        for number in np.unique(seen.met[seen.met != NOTHING]).tolist():
            which, geometry = np.flatnonzero(seen.met == number), self._solids[number].geometry
            materials = geometry.materials(depsgraph) or [NO_MATERIAL]
            each = np.array(
                [luminance(self._surfaces.reflectance(uid)) for uid in materials], np.float64
            )
            slot: Index = np.zeros(len(which), np.intp)
            if np.ptp(each) > 0.0:
                slots = geometry.material_slots(depsgraph)
                slot = slots[np.clip(seen.faces[which], 0, len(slots) - 1)].astype(np.intp)
            found[which] = each[np.clip(slot, 0, len(each) - 1)]
        return found


def colours_change() -> bool:
    """Whether the colours of anything may be animated."""
    return any(isinstance(owner, COLOURED) for owner in all_animated())
