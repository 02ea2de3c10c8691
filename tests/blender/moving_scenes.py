# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes in which objects move, hide, change shape, follow outputs, are instanced or fall."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from light_stage import lamp
from pressure_scenes import Physics
from restless_scenes import SCENES
from still_scenes import strip_of

AHEAD = (1.5707963, 0.0, -1.5707963)
SWITCHED = 13


def among(furnish: Callable[..., None]) -> Callable[..., Any]:
    """Register a scene with these sensors and the objects that a function adds."""

    def keep(add: Callable[..., None]) -> Callable[..., None]:
        def build(world: Any, _: Any) -> None:
            furnish(world)
            add(world)

        SCENES[add.__name__] = build, None
        return add

    return keep


# Before sensors of all kinds


def watchers(world: Any) -> None:
    """Add sensors of different rates about the origin, and stretch the time.

    A range scan that takes its tilts in turn, one of all tilts, a pyroelectric detector, a distance
    sensor, an infrared array and two switches.
    """
    world.scene.angen_substeps, world.scene.render.frame_map_new = 3, 50
    fan = {"rays": 24, "vertical_fov": 0.6, "vertical_step": 0.2, "range_max": 4.0}
    placed = [
        world.pir("turns", update_rate=10.0, **fan),
        world.pir("all", update_rate=24.0, sweep="ALL", **fan),
        world.sensor("PIR", "warm", model="PYROELECTRIC", update_rate=24.0, zone_rays=4),
        world.sensor("DISTANCE", "far", update_rate=7.0),
        world.sensor(
            "THERMAL_ARRAY", "array", update_rate=5.0, rays=5, settling_time=0.3, netd=0.1
        ),
        world.switch("beam", update_rate=3.0, range_max=4.0, threshold=2.0, aperture_rays=3),
        world.switch("swept", update_rate=2.0, range_max=4.0, threshold=2.0, swept=True),
    ]
    for i, sensor in enumerate(placed):
        sensor.location = (0.1 * i - 0.2, -2.0, 0.1)
        sensor.rotation_euler = (np.pi / 2, 0.0, 0.0)


def body(world: Any, name: str = "body", at: Any = (0, 0, 0)) -> Any:
    """Add a warm box."""
    obj = world.box((0.6, 0.5, 0.9), at, name)
    obj.angen_warmth.use_temperature, obj.angen_warmth.temperature = True, 33.0
    return obj


def walks(world: Any, obj: Any, far: float = 1.5) -> None:
    world.key(obj, "location", {1: (-far, 0, 0), 30: (far, 0.4, 0), 48: (0, 0, 0)}, "LINEAR")


@among(watchers)
def goes_by_a_strip_that_hides_it(world: Any) -> None:
    obj = body(world)
    world.key(obj, "hide_viewport", {1: False, 22: True, 26: False}, "CONSTANT")
    strip_of(world, obj, 1, {1: -2.0, 30: 2.0})


@among(watchers)
def is_mirrored_and_turned(world: Any) -> None:
    obj = body(world)
    obj.scale = (-1.0, 0.7, 1.2)
    world.key(obj, "rotation_euler", {1: (0, 0, 0), 48: (1.0, 2.0, 6.0)}, "LINEAR")


@among(watchers)
def bends(world: Any) -> None:
    obj = body(world)
    obj.shape_key_add(name="Basis")
    for vertex, point in zip(obj.data.vertices, obj.shape_key_add(name="wide").data, strict=True):
        point.co = vertex.co * 1.8
    for frame, value in ((1, 0.0), (20, 1.0), (40, 0.2)):
        key = obj.data.shape_keys.key_blocks["wide"]
        key.value = value
        key.keyframe_insert("value", frame=frame)
    walks(world, obj)


@among(watchers)
def comes_and_goes(world: Any) -> None:
    one, two = body(world, "one"), body(world, "two", (0.9, 0.4, 0))
    walks(world, one)
    world.key(one, "hide_viewport", {1: False, 9: True, 22: False}, "CONSTANT")
    world.key(two, "hide_viewport", {1: True, 9: False, 22: True}, "CONSTANT")


