# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes in which objects stand still, at least for a while."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

Build = Callable[[Any, Path], None]
SCENES: dict[str, tuple[Build, bool]] = {}
REST = {1: -0.3, 10: -0.3, 14: -0.2, 40: -0.2, 44: -0.35}


def scene(skips: bool) -> Callable[[Build], Build]:
    """Register a scene; `skips`: a run must skip some of its frames."""

    def keep(build: Build) -> Build:
        SCENES[build.__name__] = build, skips
        return build

    return keep


def watched(world: Any) -> Any:
    """Add a wall in the beam of a switch."""
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
    """Add the keys as an NLA strip that begins at a frame."""
    key_height(world, obj, keys)
    data = obj.animation_data
    action, slot = data.action, getattr(data, "action_slot", None)
    data.action = None
    strip = data.nla_tracks.new().strips.new("strip", start, action)
    if slot is not None:
        strip.action_slot = slot
    return strip


def nodes_of(world: Any, obj: Any, *kinds: str) -> tuple[Any, list[Any]]:
    """Add geometry nodes to an object; return their tree, and these nodes with its ends."""
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
    lux = world.sensor("LIGHT", "lux", update_rate=24.0, method="ILLUMINANCE", samples=16)
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
    world.key(data, "eval_time", {1: 0.0, 20: 0.0, 30: 80.0}, "BEZIER")


@scene(skips=True)
def a_texture_that_moves_a_surface(world: Any, _: Path) -> None:
    bpy, wall = world.bpy, watched(world)
    texture = bpy.data.textures.new("clouds", "CLOUDS")
    displace = wall.modifiers.new("displace", "DISPLACE")
    displace.texture, displace.strength = texture, 0.2
    world.key(texture, "noise_scale", {1: 0.2, 20: 0.2, 25: 1.5}, "BEZIER")


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
