# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators as a user calls them, what they refuse, and how long a recording stays valid."""

import csv

import bpy
import pytest
from mathutils import Vector

ops = bpy.ops.angen
KINDS = ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")


@pytest.fixture
def door(world):
    """A switch that a door opens at frame 13 and closes at frame 37, sensed at every frame."""
    world.door(13, 37)
    world.switch("Front door")
    world.pir("Hall, PIR", hold_time=0.1)
    world.update()
    return world


DOOR_EVENTS = [
    ("0.000000", "1", "Front door", "OPTICAL_SWITCH", "open", "0"),
    ("0.500000", "13", "Front door", "OPTICAL_SWITCH", "open", "1"),
    ("1.500000", "37", "Front door", "OPTICAL_SWITCH", "open", "0"),
]


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


def test_a_new_pad_feels_what_stands_on_it(world):
    """No rigid body, a centimetre thick, in the same place as the box: it reads 5 kg."""
    bpy.ops.rigidbody.world_add()
    for name, size, z, kind in (("floor", 4.0, -2.0, "PASSIVE"), ("box", 0.2, 0.1, "ACTIVE")):
        bpy.context.view_layer.objects.active = world.box((size,) * 3, (0, 0, z), name)
        bpy.ops.rigidbody.object_add(type=kind)
        bpy.context.object.rigid_body.collision_shape = "BOX"
    bpy.context.object.rigid_body.mass = 5.0
    ops.sensor_add(kind="PRESSURE")
    bpy.context.object.angen_sensor.update_rate = 24.0
    recording = world.run()
    force = world.series(recording, "Pressure sensor", "force_n")
    assert force[-8:] == pytest.approx([5 * 9.81] * 8, rel=1e-3)
    assert world.series(recording, "Pressure sensor", "partners")[-1] == "box"


def test_sensor_add_with_a_preset(world):
    ops.sensor_add(kind="PRESSURE", preset="FSR_402_3K3")
    pressure = bpy.context.object.angen_sensor.pressure
    assert (pressure.load_resistor, pressure.hysteresis) == pytest.approx((3300.0, 0.1))
    with pytest.raises(RuntimeError, match=r"FSR_402_3K3.*there are THESIS"):
        ops.sensor_add(kind="PIR", preset="FSR_402_3K3")
    assert len(bpy.data.objects) == 1
    with pytest.raises(RuntimeError, match=r"there are THESIS, GL5516"):
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


def test_a_scene_whose_sensors_are_off_has_nothing_to_simulate(world):
    ops.sensor_add(kind="LIGHT")
    assert ops.simulate.poll()
    bpy.context.object.angen_sensor.enabled = False
    assert not ops.simulate.poll()


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return [tuple(row) for row in csv.reader(file)]


def test_simulate_and_export_events(door, tmp_path):
    assert ops.simulate() == {"FINISHED"}
    path = tmp_path / "events.csv"
    assert ops.export_events(filepath=str(path)) == {"FINISHED"}
    rows = read(path)
    assert rows[0] == ("time_s", "frame", "sensor", "kind", "field", "value")
    assert [row for row in rows if row[2] == "Front door"] == DOOR_EVENTS


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


def test_simulate_refuses_bad_parameters_and_names_the_sensor(door):
    bpy.data.objects["Front door"].angen_sensor.optical_switch.range_min = 9.0
    with pytest.raises(RuntimeError, match=r"Front door.*range_min"):
        ops.simulate()
    assert not ops.clear_recording.poll()


def test_export_samples_writes_a_file_a_sensor(door, tmp_path):
    door.switch("a/b")
    door.switch("a_b")
    ops.simulate()
    assert ops.export_samples(directory=str(tmp_path)) == {"FINISHED"}
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "Front door.csv",
        "Hall, PIR.csv",
        "a_b-2.csv",
        "a_b.csv",
    ]
    rows = read(tmp_path / "Hall, PIR.csv")
    assert rows[0] == ("time_s", "frame", "angle_rad", "moved")
    assert len(rows) == 1 + 48


def test_export_into_a_missing_folder_is_told(door, tmp_path):
    ops.simulate()
    with pytest.raises(RuntimeError, match="does not exist"):
        ops.export_events(filepath=str(tmp_path / "missing" / "events.csv"))
    with pytest.raises(RuntimeError, match="No such file"):
        ops.export_samples(directory=str(tmp_path / "missing" / "samples"))
    assert list(tmp_path.iterdir()) == []