@among(watchers)
def comes_with_what_hangs_on_it(world: Any) -> None:
    """Hide a moved and turned object at first; its child appears later and hides earlier.

    The object that bends the child stays hidden.
    """
    one, child = body(world, "one"), body(world, "child")
    cage = world.link("cage", bpy.data.lattices.new("cage"), (0, 0, 0))
    one.modifiers.new("cage", "LATTICE").object = cage
    world.key(cage, "scale", {1: (1, 1, 1), 30: (2, 1, 1.5)}, "LINEAR")
    walks(world, one)
    world.key(one, "rotation_euler", {1: (0, 0, 0), 12: (0, 0, 2.0), 48: (0, 0, 2.0)}, "LINEAR")
    child.parent, child.location = one, (0.4, -0.6, 0.2)
    world.key(one, "hide_viewport", {1: True, 7: False, 40: True}, "CONSTANT")
    world.key(child, "hide_viewport", {1: True, 11: False, 31: True, 33: False}, "CONSTANT")
    world.key(cage, "hide_viewport", {1: True}, "CONSTANT")


@among(watchers)
def is_instanced(world: Any) -> None:
    inner = bpy.data.collections.new("inner")
    inner.objects.link(bpy.data.objects.new("seat", body(world, "seat", (0, 9, 0)).data))
    holder = world.instance("holder", inner)
    walks(world, holder)


@among(watchers)
def carries_the_sensors(world: Any) -> None:
    walks(world, body(world))
    cart = world.link("cart", None, (0, 0, 0))
    world.key(cart, "location", {1: (0, 0, 0), 40: (0.5, 0.3, 0)}, "LINEAR")
    for name in ("turns", "beam"):
        bpy.data.objects[name].parent = cart


@among(watchers)
def changes_what_sensors_are(world: Any) -> None:
    walks(world, body(world))
    pir = bpy.data.objects["turns"]
    world.key(pir, "angen_sensor.enabled", {1: True, 14: False, 26: True}, "CONSTANT")
    world.key(bpy.data.objects["all"], "angen_sensor.pir.range_max", {1: 4.0, 40: 1.5}, "LINEAR")


@among(watchers)
def begins_late(world: Any) -> None:
    walks(world, body(world))
    world.box((4, 0.1, 3), (0, 1.0, 0), "wall")
    late = body(world, "late", (0.5, 0.2, 0))
    world.key(late, "location", {33: (0.5, 0.2, 0), 40: (0.5, 0.2, 2.5)}, "CONSTANT")


@among(watchers)
def steps_on_a_pad(world: Any) -> None:
    """Let a person step on a pad, wait, hop to a slab on another pad, and then on a mattress.

    A drawer moves below that slab. The mattress has no mass, and is pulled over the pad below it.
    A fourth pad is far away, as is a cat that walks all the time.
    """
    pads = {"pad": (0, 0, 0.01), "far": (7, 0, 0.01), "slab's": (0, 2, 0.01), "bed": (2.5, 2, 0.01)}
    for name, at in pads.items():
        world.sensor("PRESSURE", name, world.box((0.5, 0.5, 0.02), at, name), update_rate=6.0)
    world.box((9, 9, 1), (0, 0, -0.5), "floor")
    world.box((0.4, 0.4, 0.1), (0, 2, 0.07), "slab").angen_load.mass = 5.0
    person = body(world, "person", (-3, 0, 0.45))
    person.angen_load.mass = 60.0
    at = {1: (-3, 0, 0.45), 9: (0, 0, 0.47), 25: (0, 0, 0.47), 27: (0, 0, 0.8), 29: (0, 2, 0.57)}
    at |= {38: (0, 2, 0.57), 42: (2.5, 2, 0.67)}
    world.key(person, "location", at, "LINEAR")
    mattress = world.box((1.2, 1.2, 0.2), (2.5, 2, 0.12), "mattress")
    world.key(mattress, "location", {12: (3.5, 2, 0.12), 16: (2.5, 2, 0.12)}, "LINEAR")
    cat = {1: (-3, 5, 0), 48: (3, 5, 0)}
    world.key(body(world, "cat"), "location", cat, "LINEAR")
    drawer = world.box((0.2, 0.2, 0.02), (0, 2, -0.2), "drawer")
    world.key(drawer, "location", {36: (0, 2, -0.2), 44: (1, 2, -0.2)}, "LINEAR")


# Objects that read a switch's output


