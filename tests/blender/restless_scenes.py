# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that may change at each frame; and still objects beside lamps, warmth and loads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from still_scenes import SCENES, drive, key_height, nodes_of, scene, watched


@scene(skips=False)
def noise_on_keys(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, {1: -0.3})
    world.curves_of(wall)[2].modifiers.new("NOISE").strength = 0.2


@scene(skips=False)
def cycles_of_keys(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, {1: -0.3, 5: -0.2})
    for curve in world.curves_of(wall):
        curve.modifiers.new("CYCLES")


@scene(skips=False)
def baked_samples(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, {1: -0.1, 47: -0.4})
    for curve in world.curves_of(wall):
        curve.convert_to_samples(1, 48)


@scene(skips=False)
def a_driver_on_the_frame(world: Any, _: Path) -> None:
    drive(watched(world), "location", "-0.3 + sin(frame / 10) / 9", 2)


@scene(skips=False)
def a_driver_that_asks_python(world: Any, _: Path) -> None:
    space = world.bpy.app.driver_namespace
    space["height"] = lambda: -0.3 - world.scene.frame_current / 99
    drive(watched(world), "location", "height()", 2)


@scene(skips=False)
def a_driver_of_what_sensors_say(world: Any, _: Path) -> None:
    wall = watched(world)
    lead = world.bpy.data.objects["switch"]
    drive(wall, "location", "-0.3 if a > 0.31 else -a - 0.01", 2, a=(lead, "angen_sensor.value"))


@scene(skips=False)
def nodes_on_the_frame(world: Any, _: Path) -> None:
    wall = watched(world)
    tree, (into, out, move, time, join) = nodes_of(
        world, wall, "GeometryNodeTransform", "GeometryNodeInputSceneTime", "ShaderNodeCombineXYZ"
    )
    tree.links.new(into.outputs[0], move.inputs[0])
    tree.links.new(time.outputs["Seconds"], join.inputs["Z"])
    tree.links.new(join.outputs[0], move.inputs["Translation"])
    tree.links.new(move.outputs[0], out.inputs[0])


@scene(skips=False)
def a_simulation_of_nodes(world: Any, _: Path) -> None:
    wall = watched(world)
    tree, (into, out, first, last, move) = nodes_of(
        world,
        wall,
        "GeometryNodeSimulationInput",
        "GeometryNodeSimulationOutput",
        "GeometryNodeTransform",
    )
    first.pair_with_output(last)
    move.inputs["Translation"].default_value = (0, 0, 0.005)
    tree.links.new(into.outputs[0], first.inputs["Geometry"])
    tree.links.new(first.outputs["Geometry"], move.inputs[0])
    tree.links.new(move.outputs[0], last.inputs["Geometry"])
    tree.links.new(last.outputs["Geometry"], out.inputs[0])


@scene(skips=False)
def a_falling_body(world: Any, _: Path) -> None:
    bpy, wall = world.bpy, watched(world)
    bpy.context.view_layer.objects.active = wall
    bpy.ops.rigidbody.object_add(type="ACTIVE")


@scene(skips=False)
def waves(world: Any, _: Path) -> None:
    wall = watched(world)
    wave = wall.modifiers.new("wave", "WAVE")
    wave.height, wave.speed, wave.narrowness, wave.width = 0.2, 0.1, 2.0, 2.0


@scene(skips=False)
def hair_that_grows(world: Any, _: Path) -> None:
    bpy = world.bpy
    watched(world)
    floor = world.box((0.2, 0.2, 0.02), (0, 0, -0.05), "emitter")
    seed = world.box((0.3, 0.3, 0.01), (9, 0, 0), "seed")
    bpy.context.view_layer.objects.active = floor
    floor.modifiers.new("rain", "PARTICLE_SYSTEM")
    settings = floor.particle_systems[0].settings
    settings.render_type, settings.instance_object = "OBJECT", seed
    settings.particle_size, settings.frame_end, settings.lifetime = 0.5, 40, 90


@scene(skips=True)
def a_lamp_of_materials_and_world(world: Any, _: Path) -> None:
    bpy = world.bpy
    world.sensor("LIGHT", "lux", update_rate=24.0, method="ILLUMINANCE", samples=16)
    lamp = bpy.data.lights.new("lamp", "POINT")
    world.link("lamp", lamp, (0, 0, -1))
    world.key(lamp, "energy", {1: 10.0, 20: 10.0, 25: 40.0}, "BEZIER")


@scene(skips=True)
def a_wall_that_glows(world: Any, _: Path) -> None:
    glowing(world).inputs["Emission Strength"].keyframe_insert("default_value", frame=20)
    strength = glowing(world).inputs["Emission Strength"]
    strength.default_value = 9.0
    strength.keyframe_insert("default_value", frame=24)


