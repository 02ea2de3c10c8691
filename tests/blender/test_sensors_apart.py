# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors do not know of each other: whatever sensor is added to whatever scene, the others read
the same to the bit, in a run and at the playhead."""

import math

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import state
from pressure_scenes import Physics, live_problem
from tiers import mostly_slow

LAST = 6


# Scenes


def falling(world):
    """A crate falls on a pad, one on a table with a hinge; a hat hangs on the crate."""
    physics = Physics(world)
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


def hidden_in_renders(world):
    """The same, where renders show neither bodies nor hinge."""
    falling(world)
    for obj in world.scene.objects:
        obj.hide_render = True


def baked(world):
    falling(world)
    cache = world.scene.rigidbody_world.point_cache
    cache.frame_end = LAST + 2
    with bpy.context.temp_override(point_cache=cache):
        bpy.ops.ptcache.bake(bake=True)


def loose_bodies(world):
    """Bodies that are in a collection of their own beside the world's, and one in none of it."""
    physics = Physics(world)
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


def whole_scene_is_bodies(world):
    """The rigid-body world takes the collection that holds everything."""
    physics = Physics(world)
    physics.floor()
    everything = bpy.data.collections.new("everything")
    world.scene.collection.children.link(everything)
    for name in ("a", "b"):
        body = physics.body(name, (0.1, 0.1, 0.1), (0, 0, 0.3 + 0.4 * (name == "b")), 5.0)
        everything.objects.link(body)
    everything.objects.link(world.scene.objects["floor"])
    world.scene.rigidbody_world.collection = everything
    physics.pad(at=(0, 0, 0.005))


def bodies_without_a_world(world):
    physics = Physics(world)
    physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.3), 5.0)
    physics.floor()
    with bpy.context.temp_override(scene=world.scene):
        bpy.ops.rigidbody.world_remove()
    crate = world.scene.objects["crate"]
    world.key(crate, "location", {1: (0, 0, 0.3), LAST: (0.3, 0, 0.1)})


def door(world):
    """A keyed door that is its frame's child, and a handle held by a constraint."""
    frame = world.link("frame", None, (-0.3, 0, 0))
    leaf = world.box((0.6, 0.05, 2.0), (0.3, 0, 0), "leaf")
    leaf.parent = frame
    world.key(frame, "rotation_euler", {1: (0, 0, 0), LAST: (0, 0, 1.2)})
    handle = world.box((0.05, 0.2, 0.05), (0, 0, 0), "handle")
    handle.constraints.new("COPY_TRANSFORMS").target = leaf
    handle.hide_render = True


def person(world):
    """Somebody with bones walks over the pad; weighs something."""
    physics = Physics(world)
    physics.solid("floor", (3, 3, 0.1), (0, 0, -0.1))
    physics.pad()
    armature = bpy.data.armatures.new("bones")
    rig = world.link("rig", armature)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.edit_bones.new("leg")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    body = physics.carried("person", (0.1, 0.1, 0.5), (0, 0, 0.51), 70.0)
    body.parent = rig
    body.vertex_groups.new(name="leg").add(range(8), 1.0, "REPLACE")
    body.modifiers.new("bones", "ARMATURE").object = rig
    leg = rig.pose.bones["leg"]
    leg.rotation_mode = "XYZ"
    for frame in (1, LAST):
        leg.rotation_euler.x = 0.02 * frame
        leg.keyframe_insert("rotation_euler", frame=frame)
    world.key(rig, "location", {1: (-0.3, 0, 0), LAST: (0.2, 0, 0)})