def followed(world: Any) -> None:
    """Add a door before a switch, all kinds of sensors, and a screen for the switch to drive."""
    world.scene.frame_end = 24
    world.door(5, 9, 14, 15, 20)
    world.switch("switch")
    pir = world.pir("pir")
    pir.location, pir.rotation_euler = (2.0, 0.0, 0.0), AHEAD
    lamp(world, "POINT", at=(6.5, 0.0, 1.0), energy=50.0).name = "Bulb"
    given = {"method": "ILLUMINANCE", "samples": 16, "update_rate": 24.0, "threshold": 1.0}
    world.sensor("LIGHT", "lux", **given).location = (5.5, 0.0, 1.0)
    ranger = world.sensor("DISTANCE", "range", update_rate=24.0, noise_sigma=0.0)
    ranger.location, ranger.rotation_euler = (4.5, 0.0, 0.0), AHEAD
    world.box((0.1, 4.0, 3.0), at=(8.0, 0.0, 0.0), name="wall")


def follow(owner: Any, path: str, index: int = -1) -> None:
    """Drive a property by `active` of the switch."""
    driver = owner.driver_add(path, index).driver if index >= 0 else owner.driver_add(path).driver
    driver.type, variable = "SUM", driver.variables.new()
    variable.targets[0].id = bpy.data.objects["switch"]
    variable.targets[0].data_path = "angen_sensor.active"


def screen(world: Any, name: str = "screen") -> Any:
    """Add a screen before the detector, and beside the lamp."""
    return world.box((0.02, 1.5, 1.5), at=(6.0, 0.0, 0.0), name=name)


@among(followed)
def moved(world: Any) -> None:
    follow(screen(world), "location", 1)


@among(followed)
def parent_turned(world: Any) -> None:
    above = world.link("above", None)
    screen(world).parent = above
    follow(above, "rotation_euler", 2)


@among(followed)
def bent(world: Any) -> None:
    modifier = screen(world).modifiers.new("d", "DISPLACE")
    modifier.strength = 0.0
    follow(modifier.id_data, 'modifiers["d"].strength')


@among(followed)
def held(world: Any) -> None:
    far = world.link("far", None, at=(4.0, 0.5, 0.0))
    constraint = screen(world).constraints.new("COPY_LOCATION")
    constraint.target = far
    follow(constraint.id_data, 'constraints["Copy Location"].influence')


@among(followed)
def instanced(world: Any) -> None:
    group = bpy.data.collections.new("group")
    group.objects.link(bpy.data.objects.new("leaf", screen(world).data))
    holder = world.instance("holder", group, (5.0, 0.0, 0.0))
    follow(holder, "location", 1)


@among(followed)
def lamp_lit(world: Any) -> None:
    follow(bpy.data.objects["Bulb"].data, "energy")


@among(followed)
def of_another_sensor(world: Any) -> None:
    screen(world)
    follow(bpy.data.objects["range"], "location", 1)


# Within instances


def shown_within(world: Any) -> None:
    """Add a switch before a plate in a collection instance, and a walker elsewhere.

    The plate is 0.2 m ahead, in the collection `inner`, which the empty `near` instances. The
    walker moves all the time.
    """
    world.switch(range_max=1.0, threshold=0.5)
    walker = world.box((0.1, 0.1, 0.1), at=(5, 0, 0), name="walker")
    world.key(walker, "location", {1: (5, 0, 0), 48: (6, 0, 0)})
    world.inner = bpy.data.collections.new("inner")
    world.plate = world.wall(0.2, "plate", 0.1)
    world.scene.collection.objects.unlink(world.plate)
    world.inner.objects.link(world.plate)
    world.near = world.instance("near", world.inner)


def at_switch(world: Any, obj: Any, path: str, before: Any, after: Any) -> None:
    world.key(obj, path, {1: before, SWITCHED: after}, "CONSTANT")


@among(shown_within)
def part_is_hidden(world: Any) -> None:
    at_switch(world, world.plate, "hide_viewport", False, True)


@among(shown_within)
def part_is_moved_by_its_parent(world: Any) -> None:
    world.plate.parent = arm = bpy.data.objects.new("arm", None)
    world.inner.objects.link(arm)
    at_switch(world, arm, "location", (0, 0, 0), (3, 0, 0))


@among(shown_within)
def part_changes_shape(world: Any) -> None:
    world.plate.shape_key_add(name="flat")
    away = world.plate.shape_key_add(name="away")
    for point in away.data:
        point.co.x += 3
    at_switch(world, world.plate.data.shape_keys, 'key_blocks["away"].value', 0.0, 1.0)


@among(shown_within)
def holder_is_moved_by_a_constraint(world: Any) -> None:
    target = world.link("target", None)
    world.near.constraints.new("COPY_LOCATION").target = target
    at_switch(world, target, "location", (0, 0, 0), (3, 0, 0))


