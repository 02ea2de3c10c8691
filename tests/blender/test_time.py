# SPDX-License-Identifier: GPL-3.0-or-later
"""Time in the scene: sub-frames, playback, jumps, scrubbing, and animated parameters.

Also changes that Blender does not report, or reports in unusual ways.
"""

import random

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError as error


def walker(world, last=48):
    """Add a box that walks past the sensors, there and back."""
    box = world.box((0.4, 0.4, 1.8), name="walker")
    box.rotation_euler.y = 0.1
    world.key(box, "location", {1: (-2, 0, -1.5), last / 2: (2, 0, -1.5), last: (-2, 0, -1.5)})
    return box


def shown(sensor):
    return bool(sensor.angen_sensor.active), sensor.angen_sensor.value


def recorded(recording, name, frame):
    track = recording.tracks[name]
    index = track.at(frame)
    return bool(track.active[index]), track.value[index]


@pytest.fixture
def crossing(world):
    """Add a card of 1 cm that crosses a beam at 1 m/s, midway between two frames.

    It is in the beam for 10 ms of the 42 ms of a frame.
    """
    card = world.box((0.01, 0.1, 0.001), name="card", at=(0, 0, -0.1))
    metres_a_frame = 1 / 24
    place = (10.5 - 1) * metres_a_frame
    start, end = -place, 23 * metres_a_frame - place
    world.key(card, "location", {1: (start, 0, -0.1), 24: (end, 0, -0.1)})
    world.switch(update_rate=1000.0, threshold=0.3)
    world.scene.frame_end = 24
    return world


def test_a_card_between_two_frames_is_missed_without_substeps(crossing, each_caster):
    log = crossing.log(crossing.run())
    assert [row[1:] for row in log] == [["1", "switch", "OPTICAL_SWITCH", "open", "1"]]


@pytest.mark.parametrize("substeps", [5, 8, 16])
def test_a_card_between_two_frames_is_found_with_substeps(crossing, substeps):
    crossing.scene.angen_substeps = substeps
    log = crossing.log(crossing.run())
    assert [row[5] for row in log] == ["1", "0", "1"]
    # Its edges pass at frame 10.5 ± 0.12; the log has the first sub-frame at or after.
    for row, crosses in zip(log[1:], (10.38, 10.62), strict=True):
        frame, time = float(row[1]), float(row[0])
        assert crosses <= frame < crosses + 1 / substeps
        assert time == pytest.approx((frame - 1) / 24, abs=1e-6)
        assert float(row[1]) * substeps == pytest.approx(round(frame * substeps), abs=1e-4)
    assert any("." in row[1] for row in log)


@pytest.mark.parametrize("start", [1, 10, 25])
def test_a_part_of_a_run_has_the_readings_of_the_whole(world, start):
    """t = 0 stays at the scene's start; a first scan without a previous one is no movement."""
    walker(world)
    world.switch(update_rate=7.0, threshold=0.3, range_max=3.0, noise_sigma=0.01)
    whole, part = world.run(), world.run(start, 40)
    track = whole.tracks["switch"]
    first = next(i for i, frame in enumerate(track.frames) if frame >= start)
    last = next(i for i, frame in enumerate(track.frames) if frame > 40)
    assert list(part.tracks["switch"].frames) == list(track.frames[first:last])
    assert list(part.tracks["switch"].times) == list(track.times[first:last])
    assert list(part.tracks["switch"].value) == list(track.value[first:last])


def test_two_runs_are_equal_to_the_bit(world, figure):
    walker(world)
    world.pir(noise_sigma=0.02, rays=40)
    world.switch(noise_sigma=0.02, range_max=3.0)
    first, second = world.run(), world.run()
    assert first == second
    assert world.log(first) == world.log(second)
    assert len(set(first.tracks["switch"].value)) > 9, "there was noise"
    figure(f"0 of {sum(len(track) for track in first.tracks.values())} readings differ")


