# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked keys are the recording, in a separate action of the sensor, and change nothing else."""

from importlib import import_module

import bpy
import numpy as np
import pytest

ADDON = "bl_ext.user_default.angen_sensors"
ops = bpy.ops.angen
ACTIVE, VALUE = "angen_sensor.active", "angen_sensor.value"
SLOTS = bpy.app.version >= (4, 4)


@pytest.fixture
def door(world):
    """Add a switch that a door opens at frame 13 and closes at frame 37, sensed at every frame."""
    world.door(13, 37)
    world.switch("Front door")
    world.update()
    return world


def bake():
    assert ops.simulate() == {"FINISHED"}
    assert ops.bake_keyframes() == {"FINISHED"}


def sensor():
    return bpy.data.objects["Front door"]


def recording():
    return import_module(f"{ADDON}.angen_addon.recording.results").RESULTS.recording(
        bpy.context.scene
    )


def points(curve):
    return [tuple(point.co) for point in curve.keyframe_points]


def curve(fcurves, obj, path):
    (found,) = (c for c in fcurves(obj) if c.data_path == path)
    return found


def test_into_a_new_action_named_after_the_sensor(door, fcurves):
    bake()
    assert sensor().animation_data.action.name == "Front door readings"
    assert {c.data_path for c in fcurves(sensor())} == {ACTIVE, VALUE}
    assert points(curve(fcurves, sensor(), ACTIVE)) == [(1, 0), (13, 1), (37, 0)]
    count = len(bpy.data.actions)
    bake()
    assert len(bpy.data.actions) == count
    assert points(curve(fcurves, sensor(), ACTIVE)) == [(1, 0), (13, 1), (37, 0)]


def test_curves_evaluate_to_the_recording_at_every_frame(world, fcurves):
    """The detector sweeps and changes often, with substeps."""
    mover = world.box((0.5, 0.5, 0.5), at=(0, 0, -2), name="mover")
    world.key(mover, "location", {1: (-2, 0, -2), 48: (2, 0, -2)})
    world.pir("pir", vertical_fov=1.2, update_rate=37.0)
    world.scene.angen_substeps = 4
    world.update()
    bake()
    obj, track = bpy.data.objects["pir"], recording().tracks["pir"]
    assert len(track) > 60
    for path, column in ((ACTIVE, track.active), (VALUE, track.value)):
        found = curve(fcurves, obj, path)
        for frame, value in zip(track.frames, column, strict=True):
            assert found.evaluate(frame) == pytest.approx(value, abs=1e-6)
        changes = 1 + np.count_nonzero(np.diff(np.array(column, float)))
        assert len(found.keyframe_points) == changes
        assert {p.interpolation for p in found.keyframe_points} == {"CONSTANT"}


def test_beside_other_curves_of_the_object(door, fcurves):
    obj = sensor()
    door.key(obj, "rotation_euler", {1: (0, 0, 0), 48: (0, 0, 1)})
    door.key(obj, "angen_sensor.enabled", {1: True}, "CONSTANT")
    action = obj.animation_data.action
    before = {(c.data_path, c.array_index): points(c) for c in fcurves(obj)}
    bake()
    bake()
    assert obj.animation_data.action == action
    after = {(c.data_path, c.array_index): points(c) for c in fcurves(obj)}
    assert after.keys() == before.keys() | {(ACTIVE, 0), (VALUE, 0)}
    assert {key: after[key] for key in before} == before


def test_an_action_that_others_play_is_copied_first(door, fcurves, capfd):
    obj, other = sensor(), door.switch("Back door")
    for one in (obj, other):
        one.location = (0, 0, 0)
    other.location.x = 5
    door.key(obj, "rotation_euler", {1: (0, 0, 0), 48: (0, 0, 0)})
    shared = obj.animation_data.action
    other.animation_data_create().action = shared
    if SLOTS:
        other.animation_data.action_slot = obj.animation_data.action_slot
    door.update()
    bake()
    assert "its own copy" in capfd.readouterr().out
    assert obj.animation_data.action != other.animation_data.action
    assert shared in {obj.animation_data.action, other.animation_data.action}
    for one, name in ((obj, "Front door"), (other, "Back door")):
        track = recording().tracks[name]
        found = curve(fcurves, one, VALUE)
        assert points(found)[0] == pytest.approx((1, track.value[0]), abs=1e-6)
        assert sum(c.data_path == "rotation_euler" for c in fcurves(one)) == 3


