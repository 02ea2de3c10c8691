# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators as a user calls them, and the errors that they report."""

import csv
import types
from pathlib import Path

import bpy
import pytest
from mathutils import Vector

ops = bpy.ops.angen
KINDS = ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")


@pytest.fixture
def door(world):
    """Add a switch that a door opens at frame 13 and closes at frame 37, sensed at every frame."""
    world.door(13, 37)
    world.switch("Front door")
    world.pir("Hall, PIR", hold_time=0.1)
    world.update()
    return world


@pytest.mark.parametrize("kind", KINDS)
def test_sensor_add(world, kind):
    world.scene.cursor.location = (1, 2, 3)
    other = world.box((1, 1, 1))
    world.update()
    other.select_set(True)
    assert ops.sensor_add(kind=kind) == {"FINISHED"}
    sensor = bpy.context.object
    assert sensor.angen_sensor.kind == kind
    assert sensor.angen_sensor.enabled
    assert sensor.angen_sensor.update_rate == (10.0 if kind == "PIR" else 1.0)
    assert bpy.context.selected_objects == [sensor]
    world.update()
    assert tuple(sensor.matrix_world.translation) == (1, 2, 3)


def test_sensor_add_of_an_unknown_preset_adds_nothing(world):
    with pytest.raises(RuntimeError, match="no such thing"):
        ops.sensor_add(kind="PIR", preset="no such thing")
    assert not bpy.data.objects


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_a_new_pad_lies_on_its_underside_at_the_cursor(world, scale):
    world.scene.unit_settings.scale_length = scale
    world.scene.cursor.location = (1, 2, 3)
    ops.sensor_add(kind="PRESSURE")
    pad = bpy.context.object
    assert pad.rigid_body is None
    world.update()
    corners = [pad.matrix_world @ v.co for v in pad.data.vertices]
    lo = [min(c[i] for c in corners) for i in range(3)]
    hi = [max(c[i] for c in corners) for i in range(3)]
    half = 0.15 / scale
    assert lo == pytest.approx([1 - half, 2 - half, 3])
    assert hi == pytest.approx([1 + half, 2 + half, 3 + 0.01 / scale])
    centre = Vector((0, 0, 0.005 / scale))
    for face in pad.data.polygons:
        assert face.normal.dot(face.center - centre) > 0, "faces look outwards"
    edges = [tuple(sorted(key)) for face in pad.data.polygons for key in face.edge_keys]
    assert all(edges.count(edge) == 2 for edge in edges), "closed"


def test_sensor_add_with_a_preset(world):
    ops.sensor_add(kind="PRESSURE", preset="FSR_402_3K3")
    pressure = bpy.context.object.angen_sensor.pressure
    assert (pressure.load_resistor, pressure.hysteresis) == pytest.approx((3300.0, 0.1))
    with pytest.raises(RuntimeError, match=r"FSR_402_3K3.*choose one of THESIS"):
        ops.sensor_add(kind="PIR", preset="FSR_402_3K3")
    assert len(bpy.data.objects) == 1
    with pytest.raises(RuntimeError, match=r"choose one of THESIS, GL5516"):
        ops.sensor_add(kind="LIGHT", preset="FSR_402_3K3")


def test_assigning_a_pad_warns_of_what_has_no_surface(world, capfd):
    empty, box = world.link("empty", None), world.box((1, 1, 1))
    world.update()
    bpy.context.view_layer.objects.active = empty
    assert ops.sensor_assign(kind="PRESSURE") == {"FINISHED"}
    assert "no surface" in capfd.readouterr().out
    bpy.context.view_layer.objects.active = box
    assert ops.sensor_assign(kind="PRESSURE") == {"FINISHED"}
    assert "no surface" not in capfd.readouterr().out
    assert ops.sensor_clear() == {"FINISHED"}
    assert box.angen_sensor.kind == "NONE"
    assert len(box.data.polygons) == 6, "the mesh stays as it was"


def test_sensor_assign_and_clear(world):
    box = world.box((1, 1, 1))
    world.update()
    bpy.context.view_layer.objects.active = box
    assert ops.sensor_assign(kind="PIR") == {"FINISHED"}
    assert (box.angen_sensor.kind, box.angen_sensor.update_rate) == ("PIR", 10.0)
    assert ops.sensor_assign(kind="OPTICAL_SWITCH") == {"FINISHED"}
    assert (box.angen_sensor.kind, box.angen_sensor.update_rate) == ("OPTICAL_SWITCH", 1.0)
    box.angen_sensor.update_rate = 5.0
    assert ops.sensor_assign(kind="PIR") == {"FINISHED"}
    assert box.angen_sensor.update_rate == 5.0, "the user chose it"
    assert ops.sensor_clear() == {"FINISHED"}
    assert box.angen_sensor.kind == "NONE"
    assert not ops.sensor_clear.poll()


@pytest.mark.parametrize(
    ("operator", "words"),
    [
        ("simulate", "Add a sensor first"),
        ("sensor_assign", "Select the object"),
        ("sensor_clear", "Select a sensor"),
        ("preset_apply", "Select a sensor"),
        ("bake_keyframes", "Simulate first"),
        ("export_events", "Simulate first"),
        ("export_samples", "Simulate first"),
        ("clear_recording", "There is no recording"),
    ],
)
def test_operators_say_why_they_cannot_run(world, operator, words):
    call = getattr(ops, operator)
    assert not call.poll()
    with pytest.raises(RuntimeError, match=words):
        call()