def test_another_seed_is_another_noise(world):
    world.wall(0.3)
    world.switch(noise_sigma=0.02)
    first = world.run().tracks["switch"]
    world.scene.angen_seed = 1
    assert not set(world.run().tracks["switch"].value) & set(first.value)


def test_playing_in_a_loop_shows_the_same_each_time(world):
    walker(world)
    sensor = world.pir(rays=40)
    first = []
    for turn in range(2):
        for frame in range(1, 49):
            world.scene.frame_set(frame)
            first.append(shown(sensor))
        assert first[:48] == first[-48:], turn
    assert any(active for active, _ in first)


def test_a_jump_is_never_movement(world, figure):
    """All objects moved, but no time passed."""
    walker(world)
    sensors = [world.pir(), world.pir("all tilts", sweep="ALL", vertical_fov=0.6, hold_time=5.0)]
    jump = random.Random(3)
    before = 1
    world.scene.frame_set(before)
    for _ in range(40):
        frame = jump.choice([f for f in range(1, 49) if abs(f - before) > 1])
        world.scene.frame_set(frame)
        assert [shown(sensor)[0] for sensor in sensors] == [False, False], (before, frame)
        before = frame
    figure("0 of 40 jumps")


def test_moving_something_while_paused_is_no_movement(world):
    wall = world.wall(2.0, size=20)
    sensor = world.pir()
    world.scene.frame_set(10)
    world.scene.frame_set(11)
    wall.location.z = -1.0
    world.update()
    world.scene.frame_set(12)
    assert not sensor.angen_sensor.active


def test_live_off_leaves_the_outputs_alone(world):
    world.wall(0.02)
    sensor = world.switch()
    world.scene.angen_live = False
    sensor.angen_sensor.active = True
    world.scene.frame_set(5)
    assert sensor.angen_sensor.active
    world.scene.angen_live = True
    world.scene.frame_set(6)
    assert not sensor.angen_sensor.active


def test_scrubbing_shows_what_was_recorded(world):
    walker(world)
    sensors = [world.pir(rays=40, update_rate=10.0), world.switch(threshold=1.6, range_max=3.0)]
    recording = world.run()
    assert world.bpy.ops.angen.simulate() == {"FINISHED"}
    scrub = random.Random(1)
    for _ in range(60):
        frame = scrub.randint(1, 48)
        world.scene.frame_set(frame)
        for sensor in sensors:
            active, value = recorded(recording, sensor.name, frame)
            assert shown(sensor) == (active, pytest.approx(value, abs=1e-5)), (sensor.name, frame)


def test_drivers_follow_the_recording(world):
    """An output drives a lamp, as users do, which must not count as an edit of the scene."""
    walker(world)
    sensor = world.switch(threshold=1.6, range_max=3.0)
    lamp = world.link("lamp", None, at=(9, 9, 9))
    driver = lamp.driver_add("location", 2).driver
    variable = driver.variables.new()
    variable.name, variable.targets[0].id = "active", sensor
    variable.targets[0].data_path = "angen_sensor.active"
    driver.expression = "active * 1.0"
    world.update()
    recording = world.run()
    world.bpy.ops.angen.simulate()
    for frame in (*range(1, 49), 3, 40, 12, 30):
        world.scene.frame_set(frame)
        depsgraph = world.update()
        active, _ = recorded(recording, "switch", frame)
        assert lamp.evaluated_get(depsgraph).matrix_world.translation.z == active, frame
    assert world.bpy.ops.angen.clear_recording.poll(), "the recording is still there"


# Animated and driven parameters are read at the frame; sensors that are off stay silent


def test_an_animated_threshold_is_read_at_each_frame(world, each_caster):
    world.wall(0.2)
    sensor = world.switch()
    world.key(sensor, "angen_sensor.optical_switch.threshold", {1: 0.1, 5: 0.3, 9: 0.1}, "CONSTANT")
    world.scene.frame_end = 12
    assert world.series(world.run(), "switch", "open") == [1] * 4 + [0] * 4 + [1] * 4


