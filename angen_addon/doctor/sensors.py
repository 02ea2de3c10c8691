# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the poses of sensors, of pressure pads and of light.

They also find scenes in which nothing moves, presses or shines that the sensors could notice.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from ...sensor_logic.kind import FORCES, LIGHT, POSES, RAYS, USES, WARMTH
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.wording import capital, named, percent, uncapitalized
from ...sensor_logic.model import NOT_YET, Array
from ...sensor_logic.parameters import specs
from ..advice import sensing, warmth
from ..advice import sensing as advice
from ..runtime.sensor_runner import all_rays
from ..runtime.time_base import clock_of
from ..runtime.trace import Trace
from ..scene.animation import idle_keys, is_animated, playing
from ..scene.forces.bodies import Pad
from ..scene.forces.tracker import ContactTracker
from ..scene.lengths import lengths_of
from ..scene.light.engine import why_no_eevee
from ..scene.light.materials import has_nodes
from ..scene.light.scene import is_portal
from ..scene.rays.caster import NOTHING
from ..scene.rays.geometry import faces_along
from ..scene.rays.solids import Solid
from ..scene.sensors import NotPlaced, Sensor, placed_matrix
from ..scene.timed import frames_to_step_from, may_follow_frame
from ..scene.units import (
    AREA,
    VOLUME,
    WATTS,
    gravity_factor,
    kilograms,
    peak_power,
    watts_factor,
)
from ..scene.uses import check_watched, may_change, watched_object
from .examined import Examined, Found

BUNDLE_AXES, BUNDLE_NEAR, BUNDLE_SLIT, BUNDLE_AHEAD = -42, -43, -44, -46
# m. A sensor can only be inside a solid that two opposite rays hit within this distance in all.
THICKEST = 0.6
# A sensor is blocked if more than this fraction of its rays hit something nearer than range min.
BLOCKED = 0.25
# m. A real beam does not pass a slit of width 2 SLIT. Its sides are equally far from the sensor,
# within LEVEL. What the ray through the slit hits is farther away by at least BEHIND.
SLIT, LEVEL, BEHIND = 0.01, 0.15, 0.5
# m. A sensor faces a wall if all rays within 30° of its axis end there, nearer than HAND.
# They start OFF before it.
HAND, OFF = 0.25, 0.002
AHEAD = np.array(
    [(0.0, 0.0, -1.0)]
    + [
        (np.sin(off) * np.cos(turn), np.sin(off) * np.sin(turn), -np.cos(off))
        for off in np.radians([15.0, 30.0])
        for turn in np.radians(np.arange(0.0, 360.0, 45.0))
    ]
)
# Types of datablocks whose animation moves no surface.
BY_LIGHT_ALONE = ("LIGHT", "MATERIAL", "WORLD", "CAMERA", "NODETREE", "TEXTURE", "LINESTYLE")


def nothing_moves(home: Examined) -> Iterator[Found]:
    """Yield a finding if the scene has sensors of movement, but nothing that moves."""
    sensors = home.requiring(RAYS, WARMTH, POSES)
    if sensors and not home.moved_without_keys and not _moves(home):
        yield (
            f"Nothing in the scene is animated: {named(s.name for s in sensors)} will publish "
            "only their first reading",
            "Animate a person or a door (I in the 3D view inserts keyframes), import a walk "
            "cycle, or add a resident, mark places and run a routine with `angen day`",
            tuple(s.name for s in sensors),
        )


def _moves(home: Examined) -> bool:
    if frames_to_step_from(home.scene):
        return True
    owners = [evaluated.original for evaluated in home.depsgraph.ids]
    return any(map(_is_animated, owners)) or any(
        may_follow_frame(owner) for owner in owners if owner.id_type == "OBJECT"
    )


def _is_animated(datablock: Any) -> bool:
    """Return whether keyframes, strips or drivers of a datablock move something.

    Animation of lamps, materials and sensor outputs does not count.
    """
    if getattr(datablock, "animation_data", None) is None or datablock.id_type in BY_LIGHT_ALONE:
        return False
    curves, strips = playing(datablock)
    return bool(strips) or any(not c.data_path.startswith("angen_sensor.") for c in curves)


