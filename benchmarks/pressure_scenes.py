# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes of known statics, with what their pads read and what MuJoCo computes."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner, single_update
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph

from .common import box_mesh, has, link, new_scene, sensors_of

Array = np.typing.NDArray[np.float64]
Vec = Sequence[float]
# Moving bodies are Blender's own shapes: (operator, its arguments for a radius).
ROUND = {
    "SPHERE": ("uv_sphere", lambda r: {"radius": r}),
    "CAPSULE": ("cylinder", lambda r: {"radius": r / 2, "depth": 2 * r}),
    "CYLINDER": ("cylinder", lambda r: {"radius": r, "depth": 2 * r}),
    "ICOSAHEDRON": ("ico_sphere", lambda r: {"radius": r, "subdivisions": 1}),
    "CONE": ("cone", lambda r: {"radius1": r, "depth": 2 * r}),
}
STEP = 0.001
SETTLING, SECONDS = 3.0, 3.5
HEAD = f"""<mujoco><option timestep="{STEP}" gravity="0 0 -9.81" cone="elliptic" iterations="300"
tolerance="1e-12"/><default><geom friction="0.5 0 0" solref="0.004 1" margin="0"/></default>
<worldbody>"""


def new_world(fps: int = 24, last: int = 48) -> Any:
    """Return an empty file with a rigid-body world and frames 1 … `last`."""
    scene = new_scene(fps, last)
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new("RigidBodyWorld")
    world.substeps_per_frame, world.solver_iterations = 10, 10
    world.point_cache.frame_end = last + 1
    return scene


def rigid(obj: Any, kind: str, mass: float = 1.0, shape: str = "BOX", **settings: Any) -> Any:
    """Make an object a rigid body, and return it."""
    rotation = settings.pop("rotation", None)
    if rotation is not None:
        obj.rotation_mode, obj.rotation_quaternion = "QUATERNION", rotation
    bpy.context.scene.rigidbody_world.collection.objects.link(obj)
    body = obj.rigid_body
    body.type, body.mass, body.collision_shape = kind, mass, shape
    for name, value in settings.items():
        setattr(body, name, value)
    return obj


def _box(name: str, half: Vec, at: Vec, parent: Any = None) -> Any:
    return link(name, box_mesh([(half, (0, 0, 0))]), at, parent)


def floor(at: Vec = (0, 0, -0.5), half: Vec = (6, 6, 0.5), **settings: Any) -> Any:
    return rigid(_box("floor", half, at), "PASSIVE", **settings)


def pad(name: str, half: Vec, at: Vec, physics: bool = True, **settings: Any) -> Any:
    """Add a pad that senses at every frame; `physics`: whether it is a rigid body too."""
    obj = _box(name, half, at)
    obj.angen_sensor.kind = "PRESSURE"
    obj.angen_sensor.update_rate = bpy.context.scene.render.fps
    return rigid(obj, "PASSIVE", **settings) if physics else obj


def box(name: str, half: Vec, at: Vec, mass: float, **settings: Any) -> Any:
    return rigid(_box(name, half, at), "ACTIVE", mass, **settings)


def solid(name: str, shape: str, radius: float, at: Vec, mass: float, **settings: Any) -> Any:
    """Add a body of any of Blender's collision shapes, with half its height as `radius`.

    `form` is the shape of its mesh, if this is not the collision shape. A hull or a mesh is a box
    without `form`.
    """
    form = settings.pop("form", shape)
    if form in ROUND:
        operator, sizes = ROUND[form]
        getattr(bpy.ops.mesh, f"primitive_{operator}_add")(**sizes(radius))
        obj = bpy.context.object
        obj.name, obj.location = name, at
    else:
        obj = _box(name, (radius,) * 3, at)
    return rigid(obj, "ACTIVE", mass, shape, **settings)


def compound(name: str, parts: Sequence[tuple[Vec, Vec]], at: Vec, mass: float) -> Any:
    """Add a body of boxes with its centre of mass at `at`."""
    obj = rigid(link(name, box_mesh(parts), at), "ACTIVE", mass, "COMPOUND")
    for index, (half, middle) in enumerate(parts):
        rigid(_box(f"{name} {index}", half, middle, obj), "ACTIVE")
    return obj


def carried(name: str, half: Vec, at: Vec, mass: float) -> Any:
    """Add an animated body: a mass without physics."""
    obj = _box(name, half, at)
    obj.angen_load.mass = mass
    return obj


@dataclass
class Track:
    """Readings of one pad, an entry per frame: newtons, whether valid, share left unexplained."""

    force: list[float] = field(default_factory=list)
    valid: list[bool] = field(default_factory=list)
    residual: list[float] = field(default_factory=list)
    problems: set[str] = field(default_factory=set)


