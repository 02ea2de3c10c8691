# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the temperature and the emissivity of the surfaces that rays hit."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.heat import HEATS, Heat, warm_share, warm_steps
from ....sensor_logic.kind import WARMTH
from ....sensor_logic.logs.wording import ZERO_CELSIUS
from ....sensor_logic.model import Answers, Array, Emission, Index
from ....sensor_logic.physics import insulated_share
from ....sensor_logic.warmth_left import Imprint, Place, Print, Spots, WarmthLeft, ages, start_of
from ..animation import is_animated, played_curves, time_stretch
from ..instances import Uid
from ..rays.caster import NOTHING, RayCaster, RayHits, Rays
from ..rays.solids import Solid, Solids, inverted
from ..sensors import unit_scale
from .contacts import Bodies, in_frame
from .probe import HitSurfaces

# Temperatures.
#
# A temperature is set on a material, an object or a collection. The first of these counts, and of
# collections the nearest. A solid without one has the scene's ambient temperature. Where an
# insulation covers it, the surface is between that temperature and the ambient one.

ANIMATED = tuple(f"angen_warmth.{name}" for name in ("temperature", "emissivity", "insulation"))
DEFAULT_EMISSIVITY = 0.95
# Data path of whether an object is in use.
IN_USE = "angen_use.in_use"


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


class Warmth(HitSurfaces):
    """Reads the temperature and emissivity of the surfaces that rays hit, as `Emission`."""

    need = WARMTH

    @staticmethod
    def changes_by_itself(scene: Any) -> bool:
        """Return whether a temperature is animated, also the ambient one, or changes with use."""
        owners = *bpy.data.objects, *bpy.data.materials
        return (
            scene.animation_data is not None
            or any(map(_is_animated, owners))
            or any(heat_of(obj) is not None for obj in bpy.data.objects)
        )

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        # The values (solids, 3) of `OwnWarmth` by the solid's number.
        self._values = np.empty((0, 3))
        self._patches: dict[int, _Patches] = {}
        self._changing: list[Solid] = []
        self._bodies = Bodies(caster, {})
        # Contacts at the frames of the present batch, by the state of the scene.
        self._row_of: dict[int, int] = {}
        self._contacts: dict[Hashable, dict[Place, Imprint]] = {}
        self._batch: Any = None

    @property
    def _solids(self) -> Solids:
        return self._rays.solids

    def _see(self, sensor: Uid, bundle: int, rays: Rays, frames: Index, *details: Any) -> Answers:
        """Return the `Emission` at each frame.

        `details` is empty, or has the times (k,) of the frames in s and the sensor's `WarmthLeft`.
        """
        sees_prints = details and self._depsgraph.scene_eval.angen_warmth_left and self._bodies
        if not sees_prints:
            return super()._see(sensor, bundle, rays, frames)
        found = self._rays.see_at(sensor, bundle, rays, frames)
        return _SeenPrints(self, rays, found, *details).answers(frames)

    def scene_at(self, frame: int) -> Hashable:
        """Return a value that differs between frames of the caster at which solids differ."""
        return self._listing, self._rays.frames.version[frame].tobytes()

    def contacts(self, frame: int) -> dict[Place, Imprint]:
        """Return where warm bodies touch other solids, at a frame of the caster."""
        at, state = self._rays.frames, self.scene_at(frame)
        if self._batch is not at:
            self._batch, self._contacts = at, {}
        if state not in self._contacts:
            ambient = kelvin(self._depsgraph.scene_eval.angen_ambient_temperature)
            temperature, _, share = self._values.T
            surface = temperature + share * (ambient - temperature)
            cold = np.where(np.isnan(surface), ambient, surface)
            at.show(self._solids, frame)
            try:
                metres = unit_scale(self._depsgraph.scene)
                self._contacts[state] = self._bodies.contacts(metres, cold)
            finally:
                at.show(self._solids, -1)
        return self._contacts[state]

    def points_in(self, place: Place, frame: int, points: Array, metres: float) -> Array:
        """Return points (k, 3) of the world in the frame of a print, in m."""
        number, axis = place
        row, at = self._row_of[number], self._rays.frames
        column = at.column.get(row)
        matrix = self._solids.matrix[row] if column is None else at.matrix[frame, column]
        return in_frame(matrix, inverted(matrix), axis, points, metres)

    def _values_at(self, seen: RayHits) -> Emission:
        ambient = kelvin(self._depsgraph.scene_eval.angen_ambient_temperature)
        values = self._values[seen.solids]
        for number in np.unique(seen.solids).tolist() if self._patches else ():
            patches = self._patches.get(number)
            if patches is not None:
                which = np.flatnonzero(seen.solids == number)
                slot = self._slots(patches, seen.faces[which])
                values[which] = patches.values[slot]
        temperature, emissivity, share = values.T
        surface = temperature + share * (ambient - temperature)
        return Emission(np.where(np.isnan(surface), ambient, surface), emissivity, ambient)

    def _slots(self, patches: _Patches, faces: Index) -> Index:
        geometry = patches.solid.geometry
        # A modifier may change the faces.
        corners = geometry.state.corners
        if patches.slots is None or not np.array_equal(patches.corners, corners):
            patches.slots, patches.corners = geometry.material_slots(self._depsgraph), corners
        found: Index = np.clip(
            patches.slots[np.clip(faces, 0, len(patches.slots) - 1)],
            0,
            len(patches.values) - 1,
        )
        return found

    def _update(self) -> None:
        """Read all temperatures if the scene was edited, and otherwise only the animated ones."""
        solids = self._solids
        if self._listing == solids.listing:
            if self._changing:
                by_uid, parents = _by_uid(), collection_parents()
                for solid in self._changing:
                    self._read(solid, by_uid, parents)
                self._bodies = Bodies(self._rays, self._warmest())
            return
        self._listing = solids.listing
        size = max((solid.number for solid in solids.solids), default=NOTHING) + 1
        self._values = np.tile(AMBIENT, (size, 1))
        self._patches.clear()
        by_uid, parents = _by_uid(), collection_parents()
        self._changing = [s for s in solids.solids if self._read(s, by_uid, parents)]
        self._row_of = {solid.number: solid.row for solid in solids.solids}
        self._bodies = Bodies(self._rays, self._warmest())

    def _warmest(self) -> dict[int, float]:
        """Return the highest temperature in K, beneath insulation, of each solid that has one."""
        found = {}
        for solid in self._solids.solids:
            values = self._values[solid.number, :1]
            patches = self._patches.get(solid.number)
            every = values if patches is None else patches.values[:, 0]
            every = every[~np.isnan(every)]
            if len(every):
                found[solid.number] = float(every.max())
        return found

    def _read(self, solid: Solid, by_uid: dict[int, Any], parents: dict[Any, list[Any]]) -> bool:
        """Store the temperature of a solid; return whether it changes by itself.

        `by_uid` has the objects and materials of the file by session uid, and `parents` the direct
        parents of each collection.
        """
        depsgraph, original = self._depsgraph, by_uid[solid.key[0]]
        whole = own_warmth(original.evaluated_get(depsgraph))
        if whole is None:
            inherited = inherited_warmth(original, parents)
            whole = AMBIENT if inherited is None else inherited
        animated, heat = _is_animated(original), heat_of(original)
        if heat is not None:
            animated, scene = True, depsgraph.scene_eval
            ambient = kelvin(scene.angen_ambient_temperature)
            whole = whole._replace(
                temperature=ambient + heat.excess * share_in_use(original, heat, depsgraph.scene),
                share=0.0,
            )
        self._values[solid.number] = whole
        materials = [by_uid.get(uid) for uid in solid.geometry.materials(depsgraph)]
        each = [own_warmth(m.evaluated_get(depsgraph)) if m else None for m in materials]
        animated |= any(_is_animated(m) for m in materials if m)
        if any(warmth is not None for warmth in each):
            values = np.array([whole if warmth is None else warmth for warmth in each])
            self._patches.setdefault(solid.number, _Patches(solid, values)).values = values
        else:
            self._patches.pop(solid.number, None)
        return animated


