# SPDX-License-Identifier: GPL-3.0-or-later
"""Warmth that bodies leave in seats and beds: what an infrared array sees after they went."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.runtime.live import live_of
from bl_ext.user_default.angen_sensors.angen_addon.scene.animation import action_curves
from bl_ext.user_default.angen_sensors.residents.blender.settings import (
    add_resident,
    build_of,
    posed,
    show_pose,
)
from bl_ext.user_default.angen_sensors.residents.body.skeleton import Sort
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.thermal_array import array as arrays
from mathutils import Matrix, Vector

ROOM, SKIN = 21.0, 33.5
FPS = 2


@pytest.fixture
def room(world):
    """A stool 2 m below an array, in a room of 21 °C, at two frames a second."""
    world.scene.angen_ambient_temperature = ROOM
    world.scene.render.fps = FPS
    world.box((0.5, 0.5, 0.4), (0, 0, -2.2), "Stool")
    world.box((9, 9, 0.1), (0, 0, -2.5), "Floor")
    array(world)
    return world


def array(world, name="array", rate=FPS, **settings):
    plain = {"hold_time": 0.0, "rays": 10, "columns": 12, "rows": 12, **settings}
    return world.sensor("THERMAL_ARRAY", name, update_rate=rate, **plain)


def sitter(world, seconds, celsius=SKIN, at=(0, 0)):
    """Add a body that sits on the stool for some seconds; return the frame at which it is gone."""
    body = world.box((0.4, 0.4, 0.3), (*at, -1.85), "Sitter")
    body.angen_load.mass = 70.0
    body.angen_warmth.use_temperature, body.angen_warmth.temperature = True, celsius
    leaves = 1 + round(seconds * FPS)
    world.key(body, "location", {1: (*at, -1.85), leaves: (30, 0, -1.85)}, "CONSTANT")
    return leaves


def excess(world, recording, name="array"):
    return np.array(world.series(recording, name, "max_c"), float) - ROOM


def minutes_occupied(world, seconds):
    leaves = sitter(world, seconds)
    recording = world.run(1, leaves + 15 * 60 * FPS)
    occupied = np.array(world.series(recording, "array", "occupied"))
    assert occupied[: leaves - 1].all() and not occupied[-1]
    return np.count_nonzero(occupied[leaves - 1 :]) / FPS / 60.0


def test_after_a_long_stay_occupied_ends_minutes_later(room):
    assert 3.0 < minutes_occupied(room, 1200.0) < 10.0


def test_after_a_short_stay_occupied_ends_soon(room):
    assert 0.0 < minutes_occupied(room, 15.0) < 0.5


def test_switched_off_a_seat_is_cold_at_once(room):
    room.scene.angen_warmth_left = False
    assert minutes_occupied(room, 300.0) == 0.0


@pytest.mark.parametrize("needs", ["mass", "temperature"])
def test_only_warm_bodies_leave_warmth(room, needs):
    leaves = sitter(room, 60.0)
    body = bpy.data.objects["Sitter"]
    if needs == "mass":
        body.angen_load.mass = 0.0
    else:
        body.angen_warmth.use_temperature = False
    assert excess(room, room.run(1, leaves + 5))[leaves - 1 :] == pytest.approx(0.0, abs=1e-6)


def test_another_array_changes_no_reading(room):
    leaves = sitter(room, 30.3)
    alone = room.series(room.run(1, leaves + 60), "array", "frame_c")
    array(room, "other", rate=0.7)
    assert room.series(room.run(1, leaves + 60), "array", "frame_c") == alone


def test_live_and_simulated_readings_are_the_same(room):
    leaves = sitter(room, 20.0)
    last = leaves + 40
    recorded = room.series(room.run(1, last), "array", "frame_c")
    live, view_layer = live_of(room.scene), bpy.context.view_layer
    found = []
    for frame in range(1, last + 1):
        room.scene.frame_set(frame)
        live.follow(room.scene, view_layer, view_layer.depsgraph)
        found.append(live.readings["array"].reading.fields["frame_c"])
    assert found == recorded


def test_a_run_that_evaluates_every_frame_gives_the_same(room):
    """A driver that reads the frame lets nothing be skipped."""
    leaves = sitter(room, 40.0)
    skipped = room.series(room.run(1, leaves + 60), "array", "frame_c")
    other = room.box((0.1, 0.1, 0.1), (50, 0, 0), "driven")
    other.driver_add("location", 2).driver.expression = "frame * 0.001"
    assert room.series(room.run(1, leaves + 60), "array", "frame_c") == skipped


def test_the_print_moves_and_turns_with_the_seat(room):
    """The sitter was at the left of the stool, which then turns and is pushed to the front."""
    stool = bpy.data.objects["Stool"]
    leaves = sitter(room, 120.0, at=(-0.15, 0.0))
    keys = {1: (0, 0, -2.2), leaves + 2: (0.0, -0.3, -2.2)}
    room.key(stool, "location", keys, "CONSTANT")
    turns = {1: (0, 0, 0), leaves + 2: (0, 0, math.radians(90))}
    room.key(stool, "rotation_euler", turns, "CONSTANT")
    texts = room.series(room.run(1, leaves + 4), "array", "frame_c")
    before, after = (
        np.array(texts[k].split(";"), float).reshape(12, 12) - ROOM for k in (leaves, leaves + 2)
    )
    row, column = (np.average(np.arange(12), weights=before.sum(axis=a)) for a in (1, 0))
    assert column < 5.0 and row == pytest.approx(5.5, abs=0.3)
    row, column = (np.average(np.arange(12), weights=after.sum(axis=a)) for a in (1, 0))
    assert row > 7.0 and column == pytest.approx(5.5, abs=0.3)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_scaled_objects_and_units_change_nothing(room, scale):
    leaves = sitter(room, 30.0)
    plain = excess(room, room.run(1, leaves + 20))[leaves:]
    room.scene.unit_settings.scale_length = scale
    for obj in bpy.data.objects:
        obj.location /= scale
        obj.scale = (1 / scale,) * 3
    moving = bpy.data.objects["Sitter"].animation_data
    for curve in action_curves(moving.action, getattr(moving, "action_slot", None)):
        for point in curve.keyframe_points:
            point.co.y /= scale
    stool = bpy.data.objects["Stool"]
    stool.data.transform(Matrix.Diagonal((2.0, -0.5, 1.0, 1.0)))
    stool.scale = (0.5 / scale, 2.0 / scale, 1.0 / scale)
    assert excess(room, room.run(1, leaves + 20))[leaves:] == pytest.approx(plain, abs=0.05)


def test_the_reference_ray_caster_gives_the_same(room):
    leaves = sitter(room, 20.0)
    plain = room.series(room.run(1, leaves + 10), "array", "frame_c")
    room.scene.angen_ray_caster = "SCENE"
    assert room.series(room.run(1, leaves + 10), "array", "frame_c") == plain


def test_a_broken_body_leaves_warmth_and_a_huge_one_nothing(room):
    leaves = sitter(room, 20.0)
    body = bpy.data.objects["Sitter"]
    body.data.vertices[0].co.x = math.nan
    body.data.update()
    assert excess(room, room.run(1, leaves + 10))[leaves] > 1.0, "its other faces are there"
    body.data.vertices[0].co = (0, 0, 1e3)
    body.data.update()
    assert excess(room, room.run(1, leaves + 10))[leaves] == 0.0


def test_updates_that_are_answered_in_parts_give_the_same(room, monkeypatch):
    leaves = sitter(room, 20.0)
    plain = room.series(room.run(1, leaves + 60), "array", "frame_c")
    monkeypatch.setattr(arrays, "AT_ONCE", 7 * 12 * 12 * 10)
    recording = room.run(1, leaves + 60)
    assert room.series(recording, "array", "frame_c") == plain
    (sensor,) = room.sensors()
    assert explain(room.scene, sensor, recording, leaves + 1).headline.startswith("Occupied: 'St")


def test_a_pad_on_the_seat_changes_nothing(room):
    """Arrays see through its housing, and so the warmth is left in the seat beneath it."""
    leaves = sitter(room, 30.0)
    plain = room.series(room.run(1, leaves + 10), "array", "frame_c")
    bpy.ops.angen.sensor_add(kind="PRESSURE", preset="")
    pad = bpy.context.object
    pad.location, pad.rotation_euler, pad.scale = (0, 0, -2.01), (0, 0, 0), (10, 10, 1)
    room.update()
    assert room.series(room.run(1, leaves + 10), "array", "frame_c") == plain


def test_parts_of_a_body_can_be_far_apart(room):
    leaves = sitter(room, 20.0)
    plain = room.series(room.run(1, leaves + 10), "array", "frame_c")
    far = room.box((0.1, 0.1, 0.1), (0, 0, 0), "Far")
    far.parent = bpy.data.objects["Sitter"]
    far.location = (4e5, 4e5, 0)
    far.angen_warmth.use_temperature, far.angen_warmth.temperature = True, SKIN
    assert room.series(room.run(1, leaves + 10), "array", "frame_c") == plain


def test_a_seat_that_is_hidden_or_deleted(room):
    leaves = sitter(room, 20.0)
    stool = bpy.data.objects["Stool"]
    room.key(stool, "hide_viewport", {1: False, leaves + 3: True, leaves + 6: False}, "CONSTANT")
    assert excess(room, room.run(1, leaves + 10))[leaves + 3] == 0.0
    bpy.data.objects.remove(stool)
    assert excess(room, room.run(1, leaves + 10))[leaves] == 0.0


def test_explain_names_the_seat(room):
    leaves = sitter(room, 120.0)
    recording = room.run(1, leaves + 10)
    (sensor,) = room.sensors()
    found = explain(room.scene, sensor, recording, leaves + 1)
    assert found.headline.startswith("Occupied: 'Stool'") and not found.doubt
    assert "of who rested there before" in dict(found.facts)["Warmth left"]


@pytest.mark.slow
def test_a_resident_leaves_a_print_where_she_lay_and_none_where_she_stood(room):
    bpy.data.objects.remove(bpy.data.objects["Stool"])
    rig = add_resident(bpy.context, Sort.ADULT, Vector((0, 0, 0)), 0.0)
    left = {}
    for posture in ("standing", "lying"):
        rig.animation_data_clear()
        show_pose(rig, posed(build_of(rig), posture, (0.0, 0.0, -2.45), 0.0, -2.45))
        room.key(rig, "location", {1: tuple(rig.location), 61: (30.0, 0.0, 0.0)}, "CONSTANT")
        texts = room.series(room.run(1, 70), "array", "frame_c")
        left[posture] = np.array(texts[61].split(";"), float).reshape(12, 12) - ROOM
    assert left["standing"] == pytest.approx(0.0, abs=0.005)
    # Her head points along +x: heels on the left, hips and back on the right, 0.24 m a pixel.
    columns = np.flatnonzero((left["lying"] > 1.0).any(axis=0))
    assert columns[-1] - columns[0] >= 4 and len(columns) < columns[-1] - columns[0] + 1
