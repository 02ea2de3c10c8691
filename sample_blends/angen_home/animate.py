# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns the story into keyframes: person, doors, fridge, lamps, props. `plan.FPS` frames a second.

`add_person_and_story` comes last when the home is built: it finds the home's objects by name.
"""

from collections.abc import Sequence
from math import ceil, radians

import bpy
import numpy as np
from mathutils import Quaternion, Vector

from . import plan
from .director import GRIPS, HINGED, direct
from .keys import Keys
from .meshes import MeshBuilder, collection, place
from .person import add_person
from .pose import Pose, about_z, ease, solve
from .skeleton import HEAD, PARENT
from .story import SPOTS
from .timeline import Hold, Timeline, palm, upright

# What a straight line between two keys may miss.
TURN_TOLERANCE = 5e-4  # of a quaternion's component: 0.06°
PLACE_TOLERANCE = 8e-4  # m
YAW_TOLERANCE = 1e-3  # rad
# How it is turned there: a coat edgeways, to fit through doors.
CARRIED_YAW = {"Coat": radians(-90)}


def add_person_and_story(scene: bpy.types.Scene) -> Timeline:
    """Adds the person and what the person carries, and animates the whole story."""
    line = direct()
    _add_bottle()
    rig = add_person(collection("People"))
    animate(scene, rig, line)
    return line


def animate(scene: bpy.types.Scene, rig: bpy.types.Object, line: Timeline) -> None:
    """Keyframes of a timeline for the person's armature and the home's objects."""
    frames = ceil(line.duration * plan.FPS)
    scene.render.fps, scene.render.fps_base = plan.FPS, 1.0
    scene.frame_start, scene.frame_end = 1, frames
    times = np.arange(frames) / plan.FPS
    poses = [line.pose(float(t)) for t in times]
    bones = [solve(pose) for pose in poses]
    _bake_person(rig, poses, [turn for turn, _ in bones])
    for name, holds in line.props.items():
        _bake_prop(_object(name), holds, times, poses, bones, line)
    _bake_leaves(line, times)
    _key_lamps(line)
    scene.frame_set(1)


def _object(name: str) -> bpy.types.Object:
    obj = bpy.data.objects.get(name)
    if obj is None:
        raise ValueError(f"the story needs an object {name!r}, which the home does not have")
    return obj


def local_turns(
    pose: Pose, turn: dict[str, Quaternion], rest: dict[str, Quaternion]
) -> dict[str, Quaternion]:
    """The pose bones' own quaternions: each against its parent, in its bone's axes."""
    out = {}
    for bone, world in turn.items():
        above = PARENT[bone]
        base = turn[above] if above else about_z(pose.heading)
        out[bone] = rest[bone].inverted() @ base.inverted() @ world @ rest[bone]
    return out


def _bake_person(
    rig: bpy.types.Object, poses: Sequence[Pose], turns: Sequence[dict[str, Quaternion]]
) -> None:
    rest = {bone.name: bone.matrix_local.to_quaternion() for bone in rig.data.bones}
    local = [local_turns(p, t, rest) for p, t in zip(poses, turns, strict=True)]
    keys = Keys(rig, "Story person")
    root = np.array([(p.pelvis.x, p.pelvis.y, plan.FLOOR_Z) for p in poses])
    for axis in range(3):
        keys.bake("location", axis, root[:, axis], PLACE_TOLERANCE)
    keys.bake("rotation_euler", 2, np.array([p.heading for p in poses]), YAW_TOLERANCE)
    lift = [Vector((0, 0, p.pelvis.z - plan.FLOOR_Z - HEAD["pelvis"][2])) for p in poses]
    moved = np.array([rest["pelvis"].inverted() @ v for v in lift])
    for axis in range(3):
        keys.bake('pose.bones["pelvis"].location', axis, moved[:, axis], PLACE_TOLERANCE)
    for bone in rest:
        values = np.array([q[bone] for q in local])
        # A quaternion and its negative are the same turn: stay on one side.
        flips = np.sign((values[1:] * values[:-1]).sum(1))
        values[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
        for axis in range(4):
            path = f'pose.bones["{bone}"].rotation_quaternion'
            keys.bake(path, axis, values[:, axis], TURN_TOLERANCE)


def _bake_prop(
    prop: bpy.types.Object, holds: list[Hold], times: np.ndarray, poses: Sequence[Pose],
    bones: Sequence[tuple[dict, dict]], line: Timeline,
) -> None:  # fmt: skip
    grip = Vector(GRIPS[prop.name])
    at, turn = np.zeros((len(times), 3)), np.zeros((len(times), 4))

    def state(hold: Hold, i: int) -> tuple[Vector, Quaternion]:
        if hold.hand is None:
            return hold.at, Quaternion()
        t = float(times[i])
        tilt = sum(1.45 * g.weight(t) for g in line.tilts.get(prop.name, ()))
        q = upright(poses[i], tilt) @ about_z(CARRIED_YAW.get(prop.name, 0.0))
        return palm(bones[i], hold.hand) - q @ grip, q

    for i, t in enumerate(times):
        k = max((k for k, hold in enumerate(holds) if hold.start <= t + 1e-9), default=0)
        where, how = state(holds[k], i)
        if k and t - holds[k].start < 0.3:  # from hand to table without a jump
            before = state(holds[k - 1], i)
            share = ease((t - holds[k].start) / 0.3)
            where, how = before[0].lerp(where, share), before[1].slerp(how, share)
        at[i], turn[i] = where, how
    prop.rotation_mode = "QUATERNION"
    keys = Keys(prop, f"Story {prop.name}")
    flips = np.sign((turn[1:] * turn[:-1]).sum(1))
    turn[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
    for axis in range(3):
        keys.bake("location", axis, at[:, axis], PLACE_TOLERANCE)
    for axis in range(4):
        keys.bake("rotation_quaternion", axis, turn[:, axis], 2 * TURN_TOLERANCE)


def _bake_leaves(line: Timeline, times: np.ndarray) -> None:
    closed = {f"Door {name}": door.closed_yaw for name, door in plan.DOORS.items()}
    closed |= {name: thing.closed_yaw for name, thing in HINGED.items()}
    for name in line.swings:
        yaws = np.array([radians(line.yaw(name, float(t), closed[name])) for t in times])
        Keys(_object(name), f"Story {name}").bake("rotation_euler", 2, yaws, YAW_TOLERANCE)


def _key_lamps(line: Timeline) -> None:
    switched: dict[str, list[tuple[float, bool]]] = {}
    for t, name, on in line.lamps:
        switched.setdefault(name, []).append((t, on))
    for name, changes in switched.items():
        lamp = _object(name).data
        states = [(0.0, not changes[0][1]), *changes]
        frames = [1.0 + round(t * plan.FPS) for t, _ in states]
        values = [lamp.energy if on else 0.0 for _, on in states]
        first = 1 if frames[1] <= frames[0] else 0
        keys = Keys(lamp, f"Story {name}")
        keys.add("energy", 0, frames[first:], values[first:], "CONSTANT")


def _add_bottle() -> None:
    b = MeshBuilder("green")
    b.lathe(
        [(0, 0), (0.030, 0), (0.034, 0.006), (0.034, 0.13), (0.028, 0.16), (0.014, 0.19),
         (0.013, 0.215), (0.015, 0.217), (0.015, 0.23), (0, 0.23)], segments=16,
    )  # fmt: skip
    b.cylinder((0, 0, 0.035), 0.0345, 0.075, 16, "paper")
    place("Bottle", b, "People", SPOTS["fridge shelf"])
