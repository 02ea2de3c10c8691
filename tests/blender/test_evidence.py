# SPDX-License-Identifier: GPL-3.0-or-later
"""`Recording.evidence` of each kind: the object, the part and the numbers behind each event."""

import math
import pickle

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.api.recording import Recording
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError
from light_stage import lamp


def recorded(world, last):
    """Simulate frames 1 to `last`; return the recording of scripts."""
    return Recording(world.run(1, last), {}, {})


def comes(world, body, at, frame=5):
    """Let a body appear at a place at a frame."""
    world.key(body, "location", {1: (9, 9, 9), frame: at}, "CONSTANT")
    return body


def last_event(world, sensor, field, last=6):
    """Return the last event of a field, for an explanation that agrees with it."""
    run = world.run(1, last)
    found = [one for one in Recording(run, {}, {}).evidence(sensor) if one.field == field][-1]
    index = run.tracks[sensor].at(found.frame)
    told = explain(world.scene, next(s for s in world.sensors() if s.name == sensor), run, index)
    assert told.cause_name == (found.objects[0] if found.objects else "")
    return found


def test_a_range_scan_tells_the_ray_and_its_ranges(world):
    world.wall(3.0)
    comes(world, world.box((1, 1, 1), name="Box"), (0, 0, -2.0))
    world.pir(rays=1, range_max=4.0)
    recording = recorded(world, 8)
    first, on, off = recording.evidence("pir")
    assert (first.value, first.objects, first.part) == (False, (), "")
    assert (on.time_s, on.frame) == (pytest.approx(4 / 24), 5.0)
    assert (on.field, on.value, on.objects) == ("moved", True, ("Box",))
    assert (on.part, on.measure) == ("tilt 0, ray 0", "range_m")
    assert (on.before, on.after) == pytest.approx((3.0, 1.5), abs=1e-5)
    assert (off.value, off.objects) == (False, ()), "no object ends a motion"
    last_event(world, "pir", "moved")


def test_a_pyroelectric_detector_tells_who_crossed_its_zones(world):
    world.wall(4.0, size=8.0)
    walker = world.box((0.5, 1.7, 0.3), name="Walker")
    world.warm(walker, 34.0)
    world.key(walker, "location", {1: (-1.5, -0.3, -2.5), 24: (1.5, -0.3, -2.5)})
    world.sensor("PIR", "pir", model="PYROELECTRIC", update_rate=24.0)
    on = next(one for one in recorded(world, 24).evidence("pir") if one.value)
    assert (on.objects, on.part, on.measure) == (("Walker",), "", "signal")
    assert abs(on.before) <= 1.0 < abs(on.after)


def test_a_switch_tells_what_broke_its_beam_and_what_freed_it(world):
    box = comes(world, world.box((1, 1, 1), name="Box"), (0, 0, -2.0), 3)
    box.keyframe_insert("location", frame=4)
    box.location = 9, 9, 9
    box.keyframe_insert("location", frame=5)
    world.switch(range_max=3.0, threshold=2.0)
    first, shut, wide = recorded(world, 6).evidence("switch")
    assert (first.value, first.objects, math.isnan(first.before)) == (True, (), True)
    assert (shut.value, shut.objects, shut.measure) == (False, ("Box",), "range_m")
    assert (shut.before, shut.after) == pytest.approx((3.0, 1.5))
    assert (wide.value, wide.objects, wide.before) == (True, ("Box",), pytest.approx(1.5))


def test_a_pad_tells_what_presses_and_with_what_force(world):
    pad = world.sensor("PRESSURE", "pad", world.box((1, 1, 0.02), name="pad"), update_rate=24.0)
    pad.angen_sensor.pressure.threshold = 10.0
    world.box((9, 9, 0.1), (0, 0, -0.06), "floor")
    comes(world, world.box((0.2, 0.2, 0.2), name="Box"), (0, 0, 0.11)).angen_load.mass = 5.0
    on = last_event(world, "pad", "pressed", 8)
    assert (on.value, on.objects, on.measure, on.before) == (True, ("Box",), "force_n", 0.0)
    assert on.after == pytest.approx(5 * 9.81, rel=1e-3)


def test_a_light_sensor_tells_the_lamp_that_changed(world):
    one = lamp(world, "POINT", at=(0, 0, 2), energy=100.0)
    one.name = "One"
    world.key(one.data, "energy", {1: 0.0, 4: 100.0}, "CONSTANT")
    sensor = world.sensor("LIGHT", "light", method="ILLUMINANCE", samples=64, update_rate=24.0)
    sensor.rotation_euler = math.pi, 0, 0
    on = last_event(world, "light", "illuminance_lux")
    assert (on.frame, on.objects, on.measure) == (4.0, ("One",), "illuminance_lux")
    assert (on.before, on.after) == (0.0, pytest.approx(on.value, rel=0.02))