def test_an_animated_number_of_rays_is_no_movement(world):
    world.wall(2.0, size=20)
    sensor = world.pir()
    world.key(sensor, "angen_sensor.pir.rays", {1: 9, 5: 30}, "CONSTANT")
    world.scene.frame_end = 12
    assert world.series(world.run(), "pir", "moved") == [0] * 12


def test_a_driven_parameter_is_read_evaluated(world):
    world.wall(0.2)
    sensor = world.switch()
    driver = sensor.driver_add("angen_sensor.optical_switch.threshold").driver
    driver.expression = "frame / 20"
    world.scene.frame_end = 6
    # Frame 4 drives the threshold to exactly 0.2, at which the switch is still open.
    assert world.series(world.run(), "switch", "open")[:3] == [1, 1, 1]
    assert world.series(world.run(), "switch", "open")[4:] == [0, 0]


def test_an_animated_parameter_that_goes_wrong_stops_the_run_and_says_so(world):
    world.wall(0.2)
    sensor = world.switch()
    world.key(sensor, "angen_sensor.optical_switch.range_min", {1: 0.001, 5: 0.6}, "CONSTANT")
    with pytest.raises(error, match=r"'switch'.*range_min"):
        world.run()


def test_a_sensor_on_a_moving_parent_with_a_constraint(world):
    """The evaluated place counts: the parent is keyed, the sensor copies another's location."""
    world.wall(0.3)
    target = world.link("target", None)
    world.key(target, "location", {1: (0, 0, 0), 5: (0, 0, -0.2)})
    sensor = world.switch()
    sensor.constraints.new("COPY_LOCATION").target = target
    world.scene.frame_end = 5
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges == pytest.approx([0.3, 0.25, 0.2, 0.15, 0.1], abs=2e-5)


@pytest.mark.parametrize("scale", [(0, 0, 0), (1, 1, 0), (float("nan"), 1, 1)])
def test_a_sensor_without_a_direction_is_refused_by_name(world, scale):
    sensor = world.switch("Kitchen")
    sensor.scale = scale
    with pytest.raises(error, match="'Kitchen'"):
        world.run()


def test_a_sensor_at_nan_is_refused_by_name(world):
    world.switch("Kitchen").location.x = float("nan")
    with pytest.raises(error, match="'Kitchen'"):
        world.run()


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        ("PIR", "range_min", 4.0),
        ("PIR", "vertical_step", 0.0),
        ("PIR", "rays", 0),
        ("PIR", "update_rate", 0.0),
        ("OPTICAL_SWITCH", "range_max", 0.0),
        ("OPTICAL_SWITCH", "threshold", 0.7),
        ("OPTICAL_SWITCH", "aperture_rays", 0),
        ("OPTICAL_SWITCH", "hysteresis", 1.5),
    ],
)
def test_parameters_out_of_range_reach_the_user(world, kind, name, value):
    """Blender's property accepts them, and the run reports the error."""
    world.sensor(kind, "Kitchen", **{name: value})
    with pytest.raises(error, match=rf"'Kitchen'.*{name}"):
        world.run()


def test_bad_parameters_of_a_sensor_that_is_off_do_not_matter(world):
    world.switch("off", enabled=False, range_max=0.0)
    world.switch()
    assert list(world.run().tracks) == ["switch"]


# Changes that Blender does not report, or reports in unusual ways


FAR = 0.5


def nodes_that_instance(obj, from_frame):
    """Add geometry nodes that put a square across the beam, 0.1 m ahead, from a frame on."""
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
    world.instance("instance", source, (0, 0, -0.1))
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


def test_keyed_outputs_are_what_their_keys_say(world):
    switch = world.switch()
    world.key(switch, "angen_sensor.active", {1: False, 10: False}, "CONSTANT")
    world.scene.frame_set(5)
    assert not switch.angen_sensor.active
    world.scene.frame_set(7)
    assert not switch.angen_sensor.active