def keys_that_do_not_play(home: Examined) -> Iterator[Found]:
    """Yield a finding for each reason why keyframes, strips or drivers have no effect."""
    scene = home.scene
    found: dict[tuple[str, str], list[str]] = {}
    for owner in dict.fromkeys(evaluated.original for evaluated in home.depsgraph.ids):
        for reason in idle_keys(owner, scene.frame_start, scene.frame_end):
            found.setdefault(reason, []).append(owner.name)
    for (what, mend), names in found.items():
        yield f"{what}: {named(sorted(names))}", mend, tuple(sorted(names))


def inside_walls(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor that is inside a solid object."""
    for sensor in home.requiring(RAYS, WARMTH, LIGHT):
        inside = _surrounded_by(home, sensor)
        if inside:
            yield (
                f"'{sensor.name}' is inside the object '{inside}', so it sees nothing else",
                "Move it out, or place it again with Shift+A, Sensor, … on Surface",
                (sensor.name, inside),
            )


def _surrounded_by(home: Examined, sensor: Sensor) -> str:
    """Return the name of the solid that a sensor is inside; empty if it is inside none.

    Two opposite rays from the sensor both hit this solid nearby. Each ray leaves it through an odd
    number of faces. The directions of the faces' normals do not matter.
    """
    matrix = sensor.world_matrix(home.depsgraph)
    axes = np.concatenate([np.eye(3), np.array(matrix.to_3x3().normalized(), np.float64).T])
    directions = np.concatenate([axes, -axes])
    origins = np.tile(np.array(matrix.translation, np.float64), (len(directions), 1))
    far = np.full(len(directions), THICKEST / home.metres)
    caster = home.home.caster
    ranges, hit = caster.cast_solids(sensor.uid, BUNDLE_AXES, origins, directions, far)
    for one in range(len(axes)):
        two = one + len(axes)
        near = (ranges[one] + ranges[two]) * home.metres < THICKEST
        if hit[one] == NOTHING or hit[one] != hit[two] or not near:
            continue
        solid = next(s for s in caster.solids.solids if s.number == hit[one])
        faces = (_crossings(home, solid, origins[0], directions[side]) for side in (one, two))
        if all(count % 2 for count in faces):
            return solid.name
    return ""


def _crossings(home: Examined, solid: Solid, origin: Array, direction: Array) -> int:
    """Return how many faces of a solid a ray crosses, or 0 if there are too many to count."""
    inverse = home.home.caster.solids.inverse[solid.row]
    tree = solid.geometry.tree(home.depsgraph)
    point = inverse[:3, :3] @ origin + inverse[:3, 3] - solid.geometry.pivot
    ahead = inverse[:3, :3] @ direction
    size = float(np.linalg.norm(solid.geometry.hi - solid.geometry.lo))
    return faces_along(tree, point, ahead / np.linalg.norm(ahead), size * 1e-6)


def looks_into_something(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor with an obstacle nearer than the least range that it sees."""
    for sensor in home.requiring(RAYS):
        try:
            sight = all_rays(sensor, clock_of(home.scene), home.depsgraph)
        except AngenError as error:
            yield (
                str(error),
                "Correct the sensor's parameters in the sidebar, Active Sensor",
                (sensor.name,),
            )
            continue
        if sight is None or not sight.bundles:
            continue
        shortest = float(getattr(sight.parameters, "range_min", 0.0))
        directions = np.ascontiguousarray(sight.rays(home.metres).directions)
        origins = np.tile(sight.pose.origin / home.metres, (len(directions), 1))
        far = np.full(len(directions), shortest / home.metres)
        hit = home.home.caster.cast_solids(sensor.uid, BUNDLE_NEAR, origins, directions, far)[1]
        blocked = hit != NOTHING
        if blocked.mean() > BLOCKED:
            numbers, counts = np.unique(hit[blocked], return_counts=True)
            name = home.home.caster.solids.name_of(int(numbers[counts.argmax()]))
            yield (
                f"'{sensor.name}' looks into '{name}', which is nearer than its parameter Range "
                f"min of {shortest * 100:g} cm: {percent(blocked.mean())} of its rays ignore the "
                "object",
                f"Move the sensor away from '{name}', or turn it (it looks along its -Z axis). If "
                f"'{name}' is its housing, parent that to the sensor",
                (sensor.name, name),
            )


def faces_a_wall(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor that has only a wall, or another still object, before it."""
    for sensor in home.sensors:
        # A pad lies on something, and a plug looks at nothing. A switch, or a contact, is for what
        # is near.
        is_near = any(map(sensor.kind.requires, (FORCES, USES))) or any(
            field.quantity == "opening" for field in sensor.kind.events
        )
        reach = getattr(sensor.parameters, "range_max", np.inf)
        if is_near or reach <= 2 * HAND or _surrounded_by(home, sensor):
            continue
        matrix = sensor.world_matrix(home.depsgraph)
        axes = np.array(matrix.to_3x3().normalized(), np.float64)
        directions = np.ascontiguousarray(AHEAD @ axes.T)
        # A sensor can lie on a surface with its origin.
        start = np.array(matrix.translation, np.float64) + directions[0] * (OFF / home.metres)
        origins = np.tile(start, (len(AHEAD), 1))
        far = np.full(len(AHEAD), HAND / home.metres)
        ranges, hit = home.home.caster.cast_solids(
            sensor.uid, BUNDLE_AHEAD, origins, directions, far
        )
        if (hit != hit[0]).any() or hit[0] == NOTHING:
            continue
        name = home.home.caster.solids.name_of(int(hit[0]))
        if not _moves_itself(home.scene.objects.get(name)):
            away = ranges[0] * home.metres + OFF
            yield (
                f"'{sensor.name}' faces '{name}' at {100 * away:.0f} cm, and sees little else",
                "Turn it round (it looks along its -Z axis), or place it again with Shift+A, "
                "Sensor, … on Surface",
                (sensor.name, name),
            )


def _moves_itself(obj: Any) -> bool:
    """Return whether an object or one of its parents is animated or simulated."""
    while obj is not None:
        if _is_animated(obj) or (obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE"):
            return True
        obj = obj.parent
    return False


def slits(home: Examined) -> Iterator[Found]:
    """Yield a finding for each slit that a detector's rays pass, but a real beam would not."""
    for sensor in home.requiring(RAYS):
        if not any(field.quantity == "motion" for field in sensor.kind.events):
            continue
        with suppress(AngenError):
            sight = all_rays(sensor, clock_of(home.scene), home.depsgraph)
            for one, other in _slits(home, sight) if sight is not None else ():
                yield (
                    f"'{sensor.name}' sees through a slit between '{one}' and '{other}', thinner "
                    f"than {2000.0 * SLIT:.0f} mm: it notices movements behind them",
                    "Let one overlap the other, as the frame of a door overlaps its leaf",
                    (sensor.name, one, other),
                )


def _slits(home: Examined, trace: Trace) -> list[tuple[str, str]]:
    """Return the slits that rays pass through, each as the names of the two solids beside it."""
    rays, caster, sensor = trace.rays(home.metres), home.home.caster, trace.sensor
    directions, reach = np.ascontiguousarray(rays.directions), rays.reach
    if not len(directions):
        return []
    helper = np.where(np.abs(directions[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    across = np.cross(directions, helper)
    across /= np.linalg.norm(across, axis=1)[:, None]
    origins = np.ascontiguousarray(rays.origins)
    far, _ = caster.cast_solids(sensor.uid, BUNDLE_SLIT, origins, directions, reach)
    found: dict[tuple[str, str], None] = {}
    for side in (across, np.cross(directions, across)):
        sides = [
            caster.cast_solids(sensor.uid, BUNDLE_SLIT, origins + turn * side, directions, reach)
            for turn in (SLIT / home.metres, -SLIT / home.metres)
        ]
        (one, met_one), (two, met_two) = sides
        beside = np.maximum(one, two) * home.metres
        passed = (np.abs(one - two) * home.metres < LEVEL) & (beside + BEHIND < far * home.metres)
        for pair in zip(met_one[passed].tolist(), met_two[passed].tolist(), strict=True):
            names = sorted(caster.solids.name_of(number) for number in pair)
            # Real beams also pass an object with openings, such as the back of a chair.
            if names[0] != names[1]:
                found[names[0], names[1]] = None
    return list(found)


def names_nothing(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor that lacks an object it needs, such as a contact's magnet."""
    for sensor in home.requiring(POSES):
        for name, spec in specs(sensor.kind.parameters).items():
            if spec.pointer == "Object" and getattr(sensor.parameters, name) is None:
                yield (
                    f"'{sensor.name}' has no {spec.label.lower()}, so it always reads the same",
                    f"Choose its {spec.label} in the sidebar, Active Sensor",
                    (sensor.name,),
                )


def never_close(home: Examined) -> Iterator[Found]:
    """Yield a finding for each door contact that no magnet closes."""
    for sensor in home.requiring(POSES):
        found = sensing.never_closes(sensor, home.depsgraph, lengths_of(home.scene))
        if found:
            yield f"'{sensor.name}': {uncapitalized(found.problem)}", found.mend, (sensor.name,)


def watches_nothing(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor that watches no object, or one whose use never changes."""
    for sensor in home.requiring(USES):
        watched = watched_object(sensor)
        if watched is None:
            yield (
                f"'{sensor.name}' watches no object, so it always reads the same",
                "Choose what it Watches in the sidebar, Active Sensor, or parent it to the object",
                (sensor.name,),
            )
        elif not may_change(sensor) and watched.angen_place.use == "NONE":
            yield (
                f"Nothing keys whether '{watched.name}' is in use: '{sensor.name}' always reads "
                "the same",
                "Key its In Use (Physics tab), or mark it as a place that residents use",
                (sensor.name, watched.name),
            )
        try:
            check_watched(sensor, home.depsgraph)
        except NotPlaced as error:
            yield f"'{sensor.name}': {error.problem}", capital(error.mend), (sensor.name,)


def unplaced(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor that Blender does not evaluate, so that it has no pose.

    The same is done for objects that a sensor, a lamp or a resident refers to.
    """
    for sensor in home.unplaced:
        yield (
            f"'{sensor.name}' is disabled in viewports, so Blender does not place it",
            "Enable it there (monitor icon), or switch the sensor off",
        )
    for owner, obj in _named_objects(home):
        try:
            placed_matrix(obj, home.depsgraph)
        except NotPlaced as error:
            yield f"'{owner}' needs '{obj.name}': {error.problem}", capital(error.mend)


def _named_objects(home: Examined) -> Iterator[tuple[str, Any]]:
    """Yield pairs: the name of a sensor, lamp or resident, and an object that it refers to."""
    for sensor in home.sensors:
        for name, spec in specs(sensor.kind.parameters).items():
            used = getattr(sensor.parameters, name) if spec.pointer == "Object" else None
            if used is not None and not sensor.holders:
                yield sensor.name, used
    for obj in home.view_layer.objects:
        for used in (obj.angen_place.switch, obj.angen_resident.walking_frame):
            if used is not None:
                yield obj.name, used


def nothing_warm(home: Examined) -> Iterator[Found]:
    """Yield a finding if there are sensors of warmth, but no object has a temperature."""
    found = warmth.sensing_warmth(home.sensors)
    warning = warmth.nothing_warm(home.view_layer) if found else None
    if warning:
        names = tuple(s.name for s in found)
        yield f"{warning.problem} ({named(names)})", warning.mend, names


def unreachable(home: Examined) -> Iterator[Found]:
    """Yield a finding for each sensor whose output can never switch on, or never off."""
    for sensor in home.sensors:
        for found in sensing.unreachable(sensor, lengths_of(home.scene)):
            text = f"'{sensor.name}': {uncapitalized(found.problem)}"
            yield text, found.mend, (sensor.name,)


# Checks of pressure pads, and of the rigid bodies that press on them.

BUNDLE = -41
# m. A pad hangs in the air if nothing is this near below it.
GAP = 0.05


def advised(home: Examined) -> Iterator[Found]:
    """Yield a finding for each pad that nothing can press on, or that sinks under other bodies."""
    for pad in home.requiring(FORCES):
        for warning in (
            advice.without_surface(pad.object),
            advice.sinks(pad.object, home.scene),
            advice.weightless(pad.object, home.scene, home.view_layer),
            advice.hidden_partner(pad, home.view_layer),
        ):
            if warning:
                yield f"'{pad.name}': {uncapitalized(warning.problem)}", warning.mend, (pad.name,)


def margins(home: Examined) -> Iterator[Found]:
    """Yield a finding if active rigid bodies have the shape Mesh.

    Their collision margin makes them hop on pads, so that the pads' readings are often not valid.
    """
    if not home.requiring(FORCES):
        return
    margins = {
        part.name: part.rigid_body.collision_margin * home.metres * 1000.0
        for body in advice.simulated_bodies(home.scene)
        for part in (body, *body.children)
        if part.rigid_body is not None and part.rigid_body.collision_shape == "MESH"
    }
    if margins:
        yield (
            "Active rigid bodies with the shape Mesh, which bounce on pads because of their "
            f"collision margin (up to {max(margins.values()):.3g} mm): {named(sorted(margins))}",
            "Choose Convex Hull or Compound as their shape (Physics tab, Collisions)",
        )


def hanging_in_the_air(home: Examined) -> Iterator[Found]:
    """Yield a finding for each pad without parent, rigid body, or surface close below."""
    for pad in home.requiring(FORCES):
        if pad.object.parent is not None or pad.object.rigid_body is not None:
            continue
        solids = home.home.caster.solids
        rows = solids.owned_by(pad.uid)
        lo, hi = solids.lo[rows], solids.hi[rows]
        if not len(lo) or not np.isfinite(lo).all():
            continue
        middle = (lo.min(axis=0) + hi.max(axis=0)) / 2.0
        start = np.array([[middle[0], middle[1], hi[:, 2].max()]])
        length = np.array([float(hi[:, 2].max() - lo[:, 2].min()) + GAP / home.metres])
        down = np.array([[0.0, 0.0, -1.0]])
        hit = home.home.caster.cast_solids(pad.uid, BUNDLE, start, down, length)[1]
        if hit[0] == NOTHING:
            yield (
                f"'{pad.name}' hangs in the air: nothing is within {GAP * 100:g} cm below it",
                "Lower the pad onto the floor, which must have faces and be visible; or parent it "
                "to the object that it is part of",
                (pad.name,),
            )


def not_weighed(home: Examined) -> Iterator[Found]:
    """Yield a finding for each pad that cannot be valid: at the present frame, or under a chair.

    Scenes with rigid bodies are left out, because their bodies may still have to be simulated.
    """
    pads = [Pad(sensor.uid, sensor.object) for sensor in home.requiring(FORCES)]
    if not pads or home.scene.rigidbody_world is not None:
        return
    solids, frame = home.home.caster.solids, home.scene.frame_current
    tracker = ContactTracker(solids)
    tracker.pads = pads
    tracker.look(home.depsgraph, frame, [pad.uid for pad in pads])
    for pad in pads:
        if advice.without_surface(pad.original):
            continue
        name, problem = pad.original.name, tracker.forces(pad.uid, frame).problem
        if problem not in ("", NOT_YET):
            what, _, mend = problem.partition(": ")
            yield (
                f"'{name}' is not valid at frame {frame}: {what}",
                capital(mend) or "Move it onto a surface, or away from the pad",
                (name,),
            )
        for cover in tracker.furniture(pad.uid):
            yield (
                f"'{cover}' stands on '{name}' with some of its parts and has no mass: while "
                "somebody is on it, the pad is not valid",
                f"Give '{cover}' a mass (Physics tab, Weight on Sensors)",
                (name, cover),
            )


def caches(home: Examined) -> Iterator[Found]:
    """Yield findings of a rigid-body cache that is too short or old, and of late releases."""
    if home.requiring(FORCES):
        yield from filter(None, (advice.short_cache(home.scene), advice.outdated_cache(home.scene)))
    yield from filter(None, [advice.late_releases(home.scene)])


# Checks of numbers with units, in scenes whose unit is not the metre.


def units(home: Examined) -> Iterator[Found]:
    """Yield findings on numbers that Blender's fields show otherwise than sensors take them."""
    metres, scene = home.metres, home.scene
    if metres == 1.0:
        return
    bodies = list(advice.simulated_bodies(scene)) if home.requiring(FORCES) else []
    masses = {
        body.name: (body.rigid_body.mass * metres**VOLUME, kilograms(body.rigid_body, metres))
        for body in bodies
    }
    powers = {
        lamp.name: (
            peak_power(lamp.data) * metres**AREA,
            peak_power(lamp.data) * watts_factor(lamp.data, metres),
        )
        for lamp in (_lamps(home) if home.requiring(LIGHT) else ())
        if lamp.data.type != "SUN"
    }
    for what, unit, found, where in (
        ("mass", "kg", masses, "Mass (Physics tab, Rigid Body)"),
        ("power", "W", powers, "Power (Light tab)"),
    ):
        apart = {name: pair for name, pair in found.items() if pair[0] != pair[1]}
        if apart:
            shown, taken = next(iter(apart.values()))
            yield (
                f"At Unit Scale {metres:g}, Blender shows a {what} of {shown:.3g} {unit}, and "
                f"sensors take {taken:.3g} {unit}: {named(sorted(apart))}",
                f"Type the {what} into {where}, so that both agree",
                tuple(sorted(apart)),
            )
    stored = float(np.linalg.norm(scene.gravity))
    true = stored * gravity_factor(scene.gravity, metres)
    if home.requiring(FORCES) and scene.use_gravity and true != stored * metres:
        yield (
            f"At Unit Scale {metres:g}, Blender's gravity is {stored * metres:.3g} m/s², and pads "
            f"take {true:.3g} m/s²: rigid bodies fall too {'slowly' if metres < 1 else 'fast'}",
            f"Type {true:.3g} m/s² into Gravity (Scene tab), so that both agree",
        )


# Checks of the light on light sensors.

# W/m² of light. The sun gives no more.
MOST_SUN = 150.0
USUAL_LUMENS = 800


def electrical_watts(home: Examined) -> Iterator[Found]:
    """Yield a finding for each lamp whose power is so high that it is probably electrical."""
    if not home.requiring(LIGHT):
        return
    efficacy = home.scene.angen_luminous_efficacy
    for lamp in _lamps(home):
        data, sun = lamp.data, lamp.data.type == "SUN"
        most, unit = (MOST_SUN, "W/m²") if sun else (WATTS.most, "W")
        power = peak_power(data) * watts_factor(data, home.metres)
        if power <= most:
            continue
        what = "lx" if sun else "lm"
        usual = (
            "up to 100 W/m² at noon"
            if sun
            else f"{USUAL_LUMENS / efficacy:.2g} W for a household lamp of {USUAL_LUMENS} lm"
        )
        yield (
            f"'{lamp.name}' shines with {power:g} {unit} of light, "
            f"{power * efficacy:,.0f} {what}: is that the lamp's electrical power?",
            f"Blender's watts are watts of light. In the Light tab, set "
            f"{'Strength' if sun else 'Power'} to the lumens divided by {efficacy:g}. "
            f"Usual: {usual}",
            (lamp.name,),
        )


def none_lit(home: Examined) -> Iterator[Found]:
    """Yield a finding if there are light sensors, but nothing in the scene shines."""
    sensors = home.requiring(LIGHT)
    lit = any(lamp.data.energy > 0 or is_animated(lamp.data, "energy") for lamp in _lamps(home))
    if not sensors or lit or _world_shines(home.scene.world) or _something_shines(home):
        return
    yield (
        f"No lamp, sky or glowing surface lights {named(s.name for s in sensors)}",
        "Add a lamp (Shift+A, Light) or a sky (World tab, Color), or show hidden lamps",
        tuple(s.name for s in sensors),
    )


def opaque_glass(home: Examined) -> Iterator[Found]:
    """Yield a finding for each glass that keeps lamps and the sun from light sensors."""
    if home.requiring(LIGHT):
        yield from sensing.opaque_glass(home.view_layer)


def eevee_cannot_run(home: Examined) -> Iterator[Found]:
    """Yield a finding if light sensors are set to EEVEE and it cannot run here."""
    sensors = [s for s in home.requiring(LIGHT) if getattr(s.parameters, "engine", "") == "EEVEE"]
    reason = why_no_eevee() if sensors else ""
    if reason:
        names = tuple(s.name for s in sensors)
        yield f"{named(names)}: {reason}", "Set Engine to Cycles", names


def _lamps(home: Examined) -> list[Any]:
    lamps = dict.fromkeys(obj for obj, _ in home.seen if obj.type == "LIGHT")
    return [lamp for lamp in lamps if not is_portal(lamp)]


def _world_shines(world: Any) -> bool:
    if world is None:
        return False
    if not has_nodes(world):
        return any(part > 0 for part in world.color)
    return any(_gives_light(node) for node in world.node_tree.nodes if node.type == "BACKGROUND")


def _gives_light(node: Any) -> bool:
    """Return whether an emission or background node gives light, or may do so by a linked input."""
    strength = next((s for s in node.inputs if s.name in {"Strength", "Emission Strength"}), None)
    names = {"Color", "Emission Color", "Emission"}
    colour = next((s for s in node.inputs if s.name in names), None)
    lit = strength is None or strength.is_linked or strength.default_value > 0
    coloured = (
        colour is None or colour.is_linked or any(part > 0 for part in colour.default_value[:3])
    )
    return bool(lit and coloured)


def _something_shines(home: Examined) -> bool:
    return any(
        _gives_light(node)
        for obj in home.shown()
        for slot in obj.material_slots
        if slot.material is not None and slot.material.node_tree is not None
        for node in slot.material.node_tree.nodes
        if node.type in {"EMISSION", "BSDF_PRINCIPLED"}
    )