class _SeenPrints:
    """The answers to one query of a sensor that sees the warmth left in seats and beds.

    Parameters
    ----------
    probe, rays
        The probe, and the rays in Blender units.
    found
        The hits of the rays at each update.
    times, left
        The times (n,) of the updates in s, and the state of the sensor.
    """

    def __init__(
        self,
        probe: Warmth,
        rays: Rays,
        found: Answers,
        times: Array,
        left: WarmthLeft,
    ) -> None:
        self._probe, self._rays = probe, rays
        self._found, self._times, self._left = found, times, left
        self._table: list[Emission] = []
        self._rows = np.zeros(len(times), np.intp)
        # What the last answer depends on.
        self._last: Any = None
        self._plain: dict[int, Emission] = {}
        # The prints that rays hit, and the row of hits and the prints for which they are valid.
        self._spots: list[tuple[Print, Spots]] = []
        self._spots_of: Any = None

    def answers(self, frames: Index) -> Answers:
        """Return the `Emission` at each update; `frames` (n,) are their frames of the caster."""
        looks = self._left.looks(self._times)
        for part in np.split(np.arange(len(frames)), np.flatnonzero(np.diff(frames)) + 1):
            frame, due = int(frames[part[0]]), part[looks[part]]
            # Nothing moves within the part, so one look is enough.
            if len(due) and self._left.scene != self._probe.scene_at(frame):
                self._answer(frame, part[part < due[0]])
                self._left.scene = self._probe.scene_at(frame)
                contacts = self._probe.contacts(frame)
                self._left.touch(float(self._times[due[0]]), contacts)
                part = part[part >= due[0]]
            self._answer(frame, part)
        return Answers(self._table, self._rows)

    def _answer(self, frame: int, part: Index) -> None:
        """Answer the updates `part` (k,), between which neither solids nor contacts change."""
        if not len(part):
            return
        row, times = int(self._found.rows[part[0]]), self._times[part]
        self._find_spots(frame, row)
        passed = [ages(times, one.since) for one, _ in self._spots]
        changes = np.array(passed, np.int64).reshape(len(passed), len(part))
        cuts = np.flatnonzero(np.diff(changes, axis=1).any(axis=0)) + 1
        for same in np.split(np.arange(len(part)), cuts):
            state = [
                (one, one.revision, int(age[same[0]]))
                for (one, _), age in zip(self._spots, passed, strict=True)
            ]
            if self._last != (row, state):
                self._last = row, state
                self._table.append(self._emission(row, [age for *_, age in state]))
            self._rows[part[same]] = len(self._table) - 1

    def _find_spots(self, frame: int, row: int) -> None:
        """Find where the hits in a row of the table lie on prints."""
        prints = self._left.prints
        valid_for = row, [(one, one.revision) for one in prints.values()]
        if self._spots_of == valid_for:
            return
        self._spots_of, self._spots = valid_for, []
        hits: RayHits = self._found.table[row]
        metres = unit_scale(self._probe._depsgraph.scene)
        for place, one in prints.items():
            which = np.flatnonzero(hits.solids == place[0])
            if len(which):
                origins, ways, _ = (values[which] for values in self._rays)
                points = origins + ways * hits.ranges[which, None]
                local = self._probe.points_in(place, frame, points, metres)
                spots = one.spots(which, local)
                if len(spots.ray):
                    self._spots.append((one, spots))

    def _emission(self, row: int, passed: list[int]) -> Emission:
        """Return the emission of a row of hits, with the prints at the start of their intervals."""
        if row not in self._plain:
            self._plain[row] = self._probe._values_at(self._found.table[row])
        plain = self._plain[row]
        if not self._spots:
            return plain
        left = np.zeros(len(plain.temperature))
        for (one, spots), age in zip(self._spots, passed, strict=True):
            excess = one.excess(start_of(age, one.since))
            left[spots.ray] += (excess[spots.cell] * spots.weight).sum(axis=1)
        return Emission(plain.temperature + left, plain.emissivity, plain.ambient, left)


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


