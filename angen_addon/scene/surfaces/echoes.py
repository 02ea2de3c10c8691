# SPDX-License-Identifier: GPL-3.0-or-later
"""Read what the rays of radars hit: through thin walls, with the motion of the surfaces.

A solid lets waves pass if they lose less than `STOPS` dB at one crossing. The first cast goes
through all of these solids, to the surface that stops the waves. Further casts, of the solids that
let waves pass alone, find what each ray crosses before that.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.arrays import are_equal
from ....sensor_logic.model import Answers, Array, Index
from ....sensor_logic.radio.echoes import ECHOES, Echoes
from ....sensor_logic.radio.properties import AUTO, THICKNESS, THIN, YES, is_textile
from ....sensor_logic.radio.substances import attenuation, reflectance
from ..animation import may_set
from ..bearers import armatures, bearer, candidates
from ..instances import Uid
from ..rays.caster import NOTHING, RayCaster, RayHits, Rays
from ..rays.geometry import Surface
from ..rays.places import SolidPlaces
from ..rays.solids import Solid, Solids, inverted
from ..sensors import unit_scale
from .probe import SurfaceProbe

# dB, one way. More than this, and nothing comes back.
STOPS = 30.0
# The most surfaces that a ray is followed through, two for each wall.
MOST_SURFACES = 64
# The next cast begins this far behind a surface, in m.
BEHIND = 1e-4
# What everything is made of that has no substance, and living bodies.
DEFAULT, BODY, TEXTILE = "CONCRETE", "BODY", "TEXTILE"
# The times in s and the places of solids at successive steps.
Past = Sequence[tuple[float, SolidPlaces]]
PARTS = RADAR, BREATHING = "angen_radar", "angen_breathing"


class _CasterOfSome(RayCaster):
    """Casts the rays of radars through all solids but those in the mask `left_out` (n,)."""

    def __init__(self, solids: Solids, left_out: NDArray[np.bool_]) -> None:
        super().__init__(solids)
        self._left_out = left_out

    def _passes(self, sensor: Uid) -> NDArray[np.bool_]:
        return super()._passes(sensor) | self._left_out

    def columns(self, sensor: Uid) -> Index:
        """Return the columns (m,) in `frames` of the moving solids that the rays can hit."""
        return self._own_solids(sensor).columns


class _Entries(NamedTuple):
    """The places where rays enter solids that let waves pass.

    `ray` (k,) has the indices of the rays, `distance` (k,) the distances along them in Blender
    units, and `number` (k,) the numbers of the solids.
    """

    ray: Index
    distance: Array
    number: Index


NO_ENTRIES = _Entries(np.zeros(0, np.intp), np.zeros(0), np.zeros(0, np.intp))


@dataclass
class _Substances:
    """The substances of all solids at one carrier frequency.

    Attributes
    ----------
    loss
        The one-way attenuation (numbers,) in dB at a crossing, by the number of the solid.
    reflectance
        The reflected part (numbers,) of the power, by the number of the solid.
    stopping, passing
        Cast rays at the solids that stop the waves, and at all others.
    any_pass
        Whether any solid lets the waves pass.
    entered
        The entries of the rays of each bundle at its latest query, with the state of the scene.
    """

    loss: Array
    reflectance: Array
    stopping: _CasterOfSome
    passing: _CasterOfSome
    any_pass: bool
    entered: dict[tuple[Uid, int], tuple[Rays, Index, _Entries]] = field(default_factory=dict)

    def entries(
        self, sensor: Uid, bundle: int, rays: Rays, frames: Index, behind: float
    ) -> list[_Entries]:
        """Return the entries of the rays at each of the frames; `behind` is `BEHIND` in units."""
        if not self.any_pass:
            return [NO_ENTRIES] * len(frames)
        columns = self.passing.columns(sensor)
        known = self.entered.get((sensor, bundle))
        found = []
        for frame in frames.tolist():
            version = self.passing.frames.version[frame, columns]
            if known is None or not _is_same(known, rays, version):
                entries = self._follow(sensor, bundle, rays, frame, behind)
                known = self.entered[sensor, bundle] = rays, version, entries
            found.append(known[2])
        return found

    def _follow(self, sensor: Uid, bundle: int, rays: Rays, frame: int, behind: float) -> _Entries:
        """Follow the rays from surface to surface of the solids that let waves pass."""
        origins, directions, length = rays
        active, start = np.arange(len(length)), np.zeros(len(length))
        found = [NO_ENTRIES]
        for cast in range(MOST_SURFACES):
            points = origins[active] + directions[active] * start[active, None]
            left = points, directions[active], length[active] - start[active]
            number = bundle * MOST_SURFACES + cast
            seen = self.passing.see_at(sensor, number, left, np.array([frame]))[0]
            is_hit = seen.solids != NOTHING
            active, solid = active[is_hit], seen.solids[is_hit].astype(np.intp)
            distance = start[active] + seen.ranges[is_hit]
            found.append(_Entries(active, distance, solid))
            start[active] = distance + behind
            active = active[start[active] < length[active]]
            if not len(active):
                break
        return _entries(_Entries(*map(np.concatenate, zip(*found, strict=True))))


def _entries(crossed: _Entries) -> _Entries:
    """Return those of the crossed surfaces at which rays enter a solid.

    A ray enters and leaves each solid by turns, whatever other solids lie inside of it.
    """
    order = np.lexsort((crossed.distance, crossed.number, crossed.ray))
    ray, distance, number = (values[order] for values in crossed)
    starts = np.ones(len(ray), bool)
    starts[1:] = (ray[1:] != ray[:-1]) | (number[1:] != number[:-1])
    first = np.flatnonzero(starts)
    nth = np.arange(len(ray)) - np.repeat(first, np.diff(np.append(first, len(ray))))
    enters = nth % 2 == 0
    again = np.argsort(distance[enters], kind="stable")
    return _Entries(*(values[enters][again] for values in (ray, distance, number)))


def _is_same(known: tuple[Rays, Index, _Entries], rays: Rays, version: Index) -> bool:
    return np.array_equal(known[1], version) and are_equal(known[0], rays)


class EchoProbe(SurfaceProbe):
    """Reads `Echoes`."""

    need = ECHOES

    @staticmethod
    def changes_by_itself(scene: Any) -> bool:
        """Return whether the substance or the breathing of anything is animated."""
        owners = *bpy.data.objects, *bpy.data.materials
        return any(may_set(owner, *PARTS) for owner in owners)

    def __init__(self, caster: RayCaster) -> None:
        super().__init__(caster)
        self._animated = False
        self._breathing = self._rate = np.empty(0)
        self._names: dict[int, str] = {}
        self._made_of: dict[int, list[tuple[str, float]]] = {}
        self._by_frequency: dict[float, _Substances] = {}

    def _see(self, sensor: Uid, bundle: int, rays: Rays, frames: Index, *details: Any) -> Answers:
        """Return the `Echoes` at each frame.

        `details` has the carrier frequency in GHz, the integration time in s and, for each frame,
        the times and the places of solids at the steps in it. The last of them is the frame itself.
        Without these places, all speeds are 0.
        """
        at, metres = self._substances(float(details[0])), unit_scale(self._depsgraph.scene)
        self._casting = at.stopping
        for caster in (at.stopping, at.passing):
            caster.show(self._rays.frames)
        entries = at.entries(sensor, bundle, rays, frames, BEHIND / metres)
        found = at.stopping.see_at(sensor, bundle, rays, frames)
        pasts: Sequence[Past] = details[2] if len(details) > 2 else [()] * len(frames)
        speeds = [_speeds(past, rays, found[i]) for i, past in enumerate(pasts)]
        table: list[Echoes] = []
        rows = np.zeros(len(frames), np.intp)
        for i in range(len(frames)):
            same = i > 0 and found.rows[i] == found.rows[i - 1] and entries[i] is entries[i - 1]
            if not same or speeds[i].any() or speeds[i - 1].any():
                table.append(self._echoes(at, found[i], entries[i], speeds[i], metres))
            rows[i] = len(table) - 1
        return Answers(table, rows)

    def _echoes(
        self, at: _Substances, seen: RayHits, entries: _Entries, speed: Array, metres: float
    ) -> Echoes:
        before = entries.distance < seen.ranges[entries.ray]
        ray, number = entries.ray[before], entries.number[before]
        names: dict[int, list[str]] = {}
        for one, solid in zip(ray.tolist(), number.tolist(), strict=True):
            names.setdefault(one, []).append(self._names[solid])
        return Echoes(
            ranges=seen.ranges * metres,
            speed=speed * metres,
            breathing=self._breathing[seen.solids],
            rate=self._rate[seen.solids],
            loss=np.bincount(ray, at.loss[number], len(seen.solids)).astype(np.float64),
            reflectance=at.reflectance[seen.solids],
            solid=seen.solids.astype(np.intp),
            through={one: tuple(passed) for one, passed in names.items()},
        )

    # Substances and breathing.

    def _update(self) -> None:
        """Read all substances if the scene was edited, or if any of them is animated."""
        solids, depsgraph = self._rays.solids, self._depsgraph
        if self._listing == solids.listing and not self._animated:
            return
        self._listing = solids.listing
        self._animated = self.changes_by_itself(depsgraph.scene)
        self._by_frequency.clear()
        size = max((solid.number for solid in solids.solids), default=NOTHING) + 1
        self._breathing, self._rate = np.zeros(size), np.zeros(size)
        by_uid = {material.session_uid: material for material in bpy.data.materials}
        for solid in solids.solids:
            materials = [by_uid.get(uid) for uid in solid.geometry.materials(depsgraph)]
            self._names[solid.number] = solid.name
            found = _made_of(solid, materials, depsgraph, unit_scale(depsgraph.scene))
            self._made_of[solid.number] = list(found)
            breath = _breath(solid.original, depsgraph)
            self._breathing[solid.number], self._rate[solid.number] = breath

    def _substances(self, frequency: float) -> _Substances:
        """Return the substances of all solids at a carrier frequency in GHz."""
        if frequency not in self._by_frequency:
            solids = self._rays.solids
            loss, reflected = np.zeros(len(self._rate)), np.zeros(len(self._rate))
            for solid in solids.solids:
                losses = [
                    (attenuation(name, thickness, frequency), name)
                    for name, thickness in self._made_of[solid.number]
                ]
                loss[solid.number], substance = max(losses)
                reflected[solid.number] = reflectance(substance, frequency)
            numbers = np.array([solid.number for solid in solids.solids], np.intp)
            stops = loss[numbers] > STOPS
            stopping, passing = _CasterOfSome(solids, ~stops), _CasterOfSome(solids, stops)
            self._by_frequency[frequency] = _Substances(
                loss, reflected, stopping, passing, not stops.all()
            )
        return self._by_frequency[frequency]


def _made_of(
    solid: Solid, materials: Sequence[Any], depsgraph: Any, metres: float
) -> Iterable[tuple[str, float]]:
    """Yield the substances of a solid, each with the thickness in m of a crossing.

    `materials` are its materials, or None for an empty slot. `metres` is the length of a Blender
    unit.
    """
    own = _substance_of(solid.original, depsgraph) or _substance_of(solid.owner, depsgraph)
    of_materials = [_substance_of(m, depsgraph) for m in materials if m is not None]
    known = [own] if own else [found for found in of_materials if found]
    if known:
        yield from known
    else:
        substance = DEFAULT
        if _living(solid.original) is not None:
            substance = BODY
        elif _is_textile(solid, materials, metres):
            substance = TEXTILE
        yield substance, THICKNESS[substance]


def _is_textile(solid: Solid, materials: Sequence[Any], metres: float) -> bool:
    """Return whether a solid bends as cloth, or is thin and named as textile.

    `materials` and `metres` are as for `_made_of`.
    """
    obj = solid.original
    if any(modifier.type == "CLOTH" for modifier in obj.modifiers):
        return True
    if not is_textile(obj.name, [material.name for material in materials if material is not None]):
        return False
    # As modelled: a mesh that bends stays what it is.
    if obj.type == "MESH" and len(obj.data.vertices):
        points = np.empty(len(obj.data.vertices) * 3, np.float32)
        obj.data.vertices.foreach_get("co", points)
        size = np.ptp(points.reshape(-1, 3), axis=0)
    else:
        size = solid.geometry.hi - solid.geometry.lo
    scale = np.linalg.norm(np.array(obj.matrix_world)[:3, :3], axis=0)
    return bool((size * scale).min() * metres <= THIN)


def _substance_of(owner: Any, depsgraph: Any) -> tuple[str, float] | None:
    """Return the substance and thickness that are set on an object or a material, or None."""
    settings = getattr(owner.evaluated_get(depsgraph), RADAR)
    if settings.substance in (AUTO, ""):
        return None
    return settings.substance, settings.thickness or THICKNESS[settings.substance]


def _living(obj: Any) -> Any:
    """Return the object with the mass of the body that a surface belongs to, or None.

    A body is bent by an armature: furniture can have a mass too.
    """
    found = bearer(obj)
    is_body = found is not None and (found.type == "ARMATURE" or armatures(found))
    return found if is_body else None


def _breath(obj: Any, depsgraph: Any) -> tuple[float, float]:
    """Return the chest displacement in m and the breathing rate in Hz of a body; zeros for none."""
    chosen = (o for o in candidates(obj) if getattr(o, BREATHING).breathes not in (AUTO, ""))
    body = next(chosen, None) or _living(obj)
    if body is None:
        return 0.0, 0.0
    settings = getattr(body.evaluated_get(depsgraph), BREATHING)
    if settings.breathes not in (AUTO, YES):
        return 0.0, 0.0
    return float(f"{settings.displacement:.7g}"), float(f"{settings.rate:.7g}")


def _speeds(past: Past, rays: Rays, seen: RayHits) -> Array:
    """Return the radial speeds (m, n) of the points that rays hit, in Blender units per second.

    `past` has the times and places of m + 1 steps, the last at the hits. A solid that did not exist
    before has not moved. Where nothing moved, return one part of zeros.
    """
    origins, directions, _ = rays
    moved = [now.moved_since(then) for (_, then), (_, now) in pairwise(past)]
    speeds = np.zeros((max(1, len(moved)), len(seen.solids)))
    for number in sorted(frozenset().union(*moved)):
        which = np.flatnonzero(seen.solids == number)
        if len(which):
            ways = directions[which]
            points = origins[which] + ways * seen.ranges[which, None]
            along = _along(past, moved, number, points, ways, seen.faces[which])
            seconds = np.diff([time for time, _ in past])
            speeds[:, which] = np.diff(along, axis=0) / seconds[:, None]
    return speeds if speeds.any() else speeds[:1]


def _along(
    past: Past, moved: list[frozenset[int]], number: int, points: Array, ways: Array, faces: Index
) -> Array:
    """Return how far (m + 1, k) along the rays the material points of a solid were at each step.

    Parameters
    ----------
    past
        The times and places of m + 1 steps.
    moved
        The numbers of the solids that moved in each of the m parts.
    number
        The number of the solid.
    points, faces
        The points (k, 3) that rays hit at the last step, and the faces (k,).
    ways
        The directions (k, 3) of the rays.
    """
    state = past[-1][1].of(number)
    assert state is not None
    matrix, now = state
    inverse = inverted(matrix)
    # The points in the space of the solid, and how those on a surface follow its vertices.
    local = points @ inverse[:3, :3].T + inverse[:3, 3]
    surface, vertices, weights = now, None, np.empty(0)
    along = [(points * ways).sum(axis=1)]
    for (_, places), changed in zip(past[-2::-1], moved[::-1], strict=True):
        state = places.of(number) if number in changed else None
        if state is None:
            along.append(along[-1])
            continue
        matrix = state[0]
        if state[1] is not surface:
            surface = state[1]
            if surface.points.shape == now.points.shape and surface.has_faces_of(now):
                if vertices is None:
                    vertices, weights = _on_faces(local, faces, now)
                local = (surface.points[:, vertices] * weights).sum(axis=1).T
        along.append(((local @ matrix[:3, :3].T + matrix[:3, 3]) * ways).sum(axis=1))
    return np.array(along[::-1])


def _on_faces(points: Array, faces: Index, surface: Surface) -> tuple[Index, Array]:
    """Return the vertices (3, k) of a surface between which points (k, 3) are, and their weights.

    `faces` (k,) has the face of each point. A point keeps its barycentric coordinates in a triangle
    of its face, the weights (3, k). In a triangle without an area, it keeps to the first vertex.
    """
    corners, face = surface.triangles
    vertices = corners[:, np.minimum(np.searchsorted(face, faces), len(face) - 1)]
    a, b, c = (surface.points[:, corner].T.astype(np.float64) for corner in vertices)
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    wu, wv = (w * u).sum(1), (w * v).sum(1)
    area = uu * vv - uv * uv
    flat = area <= 1e-12 * uu * vv
    area = np.where(flat, 1.0, area)
    s = np.where(flat, 0.0, (vv * wu - uv * wv) / area)
    t = np.where(flat, 0.0, (uu * wv - uv * wu) / area)
    return vertices, np.stack([1.0 - s - t, s, t])


PROBE = EchoProbe
