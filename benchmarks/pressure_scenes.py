# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes of known statics, and what their pads read."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph
from angen_sensors.angen_addon.scene.sensors import all_sensors

Array = np.typing.NDArray[np.float64]
Vec = Sequence[float]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
# What moves is made with Blender's own shapes: (operator, its settings for a radius).
ROUND = {
    "SPHERE": ("uv_sphere", lambda r: {"radius": r}),
    "CAPSULE": ("cylinder", lambda r: {"radius": r / 2, "depth": 2 * r}),
    "CYLINDER": ("cylinder", lambda r: {"radius": r, "depth": 2 * r}),
    "ICOSAHEDRON": ("ico_sphere", lambda r: {"radius": r, "subdivisions": 1}),
    "CONE": ("cone", lambda r: {"radius1": r, "depth": 2 * r}),
}


def new_scene(fps: int = 24, last: int = 48, substeps: int = 10, iterations: int = 10) -> Any:
    """An empty file with a rigid-body world; frames 1 … `last`."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, last, fps
    # Values at the playhead would be sensed a second time.
    scene.angen_live = False
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new("RigidBodyWorld")
    world.substeps_per_frame, world.solver_iterations = substeps, iterations
    world.point_cache.frame_end = last + 1
    return scene


def box_mesh(parts: Sequence[tuple[Vec, Vec]]) -> Any:
    """A mesh of boxes, each (half size, middle)."""
    points: list[Any] = []
    faces: list[Any] = []
    for half, middle in parts:
        first = len(points)
        signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        points += [tuple(m + s * h for m, s, h in zip(middle, sign, half, strict=True))
                   for sign in signs]  # fmt: skip
        faces += [tuple(first + i for i in face) for face in FACES]
    mesh = bpy.data.meshes.new("boxes")
    mesh.from_pydata(points, [], faces)
    return mesh


def add(name: str, mesh: Any, at: Vec, parent: Any = None, rotation: Any = None) -> Any:
    obj = bpy.data.objects.new(name, mesh)
    obj.location = at
    obj.parent = parent
    if rotation is not None:
        obj.rotation_mode = "QUATERNION"
        obj.rotation_quaternion = rotation
    bpy.context.scene.collection.objects.link(obj)
    return obj


def rigid(obj: Any, kind: str, mass: float = 1.0, shape: str = "BOX", **settings: Any) -> Any:
    """Makes an object a rigid body; returns the object."""
    bpy.context.scene.rigidbody_world.collection.objects.link(obj)
    body = obj.rigid_body
    body.type, body.mass, body.collision_shape = kind, mass, shape
    for name, value in settings.items():
        setattr(body, name, value)
    return obj


def floor(at: Vec = (0, 0, -0.5), half: Vec = (6, 6, 0.5), **settings: Any) -> Any:
    rotation = settings.pop("rotation", None)
    obj = add("floor", box_mesh([(half, (0, 0, 0))]), at, rotation=rotation)
    return rigid(obj, "PASSIVE", **settings)


def pad(name: str, half: Vec, at: Vec, physics: bool = True, **settings: Any) -> Any:
    """A pad that senses at every frame; `physics`: whether things rest on it in the engine."""
    rotation = settings.pop("rotation", None)
    obj = add(name, box_mesh([(half, (0, 0, 0))]), at, rotation=rotation)
    obj.angen_sensor.kind = "PRESSURE"
    obj.angen_sensor.update_rate = bpy.context.scene.render.fps
    return rigid(obj, "PASSIVE", **settings) if physics else obj


def box(name: str, half: Vec, at: Vec, mass: float, **settings: Any) -> Any:
    rotation = settings.pop("rotation", None)
    obj = add(name, box_mesh([(half, (0, 0, 0))]), at, rotation=rotation)
    return rigid(obj, "ACTIVE", mass, **settings)


def solid(name: str, shape: str, radius: float, at: Vec, mass: float, **settings: Any) -> Any:
    """A body of any of Blender's collision shapes, `radius` the half of its height. `form`: what
    its mesh is, where that is not the shape; a hull or a mesh is a box else."""
    rotation = settings.pop("rotation", None)
    form = settings.pop("form", shape)
    if form in ROUND:
        operator, sizes = ROUND[form]
        getattr(bpy.ops.mesh, f"primitive_{operator}_add")(**sizes(radius))
        obj = bpy.context.object
        obj.name, obj.location = name, at
        if rotation is not None:
            obj.rotation_mode, obj.rotation_quaternion = "QUATERNION", rotation
    else:
        obj = add(name, box_mesh([((radius,) * 3, (0, 0, 0))]), at, rotation=rotation)
    return rigid(obj, "ACTIVE", mass, shape, **settings)


def compound(name: str, parts: Sequence[tuple[Vec, Vec]], at: Vec, mass: float) -> Any:
    """A body of boxes, its centre of mass at `at`."""
    obj = rigid(add(name, box_mesh(parts), at), "ACTIVE", mass, "COMPOUND")
    for index, (half, middle) in enumerate(parts):
        part = add(f"{name} {index}", box_mesh([(half, (0, 0, 0))]), middle, parent=obj)
        rigid(part, "ACTIVE")
    return obj


def carried(name: str, half: Vec, at: Vec, mass: float) -> Any:
    """An animated body: a mass without physics."""
    obj = add(name, box_mesh([(half, (0, 0, 0))]), at)
    obj.angen_load.mass = mass
    return obj


@dataclass
class Track:
    """What one pad read, an entry a frame: newtons, whether valid, share left unexplained."""

    force: list[float] = field(default_factory=list)
    valid: list[bool] = field(default_factory=list)
    residual: list[float] = field(default_factory=list)
    problems: set[str] = field(default_factory=set)


@dataclass
class Followed:
    """Tracks by pad, seconds a frame that sensing took, and poses of the bodies that were asked
    for (frames, 4, 4)."""

    tracks: dict[str, Track]
    seconds: list[float]
    poses: dict[str, Array]


def follow(scene: Any, watched: Sequence[Any] = ()) -> Followed:
    """Plays the scene from its start and reads all pads at every frame, as a run does, its time
    apart from that of Blender's own evaluation of the frame."""
    bpy.context.view_layer.update()
    clock = clock_of(scene)
    runners = [SensorRunner(sensor, clock) for sensor in all_sensors(bpy.context.view_layer)]
    pads = [runner.sensor for runner in runners]
    probes = Probes(scene)
    probes.serve(runner.sensor for runner in runners)
    done = Followed({pad.name: Track() for pad in pads}, [], {})
    poses: dict[str, list[Array]] = {obj.name: [] for obj in watched}
    waiting: list[Any] = []
    for step in range(scene.frame_end - scene.frame_start + 2):
        scene.frame_set(scene.frame_start + step)
        depsgraph = evaluated_depsgraph()
        for obj in watched:
            poses[obj.name].append(np.array(obj.evaluated_get(depsgraph).matrix_world))
        begin = time.perf_counter()
        probes.look(depsgraph, scene.frame_current, pads)
        readings = [taken.reading() for taken in waiting]
        waiting = [runner.take(step, step, depsgraph, probes) for runner in runners]
        done.seconds.append(time.perf_counter() - begin)
        for pad, reading in zip(pads, readings, strict=False):
            track = done.tracks[pad.name]
            track.force.append(reading.fields["force_n"])
            track.valid.append(bool(reading.fields["valid"]))
            track.residual.append(reading.fields["residual"])
            track.problems |= {reading.fields["problem"]} - {""}
    done.poses = {name: np.array(found) for name, found in poses.items()}
    return done
