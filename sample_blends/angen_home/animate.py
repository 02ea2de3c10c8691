# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns the story into keyframes: person, doors, fridge, lamps, props. `plan.FPS` frames a second.

`add_person_and_story` comes last when the home is built: it finds the home's objects by name.
"""

from math import ceil, radians

import bpy
import numpy as np
from angen_sensors.residents.acting.timeline import Acted, Hold, Switch
from angen_sensors.residents.blender.keys import CONSTANT, TILT, Curves
from angen_sensors.residents.blender.person import add_person, body_of
from angen_sensors.residents.body.pose import BodyPose
from angen_sensors.residents.body.poses import palm, upright
from angen_sensors.residents.body.solve import Bones, channels, solve
from angen_sensors.residents.body.turns import about_z, ease, mix, mix_turns, turned
from angen_sensors.residents.body.turns import times as composed

from . import plan
from .director import direct
from .keys import bake
from .meshes import collection
from .stage import GRIPS, leaf_yaw

# What a straight line between two keys may miss.
TURN_TOLERANCE = 5e-4  # of a quaternion's component: 0.06°
PLACE_TOLERANCE = 8e-4  # m
YAW_TOLERANCE = 1e-3  # rad
# How it is turned there: a coat edgeways, to fit through doors.
CARRIED_YAW = {"Coat": radians(-90)}
_STILL = np.array([1.0, 0.0, 0.0, 0.0])


def add_person_and_story(scene: bpy.types.Scene) -> Acted:
    """Adds the person and what the person carries, and animates the whole story."""
    acted = direct()
    animate(scene, add_story_person(), acted)
    return acted


def add_story_person() -> bpy.types.Object:
    """The armature "Person rig" with its mesh "Person"; returns the armature."""
    rig = add_person(collection("People"), name="Person rig")
    body_of(rig).name = body_of(rig).data.name = "Person"
    return rig


def animate(scene: bpy.types.Scene, rig: bpy.types.Object, acted: Acted) -> None:
    """Keyframes of what one person did, for the armature and the home's objects."""
    (line,) = acted.bodies.values()
    frames = ceil(line.duration * plan.FPS)
    scene.render.fps, scene.render.fps_base = plan.FPS, 1.0
    scene.frame_start, scene.frame_end = 1, frames
    times = np.arange(frames) / plan.FPS
    pose = line.poses(times)
    bones = solve(pose)
    _bake_person(rig, pose, bones)
    for name in acted.holds:
        _bake_prop(_object(name), acted, times, pose, bones)
    for name in acted.swings:
        yaws = np.radians(leaf_yaw(acted, name, times))
        bake(Curves(_object(name), f"Story {name}"), "rotation_euler", 2, yaws, YAW_TOLERANCE)
    _key_lamps(acted.switches)
    scene.frame_set(1)


def _object(name: str) -> bpy.types.Object:
    obj = bpy.data.objects.get(name)
    if obj is None:
        raise ValueError(f"the story needs an object {name!r}, which the home does not have")
    return obj


def _bake_person(rig: bpy.types.Object, pose: BodyPose, bones: Bones) -> None:
    rest = {b.name: np.array(b.matrix_local.to_quaternion()) for b in rig.data.bones}
    curves = Curves(rig, "Story person")
    for path, axis, values in channels(pose, rest, bones):
        tolerance = PLACE_TOLERANCE if path.endswith("location") else TURN_TOLERANCE
        bake(curves, path, axis, values, YAW_TOLERANCE if "euler" in path else tolerance)


def _bake_prop(
    prop: bpy.types.Object, acted: Acted, times: np.ndarray, pose: BodyPose, bones: Bones
) -> None:
    holds = acted.holds[prop.name]
    at, turn = np.zeros((len(times), 3)), np.zeros((len(times), 4))
    tilt = sum((TILT * sip.weight(times) for sip in acted.sips.get(prop.name, ())), 0 * times)
    carried = composed(upright(pose, tilt), about_z(CARRIED_YAW.get(prop.name, 0.0)))
    offset = turned(carried, GRIPS[prop.name])
    palms = [palm(bones, side, pose.build.scale) for side in (0, 1)]

    def state(hold: Hold, i: int) -> tuple[np.ndarray, np.ndarray]:
        if hold.hand is None:
            return hold.at, _STILL
        return palms[hold.hand][i] - offset[i], carried[i]

    for i, t in enumerate(times):
        k = max((k for k, hold in enumerate(holds) if hold.start <= t + 1e-9), default=0)
        where, how = state(holds[k], i)
        if k and t - holds[k].start < 0.3:  # from hand to table without a jump
            before = state(holds[k - 1], i)
            share = ease((t - holds[k].start) / 0.3)
            where, how = mix(before[0], where, share), mix_turns(before[1], how, share)
        at[i], turn[i] = where, how
    prop.rotation_mode = "QUATERNION"
    curves = Curves(prop, f"Story {prop.name}")
    flips = np.sign((turn[1:] * turn[:-1]).sum(1))
    turn[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
    for axis in range(3):
        bake(curves, "location", axis, at[:, axis], PLACE_TOLERANCE)
    for axis in range(4):
        bake(curves, "rotation_quaternion", axis, turn[:, axis], 2 * TURN_TOLERANCE)


def _key_lamps(switches: list[Switch]) -> None:
    switched: dict[str, list[tuple[float, bool]]] = {}
    for one in switches:
        switched.setdefault(one.object, []).append((one.time, one.on))
    for name, changes in switched.items():
        lamp = _object(name).data
        states = [(0.0, not changes[0][1]), *changes]
        frames = [1.0 + round(t * plan.FPS) for t, _ in states]
        values = [lamp.energy if on else 0.0 for _, on in states]
        first = 1 if frames[1] <= frames[0] else 0
        Curves(lamp, f"Story {name}").write("energy", 0, frames[first:], values[first:], CONSTANT)