def nodes(world):
    """Geometry nodes: cubes that exist nowhere else, and a zone that simulates."""
    tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    grid, cube = tree.nodes.new("GeometryNodeMeshGrid"), tree.nodes.new("GeometryNodeMeshCube")
    cube.inputs["Size"].default_value = (0.2, 0.2, 0.2)
    put, out = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("NodeGroupOutput")
    time, turn = (
        tree.nodes.new("GeometryNodeInputSceneTime"),
        tree.nodes.new("ShaderNodeCombineXYZ"),
    )
    tree.links.new(time.outputs[0], turn.inputs[2])
    tree.links.new(turn.outputs[0], put.inputs["Rotation"])
    tree.links.new(grid.outputs[0], put.inputs["Points"])
    tree.links.new(cube.outputs[0], put.inputs["Instance"])
    tree.links.new(put.outputs[0], out.inputs[0])
    world.box((1, 1, 1), (0, 0, -0.5), "scatter").modifiers.new("n", "NODES").node_group = tree
    zone = bpy.data.node_groups.new("zone", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        zone.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    first, last = zone.nodes.new("NodeGroupInput"), zone.nodes.new("NodeGroupOutput")
    begin = zone.nodes.new("GeometryNodeSimulationInput")
    end = zone.nodes.new("GeometryNodeSimulationOutput")
    begin.pair_with_output(end)
    move = zone.nodes.new("GeometryNodeSetPosition")
    move.inputs["Offset"].default_value = (-0.02, 0, 0)
    zone.links.new(first.outputs[0], begin.inputs[0])
    zone.links.new(begin.outputs["Geometry"], move.inputs[0])
    zone.links.new(move.outputs[0], end.inputs["Geometry"])
    zone.links.new(end.outputs["Geometry"], last.inputs[0])
    slider = world.box((0.3, 0.3, 0.3), (1.2, 0, 0), "slider")
    slider.modifiers.new("zone", "NODES").node_group = zone


def drivers(world):
    """Things that follow the frame, and each other."""
    box = world.box((0.4, 0.4, 0.4), (0.5, 0, 0), "box")
    box.driver_add("location", 0).driver.expression = "0.4 + frame / 40"
    other = world.box((0.3, 0.3, 0.3), (0, 0, -0.5), "other")
    driver = other.driver_add("location", 1).driver
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    variable.targets[0].id = box
    driver.expression = "var - 0.4"


def cloth(world):
    """A sheet falls on a ball that moves; particles rain."""
    points = [(x / 5 - 0.5, y / 5 - 0.5, 0) for y in range(6) for x in range(6)]
    faces = [(i, i + 1, i + 7, i + 6) for y in range(5) for i in range(6 * y, 6 * y + 5)]
    sheet = world.link("sheet", world.mesh(points, faces), (0.6, 0, 0.2))
    sheet.modifiers.new("cloth", "CLOTH")
    ball = world.box((0.3, 0.3, 0.3), (0.6, 0, 0), "ball")
    ball.modifiers.new("collision", "COLLISION")
    world.key(ball, "location", {1: (0.6, 0, 0), LAST: (0.6, 0.2, 0.1)})
    rain = world.box((1, 1, 0.1), (0.8, 0, 0.6), "rain")
    rain.modifiers.new("rain", "PARTICLE_SYSTEM")
    settings = rain.particle_systems[0].settings
    settings.count, settings.frame_start, settings.frame_end = 30, 1, 5
    settings.render_type, settings.instance_object = "OBJECT", ball
    settings.particle_size = 0.3


def instances(world):
    """A linked home: a collection that is shown twice and holds a lamp."""
    collection = bpy.data.collections.new("source")
    inner = bpy.data.objects.new("inner", world.box((0.3, 0.3, 0.3), (9, 9, 9), "mould").data)
    collection.objects.link(inner)
    shine = bpy.data.objects.new("bulb", bpy.data.lights.new("bulb", "POINT"))
    collection.objects.link(shine)
    for place in ((0.6, 0, 0), (0, 0.1, -0.7)):
        instance = world.link("instance", None, place)
        instance.instance_type, instance.instance_collection = "COLLECTION", collection
        world.key(instance, "location", {1: place, LAST: (0.2, 0.2, 0.2)})


SCENES = (
    falling,
    hidden_in_renders,
    baked,
    loose_bodies,
    whole_scene_is_bodies,
    bodies_without_a_world,
    door,
    person,
    nodes,
    drivers,
    cloth,
    instances,
)
# Added sensors: kind, and what is set.
CYCLES = {"engine": "CYCLES", "samples": 4, "update_rate": 24.0}
ADDED = {
    "range scan": ("PIR", {"rays": 9, "update_rate": 24.0}),
    "pyroelectric": ("PIR", {"model": "PYROELECTRIC", "update_rate": 24.0}),
    "switch": ("OPTICAL_SWITCH", {"update_rate": 24.0}),
    "swept switch": ("OPTICAL_SWITCH", {"swept": True, "update_rate": 2.0}),
    "pad": ("PRESSURE", {"update_rate": 24.0}),
    "walls by Cycles": ("LIGHT", {"method": "FOUR_WALL", **CYCLES}),
    "lux by Cycles": ("LIGHT", {"method": "ILLUMINANCE", **CYCLES}),
}


def furnish(world, scene):
    """The scene with a lamp, and with sensors that look through the middle of it."""
    world.scene.frame_start, world.scene.frame_end = 1, LAST
    bpy.context.scene.render.fps = 24
    # Few paths, and more of them in the reference, as in an ordinary run.
    world.scene.angen_light_reference = 16
    scene(world)
    world.scene.frame_end = LAST
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.energy, lamp.size = 10.0, 0.5
    world.key(world.link("lamp", lamp, (0, 0, 3)), "location", {1: (0, 0, 3), LAST: (1, 0, 3)})
    across = (0, -math.pi / 2, 0)
    world.switch("watch", range_max=4.0).rotation_euler = across
    world.switch("swept", range_max=4.0, swept=True, update_rate=6.0).rotation_euler = across
    world.pir("motion", rays=15).rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    warm = world.pir("warm", model="PYROELECTRIC")
    warm.location, warm.rotation_euler = (-1, 0, 0.2), (math.pi / 2, 0, -math.pi / 2)


def hang_meter(world):
    meter = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 4, "update_rate": 12.0}
    world.sensor("LIGHT", "meter", world.link("meter", None, (0.3, 0.3, 0.3)), **meter)


