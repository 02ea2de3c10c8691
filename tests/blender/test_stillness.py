# SPDX-License-Identifier: GPL-3.0-or-later
"""Where nothing moves nothing is evaluated, and every reading is what it is without that."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

Build = Callable[[Any, Path], None]
SCENES: dict[str, tuple[Build, bool]] = {}
REST = {1: -0.3, 10: -0.3, 14: -0.2, 40: -0.2, 44: -0.35}


def scene(skips: bool) -> Callable[[Build], Build]:
    """A scene of the table; `skips`: something of it is still, and that must be found."""

    def keep(build: Build) -> Build:
        SCENES[build.__name__] = build, skips
        return build

    return keep


def watched(world: Any) -> Any:
    """A wall in the beam of a switch."""
    world.switch(range_max=20.0, threshold=0.25)
    return world.wall(0.3)


def drive(obj: Any, path: str, expression: str, index: int = -1, **variables: Any) -> Any:
    driver = (obj.driver_add(path, index) if index >= 0 else obj.driver_add(path)).driver
    driver.expression = expression
    for name, (target, target_path) in variables.items():
        variable = driver.variables.new()
        variable.name = name
        variable.targets[0].id_type = target.id_type
        variable.targets[0].id = target
        variable.targets[0].data_path = target_path
    return driver


def key_height(world: Any, obj: Any, keys: dict[float, float], how: str = "LINEAR") -> None:
    world.key(obj, "location", {f: (0, 0, z) for f, z in keys.items()}, how)


def strip_of(world: Any, obj: Any, start: int, keys: dict[float, float]) -> Any:
    """The keys as a strip of the NLA that begins at a frame."""
    key_height(world, obj, keys)
    data = obj.animation_data
    action, slot = data.action, getattr(data, "action_slot", None)
    data.action = None
    strip = data.nla_tracks.new().strips.new("strip", start, action)
    if slot is not None:
        strip.action_slot = slot
    return strip


def nodes_of(world: Any, obj: Any, *kinds: str) -> tuple[Any, list[Any]]:
    """A tree of geometry nodes on an object, with these nodes in it and its ends."""
    tree = world.bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    made = [tree.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", *kinds)]
    obj.modifiers.new("nodes", "NODES").node_group = tree
    return tree, made


@scene(skips=True)
def pauses_between_linear_keys(world: Any, _: Path) -> None:
    key_height(world, watched(world), REST)
    world.pir("sweeping", update_rate=10.0, vertical_fov=0.6, hold_time=0.3, blocking_time=0.2)


@scene(skips=True)
def pauses_between_smooth_keys(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, REST, "BEZIER")
    for curve in world.curves_of(wall):
        for point in curve.keyframe_points:
            point.handle_left_type = point.handle_right_type = "AUTO_CLAMPED"


@scene(skips=True)
def smooth_keys_alike_with_handles_that_are_not(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, {1: -0.3, 20: -0.3, 30: -0.3}, "BEZIER")
    for curve in world.curves_of(wall):
        for point in curve.keyframe_points[:2]:
            point.handle_left_type = point.handle_right_type = "FREE"
            point.handle_right = point.co.x + 5, point.co.y + (0.4 if curve.array_index == 2 else 0)


@scene(skips=True)
def steps(world: Any, _: Path) -> None:
    key_height(world, watched(world), {1: -0.3, 12: -0.2, 12.5: -0.4, 30.00005: -0.25}, "CONSTANT")


@scene(skips=True)
def keys_upon_each_other(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, {1: -0.3, 20: -0.3, 21: -0.2, 30: -0.2})
    for curve in world.curves_of(wall):
        curve.keyframe_points[1].co.x = curve.keyframe_points[2].co.x = 20.00002


@scene(skips=True)
def between_frames(world: Any, _: Path) -> None:
    world.scene.angen_substeps = 3
    world.switch("fast", update_rate=72.0, range_max=20.0, swept=True)
    key_height(world, watched(world), {1: -0.3, 10.3: -0.3, 10.7: -0.2, 20: -0.2, 20.3: -0.3})


@scene(skips=True)
def stretched_time(world: Any, _: Path) -> None:
    world.scene.render.frame_map_old, world.scene.render.frame_map_new = 100, 300
    key_height(world, watched(world), {1: -0.3, 4: -0.3, 5: -0.2, 12: -0.2, 14: -0.3})


@scene(skips=True)
def far_from_the_first_frame(world: Any, _: Path) -> None:
    world.scene.frame_start, world.scene.frame_end = 1_000_000, 1_000_047
    world.scene.angen_substeps = 2
    world.switch("fast", update_rate=48.0, range_max=20.0)
    key_height(world, watched(world), {1_000_000 + f: z for f, z in REST.items()})


@scene(skips=True)
def a_sensor_that_moves(world: Any, _: Path) -> None:
    watched(world)
    sensor = world.bpy.data.objects["switch"]
    world.key(sensor, "location", {1: (0, 0, 0), 20: (0, 0, 0), 24: (0, 0, 0.1)}, "LINEAR")


@scene(skips=True)
def settings_of_a_sensor(world: Any, _: Path) -> None:
    watched(world)
    sensor = world.bpy.data.objects["switch"]
    path = "angen_sensor.optical_switch.range_max"
    world.key(sensor, path, {1: 20.0, 15: 0.28, 30: 20.0}, "CONSTANT")
    world.key(sensor, "angen_sensor.enabled", {1: True, 35: False, 40: True}, "CONSTANT")


@scene(skips=True)
def noise_of_a_sensor(world: Any, _: Path) -> None:
    watched(world)
    world.bpy.data.objects["switch"].angen_sensor.optical_switch.noise_sigma = 0.01
    world.pir("noisy", noise_sigma=0.01)
    lux = world.sensor("LIGHT", "lux", update_rate=24.0, method="ILLUMINANCE", engine="DIRECT")
    lux.angen_sensor.light.noise_sigma = 0.5
    world.link("lamp", world.bpy.data.lights.new("lamp", "POINT"), (0, 0.2, -1))


@scene(skips=True)
def a_driver_that_follows_keys(world: Any, _: Path) -> None:
    wall, lead = watched(world), world.link("lead", None)
    key_height(world, lead, REST)
    drive(wall, "location", "min(a, 0) * 2 if a < 9 else 0", 2, a=(lead, "location.z"))


@scene(skips=True)
def a_chain_of_bones(world: Any, _: Path) -> None:
    bpy = world.bpy
    data = bpy.data.armatures.new("rig")
    rig = world.link("rig", data)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    last = None
    for i in range(3):
        bone = data.edit_bones.new(f"b{i}")
        bone.head, bone.tail, bone.parent = (
            (0, 0.05 * (i == 1), -i * 0.1),
            (0, 0, -i * 0.1 - 0.1),
            last,
        )
        last = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    wall, target = watched(world), world.link("target", None)
    reach = rig.pose.bones["b2"].constraints.new("IK")
    reach.target = target
    wall.parent, wall.parent_type, wall.parent_bone = rig, "BONE", "b2"
    wall.location = (0, 0, 0)
    key_height(world, target, REST)


@scene(skips=True)
def shape_keys(world: Any, _: Path) -> None:
    wall = watched(world)
    wall.shape_key_add(name="Basis")
    near = wall.shape_key_add(name="near")
    for point in near.data:
        point.co.z += 0.1
    keys = wall.data.shape_keys
    for frame, value in ((1, 0.0), (20, 0.0), (25, 1.0)):
        near.value = value
        keys.keyframe_insert('key_blocks["near"].value', frame=frame)


@scene(skips=True)
def visibility(world: Any, _: Path) -> None:
    world.key(watched(world), "hide_viewport", {1: False, 20: True, 30: False}, "CONSTANT")


@scene(skips=True)
def a_path_to_follow(world: Any, _: Path) -> None:
    bpy, wall = world.bpy, watched(world)
    data = bpy.data.curves.new("path", "CURVE")
    data.dimensions, data.use_path = "3D", True
    spline = data.splines.new("POLY")
    spline.points.add(1)
    for point, z in zip(spline.points, (0.0, 0.2), strict=True):
        point.co = (0, 0, z, 1)
    follow = wall.constraints.new("FOLLOW_PATH")
    follow.target = world.link("path", data)
    for frame, value in ((1, 0.0), (20, 0.0), (30, 80.0)):
        data.eval_time = value
        data.keyframe_insert("eval_time", frame=frame)


@scene(skips=True)
def letters_and_curves(world: Any, _: Path) -> None:
    bpy = world.bpy
    watched(world)
    data = bpy.data.curves.new("text", "FONT")
    data.body, data.align_x, data.align_y, data.size = "O█O", "CENTER", "CENTER", 0.4
    world.link("text", data, (0, 0, -0.25))
    for frame, value in ((1, 0.0), (20, 0.0), (25, 0.05)):
        data.extrude = value
        data.keyframe_insert("extrude", frame=frame)


@scene(skips=True)
def a_texture_that_moves_a_surface(world: Any, _: Path) -> None:
    bpy, wall = world.bpy, watched(world)
    texture = bpy.data.textures.new("clouds", "CLOUDS")
    displace = wall.modifiers.new("displace", "DISPLACE")
    displace.texture, displace.strength = texture, 0.2
    for frame, value in ((1, 0.2), (20, 0.2), (25, 1.5)):
        texture.noise_scale = value
        texture.keyframe_insert("noise_scale", frame=frame)


@scene(skips=True)
def nodes_with_an_input(world: Any, _: Path) -> None:
    wall = watched(world)
    tree, (into, out, move) = nodes_of(world, wall, "GeometryNodeTransform")
    tree.links.new(into.outputs[0], move.inputs[0])
    tree.links.new(move.outputs[0], out.inputs[0])
    socket = move.inputs["Translation"]
    for frame, z in ((1, 0.0), (20, 0.0), (25, 0.1)):
        socket.default_value = (0, 0, z)
        socket.keyframe_insert("default_value", frame=frame)


@scene(skips=True)
def strips(world: Any, _: Path) -> None:
    strip_of(world, watched(world), 10, {0: -0.3, 4: -0.2})


@scene(skips=True)
def strips_that_end_in_nothing_on_an_action(world: Any, _: Path) -> None:
    wall = watched(world)
    strip = strip_of(world, wall, 10, {0: -0.3, 4: -0.2})
    strip.extrapolation = "NOTHING"
    key_height(world, wall, {20: -0.5, 26: -0.5})
    wall.animation_data.action_extrapolation = "NOTHING"


@scene(skips=True)
def a_parent_in_strips(world: Any, _: Path) -> None:
    wall, parent = watched(world), world.link("parent", None)
    wall.parent = parent
    strip = strip_of(world, parent, 8, {0: 0.0, 4: 0.1})
    strip.repeat = 2.0


@scene(skips=False)
def a_strip_of_changing_influence(world: Any, _: Path) -> None:
    strip = strip_of(world, watched(world), 2, {0: -0.3, 4: -0.2})
    strip.use_animated_influence = True
    for frame, value in ((2, 0.0), (44, 1.0)):
        strip.influence = value
        strip.keyframe_insert("influence", frame=frame)


@scene(skips=True)
def linked_keys(world: Any, folder: Path) -> None:
    bpy, wall = world.bpy, watched(world)
    lead = world.link("lead", None)
    key_height(world, lead, REST)
    action = lead.animation_data.action
    action.use_fake_user = True
    bpy.data.libraries.write(str(folder / "lib.blend"), {action})
    name = action.name
    bpy.data.objects.remove(lead)
    bpy.data.actions.remove(action)
    with bpy.data.libraries.load(str(folder / "lib.blend"), link=True) as (_, ours):
        ours.actions = [name]
    wall.animation_data_create().action = bpy.data.actions[name]
    if hasattr(wall.animation_data, "action_slot"):
        wall.animation_data.action_slot = bpy.data.actions[name].slots[0]


@scene(skips=True)
def one_action_for_two(world: Any, _: Path) -> None:
    wall, other = watched(world), world.link("other", None)
    key_height(world, other, {1: 0.0, 48: 5.0})
    if hasattr(other.animation_data, "action_slot"):
        wall.animation_data_create().action = other.animation_data.action
        wall.animation_data.action_slot = other.animation_data.action.slots.new("OBJECT", "wall")
    other.animation_data_clear()
    key_height(world, wall, REST)


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
def keys_that_go_on(world: Any, _: Path) -> None:
    wall = watched(world)
    key_height(world, wall, {1: -0.1, 5: -0.12})
    for curve in world.curves_of(wall):
        curve.extrapolation = "LINEAR"


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
def a_driver_on_the_frame_of_the_scene(world: Any, _: Path) -> None:
    drive(watched(world), "location", "-0.3 - f / 99", 2, f=(world.scene, "frame_current"))


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
def a_film_that_moves_a_surface(world: Any, folder: Path) -> None:
    bpy, wall = world.bpy, watched(world)
    texture = bpy.data.textures.new("film", "IMAGE")
    texture.image = film(bpy, folder)
    user = texture.image_user
    user.frame_duration, user.use_auto_refresh = 4, True
    wall.modifiers.new("displace", "DISPLACE").texture = texture


def film(bpy: Any, folder: Path) -> Any:
    """Four pictures, from black to white."""
    for number in range(1, 5):
        image = bpy.data.images.new("one", 2, 2)
        image.pixels = [number / 4, number / 4, number / 4, 1] * 4
        image.filepath_raw, image.file_format = str(folder / f"film{number:04}.png"), "PNG"
        image.save()
        bpy.data.images.remove(image)
    found = bpy.data.images.load(str(folder / "film0001.png"))
    found.source = "SEQUENCE"
    return found


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
    world.sensor("LIGHT", "lux", update_rate=24.0, method="ILLUMINANCE", engine="DIRECT")
    lamp = bpy.data.lights.new("lamp", "POINT")
    world.link("lamp", lamp, (0, 0, -1))
    for frame, value in ((1, 10.0), (20, 10.0), (25, 40.0)):
        lamp.energy = value
        lamp.keyframe_insert("energy", frame=frame)


@scene(skips=True)
def a_wall_that_glows(world: Any, _: Path) -> None:
    glowing(world).inputs["Emission Strength"].keyframe_insert("default_value", frame=20)
    strength = glowing(world).inputs["Emission Strength"]
    strength.default_value = 9.0
    strength.keyframe_insert("default_value", frame=24)


def glowing(world: Any) -> Any:
    """The shader of a wall that glows before a light sensor with few paths."""
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


@scene(skips=False)
def a_lamp_on_the_frame(world: Any, _: Path) -> None:
    world.sensor("LIGHT", "lux", update_rate=24.0, method="ILLUMINANCE", engine="DIRECT")
    lamp = world.bpy.data.lights.new("lamp", "POINT")
    world.link("lamp", lamp, (0, 0, -1))
    drive(lamp, "energy", "frame")


@scene(skips=True)
def a_shade_that_moves_a_wall(world: Any, _: Path) -> None:
    wall = watched(world)
    material = world.bpy.data.materials.new("shade")
    drive(wall, "location", "-0.3 - a / 4", 2, a=(material, "roughness"))
    for frame, value in ((1, 0.0), (20, 0.0), (25, 1.0)):
        material.roughness = value
        material.keyframe_insert("roughness", frame=frame)


@scene(skips=True)
def a_magnet_on_a_leaf(world: Any, _: Path) -> None:
    magnet = world.link("magnet", None)
    world.sensor("CONTACT", "door", update_rate=24.0, magnet=magnet)
    world.key(magnet, "location", {1: (0.005, 0, 0), 20: (0.005, 0, 0), 25: (0.1, 0, 0)}, "LINEAR")


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
    """A warm thing before a pyroelectric detector, which stands there from the first frame on."""
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
    thing.data.materials.append(material)
    material.angen_warmth.use_temperature = True
    for frame, value in ((1, 293.0), (20, 293.0), (22, 330.0)):
        material.angen_warmth.temperature = value
        material.keyframe_insert("angen_warmth.temperature", frame=frame)


def loaded(world: Any, *rates: float) -> None:
    """A load that rests on pads of these rates, slides off, comes back and grows light."""
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


def run(world: Any) -> tuple[Any, int, int]:
    """The recording, and at how many of the steps the scene was evaluated."""
    from_part = world.part
    recording = from_part("sensor_logic.recording").Recording()
    made = from_part("angen_addon.runtime.simulation").simulate(
        world.scene, world.sensors(), world.scene.frame_start, world.scene.frame_end, recording
    )
    progress = list(made)[-1]
    return recording, progress.evaluated, progress.steps


@contextmanager
def somebody_else_follows_frames(bpy: Any) -> Iterator[None]:
    """A handler of other code, which may change anything: then every frame is evaluated."""

    def act(*_: Any) -> None:
        pass

    bpy.app.handlers.frame_change_pre.append(act)
    try:
        yield
    finally:
        bpy.app.handlers.frame_change_pre.remove(act)


@pytest.mark.parametrize("name", SCENES)
def test_every_reading_is_as_without_skipping(
    name: str, world: Any, tmp_path: Path, addon_part: Any, fcurves: Any
) -> None:
    world.part, world.curves_of = addon_part, fcurves
    build, skips = SCENES[name]
    build(world, tmp_path)
    with somebody_else_follows_frames(world.bpy):
        plain, all_evaluated, steps = run(world)
    recording, evaluated, again = run(world)
    assert all_evaluated == steps == again
    readings = [v for t in plain.tracks.values() for v in t.value if not math.isnan(v)]
    assert len(set(readings)) > 1, "nothing that a wrong skip would spoil"
    assert recording.tracks == plain.tracks
    assert (evaluated < steps / 1.3) == skips, f"{evaluated} of {steps}"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("strips", "; nothing moved at 85 % of the steps\n"),
        ("a_driver_on_the_frame", "; every step was evaluated: a driver of 'wall' may follow the"),
        ("cycles_of_keys", "keys of 'wall' go on without end (modifiers, extrapolation)\n"),
    ],
)
def test_the_closing_line_tells_what_was_skipped_or_why_nothing_was(
    name: str, words: str, world: Any, tmp_path: Path, addon_part: Any, fcurves: Any
) -> None:
    world.part, world.curves_of = addon_part, fcurves
    SCENES[name][0](world, tmp_path)
    said = io.StringIO()
    line = addon_part("angen_addon.commands.progress").ProgressLine(said, False)
    recording = addon_part("sensor_logic.recording").Recording()
    simulate = addon_part("angen_addon.runtime.simulation").simulate
    for progress in simulate(world.scene, world.sensors(), 1, 48, recording):
        line.show(progress)
    line.finish(2.0, 48)
    assert words in said.getvalue()
