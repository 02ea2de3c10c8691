# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor survives duplicate, copy and paste, append, link, override and undo."""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError

ops = bpy.ops.angen
KINDS = ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")
ODD = {
    "PIR": {"range_max": 6.25, "rays": 33},
    "OPTICAL_SWITCH": {"threshold": 0.125, "aperture_rays": 7},
    "PRESSURE": {"load_resistor": 4700.0, "threshold": 12.5},
    "LIGHT": {"method": "ILLUMINANCE", "gamma": 0.75},
}


def make(world, kind):
    """Add a sensor with non-default settings, placed on a wall as its parent."""
    wall = world.box((0.2, 4, 3), at=(-0.1, 0, 1.5), name="wall")
    world.update()
    ops.sensor_place(kind=kind, location=(0, 1, 2), normal=(1, 0, 0), surface="wall", follow=True)
    sensor = bpy.context.object
    sensor.angen_sensor.update_rate = 12.5
    sensor["room"] = "hall"
    for name, value in ODD[kind].items():
        setattr(getattr(sensor.angen_sensor, kind.lower()), name, value)
    assert sensor.parent == wall
    world.update()
    return sensor


def check(sensor, kind):
    group = sensor.angen_sensor
    assert (group.kind, group.update_rate, sensor["room"]) == (kind, 12.5, "hall")
    for name, value in ODD[kind].items():
        assert getattr(getattr(group, kind.lower()), name) == value, name
    assert len(sensor.data.vertices) > 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("linked", [False, True])
def test_duplicate(world, kind, linked):
    sensor = make(world, kind)
    where = sensor.matrix_world.copy()
    bpy.ops.object.duplicate(linked=linked)
    double = bpy.context.object
    assert double != sensor and double.parent == sensor.parent
    world.update()
    assert double.matrix_world == where
    check(double, kind)
    assert (double.data == sensor.data) is linked
    double.angen_sensor.update_rate = 3.0
    check(sensor, kind)
    names = {s.name for s in world.sensors()}
    assert names == {sensor.name, double.name}


@pytest.mark.parametrize("kind", KINDS)
def test_copy_and_paste(world, kind, tmp_path):
    """Ctrl C and Ctrl V write a file and append it."""
    sensor = make(world, kind)
    name = sensor.name
    path = tmp_path / "buffer.blend"
    bpy.data.libraries.write(str(path), {sensor})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(path), link=False) as (source, target):
        target.objects = [o for o in source.objects if o == name]
    bpy.context.scene.collection.objects.link(target.objects[0])
    bpy.context.view_layer.update()
    check(target.objects[0], kind)


@pytest.mark.parametrize("kind", KINDS)
def test_override(world, kind, tmp_path):
    sensor = make(world, kind)
    devices = world.aside("devices", sensor, sensor.parent)
    linked = world.bring(world.save_library(tmp_path / "library.blend", devices))
    (library_sensor,) = [o for o in linked.all_objects if o.angen_sensor.kind != "NONE"]
    check(library_sensor, kind)
    bpy.context.view_layer.objects.active = library_sensor
    for operator in (ops.user_preset_apply, ops.preset_apply):
        with pytest.raises(RuntimeError, match="make it local or a library override"):
            operator()
    (own,) = [o for o in world.override(linked).all_objects if o.angen_sensor.kind != "NONE"]
    check(own, kind)
    bpy.context.view_layer.objects.active = own
    assert ops.preset_apply(preset="FSR_402" if kind == "PRESSURE" else "THESIS") == {"FINISHED"}
    check(library_sensor, kind)


@pytest.mark.parametrize("kind", KINDS)
def test_undo_and_redo(world, kind):
    make(world, kind)
    bpy.ops.ed.undo_push(message="made")
    preset = "FSR_402_3K3" if kind == "PRESSURE" else "THESIS"
    ops.sensor_add(kind=kind, preset=preset)
    name = bpy.context.object.name
    bpy.ops.ed.undo_push(message="added")
    bpy.ops.ed.undo()
    assert name not in bpy.data.objects
    (sensor,) = [o for o in bpy.data.objects if o.angen_sensor.kind != "NONE"]
    check(sensor, kind)
    bpy.ops.ed.redo()
    assert bpy.data.objects[name].angen_sensor.kind == kind
    assert len(world.sensors()) == 2


def test_a_fitted_door_is_undone_whole(world):
    leaf = world.box((0.9, 0.04, 2), at=(0, 0, 0), name="leaf")
    for vertex in leaf.data.vertices:
        vertex.co.x += 0.45
        vertex.co.z += 1
    world.box((4, 0.2, 0.6), at=(0, 0.12, 2.305), name="wall")
    world.update()
    bpy.context.view_layer.objects.active = leaf
    bpy.ops.ed.undo_push(message="built")
    ops.door_fit()
    bpy.ops.ed.undo_push(message="fitted")
    assert {"Switch leaf", "Flag leaf"} <= set(bpy.data.objects.keys())
    bpy.ops.ed.undo()
    assert set(bpy.data.objects.keys()) == {"leaf", "wall"}
    assert not bpy.data.objects["leaf"].children
    bpy.ops.ed.redo()
    assert bpy.data.objects["Flag leaf"].parent == bpy.data.objects["leaf"]


# Sensors from another file


@pytest.fixture
def library(world, tmp_path):
    """Save a file with a switch called "Door", 0.2 m from a wall, in a collection."""
    devices = world.aside("devices", world.switch("Door"), world.wall(0.2, "panel"))
    path = world.save_library(tmp_path / "library.blend", devices)
    world.scene.frame_end = 4
    return path


@pytest.mark.parametrize("link", [False, True])
def test_appended_and_linked_sensors_sense(world, library, link):
    world.bring(library, link)
    recording = world.run()
    assert world.series(recording, "Door", "range_m") == pytest.approx([0.2] * 4, abs=2e-5)


def test_two_sensors_of_the_same_name_are_refused_with_their_files(world, library):
    world.bring(library)
    world.switch("Door")
    with pytest.raises(AngenError) as error:
        world.run()
    for words in ("2 sensors", "'Door'", "library.blend", "this file", "rename"):
        assert words in str(error.value)
    with pytest.raises(RuntimeError, match="'Door'"):
        bpy.ops.angen.simulate()


def test_bake_passes_over_linked_sensors(world, library, fcurves):
    world.bring(library)
    world.switch("Local")
    world.update()
    bpy.ops.angen.simulate()
    assert bpy.ops.angen.bake_keyframes() == {"FINISHED"}
    assert len(fcurves(bpy.data.objects["Local"])) == 2


def test_assign_and_clear_refuse_linked_objects(world, library):
    world.bring(library)
    bpy.context.view_layer.objects.active = bpy.data.objects["Door"]
    for operator in (bpy.ops.angen.sensor_clear, bpy.ops.angen.sensor_assign):
        with pytest.raises(RuntimeError, match="linked"):
            operator()


def test_an_overridden_sensor_has_parameters_of_its_own(world, library):
    override = world.override(world.bring(library))
    sensor = next(o for o in override.all_objects if o.angen_sensor.kind != "NONE")
    sensor.angen_sensor.optical_switch.threshold = 0.3
    world.update()
    assert world.series(world.run(), sensor.name, "open") == [0] * 4
    assert sensor.override_library.reference.angen_sensor.optical_switch.threshold < 0.1