@pytest.mark.skipif(not SLOTS, reason="Blender 4.4 has slots first")
def test_an_action_that_others_play_in_slots_of_theirs_is_not_copied(door, fcurves):
    leaf = bpy.data.objects["door"]
    action = leaf.animation_data.action
    before = [points(c) for c in fcurves(leaf)]
    sensor().animation_data_create().action = action
    door.update()
    bake()
    assert sensor().animation_data.action == action
    assert [points(c) for c in fcurves(leaf)] == before
    assert {c.data_path for c in fcurves(sensor())} == {ACTIVE, VALUE}


def test_a_driven_output_is_told(door, capfd):
    driver = sensor().driver_add(ACTIVE).driver
    driver.expression = "0"
    door.switch("Back door")
    door.update()
    bake()
    assert "'Front door' got no keyframes: a driver sets its outputs" in capfd.readouterr().out
    assert sensor().animation_data.action is None


def test_a_lamp_driven_by_the_sensor_follows_the_keys(door):
    lamp = door.link("lamp", bpy.data.lights.new("lamp", "POINT"))
    driver = lamp.data.driver_add("energy").driver
    driver.type = "SUM"
    target = driver.variables.new().targets[0]
    target.id, target.data_path = sensor(), ACTIVE
    door.update()
    bake()
    ops.clear_recording()
    door.scene.angen_live = False
    for frame in (20, 40, 13, 12, 36, 37):
        door.scene.frame_set(frame)
        energy = lamp.data.evaluated_get(bpy.context.evaluated_depsgraph_get()).energy
        assert energy == (13 <= frame < 37), frame


@pytest.mark.parametrize(("old", "new"), [(100, 200), (100, 90), (90, 100), (7, 11)])
def test_baked_outputs_play_as_they_were_logged_in_stretched_time(door, old, new):
    door.scene.render.frame_map_old, door.scene.render.frame_map_new = old, new
    door.scene.frame_end = 120
    bake()
    track = recording().tracks["Front door"]
    assert len(set(track.active)) == 2
    ops.clear_recording()
    door.scene.angen_live = False
    for frame in range(1, 121):
        door.scene.frame_set(frame)
        at = track.at(frame)
        assert sensor().angen_sensor.active == bool(track.active[at]), frame
        assert sensor().angen_sensor.value == pytest.approx(track.value[at]), frame


def test_keys_that_would_not_play_are_told(door, fcurves, capfd):
    sensor().keyframe_insert(VALUE, frame=1, group="Readings")
    curve(fcurves, sensor(), VALUE).mute = True
    bake()
    assert not curve(fcurves, sensor(), VALUE).mute
    door.scene.frame_set(20)
    assert sensor().angen_sensor.value == pytest.approx(0.5)
    group = curve(fcurves, sensor(), VALUE).group
    group.mute = True
    with pytest.raises(RuntimeError, match="No sensor could get keyframes"):
        ops.bake_keyframes()
    assert "group of F-curves 'Readings' is muted: unmute it" in "".join(capfd.readouterr())
    group.mute = False
    tracks = sensor().animation_data.nla_tracks
    tracks.new().strips.new("other", 1, bpy.data.actions.new("other"))
    tracks[0].is_solo = True
    ops.simulate()
    with pytest.raises(RuntimeError, match="No sensor could get keyframes"):
        ops.bake_keyframes()
    assert "an NLA track plays alone: end its solo" in "".join(capfd.readouterr())
