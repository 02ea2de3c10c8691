# SPDX-License-Identifier: GPL-3.0-or-later
"""Advice on reasons in the scene why a sensor does not read what the user expects.

The module also finds the surfaces that press on pressure pads with the mass of an object.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.wording import Advice, Lengths, measured, named, uncapitalized
from ...sensor_logic.model import Array
from ..scene.animation import PLACE, is_animated, motion_paths, played_curves
from ..scene.bearers import candidates, has_mass
from ..scene.door_motion import ROTATIONS, keyed_motions
from ..scene.forces.bodies import rigid_bodies
from ..scene.instances import chain, with_instanced
from ..scene.lengths import lengths_of
from ..scene.light import materials
from ..scene.rays.solids import SURFACE_TYPES
from ..scene.sensors import (
    NotPlaced,
    Sensor,
    placed_matrix,
    read_parameters,
    simulated,
    unit_scale,
)
from ..scene.units import kilograms


def warm_up(sensor: Any, scene: Any) -> Advice | None:
    """Return a warning if a motion detector's warm-up lasts longer than the animation."""
    seconds = getattr(sensor.parameters, "warm_up_time", 0.0)
    frames = scene.frame_end + 1 - scene.frame_start
    length = frames * scene.render.fps_base / scene.render.fps
    if seconds < length:
        return None
    return Advice(
        f"Its warm-up time of {seconds:g} s is longer than the animation of {length:.3g} s, so it "
        "reports nothing",
        "Set Warm-up time to 0, as for a detector that was switched on long before",
    )


def background_sets(scene: Any) -> list[Advice]:
    """Return warnings of background sets, whose objects the viewport shows but no sensor sees."""
    sets = [scene]
    while sets[-1].background_set not in (None, *sets):
        sets.append(sets[-1].background_set)
    found = []
    for background in sets[1:]:
        shown = [obj.name for obj in background.objects if obj.type in SURFACE_TYPES | {"LIGHT"}]
        if shown:
            found.append(
                Advice(
                    f"No sensor sees the objects of the background set '{background.name}': "
                    f"{named(shown)}",
                    "Clear Background Set (Scene tab), and link the set's collection into this "
                    "scene",
                )
            )
    return found


def unreachable(sensor: Sensor, lengths: Lengths) -> list[Advice]:
    """Return warnings if a sensor's output can never switch on, or can never switch off.

    Return an empty list if a parameter is outside its limits; other code reports that.
    """
    try:
        return read_parameters(sensor, sensor.settings).unreachable(lengths)
    except AngenError:
        return []


# Data paths of keyframes that `keyed_motions` knows.
PLAIN_PATHS = {"location", *ROTATIONS}
# Poses between two keyframes in which a magnet is tried too, with straight lines between them.
POSES_BETWEEN = 24


def never_closes(sensor: Sensor, depsgraph: Any, lengths: Lengths) -> Advice | None:
    """Return a warning if the magnet of a door contact never comes near enough to close it.

    The magnet is tried where it is now, and where keyframes move it. Return None for other kinds,
    and where more than the keyframes of one object move the magnet or the contact.
    """
    magnet = getattr(sensor.parameters, "magnet", None)
    if magnet is None or sensor.holders:
        return None
    keyed = []
    for part in dict.fromkeys((*chain(magnet), *chain(sensor.object))):
        drivers = part.animation_data.drivers if part.animation_data is not None else ()
        paths = motion_paths(part)
        if part.parent_type != "OBJECT" or any(c.data_path.startswith(PLACE) for c in drivers):
            return None
        if not PLAIN_PATHS.issuperset(paths):
            return None
        keyed += [part] if paths else []
    try:
        closes = read_parameters(sensor, sensor.settings).close_distance
        place = placed_matrix(magnet, depsgraph).translation
    except (AngenError, NotPlaced):
        return None
    distance = f"angen_sensor.{sensor.kind.attribute}.close_distance"
    if len(keyed) > 1 or is_animated(sensor.object, distance):
        return None
    ends = place, sensor.world_matrix(depsgraph).translation
    moves = [bool(keyed) and keyed[0] in chain(obj) for obj in (magnet, sensor.object)]
    motions = keyed_motions(keyed[0], POSES_BETWEEN) if any(moves) else []
    away = np.array([
        (m @ ends[0] if moves[0] else ends[0]) - (m @ ends[1] if moves[1] else ends[1])
        for m in motions
    ]).reshape(-1, 3)  # fmt: skip
    now = np.array([ends[0] - ends[1]])
    nearest = min(_nearest(now), _nearest(away)) * unit_scale(depsgraph.scene)
    if nearest <= closes:
        return None
    return Advice(
        f"Its magnet '{magnet.name}' comes no nearer than {measured(nearest, 'm', 4, lengths)}, "
        f"and it closes at {lengths.typed(closes)}: it is always open",
        "Move the magnet to the contact, or choose a preset that closes farther away (Closes At)",
    )