@dataclass
class Followed:
    """Tracks by pad, seconds of sensing per frame, and poses of watched bodies (frames, 4, 4)."""

    tracks: dict[str, Track]
    seconds: list[float]
    poses: dict[str, Array]


def follow(scene: Any, watched: Sequence[Any] = ()) -> Followed:
    """Play the scene from its start, and read all pads at every frame, as a run does.

    Sensing is timed without Blender's own evaluation of the frame.
    """
    bpy.context.view_layer.update()
    clock = clock_of(scene)
    runners = [SensorRunner(sensor, clock) for sensor in sensors_of()]
    pads = [runner.sensor for runner in runners]
    probes = Probes(scene)
    probes.set_sensors(runner.sensor for runner in runners)
    done = Followed({pad.name: Track() for pad in pads}, [], {})
    poses = defaultdict[str, list[Array]](list)
    waiting: list[Any] = []
    for step in range(scene.frame_end - scene.frame_start + 2):
        scene.frame_set(scene.frame_start + step)
        depsgraph = evaluated_depsgraph()
        for obj in watched:
            poses[obj.name].append(np.array(obj.evaluated_get(depsgraph).matrix_world))
        begin = time.perf_counter()
        probes.look(depsgraph, step)
        probes.look_at_motion(scene.frame_current, pads)
        readings, before = [], scene.frame_current - 1
        for update in waiting:
            update.give_forces({before: probes.forces(update.runner.uid, before)})
            readings.append(update.reading())
        waiting = [single_update(runner, step, step, probes) for runner in runners]
        done.seconds.append(time.perf_counter() - begin)
        for pad, reading in zip(pads, readings, strict=False):
            track = done.tracks[pad.name]
            track.force.append(reading.fields["force_n"])
            track.valid.append(bool(reading.fields["valid"]))
            track.residual.append(reading.fields["residual"])
            track.problems |= {reading.fields["problem"]} - {""}
    done.poses = {name: np.array(found) for name, found in poses.items()}
    return done


def mujoco_forces() -> dict[str, float] | None:
    """Return the newtons on each pad of the present scene at rest, by MuJoCo.

    They are means over half a second; None without MuJoCo, or with a shape that MuJoCo lacks.
    """
    text = _mujoco_text() if has("mujoco") else None
    if text is None:
        return None
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    pads = {sensor.name: 0.0 for sensor in sensors_of("PRESSURE")}
    force = np.zeros(6)
    steps = round((SECONDS - SETTLING) / STEP)
    for step in range(round(SECONDS / STEP)):
        mujoco.mj_step(model, data)
        if step * STEP < SETTLING:
            continue
        for index in range(data.ncon):
            names = [model.geom(geom).name for geom in data.contact[index].geom]
            for name in set(names) & set(pads):
                mujoco.mj_contactForce(model, data, index, force)
                pads[name] += force[0] / steps
    return pads


def _mujoco_text() -> str | None:
    text = HEAD
    for obj in bpy.context.scene.objects:
        body = obj.rigid_body
        mass = obj.angen_load.mass
        if obj.parent is not None or (body is None and mass == 0.0):
            continue
        is_compound = body is not None and body.collision_shape == "COMPOUND"
        family = list(obj.children) if is_compound else [obj]
        geoms = [_geom(part, None if part is obj else part.location) for part in family]
        if None in geoms:
            return None
        turn = numbers(obj.matrix_world.to_quaternion())
        text += f'<body name="{obj.name}" pos="{numbers(obj.location)}" quat="{turn}">'
        if body is None or body.type == "ACTIVE":
            mass = mass or body.mass
            inertia = numbers([mass * max(obj.dimensions) ** 2 / 10.0] * 3)
            text += f'<freejoint/><inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia}"/>'
        text += "".join(str(geom) for geom in geoms) + "</body>"
    return text + "</worldbody></mujoco>"


def _geom(obj: Any, at: Any) -> str | None:
    shape = obj.rigid_body.collision_shape if obj.rigid_body is not None else "BOX"
    x, y, z = (np.ptp([vertex.co for vertex in obj.data.vertices], axis=0) / 2.0).tolist()
    if shape == "CONE":
        return None
    # The hulls and meshes of these benchmarks are boxes.
    sizes = {"SPHERE": (x,), "CAPSULE": (x, z - x), "CYLINDER": (x, z)}.get(shape, (x, y, z))
    kind = "box" if len(sizes) == 3 else shape.lower()
    place = "" if at is None else f'pos="{numbers(at)}"'
    return f'<geom name="{obj.name}" type="{kind}" size="{numbers(sizes)}" {place}/>'


def numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)