def heat_of(obj: Any) -> Heat | None:
    """Return how warm an object becomes in use; None for one that does not."""
    return HEATS.get(obj.angen_heat.sort)


def share_in_use(obj: Any, heat: Heat, scene: Any) -> float:
    """Return the share of its excess that an object has at the scene's frame, 0 to 1.

    Keys of *In Use* up to this frame count. Without keys, an object in use is as warm as can be.
    """
    uses = _uses_of(obj, scene)
    if uses is None:
        return float(obj.angen_use.in_use)
    return warm_share(heat, uses, scene.frame_float * time_stretch(scene) / _key_rate(scene))


def heat_changes(obj: Any, scene: Any) -> Array:
    """Return when the temperature of an object has changed by its use (n,), in frames of keys."""
    heat = heat_of(obj) if isinstance(obj, bpy.types.Object) else None
    uses = None if heat is None else _uses_of(obj, scene)
    if heat is None or uses is None:
        return np.empty(0)
    return np.array(warm_steps(heat, uses)) * _key_rate(scene)


def _key_rate(scene: Any) -> float:
    """Return the number of frames of keys in a second."""
    return time_stretch(scene) * float(scene.render.fps) / float(scene.render.fps_base)


def _uses_of(obj: Any, scene: Any) -> list[tuple[float, float]] | None:
    """Return (start, end) in s of each use of an object; None if its use has no keyframes.

    The uses come from the keyframes of *In Use*. A use at the first keyframe starts at −inf, since
    the object was in use before, too. A use at the last keyframe ends at inf.
    """
    curve = next((c for c in played_curves(obj) if c.data_path == IN_USE), None)
    if curve is None or not len(curve.keyframe_points):
        return None
    a_second = _key_rate(scene)
    uses: list[tuple[float, float]] = []
    since: float | None = None
    for number, key in enumerate(curve.keyframe_points):
        at, is_used = key.co[0] / a_second if number else -math.inf, key.co[1] > 0.5
        if is_used and since is None:
            since = at
        elif not is_used and since is not None:
            uses.append((since, at))
            since = None
    return uses if since is None else [*uses, (since, math.inf)]


def _is_animated(owner: Any) -> bool:
    return any(is_animated(owner, path) for path in ANIMATED)


PROBE = Warmth