def add(world, what):
    kind, settings = ADDED[what]
    if kind == "PRESSURE":
        obj = world.box((0.2, 0.2, 0.01), (2, 2, 0.005), "added")
    else:
        obj = world.link("added", None, (0.5, -0.5, 1.5))
    return world.sensor(kind, "added", obj, **settings)


def recorded(world, *beside):
    """Every reading of a run, but of the sensors `beside`, to the bit."""
    tracks = world.run(1, LAST).tracks
    return {
        (name, column): repr(list(values))
        for name, track in tracks.items()
        if name not in beside
        for column, values in {**track.columns, "frame": track.frames}.items()
    }


def shown(world, *beside):
    """What the playhead shows at each frame, the light being measured there too; the same."""
    state.CACHE.live = None
    found = {}
    for frame in range(1, LAST + 1):
        world.scene.frame_set(frame)
        live = state.CACHE.live
        if live.left_to_do:
            live.do_the_rest(world.scene, bpy.context.view_layer)
        for name, reading in live.readings.items():
            if name not in beside:
                found[name, frame] = repr(reading), live_problem(name)
    return found


def differing(found, expected):
    """What is not the same in two sets of readings, in lines."""
    keys = [*expected, *(key for key in found if key not in expected)]
    return "\n".join(
        f"{key}: {found.get(key)}, not {expected.get(key)}"
        for key in keys
        if found.get(key) != expected.get(key)
    )


QUICK = ("range scan", "swept switch", "pad")


@pytest.mark.parametrize("scene", (falling, person, instances), ids=lambda scene: scene.__name__)
def test_sensors_without_cycles_change_nothing_in_a_run(world, scene):
    """The quick part of the test below: bodies, bones and instances."""
    furnish(world, scene)
    run = recorded(world)
    for what in QUICK:
        obj = add(world, what)
        assert differing(recorded(world, "added"), run) == "", f"beside {what}"
        bpy.data.objects.remove(obj)


@pytest.mark.parametrize("scene", mostly_slow(SCENES), ids=lambda scene: scene.__name__)
def test_no_sensor_changes_what_the_others_read(world, scene):
    furnish(world, scene)
    run, live = recorded(world), shown(world)
    assert differing(recorded(world), run) == "", "two runs are the same"
    hang_meter(world)
    assert differing(recorded(world, "meter"), run) == ""
    assert differing(shown(world, "meter"), live) == ""
    run, live = recorded(world), shown(world)
    for what in ADDED:
        obj = add(world, what)
        assert differing(recorded(world, "added"), run) == "", f"in a run beside {what}"
        assert differing(shown(world, "added"), live) == "", f"at the playhead beside {what}"
        bpy.data.objects.remove(obj)