def _nearest(points: Array) -> float:
    """Return the distance of the origin from the line through points, shape (n, 3)."""
    begins, ways = points, np.diff(points, axis=0, append=points[-1:])
    along = -np.einsum("ij,ij->i", begins, ways) / np.maximum((ways**2).sum(axis=1), 1e-12)
    found = begins + np.clip(along, 0.0, 1.0)[:, None] * ways
    return float(np.linalg.norm(found, axis=1).min(initial=np.inf))


def open_for_ever(sensors: Iterable[Sensor], depsgraph: Any) -> Iterator[str]:
    """Yield a line for each of the sensors that is a door contact which no magnet closes."""
    for sensor in simulated(sensors):
        if found := never_closes(sensor, depsgraph, lengths_of(depsgraph.scene)):
            yield f"'{sensor.name}': {uncapitalized(found.text)}"


def without_surface(obj: Any) -> Advice | None:
    """Return a warning if a pressure pad has no surface to press on."""
    kind = obj.bl_rna.properties["type"].enum_items[obj.type].name.lower()
    if obj.type not in SURFACE_TYPES:
        return Advice(
            f"It has no surface to press on, since its type is {kind}", "Use a mesh object"
        )
    if obj.type == "MESH" and not obj.modifiers and not obj.data.polygons:
        return Advice("Its mesh has no faces to press on", "Give it faces")
    return None


def may_be_simulated(obj: Any) -> bool:
    """Return whether the physics engine moves the object at any frame."""
    body = obj.rigid_body
    return (
        body is not None
        and body.type == "ACTIVE"
        and (body.enabled or is_animated(obj, "rigid_body.enabled"))
        and (not body.kinematic or is_animated(obj, "rigid_body.kinematic"))
    )


def simulated_bodies(scene: Any) -> Iterator[Any]:
    """Return an iterator over the rigid bodies that the physics engine moves.

    A compound body counts as one.
    """
    return (obj for obj in rigid_bodies(scene) if may_be_simulated(obj))


def sinks(pad: Any, scene: Any) -> Advice | None:
    """Return a warning if a pressure pad is an active rigid body that sinks under heavier ones."""
    bodies = list(simulated_bodies(scene))
    if pad not in bodies:
        return None
    heavier = [b for b in bodies if b != pad and b.rigid_body.mass > pad.rigid_body.mass]
    if not heavier:
        return None
    worst = max(heavier, key=lambda body: body.rigid_body.mass)
    masses = [kilograms(body.rigid_body, unit_scale(scene)) for body in (pad, worst)]
    return Advice(
        f"It is an active rigid body of {masses[0]:g} kg: it sinks under heavier bodies, such as "
        f"'{worst.name}' ({masses[1]:g} kg)",
        "Make it passive, or remove its rigid body",
    )


def weightless(pad: Any, scene: Any, view_layer: Any) -> Advice | None:
    """Return a warning if the scene has no object with a mass that could press on the pad."""
    if any(body != pad for body in simulated_bodies(scene)):
        return None
    if any(has_mass(obj) and obj != pad for obj, _ in with_instanced(view_layer)):
        return None
    world = scene.rigidbody_world
    if world is not None and not world.enabled:
        return Advice(
            "Nothing in this scene has a weight: the rigid-body world is off",
            "Switch it on: Scene tab, Rigid Body World",
        )
    return Advice(
        "Nothing in this scene has a weight",
        "Make something an active rigid body, or give an animated person or thing a mass: "
        "Physics tab, Weight on Sensors",
    )


def hidden_partner(pad: Sensor, view_layer: Any) -> Advice | None:
    """Return a warning if all objects that a pad is set to measure are hidden.

    Rigid bodies do not count, because Blender also simulates hidden ones.
    """
    chosen, group = pad.parameters.partner_object, pad.parameters.partner_collection
    partners = [*([chosen] if chosen else ()), *(group.all_objects if group else ())]
    if not partners:
        return None
    family = {part for obj in partners for part in (obj, *obj.children_recursive)}
    if any(
        obj in family and obj.type in SURFACE_TYPES and handle.visible_get(view_layer=view_layer)
        for obj, handle in with_instanced(view_layer)
    ) or any(part.rigid_body is not None for part in family):
        return None
    return Advice(
        f"It measures only {named([chosen.name if chosen else group.name])}, which has no visible "
        "surface in the viewport, so it reads 0 N",
        "Show it (eye or monitor icon in the Outliner), or choose another object or collection to "
        "measure",
    )


