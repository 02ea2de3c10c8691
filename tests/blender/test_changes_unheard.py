# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes that Blender tells nobody of, or tells in unusual ways, and runs that must not depend on
where the playhead stood."""

import bpy
import pytest

FAR = 0.5


def nodes_that_instance(obj, from_frame):
    """Geometry nodes that put a square across the beam, 0.1 m ahead, from a frame on."""
    tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    time = tree.nodes.new("GeometryNodeInputSceneTime")
    late = tree.nodes.new("FunctionNodeCompare")
    late.operation = "GREATER_EQUAL"
    late.inputs["B"].default_value = from_frame
    point = tree.nodes.new("GeometryNodePoints")
    point.inputs["Position"].default_value = (0, 0, -0.1)
    grid = tree.nodes.new("GeometryNodeMeshGrid")
    put = tree.nodes.new("GeometryNodeInstanceOnPoints")
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(time.outputs["Frame"], late.inputs["A"])
    tree.links.new(late.outputs[0], put.inputs["Selection"])
    tree.links.new(point.outputs[0], put.inputs["Points"])
    tree.links.new(grid.outputs[0], put.inputs["Instance"])
    tree.links.new(put.outputs[0], out.inputs[0])
    obj.modifiers.new("scatter", "NODES").node_group = tree


def test_instances_that_appear_where_there_were_none_are_seen(world, each_caster):
    world.switch()
    nodes_that_instance(world.link("host", world.mesh([(9, 9, 9)], [])), from_frame=20)
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges[:19] == pytest.approx([FAR] * 19)
    assert ranges[19:] == pytest.approx([0.1] * 29, abs=1e-6)


def test_what_nodes_make_inside_a_collection_instance_is_seen(world, each_caster):
    world.switch()
    source = bpy.data.collections.new("source")
    host = bpy.data.objects.new("host", world.mesh([(9, 9, 9)], []))
    source.objects.link(host)
    nodes_that_instance(host, from_frame=0)
    instance = world.link("instance", None, at=(0, 0, -0.1))
    instance.instance_type, instance.instance_collection = "COLLECTION", source
    ranges = world.series(world.run(1, 3), "switch", "range_m")
    assert ranges == pytest.approx([0.2] * 3, abs=1e-6)


@pytest.mark.parametrize("when", ["frame_change_pre", "frame_change_post"])
def test_what_another_handler_does_to_a_mesh_is_seen(world, each_caster, when):
    world.switch()
    wall = world.wall(0.3)

    def handler(scene, depsgraph):
        if scene.frame_current == 10:
            for vertex in wall.data.vertices:
                vertex.co.z = 0.1
            wall.data.update()

    handlers = getattr(bpy.app.handlers, when)
    handlers.append(handler)
    try:
        ranges = world.series(world.run(1, 12), "switch", "range_m")
    finally:
        handlers.remove(handler)
    assert ranges[:9] == pytest.approx([0.3] * 9, abs=1e-6)
    assert ranges[10:] == pytest.approx([0.2] * 2, abs=1e-6)


def test_another_handler_costs_no_frames(world):
    world.switch(update_rate=1.0)
    seen = []

    def handler(scene, depsgraph):
        seen.append(scene.frame_current)

    bpy.app.handlers.frame_change_post.append(handler)
    try:
        world.run()
    finally:
        bpy.app.handlers.frame_change_post.remove(handler)
    assert seen[:-1] == [1, 25]


def driven_by(obj, path, sensor):
    driver = obj.driver_add(*path).driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.targets[0].id = sensor
    variable.targets[0].data_path = "angen_sensor.active"


@pytest.mark.parametrize("playhead", [1, 30])
def test_drivers_on_outputs_work_in_a_run_wherever_the_playhead_stood(world, playhead):
    """A flag that stands aside while the first switch is open; the first one opens at frame 24."""
    first = world.switch("first")
    world.key(world.wall(0.02), "location", {23: (0, 0, -0.02), 24: (9, 0, -0.02)})
    world.switch("second").location = (0, 5, 0)
    flag = world.wall(0.02, "flag")
    flag.location = (0, 5, -0.02)
    driven_by(flag, ("location", 0), first)
    flag.scale = (0.5, 0.5, 0.5)
    world.scene.frame_set(playhead)
    recording = world.run()
    assert world.series(recording, "first", "open") == [0] * 23 + [1] * 25
    # The driver sees an output from the next frame on.
    assert world.series(recording, "second", "open") == [0] * 24 + [1] * 24


@pytest.mark.parametrize("playhead", [1, 30])
def test_a_sensor_that_is_keyed_off_reports_nothing_then(world, playhead):
    switch = world.switch()
    world.key(switch, "angen_sensor.enabled", {1: True, 10: False, 20: True}, "CONSTANT")
    world.scene.frame_set(playhead)
    frames = list(world.run(1, 30).tracks["switch"].frames)
    assert frames == [*range(1, 10), *range(20, 31)]


def test_a_removed_sensor_does_not_stop_the_others_from_following(world):
    world.switch("gone")
    kept = world.switch("kept")
    world.key(world.wall(0.02), "location", {10: (0, 0, -0.02), 11: (9, 0, -0.02)})
    world.scene.frame_set(5)
    bpy.data.objects.remove(bpy.data.objects["gone"])
    world.scene.frame_set(11)
    assert kept.angen_sensor.active


def test_frames_before_the_start_raise_no_alarm(world):
    world.scene.frame_start = 5
    pir = world.pir()
    world.key(world.wall(1.0), "location", {3: (0, 0, -1), 6: (0, 0, -3)})
    for frame in range(1, 6):
        world.scene.frame_set(frame)
        assert not pir.angen_sensor.active


def test_keyed_outputs_are_what_their_keys_say(world):
    switch = world.switch()
    world.key(switch, "angen_sensor.active", {1: False, 10: False}, "CONSTANT")
    world.scene.frame_set(5)
    assert not switch.angen_sensor.active
    world.scene.frame_set(7)
    assert not switch.angen_sensor.active
