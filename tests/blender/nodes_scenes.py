# SPDX-License-Identifier: GPL-3.0-or-later
"""Homes of meshes that only geometry nodes make and instance, not objects of the file."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import bpy

Build = Callable[[Any], Any]


def nodes(build: Build, name: str = "nodes") -> Any:
    """Return a node group for a modifier whose output `build(tree)` makes."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(build(tree), out.inputs[0])
    return tree


def add_nodes(obj: Any, build: Build) -> Any:
    obj.modifiers.new("nodes", "NODES").node_group = nodes(build)
    return obj


def cubes(size=(0.1, 0.1, 0.1), count=3, step=(0.3, 0.0, 0.0), start=(0.0, 0.0, 0.0)) -> Build:
    """Build Instance on Points of a Mesh Cube node, along a line."""

    def build(tree: Any) -> Any:
        cube = tree.nodes.new("GeometryNodeMeshCube")
        cube.inputs["Size"].default_value = size
        return on_line(tree, cube.outputs[0], count, step, start)

    return build


def coloured(build: Build, material: Any) -> Build:
    def made(tree: Any) -> Any:
        put = tree.nodes.new("GeometryNodeSetMaterial")
        put.inputs["Material"].default_value = material
        tree.links.new(build(tree), put.inputs[0])
        return put.outputs[0]

    return made


def nested(inner: Build, count=2, step=(0.0, 0.5, 0.0)) -> Build:
    """Build instances of instances."""
    return lambda tree: on_line(tree, inner(tree), count, step, (0.0, 0.0, 0.0))


def moving(build: Build, speed=(0.5, 0.0, 0.0)) -> Build:
    """Move the output of `build` with the scene's time, so many units a second."""

    def made(tree: Any) -> Any:
        time = tree.nodes.new("GeometryNodeInputSceneTime")
        way = tree.nodes.new("ShaderNodeVectorMath")
        way.operation = "SCALE"
        way.inputs[0].default_value = speed
        tree.links.new(time.outputs["Seconds"], way.inputs["Scale"])
        put = tree.nodes.new("GeometryNodeTransform")
        tree.links.new(build(tree), put.inputs["Geometry"])
        tree.links.new(way.outputs[0], put.inputs["Translation"])
        return put.outputs[0]

    return made


def growing(size=(0.1, 0.1, 0.1)) -> Build:
    """Build cubes, more of them at each second, each of another size."""

    def build(tree: Any) -> Any:
        time = tree.nodes.new("GeometryNodeInputSceneTime")
        cube = tree.nodes.new("GeometryNodeMeshCube")
        larger = tree.nodes.new("ShaderNodeVectorMath")
        larger.inputs[0].default_value = size
        larger.operation = "SCALE"
        tree.links.new(time.outputs["Seconds"], larger.inputs["Scale"])
        tree.links.new(larger.outputs[0], cube.inputs["Size"])
        line = on_line(tree, cube.outputs[0], 1, (0.0, 0.2, 0.0), (0.0, 0.0, 0.0))
        counted = next(n for n in tree.nodes if n.bl_idname == "GeometryNodeMeshLine")
        tree.links.new(time.outputs["Seconds"], counted.inputs["Count"])
        return line

    return build


def on_line(tree: Any, instance: Any, count: int, step: Any, start: Any) -> Any:
    line = tree.nodes.new("GeometryNodeMeshLine")
    line.inputs["Count"].default_value = count
    line.inputs["Start Location"].default_value = start
    line.inputs["Offset"].default_value = step
    put = tree.nodes.new("GeometryNodeInstanceOnPoints")
    tree.links.new(line.outputs[0], put.inputs["Points"])
    tree.links.new(instance, put.inputs["Instance"])
    return put.outputs[0]


def home(world: Any) -> None:
    """Add a room whose shelves, walker and guest are made by nodes, with all kinds of sensors.

    The guest of 60 kg, four instanced cubes, stands on the pad 'pad'.
    """
    world.scene.frame_end = 36
    world.box((6, 6, 0.3), (0, 0, -0.15), "floor")
    world.box((6, 0.1, 2.5), (0, 3, 1.25), "wall")
    paint = bpy.data.materials.new("paint")
    paint.diffuse_color = (0.1, 0.4, 0.2, 1)
    shelf = add_nodes(world.box((0.1, 0.1, 0.1), (1, 1, 1)), nested(coloured(cubes(), paint)))
    shelf.name = "shelf"
    walker = add_nodes(world.box((0.1, 0.1, 0.1), (-1, 0, 0.5)), moving(nested(cubes())))
    walker.name = "walker"
    grown = add_nodes(world.box((0.1, 0.1, 0.1), (-1, 1, 1)), growing())
    grown.name = "growing"
    carried = bpy.data.collections.new("carried")
    carried.objects.link(add_nodes(bpy.data.objects.new("inner", shelf.data), cubes()))
    world.instance("instance", carried, (0, -1, 1))
    guest = world.link("guest", world.mesh([(0, 0, 0)], []), (2, -2, 0))
    add_nodes(guest, cubes((0.1, 0.1, 1.0), 4, (0.1, 0, 0), (-0.15, 0, 0.52)))
    guest.angen_load.mass = 60.0
    _sensors(world)


def _sensors(world: Any) -> None:
    world.sensor("PRESSURE", "pad", world.box((1, 1, 0.02), (2, -2, 0.01), "pad"), update_rate=12.0)
    up = (math.pi, 0, 0)
    level = (math.radians(90), 0, 0)
    for model in ("RANGE_SCAN", "PYROELECTRIC"):
        pir = world.sensor("PIR", model, model=model, update_rate=12.0)
        pir.location, pir.rotation_euler = (0, -2.5, 1), level
    for name, at, rays in (("beam", (-1, 0.5, 0.2), 1), ("aperture", (-0.5, 0.5, 0.2), 7)):
        switch = world.switch(name, aperture_rays=rays, aperture=0.01 if rays > 1 else 0.0)
        switch.location, switch.rotation_euler = at, up
    swept = world.switch("swept", swept=True)
    swept.location, swept.rotation_euler = (0, 0.5, 0.2), up
    for method in ("FOUR_WALL", "ILLUMINANCE"):
        light = world.sensor("LIGHT", method, method=method, samples=16, update_rate=12.0)
        light.location = (0.5, 0.5, 2)
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy = 100.0
    world.link("lamp", lamp, (0, 0, 2.3))