def test_a_distance_sensor_tells_the_zone_and_what_is_in_it(world):
    world.wall(3.0, size=20.0)
    comes(world, world.box((0.4, 0.4, 0.4), name="Box"), (0.1, 0.1, -1.2))
    bpy.ops.angen.sensor_add(kind="DISTANCE", preset="VL53L5CX")
    made = bpy.context.object
    made.name, made.location, made.rotation_euler = "ranger", (0, 0, 0), (0, 0, 0)
    made.angen_sensor.update_rate, made.angen_sensor.distance.threshold = 24.0, 1.5
    near = last_event(world, "ranger", "near")
    assert (near.value, near.objects, near.measure) == (True, ("Box",), "distance_m")
    assert near.part.startswith("zone ")
    assert (near.before, near.after) == pytest.approx((3.0, 1.0), abs=0.1)


def test_a_contact_tells_the_magnet_and_how_far_it_went(world):
    magnet = world.link("magnet", None)
    world.key(magnet, "location", {1: (0.01, 0, 0), 4: (0.5, 0, 0)}, "CONSTANT")
    world.sensor("CONTACT", "contact", update_rate=24.0, magnet=magnet)
    on = last_event(world, "contact", "open")
    assert (on.value, on.objects, on.part) == (True, ("magnet",), "")
    assert (on.measure, on.before, on.after) == ("distance_m", pytest.approx(0.01), 0.5)


def test_an_array_tells_the_hottest_pixel_and_who_is_in_it(world):
    wall = world.wall(4.0, size=40.0)
    world.warm(wall, 21.0)
    body = comes(world, world.box((0.4, 0.9, 0.3), name="Person"), (0.1, 0.1, -2.0))
    world.warm(body, 33.0)
    bpy.ops.angen.sensor_add(kind="THERMAL_ARRAY", preset="AMG8833")
    made = bpy.context.object
    made.name, made.location, made.rotation_euler = "array", (0, 0, 0), (0, 0, 0)
    made.angen_sensor.update_rate = 24.0
    on = last_event(world, "array", "occupied", 24)
    assert (on.value, on.objects[0], on.measure) == (True, "Person", "max_c")
    assert on.part.startswith("pixel ") and on.before < on.after


def test_a_radar_tells_the_gate_and_who_is_in_it(world):
    body = world.box((0.4, 1.7, 0.2), name="Anna")
    body.angen_radar.substance = "BODY"
    world.key(body, "location", {1: (0, 0, -2.0), 6: (0, 0, -2.0), 24: (0, 0, -3.0)}, "LINEAR")
    bpy.ops.angen.sensor_add(kind="PRESENCE_RADAR", preset="LD2450")
    made = bpy.context.object
    made.name, made.location, made.rotation_euler = "radar", (0, 0, 0), (0, 0, 0)
    made.angen_sensor.update_rate = 24.0
    on = last_event(world, "radar", "moving", 24)
    assert (on.value, on.objects, on.measure) == (True, ("Anna",), "energy")
    assert on.part.startswith("gate ") and on.before < on.after


@pytest.mark.parametrize(
    ("kind", "settings", "field", "measure"),
    [
        ("APPLIANCE", {"load": "STOVE"}, "on", "power_w"),
        ("FLOW", {}, "flowing", "flow_lpm"),
    ],
)
def test_what_is_in_use_is_told_with_its_power_or_flow(world, kind, settings, field, measure):
    stove = world.box((0.6, 0.6, 0.9), name="Stove")
    world.key(stove, "angen_use.in_use", {1: False, 4: True}, "CONSTANT")
    world.sensor(kind, "plug", update_rate=24.0, watched=stove, **settings)
    on = last_event(world, "plug", field)
    assert (on.frame, on.value, on.objects, on.measure) == (4.0, True, ("Stove",), measure)
    assert on.before == 0.0 < on.after


def test_there_is_evidence_for_each_row_of_the_log_also_of_a_pickled_recording(world):
    world.wall(3.0)
    world.pir(noise_sigma=0.03)
    recording = pickle.loads(pickle.dumps(recorded(world, 48)))
    rows = [row for row in recording.events if row.sensor == "pir"]
    found = recording.evidence("pir")
    assert len(found) > 4
    assert [(f"{one.time_s:.6f}", one.field, f"{one.value:d}") for one in found] == [
        (row.time_s, row.field, row.value) for row in rows
    ]
    assert not any(one.objects for one in found), "noise is no object"
    assert all(np.isfinite([one.before, one.after]).all() for one in found if one.value)


def test_an_unknown_sensor_and_a_recording_without_evidence_are_one_clear_error(world):
    world.pir()
    recording = recorded(world, 3)
    with pytest.raises(AngenError, match=r"'pit' is not in this recording; its sensors are pir$"):
        recording.evidence("pit")
    recording._run.tracks["pir"].evidence.updates = 0
    with pytest.raises(AngenError, match="does not tell why 'pir' read this: simulate again"):
        recording.evidence("pir")