def glowing(world: Any) -> Any:
    """Add a glowing wall before a light sensor with few paths; return its shader."""
    bpy = world.bpy
    material = bpy.data.materials.get("glow") or bpy.data.materials.new("glow")
    if not material.users:
        material.use_nodes = True
        world.wall(1.0).data.materials.append(material)
        given = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 4, "update_rate": 2.0}
        world.sensor("LIGHT", "lux", **given)
        world.scene.angen_light_reference = 0
        material.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1.0
    return material.node_tree.nodes["Principled BSDF"]


@scene(skips=True)
def a_shade_that_moves_a_wall(world: Any, _: Path) -> None:
    wall = watched(world)
    material = world.bpy.data.materials.new("shade")
    drive(wall, "location", "-0.3 - a / 4", 2, a=(material, "roughness"))
    world.key(material, "roughness", {1: 0.0, 20: 0.0, 25: 1.0}, "BEZIER")


@scene(skips=True)
def a_magnet_on_a_leaf(world: Any, _: Path) -> None:
    magnet = world.link("magnet", None)
    world.sensor("CONTACT", "door", update_rate=24.0, magnet=magnet)
    world.key(magnet, "location", {1: (0.005, 0, 0), 20: (0.005, 0, 0), 25: (0.1, 0, 0)}, "LINEAR")


@scene(skips=True)
def a_use_between_updates(world: Any, _: Path) -> None:
    """A flush, and a lamp that is an empty: both are used for a frame or two between updates."""
    toilet, lamp = world.box((0.4, 0.6, 0.4), (3, 3, 0), "toilet"), world.link("lamp", None)
    world.sensor("FLOW", "flush", update_rate=4.0, watched=toilet, flows="AFTER_USE")
    toilet_flow = world.bpy.data.objects["flush"].angen_sensor.flow
    toilet_flow.refill_volume, toilet_flow.noise_sigma = 0.1, 0.1
    world.sensor("APPLIANCE", "plug", update_rate=4.0, watched=lamp, load="LAMP")
    world.key(toilet, "angen_use.in_use", {1: False, 8: True, 10: False}, "CONSTANT")
    world.key(lamp, "angen_use.in_use", {1: False, 20: True, 21: False, 33: True}, "CONSTANT")
    watched(world)


@scene(skips=True)
def a_colour_that_reflects_less(world: Any, _: Path) -> None:
    wall, material = world.wall(2.0, size=9.0), world.bpy.data.materials.new("paint")
    wall.data.materials.append(material)
    material.use_nodes = True
    colour = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    for frame, grey in ((1, 0.9), (20, 0.9), (25, 0.01)):
        colour.default_value = (grey, grey, grey, 1.0)
        colour.keyframe_insert("default_value", frame=frame)
    world.sensor("DISTANCE", "tof", update_rate=24.0, rays=1)


def warm(world: Any) -> Any:
    """Add a warm object before a pyroelectric detector, from the first frame on."""
    world.pir(model="PYROELECTRIC", warm_up_time=0.0)
    return world.box((1, 1, 1), (0, 0, -2), "warm")


@scene(skips=True)
def a_thing_that_comes_and_goes_before_warmth(world: Any, _: Path) -> None:
    thing = warm(world)
    thing.angen_warmth.use_temperature, thing.angen_warmth.temperature = True, 310.0
    world.key(thing, "location", {1: (3, 0, -2), 8: (3, 0, -2), 14: (0, 0, -2)}, "LINEAR")


@scene(skips=True)
def the_warmth_of_a_material(world: Any, _: Path) -> None:
    thing, material = warm(world), world.bpy.data.materials.new("warm")
    # One edge is within a zone: both elements of a pair would see the same otherwise.
    thing.location.x = 0.44
    thing.data.materials.append(material)
    material.angen_warmth.use_temperature = True
    for frame, value in ((1, 293.0), (20, 293.0), (22, 330.0)):
        material.angen_warmth.temperature = value
        material.keyframe_insert("angen_warmth.temperature", frame=frame)


def loaded(world: Any, *rates: float) -> None:
    """Add a load on pads of several rates: it slides off, comes back and becomes lighter."""
    for number, rate in enumerate(rates):
        slab = world.box((1, 1, 0.02), (2 * number, 0, 0.01), f"slab {number}")
        world.sensor("PRESSURE", f"pad {number}", slab, update_rate=rate)
        load = world.box((0.3, 0.3, 0.3), (0, 0, 0.17), f"load {number}")
        load.angen_load.mass = 5.0
        x = 2 * number
        places = {1: x, 10: x, 16: x + 0.9, 22: x}
        world.key(load, "location", {f: (at, 0, 0.17) for f, at in places.items()}, "BEZIER")
    for frame, value in ((1, -9.8), (30, -9.8), (34, -5.0)):
        world.scene.gravity[2] = value
        world.scene.keyframe_insert("gravity", frame=frame)


@scene(skips=True)
def a_load_on_a_pad(world: Any, _: Path) -> None:
    loaded(world, 24.0)


@scene(skips=True)
def loads_on_pads_of_many_rates(world: Any, _: Path) -> None:
    world.scene.angen_substeps = 2
    world.scene.frame_end = 100
    loaded(world, 1.0, 5.0, 24.0)
    watched(world)


__all__ = ["SCENES"]
