# SPDX-License-Identifier: GPL-3.0-or-later
"""Read properties of the surfaces that sensors' rays hit: temperature and reflectance."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.kind import REFLECTANCE, WARMTH
from ...sensor_logic.model import Answers, Array, Emission, Index
from ...sensor_logic.physics import luminance
from ...sensor_logic.wording import ZERO_CELSIUS
from .animation import all_animated, is_animated
from .instances import Uid
from .light.materials import Surfaces
from .rays.caster import NOTHING, RayCaster, RayHits, Rays
from .rays.solids import Solid, Solids


class MetSurfaces(ABC):
    """Reads one property of the surfaces that the rays of a ray caster hit."""

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
        """Cast a sensor's rays at some frames, and return the property of the surfaces hit.

        Call it after the caster was updated. Lengths are in Blender units.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        sensor, bundle, rays
            As for `RayCaster.cast_at`.
        frames
            Indices (k,) of the frames of the caster; None for the last one.

        Returns
        -------
        Answers
            The property at each frame, in the form that `_values_at` returns.
        """
        self._update(depsgraph)
        if frames is None:
            frames = np.array([len(self._rays.frames) - 1])
        found = self._rays.see_at(sensor, bundle, rays, frames)
        return Answers([self._values_at(depsgraph, seen) for seen in found.table], found.rows)

    def ranges(self, sensor: Uid, bundle: int) -> Array:
        """Return the ranges (n,) of the rays of the latest call of `see`."""
        return self._rays.last_ranges(sensor, bundle)

    @abstractmethod
    def _update(self, depsgraph: Any) -> None:
        """Read the changes since the last call."""

    @abstractmethod
    def _values_at(self, depsgraph: Any, seen: RayHits) -> Any:
        """Return the property of the surfaces that the rays of `seen` hit."""


# Temperatures.
#
# A temperature is set on a material, an object or a collection. The first of these counts, and of
# collections the nearest. A solid without one has the scene's ambient temperature.

TEMPERATURE, EMISSIVITY = "angen_warmth.temperature", "angen_warmth.emissivity"
DEFAULT_EMISSIVITY = 0.95
# Temperature (K) and emissivity of a solid without a temperature.
AMBIENT = (np.nan, DEFAULT_EMISSIVITY)


@dataclass
class _Patches:
    """A solid whose faces have several temperatures.

    Attributes
    ----------
    solid
        The solid.
    temperature, emissivity
        The values of each material slot; temperatures in K.
    slots
        The slot of each face; None until it is read.
    corners
        The faces of the mesh for which `slots` is valid, by their corners.
    """

    solid: Solid
    temperature: Array
    emissivity: Array
    slots: NDArray[np.int32] | None = None
    corners: Any = None


class Warmth(MetSurfaces):
    """Reads the temperatures of hit solids, as `Emission`."""

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        self._temperature = np.empty(0)
        self._emissivity = np.empty(0)
        self._patches: dict[int, _Patches] = {}
        self._changing: list[Solid] = []

    @property
    def _solids(self) -> Solids:
        return self._rays.solids

    def _values_at(self, depsgraph: Any, seen: RayHits) -> Emission:
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
        # A modifier may change the faces.
        corners = geometry.state.corners
        if patches.slots is None or not np.array_equal(patches.corners, corners):
            patches.slots, patches.corners = geometry.material_slots(depsgraph), corners
        found: Index = np.clip(
            patches.slots[np.clip(faces, 0, len(patches.slots) - 1)],
            0,
            len(patches.temperature) - 1,
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
        self._temperature = np.full(size, AMBIENT[0])
        self._emissivity = np.full(size, AMBIENT[1])
        self._patches.clear()
        by_uid, parents = _by_uid(), collection_parents()
        self._changing = [s for s in solids.solids if self._read(depsgraph, s, by_uid, parents)]

    def _read(
        self, depsgraph: Any, solid: Solid, by_uid: dict[int, Any], parents: dict[Any, list[Any]]
    ) -> bool:
        """Store the temperature of a solid; return whether it is animated.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        solid
            The solid.
        by_uid
            The objects and materials of the file, by session uid.
        parents
            The direct parents of each collection.
        """
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
    """Return a temperature in K, and undo the rounding of single precision."""
    return float(f"{celsius:.7g}") + ZERO_CELSIUS


def own_warmth(owner: Any) -> tuple[float, float] | None:
    """Return the temperature (K) and emissivity set on an object, collection or material itself.

    Return None if it has no temperature.
    """
    settings = owner.angen_warmth
    if not settings.use_temperature:
        return None
    return kelvin(settings.temperature), float(f"{settings.emissivity:.7g}")


def inherited_warmth(obj: Any, parents: dict[Any, list[Any]]) -> tuple[float, float] | None:
    """Return the temperature (K) and emissivity of the nearest collection that has a temperature.

    Return None if none has. Of equally near collections, the first by name counts.
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
    """Return the collections that directly contain each collection."""
    found: dict[Any, list[Any]] = {}
    tops = [scene.collection for scene in bpy.data.scenes]
    for collection in [*tops, *bpy.data.collections]:
        for child in collection.children:
            found.setdefault(child, []).append(collection)
    return found


def _by_uid() -> dict[int, Any]:
    """Return the objects and materials of the file by session uid."""
    return {owner.session_uid: owner for owner in (*bpy.data.objects, *bpy.data.materials)}


def _is_animated(owner: Any) -> bool:
    return is_animated(owner, TEMPERATURE) or is_animated(owner, EMISSIVITY)


def changes_by_itself(scene: Any) -> bool:
    """Return whether any temperature is animated, the scene's ambient temperature included."""
    owners = *bpy.data.objects, *bpy.data.materials
    return scene.animation_data is not None or any(map(_is_animated, owners))


# Reflectance: the luminance of the colours of materials.

NO_MATERIAL = 0
COLOURED = (bpy.types.Material, bpy.types.ShaderNodeTree)


class Reflectance(MetSurfaces):
    """Reads the reflectance (n,) of hit solids, from 0 to 1; 0 for a ray that hits nothing."""

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        self._surfaces = Surfaces()
        # Whether materials are animated.
        self._changing = False
        self._solids: dict[int, Solid] = {}

    def _update(self, depsgraph: Any) -> None:
        solids = self._rays.solids
        if self._listing != solids.listing:
            self._listing, self._surfaces = solids.listing, Surfaces()
            self._changing = colours_change()
            self._solids = {solid.number: solid for solid in solids.solids}
        if self._changing:
            self._surfaces = Surfaces()

    def _values_at(self, depsgraph: Any, seen: RayHits) -> Array:
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
    """Return whether any material or its nodes are animated, so that its colour may change."""
    return any(isinstance(owner, COLOURED) for owner in all_animated())


# The properties of surfaces that models can query with rays.
SURFACES: dict[str, type[MetSurfaces]] = {WARMTH: Warmth, REFLECTANCE: Reflectance}