def of_several(advices: dict[str, Advice]) -> str:
    """Return one line for the advice on several pads; `advices` has the pads' names as keys.

    The line has the number of pads, the first names, and the text for the first pad. It says so if
    the texts for other pads differ.
    """
    names = list(advices)
    text = uncapitalized(advices[names[0]].text)
    if len(names) == 1:
        return f"'{names[0]}': {text}"
    if len(set(advices.values())) > 1:
        text = f"of the first: {text}"
    return f"{len(names)} pads ({named(names, 3)}): {text}"


def outdated_cache(scene: Any) -> Advice | None:
    """Return a warning if the rigid-body cache is older than the last edit."""
    world = scene.rigidbody_world
    if not any(simulated_bodies(scene)) or not world.point_cache.is_outdated:
        return None
    return Advice(
        "The rigid-body cache is out of date, so live readings are not valid",
        f"Play from frame {world.point_cache.frame_start}, or simulate the sensors",
    )


def short_cache(scene: Any) -> Advice | None:
    """Return a warning if the rigid-body cache ends before the scene's last frame."""
    if not any(simulated_bodies(scene)):
        return None
    cache = scene.rigidbody_world.point_cache
    if cache.frame_end >= scene.frame_end:
        return None
    way_out = "Delete its bake, set its end and bake again" if cache.is_baked else "Set its end"
    return Advice(
        f"The rigid-body cache ends at frame {cache.frame_end}, the scene at {scene.frame_end}: "
        "readings after it are not valid",
        f"{way_out}: Scene tab, Rigid Body World, Cache",
    )


def late_releases(scene: Any) -> Advice | None:
    """Return a warning of rigid bodies that Blender may let go a frame late.

    Blender evaluates keys of *Animated* and *Dynamic* beside the physics that read them: the later
    frame counted in some 1 of 700 runs of the sample (measured in 4.5 and 5.2). Physics wait for an
    animation with keys of the place, in which it was 0 of 4,200.
    """
    settings = "rigid_body.kinematic", "rigid_body.enabled"
    late = [
        obj.name
        for obj in rigid_bodies(scene)
        if any(is_animated(obj, path) for path in settings)
        and not any(curve.data_path.startswith(PLACE) for curve in played_curves(obj))
    ]
    if not late:
        return None
    return Advice(
        f"Now and then Blender lets {named(late)} go a frame late, since its physics do not wait "
        "for keyframes of Animated or Dynamic alone",
        "Insert a keyframe of its location at its first frame too",
    )


def opaque_glass(view_layer: Any) -> Iterator[Advice]:
    """Yield a warning for each glass that keeps lamps and the sun from light sensors."""
    for name, material in materials.opaque_glass(view_layer).items():
        yield Advice(
            f"Light sensors see no lamp and no sun through the glass '{material}' of '{name}', "
            "since it is not a thin, flat, plain pane",
            "Make it a flat pane at most 5 cm thick, without textures, keyframes or volume; or "
            "mix a Transparent BSDF into its shader, with Is Shadow Ray of the node Light Path as "
            "the factor",
        )


# Types of objects that have a surface, or can be the parent or armature of one.
BEARER_TYPES = SURFACE_TYPES | {"ARMATURE", "EMPTY", "LATTICE"}


@dataclass(frozen=True)
class Weighed:
    """The surfaces that press on pads with the mass of one object.

    Attributes
    ----------
    surfaces
        These surfaces.
    apart
        Surfaces of the object's descendants that press with another mass instead. Each is paired
        with the object that has that mass.
    """

    surfaces: list[Any]
    apart: list[tuple[Any, Any]]


def weighed_with(obj: Any, view_layer: Any) -> Weighed:
    """Return the surfaces that press on pads with the mass of `obj`, or would if it had one."""
    found = Weighed([], [])
    for surface in _surfaces(view_layer):
        possible = list(candidates(surface))
        if obj not in possible:
            continue
        other = next(filter(has_mass, possible[: possible.index(obj)]), None)
        if other is None:
            found.surfaces.append(surface)
        else:
            found.apart.append((surface, other))
    return found


def _surfaces(view_layer: Any) -> Iterator[Any]:
    for obj in view_layer.objects:
        ignored = obj.type not in SURFACE_TYPES or obj.angen_ignored
        if not ignored and obj.visible_get(view_layer=view_layer):
            yield obj