def test_sensor_add_needs_object_mode(world):
    box = world.box((1, 1, 1))
    world.update()
    bpy.context.view_layer.objects.active = box
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Object Mode"):
        ops.sensor_add(kind="PIR")


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return [tuple(row) for row in csv.reader(file)]


def test_simulate_a_part(door, tmp_path):
    assert ops.simulate(frame_start=10, frame_end=20) == {"FINISHED"}
    ops.export_samples(directory=str(tmp_path))
    rows = read(tmp_path / "Front door.csv")
    assert rows[0] == ("time_s", "frame", "open", "range_m")
    assert [row[1] for row in rows[1:]] == [str(frame) for frame in range(10, 21)]
    assert [row[2] for row in rows[1:]] == ["0"] * 3 + ["1"] * 8
    assert rows[1][0] == "0.375000", "t = 0 stays at the scene's start"


def test_simulate_refuses_reversed_frames(door):
    with pytest.raises(RuntimeError, match=r"20.*10"):
        ops.simulate(frame_start=20, frame_end=10)
    assert not ops.clear_recording.poll()


def test_export_into_a_missing_folder_is_told(door, tmp_path):
    ops.simulate()
    with pytest.raises(RuntimeError, match="does not exist"):
        ops.export_events(filepath=str(tmp_path / "missing" / "events.csv"))
    with pytest.raises(RuntimeError, match="does not exist"):
        ops.export_samples(directory=str(tmp_path / "missing" / "samples"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("home", "name"), [("", "home"), ("flat.v2.blend", "flat.v2")])
def test_other_tools_get_a_file_named_after_the_home_with_their_suffix(
    door, tmp_path, addon_part, home, name
):
    """Also before the home is saved for the first time."""
    if home:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / home))
    proposed = types.SimpleNamespace()
    manager = types.SimpleNamespace(fileselect_add=lambda _: None)
    operator = addon_part("operators.export_format").ANGEN_OT_export_format
    operator.invoke(proposed, types.SimpleNamespace(window_manager=manager), None)
    ops.simulate()
    path = tmp_path / Path(proposed.filepath).name
    ops.export_format(filepath=str(path), format="casas", start="2026-03-01T08:00")
    assert (tmp_path / f"{name} events.txt").is_file()


# Settings of the active sensor are copied to the selected sensors of its kind, and to no others


@pytest.fixture
def sensors(world):
    """Add three switches and a motion detector, all selected, the first switch active."""
    made = [world.switch(name) for name in ("one", "two", "three")] + [world.pir("pir")]
    world.update()
    for obj in made:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = made[0]
    group = made[0].angen_sensor
    group.update_rate, group.optical_switch.threshold = 7.0, 0.2
    group.optical_switch.aperture_rays = 5
    return made


def test_all_settings(sensors, capfd):
    _one, two, three, pir = sensors
    assert ops.copy_to_selected() == {"FINISHED"}
    for obj in (two, three):
        assert obj.angen_sensor.update_rate == 7.0
        assert obj.angen_sensor.optical_switch.threshold == pytest.approx(0.2)
        assert obj.angen_sensor.optical_switch.aperture_rays == 5
    assert pir.angen_sensor.update_rate == 24.0
    told = capfd.readouterr().out
    assert "9 settings from 'one' to 2 sensors" in told
    assert "Left out: 'pir' (another kind: Motion detector (PIR))" in told


def test_one_parameter(sensors, capfd):
    _one, two, three, _ = sensors
    three.select_set(False)
    ops.copy_to_selected(parameter="threshold")
    assert two.angen_sensor.optical_switch.threshold == pytest.approx(0.2)
    assert two.angen_sensor.optical_switch.aperture_rays == 1
    assert three.angen_sensor.optical_switch.threshold == pytest.approx(0.05)
    assert "threshold from 'one' to 1 sensor." in capfd.readouterr().out
    with pytest.raises(RuntimeError, match="no parameter 'hue': it has update_rate, range_min"):
        ops.copy_to_selected(parameter="hue")


def test_pointers_are_copied(world):
    pads = [world.sensor("PRESSURE", name, world.box((1, 1, 1))) for name in ("a", "b")]
    world.update()
    for pad in pads:
        pad.select_set(True)
    bpy.context.view_layer.objects.active = pads[0]
    pads[0].angen_sensor.pressure.partner_object = pads[1]
    ops.copy_to_selected()
    assert pads[1].angen_sensor.pressure.partner_object == pads[1]


def test_nothing_to_copy_to_is_told(world, sensors):
    _one, two, three, pir = sensors
    two.select_set(False)
    three.select_set(False)
    with pytest.raises(RuntimeError, match=r"to 0 sensors\. Left out: 'pir'"):
        ops.copy_to_selected()
    pir.select_set(False)
    with pytest.raises(RuntimeError, match="then the sensor to copy from"):
        ops.copy_to_selected()
    bpy.context.view_layer.objects.active = world.box((1, 1, 1))
    with pytest.raises(RuntimeError, match="Select the sensor to copy from"):
        ops.copy_to_selected()
