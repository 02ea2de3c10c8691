# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, rooms and sensors of known light, for the tests of the light probe."""

from __future__ import annotations

import math
from importlib import import_module
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

PROBE = "bl_ext.user_default.angen_sensors.angen_addon.scene"
UP = (0.0, 0.0, 1.0)


def part(name: str) -> Any:
    return import_module(f"{PROBE}.{name}")


def facing(normal: Any, at: Any = (0, 0, 0)) -> np.ndarray:
    """Return the pose of a sensor whose −Z points along `normal`."""
    turn = (-Vector(normal)).to_track_quat("Z", "Y").to_matrix().to_4x4()
    return np.array(Matrix.Translation(at) @ turn, np.float64)


def nodes_instance(world: Any, shown: Any, at: tuple[float, float, float]) -> Any:
    """Add a box whose geometry nodes make an instance of an object in its place."""
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    node = tree.nodes.new("GeometryNodeObjectInfo")
    node.inputs["Object"].default_value, node.inputs["As Instance"].default_value = shown, True
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(node.outputs["Geometry"], out.inputs[0])
    box = world.box((0.1, 0.1, 0.1), at, "by nodes")
    box.modifiers.new("nodes", "NODES").node_group = tree
    return box


def request(name: str = "sensor", matrix: Any = None, **asked: Any) -> Any:
    """Return a request of the illuminance at the origin of a face that looks up, by default."""
    pose = facing(UP) if matrix is None else matrix
    return part("light.probe").LightRequest(name, pose, **{"method": "ILLUMINANCE", **asked})


def measure(*requests: Any, efficacy: float = 1.0) -> dict[str, Any]:
    """Return the light of all requests; with an efficacy of 1 an illuminance is in W/m²."""
    bpy.context.view_layer.update()
    scene, layer = bpy.context.scene, bpy.context.view_layer
    return dict(part("light.probe").measure(scene, layer, requests, efficacy))


def lux(*requests: Any) -> Any:
    """Return the illuminance of the only request, or of each."""
    found = measure(*(requests or (request(),)))
    values = [sample.illuminance_lux for sample in found.values()]
    return values[0] if len(values) == 1 else values


def percent(**asked: Any) -> float:
    (sample,) = measure(request(method="FOUR_WALL", **asked)).values()
    return sample.luminance_percent


def lamp(world: Any, kind: str, at: Any = (0, 0, 2), aim: Any = (0, 0, -1), **settings: Any) -> Any:
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = 1.0
    if kind in {"POINT", "SPOT"}:
        data.shadow_soft_size = 0.0
    if kind == "SUN":
        data.angle = 0.0
    for name, value in settings.items():
        setattr(data, name, value)
    obj = world.link(kind.lower(), data, at)
    obj.rotation_euler = (-Vector(aim)).to_track_quat("Z", "Y").to_euler()
    return obj


def sky(world: Any, radiance: float) -> Any:
    """Set a world of one radiance in all directions."""
    found = bpy.data.worlds.new("sky")
    if not found.node_tree:
        found.use_nodes = True
    node = next(n for n in found.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (1, 1, 1, 1)
    node.inputs["Strength"].default_value = radiance
    world.scene.world = found
    return found


def material(reflects: float = 0.0, glows: Any = 0.0, name: str = "material") -> Any:
    """Return a diffuse material of one reflectance, or one that glows with a radiance."""
    found = bpy.data.materials.new(name)
    if not found.node_tree:
        found.use_nodes = True
    nodes, links = found.node_tree.nodes, found.node_tree.links
    nodes.clear()
    if reflects:
        shader = nodes.new("ShaderNodeBsdfDiffuse")
        shader.inputs["Color"].default_value = (reflects, reflects, reflects, 1)
    else:
        shader = nodes.new("ShaderNodeEmission")
        colour = np.broadcast_to(glows, 3)
        shader.inputs["Color"].default_value = (*colour, 1)
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(shader.outputs[0], output.inputs["Surface"])
    return found


def plate(world: Any, size: float, at: Any, looks: Any, of: Any = None, name: str = "plate") -> Any:
    """Add a square that faces along `looks`."""
    h = size / 2
    mesh = world.mesh([(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)])
    if of is not None:
        mesh.materials.append(of)
    obj = world.link(name, mesh, at)
    obj.rotation_euler = Vector(looks).to_track_quat("Z", "Y").to_euler()
    return obj


def ball(world: Any, radius: float, of: Any, at: Any = (0, 0, 0), rings: int = 64) -> Any:
    """Add a closed sphere."""
    rows = np.linspace(0, math.pi, rings + 1)[1:-1]
    turns = np.linspace(0, 2 * math.pi, 2 * rings, endpoint=False)
    points = [(0, 0, radius)]
    points += [
        (
            radius * math.sin(a) * math.cos(b),
            radius * math.sin(a) * math.sin(b),
            radius * math.cos(a),
        )
        for a in rows
        for b in turns
    ]
    points.append((0, 0, -radius))
    n, last = len(turns), len(points) - 1
    faces: list[Any] = [(0, 1 + i, 1 + (i + 1) % n) for i in range(n)]
    for row in range(len(rows) - 1):
        a, b = 1 + row * n, 1 + (row + 1) * n
        faces += [(a + i, b + i, b + (i + 1) % n, a + (i + 1) % n) for i in range(n)]
    a = 1 + (len(rows) - 1) * n
    faces += [(a + i, last, a + (i + 1) % n) for i in range(n)]
    mesh = world.mesh(points, faces)
    mesh.materials.append(of)
    return world.link("ball", mesh, at)


def objects(name: str) -> Any:
    return bpy.data.objects[name]


def lit_room(world: Any) -> Any:
    """Add a room with lamps of all types, through which a screen moves."""
    box = world.box((4, 4, 4), name="room")
    box.data.materials.append(material(0.7, name="paint"))
    lamp(world, "POINT", at=(0, 0, 1), shadow_soft_size=0.1)
    lamp(world, "AREA", at=(1, 0, 1.9), size=0.5)
    plate(world, 0.8, (1, 1, 0), (-1, 0, 0), material(glows=0.2, name="screen"), "screen")
    world.key(objects("screen"), "location", {1: (1, 1, 0), 48: (-1, -1, 0)})
    sky(world, 0.5)
    world.update()
    return world


def key_lamp(frames: Any = (1, 5), energies: Any = (1.0, 3.0)) -> None:
    for frame, energy in zip(frames, energies, strict=True):
        objects("point").data.energy = energy
        objects("point").data.keyframe_insert("energy", frame=frame)