@among(shown_within)
def holder_is_hidden(world: Any) -> None:
    at_switch(world, world.near, "hide_viewport", False, True)


@among(shown_within)
def holder_within_a_holder_moves(world: Any) -> None:
    outer = world.aside("outer", world.near)
    world.instance("far", outer)
    at_switch(world, world.near, "location", (0, 0, 0), (3, 0, 0))


@among(shown_within)
def instancer_by_vertices_moves(world: Any) -> None:
    world.scene.collection.objects.unlink(world.near)
    points = world.link("points", world.mesh([(0, 0, 0)], []))
    points.instance_type = "VERTS"
    world.inner.objects.unlink(world.plate)
    world.scene.collection.objects.link(world.plate)
    world.plate.parent = points
    at_switch(world, points, "location", (0, 0, 0), (3, 0, 0))


# Rigid bodies


def watched_bodies(world: Any) -> None:
    """Set six frames, and add a switch and two detectors that see bodies fall."""
    world.scene.frame_end = 6
    world.switch("switch", range_max=4.0).rotation_euler = (0, -1.5707963, 0)
    world.pir("motion", rays=15).rotation_euler = AHEAD
    warm = world.pir("warm", model="PYROELECTRIC")
    warm.location, warm.rotation_euler = (-1, 0, 0.2), AHEAD


@among(watched_bodies)
def falling(world: Any) -> None:
    """Drop a crate on a pad, and one on a table with a hinge; a hat is a child of the crate."""
    physics = Physics(world)
    world.scene.frame_end = 6
    physics.floor()
    physics.pad(kind="PASSIVE")
    crate = physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.14), 5.0)
    crate.data.materials.append(bpy.data.materials.new("wood"))
    physics.solid("hat", (0.05, 0.05, 0.02), (0, 0, 0.12), parent=crate)
    door = physics.body("flap", (0.3, 0.3, 0.01), (0.7, 0, 0.5), 1.0)
    hinge = world.link("hinge", None, (0.4, 0, 0.5))
    world.update()
    bpy.context.view_layer.objects.active = hinge
    bpy.ops.rigidbody.constraint_add(type="HINGE")
    hinge.rigid_body_constraint.object1 = crate
    hinge.rigid_body_constraint.object2 = door


@among(watched_bodies)
def hidden_in_renders(world: Any) -> None:
    """Build the same scene, with bodies and hinge hidden in renders."""
    falling(world)
    for obj in world.scene.objects:
        obj.hide_render = True


@among(watched_bodies)
def loose_bodies(world: Any) -> None:
    """Add bodies in a separate collection of the rigid-body world, and one outside the world."""
    physics = Physics(world)
    world.scene.frame_end = 6
    physics.floor()
    crate = physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.6), 5.0)
    loose = physics.body("loose", (0.1, 0.1, 0.1), (0, 0, 0.9), 5.0)
    bodies = world.scene.rigidbody_world.collection
    bodies.objects.unlink(loose)
    apart = bpy.data.collections.new("apart")
    bodies.children.link(apart)
    apart.objects.link(physics.body("third", (0.1, 0.1, 0.1), (0.05, 0, 1.2), 2.0))
    physics.pad(at=(0, 0, 0.005))
    crate.rigid_body.use_margin = True


@among(watched_bodies)
def whole_scene_is_bodies(world: Any) -> None:
    """Use the collection of the whole scene as that of the rigid-body world."""
    physics = Physics(world)
    world.scene.frame_end = 6
    physics.floor()
    everything = bpy.data.collections.new("everything")
    world.scene.collection.children.link(everything)
    for name in ("a", "b"):
        body = physics.body(name, (0.1, 0.1, 0.1), (0, 0, 0.3 + 0.4 * (name == "b")), 5.0)
        everything.objects.link(body)
    everything.objects.link(world.scene.objects["floor"])
    world.scene.rigidbody_world.collection = everything
    physics.pad(at=(0, 0, 0.005))


@among(watched_bodies)
def bodies_without_a_world(world: Any) -> None:
    physics = Physics(world)
    world.scene.frame_end = 6
    physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.3), 5.0)
    physics.floor()
    with bpy.context.temp_override(scene=world.scene):
        bpy.ops.rigidbody.world_remove()
    crate = world.scene.objects["crate"]
    world.key(crate, "location", {1: (0, 0, 0.3), 6: (0.3, 0, 0.1)})
