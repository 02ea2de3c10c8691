# SPDX-License-Identifier: GPL-3.0-or-later
"""A run leaves the scene unchanged, evaluates no frame in vain, and keeps only readings."""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.runtime.running import is_running
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError as error
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording


@pytest.fixture
def busy(world):
    """Set up a user at work: sub-frame, selection, Edit Mode, hidden objects."""
    mover = world.box((1, 1, 1), at=(0, 0, -2), name="mover")
    world.key(mover, "location", {1: (0, 0, -2), 48: (1, 0, -2)})
    edited = world.box((1, 1, 1), at=(5, 0, 0), name="edited")
    world.box((1, 1, 1), at=(0, 5, 0), name="hidden").hide_set(True)
    sensor = world.switch()
    world.pir()
    world.scene.frame_set(7, subframe=0.25)
    world.update()
    sensor.select_set(True)
    bpy.context.view_layer.objects.active = edited
    bpy.ops.object.mode_set(mode="EDIT")
    world.update()
    world.sensor_object = sensor
    return world


def test_a_run_leaves_everything_as_it_was(busy):
    before = busy.state()
    assert len(busy.run().tracks["switch"]) == 48
    assert busy.state() == before


def test_so_does_the_operator(busy):
    before = busy.state()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    # Only the mark of its recording, by which undo restores an earlier one.
    assert busy.scene.angen_recording == RESULTS.kept(busy.scene).mark
    busy.scene.angen_recording = 0
    assert busy.state() == before


@pytest.mark.usefixtures("frame_by_frame")
def test_so_does_a_run_with_substeps_that_is_closed_early(busy):
    busy.scene.angen_substeps = 3
    before = busy.state()
    recording = Recording()
    run = simulate(busy.scene, busy.sensors(), 1, 48, recording)
    for _ in range(30):
        next(run)
    run.close()
    assert busy.state() == before
    assert 0 < len(recording.tracks["switch"]) < 48, "what was recorded stays"
    assert not is_running()


def test_so_does_a_run_that_fails_half_way(busy):
    """The sensor's scale is keyed to zero at frame 30."""
    sensor = busy.sensor_object
    busy.key(sensor, "scale", {1: (1, 1, 1), 30: (0, 0, 0)}, "CONSTANT")
    busy.scene.frame_set(7, subframe=0.25)
    before = busy.state()
    with pytest.raises(error, match=r"'switch'.*scale"):
        busy.run()
    assert busy.state() == before
    assert not is_running()


@pytest.mark.usefixtures("frame_by_frame")
def test_a_run_ends_where_another_scene_is_shown(busy):
    """The recording is not taken for that scene's."""
    scene, before = busy.scene, busy.state()
    recording = Recording()
    run = simulate(scene, busy.sensors(), 1, 48, recording)
    for _ in range(10):
        next(run)
    other = bpy.data.scenes.new("other")
    bpy.context.window.scene = other
    with pytest.raises(error, match="another scene"):
        next(run)
    bpy.context.window.scene = scene
    bpy.data.scenes.remove(other)
    assert busy.state() == before
    assert len(recording.tracks["switch"]) == 10


def frames_evaluated(world, run):
    """Return the frames evaluated during a run, without the last, which resets the playhead."""
    seen = []

    def note(scene, depsgraph):
        seen.append(scene.frame_current_final)

    bpy.app.handlers.frame_change_post.append(note)
    try:
        run()
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    return seen[:-1]


def test_only_frames_on_which_a_sensor_samples_are_evaluated(world):
    world.switch(update_rate=1.0)
    world.switch("other", update_rate=3.0)
    world.switch("off", update_rate=24.0).angen_sensor.enabled = False
    assert frames_evaluated(world, world.run) == [1, 9, 17, 25, 33, 41]


@pytest.mark.parametrize("what", ["rigid body", "cloth", "nodes"])
def test_every_frame_is_evaluated_where_a_simulation_needs_it(world, what):
    world.switch(update_rate=1.0)
    box = world.box((1, 1, 1), at=(5, 5, 5))
    if what == "rigid body":
        world.update()
        bpy.context.view_layer.objects.active = box
        bpy.ops.rigidbody.world_add()
        world.scene.rigidbody_world.collection = bpy.data.collections.new("bodies")
        bpy.ops.rigidbody.object_add()
    elif what == "cloth":
        box.modifiers.new("cloth", "CLOTH")
    else:
        inner = bpy.data.node_groups.new("inner", "GeometryNodeTree")
        ends = inner.nodes.new("GeometryNodeSimulationOutput")
        inner.nodes.new("GeometryNodeSimulationInput").pair_with_output(ends)
        outer = bpy.data.node_groups.new("outer", "GeometryNodeTree")
        outer.nodes.new("GeometryNodeGroup").node_tree = inner
        box.modifiers.new("nodes", "NODES").node_group = outer
    assert frames_evaluated(world, world.run) == list(range(1, 49))
    # A part of the frames depends on those before it.
    assert frames_evaluated(world, lambda: world.run(25, 30)) == list(range(1, 31))


def test_a_falling_body_is_where_blender_drops_it(world):
    """Free fall in Bullet's steps of 1/600 s, before a switch that samples once a second."""
    body = world.box((0.2, 0.2, 0.2), at=(0, 0, -1))
    world.update()
    bpy.context.view_layer.objects.active = body
    bpy.ops.rigidbody.world_add()
    world.scene.rigidbody_world.collection = bpy.data.collections.new("bodies")
    bpy.ops.rigidbody.object_add()
    body.rigid_body.linear_damping = body.rigid_body.angular_damping = 0.0
    world.switch(update_rate=1.0, range_max=50.0)
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges[0] == pytest.approx(0.9, abs=1e-4)
    assert ranges[1] == pytest.approx(0.9 + 9.81 / 2, rel=0.03)


def test_an_empty_scene_runs_and_records_nothing(world):
    recording = world.run()
    assert recording.tracks == {} and world.log(recording) == []


def test_memory_grows_by_the_readings_alone(world):
    """By Python's own count: a run of twice as many frames keeps twice the readings."""
    import gc
    import tracemalloc

    mover = world.box((1, 1, 1), at=(0, 0, -2))
    world.key(mover, "location", {1: (0, 0, -2), 480: (1, 0, -2)})
    world.switch(update_rate=24.0)
    world.pir(update_rate=24.0)
    world.scene.frame_end = 480
    world.run()

    def held(last):
        gc.collect()
        before = tracemalloc.get_traced_memory()[0]
        recording = world.run(1, last)
        gc.collect()
        return tracemalloc.get_traced_memory()[0] - before, recording

    tracemalloc.start()
    try:
        (short, _), (long, recording) = held(120), held(480)
    finally:
        tracemalloc.stop()
    readings = sum(len(track) for track in recording.tracks.values())
    # A row is three or four floats and two bytes; arrays over-allocate by an eighth.
    assert long < 64 * readings + 40_000
    assert long - short < 64 * readings
