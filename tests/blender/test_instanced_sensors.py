# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors in collection instances, of this file and of others: each has its own name and place."""

import csv
from math import radians

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.layout.describe import describe
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError, all_sensors

ops = bpy.ops.angen


@pytest.fixture
def collection(world):
    """Return a collection outside the scene with a switch "Door" and a leaf.

    The leaf opens at frame 25, and the beam to it is 0.2 m long. The front of the switch's housing
    is 1 cm before it.
    """
    sensor = world.switch("Door", range_max=0.5, threshold=0.3)
    sensor.angen_sensor.room = "hall"
    housing = world.wall(0.01, "housing", 0.1)
    housing.parent = sensor
    leaf = world.wall(0.2, "leaf")
    world.key(leaf, "location", {1: (0, 0, -0.2), 25: (5, 0, -0.2)}, "CONSTANT")
    made = world.aside("flat", sensor, housing, leaf)
    return made


def instance(world, collection, name, at, turn=0.0):
    holder = world.instance(name, collection, at)
    holder.rotation_euler.y = radians(turn)
    return holder


@pytest.fixture
def flats(world, collection):
    """Add two instances of the collection; only the second has a wall 0.1 m ahead."""
    instance(world, collection, "A", (0, 0, 0))
    instance(world, collection, "B", (10, 0, 0), 90)
    wall = world.wall(0.1, "wall")
    wall.location, wall.rotation_euler.y = (9.9, 0, 0), radians(90)
    world.update()
    return world


def test_each_instance_senses_at_its_own_place(flats, each_caster):
    assert [s.name for s in flats.sensors()] == ["A/Door", "B/Door"]
    recording = flats.run()
    near = flats.series(recording, "A/Door", "range_m")
    assert near[:24] == pytest.approx([0.2] * 24, abs=2e-5) and set(near[24:]) == {0.5}
    assert flats.series(recording, "B/Door", "range_m") == pytest.approx([0.1] * 48, abs=2e-5)
    rows = flats.log(recording)
    assert [r[1:6] for r in rows if r[5] == "1"] == [
        ["25", "A/Door", "OPTICAL_SWITCH", "open", "1"]
    ]


def test_a_sensor_meets_the_solid_housing_of_the_other_instance(world, collection):
    """Rays then pass only through the sensor's own housing, though both are the same object."""
    next(o for o in collection.objects if o.name == "Door").angen_sensor.housing_solid = True
    instance(world, collection, "A", (0, 0, 0))
    instance(world, collection, "B", (0, 0, -0.1))
    recording = world.run(1, 2)
    # The housing of B is a centimetre before B.
    assert world.series(recording, "A/Door", "range_m") == pytest.approx([0.11] * 2, abs=2e-5)
    assert world.series(recording, "B/Door", "range_m") == pytest.approx([0.1] * 2, abs=2e-5)


def test_an_original_in_the_scene_is_another_sensor(world, collection):
    world.scene.collection.children.link(collection)
    instance(world, collection, "A", (10, 0, 0))
    names = [s.name for s in world.sensors()]
    assert names == ["A/Door", "Door"]
    recording = world.run(1, 2)
    for name in names:
        assert world.series(recording, name, "range_m") == pytest.approx([0.2] * 2, abs=2e-5)


def test_instances_in_instances_and_their_offsets(world, collection):
    collection.instance_offset = (1, 2, 3)
    floor = bpy.data.collections.new("floor")
    for name, x in (("left", 0), ("right", 20)):
        holder = instance(world, collection, name, (x, 0, 0))
        world.scene.collection.objects.unlink(holder)
        floor.objects.link(holder)
    instance(world, floor, "House", (0, 100, 0), 180)
    sensors = world.sensors()
    assert [s.name for s in sensors] == ["House/left/Door", "House/right/Door"]
    depsgraph = world.update()
    places = [tuple(s.world_matrix(depsgraph).translation) for s in sensors]
    assert places[0] == pytest.approx((1, 98, 3), abs=1e-5)
    assert places[1] == pytest.approx((-19, 98, 3), abs=1e-5)
    recording = world.run(1, 2)
    for sensor in sensors:
        found = world.series(recording, sensor.name, "range_m")
        assert found == pytest.approx([0.2] * 2, abs=2e-5)


def test_a_moving_instance_takes_its_sensors_along(world, collection):
    holder = instance(world, collection, "A", (0, 0, 0))
    world.key(holder, "location", {1: (0, 0, 0), 10: (0, 0, 10)}, "CONSTANT")
    world.wall(0.3, "wall").location.z = 9.9
    found = world.series(world.run(8, 11), "A/Door", "range_m")
    assert found == pytest.approx([0.2, 0.2, 0.1, 0.1], abs=2e-5)


def test_two_ways_of_the_same_name_are_refused(flats):
    flats.switch("A/Door")
    with pytest.raises(AngenError, match=r"2 sensors.*'A/Door'"):
        flats.run(1, 2)


def test_what_an_instance_does_not_show_is_no_sensor(world, collection):
    hidden = bpy.data.collections.new("hidden")
    collection.children.link(hidden)
    hidden.objects.link(world.switch("Spare"))
    world.scene.collection.objects.unlink(bpy.data.objects["Spare"])
    instance(world, collection, "A", (0, 0, 0))
    assert [s.name for s in world.sensors()] == ["A/Door", "A/Spare"]
    hidden.hide_viewport = True
    assert [s.name for s in world.sensors()] == ["A/Door"]


def test_list_export_report_and_recording_name_them(flats, tmp_path):
    facts = {s.name: describe(s) for s in flats.sensors()}
    assert facts["B/Door"]["location"] == pytest.approx([10, 0, 0])
    assert facts["B/Door"]["room"] == "hall"
    assert ops.simulate() == {"FINISHED"}
    ops.export_samples(directory=str(tmp_path), folder="s")
    assert sorted(p.name for p in (tmp_path / "s").iterdir()) == ["A_Door.csv", "B_Door.csv"]
    ops.export_report(filepath=str(tmp_path / "report.html"))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "A/Door" in page and "B/Door" in page
    path = str(tmp_path / "home.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert ops.export_events.poll(), "the recording is kept"
    recording = RESULTS.recording(bpy.context.scene)
    sensors = all_sensors(bpy.context.view_layer)
    assert [recording.track_of(s.uid).sensor for s in sensors] == ["A/Door", "B/Door"]


def test_a_click_on_its_row_selects_the_instance(flats):
    assert ops.sensor_show(name="B/Door") == {"FINISHED"}
    assert bpy.context.object.name == "B"
    assert bpy.context.window_manager.angen_instanced == "B/Door"


@pytest.fixture
def linked(world, collection, tmp_path):
    """Link the collection from another file, and instance it twice, as File → Link does."""
    collection.instance_offset = (1, 0, 0)
    path = world.save_library(tmp_path / "library.blend", collection)
    world.scene.frame_end = 48
    with bpy.data.libraries.load(str(path), link=True) as (_, target):
        target.collections = ["flat"]
    for name, x in (("North", 1), ("South", 11)):
        instance(world, target.collections[0], name, (x, 0, 0))
    world.update()
    return world


def test_a_linked_home_is_simulated(linked, tmp_path):
    assert [s.name for s in linked.sensors()] == ["North/Door", "South/Door"]
    assert ops.simulate() == {"FINISHED"}
    ops.export_events(filepath=str(tmp_path / "events.csv"))
    with open(tmp_path / "events.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if row[5] == "1"]
    assert [(row[1], row[2]) for row in rows] == [("25", "North/Door"), ("25", "South/Door")]


def test_an_override_takes_the_place_of_an_instance_of_a_linked_home(linked, tmp_path):
    """It moves as in the library, at the instance's place, also in a saved file."""
    ops.sensor_show(name="South/Door")
    assert ops.instance_override() == {"FINISHED"}
    real = next(s for s in linked.sensors() if not s.holders)
    assert [s.name for s in linked.sensors()] == sorted([real.name, "North/Door"])
    real.settings.optical_switch.threshold = 0.15
    path = str(tmp_path / "home.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    real = next(s for s in linked.sensors() if not s.holders)
    assert tuple(real.object.matrix_world.translation) == pytest.approx((10, 0, 0))
    recording = linked.run(23, 26)
    assert linked.series(recording, real.name, "open") == [1, 1, 1, 1]
    assert linked.series(recording, "North/Door", "open") == [0, 0, 1, 1]
    found = linked.series(recording, real.name, "range_m")
    assert found == pytest.approx([0.2, 0.2, 0.5, 0.5], abs=2e-5)


def test_what_cannot_be_overridden_is_told(flats):
    bpy.context.view_layer.objects.active = bpy.data.objects["A"]
    with pytest.raises(RuntimeError, match="Its collection is in this file"):
        ops.instance_override()


def into(collection, world, *objects):
    for obj in objects:
        world.scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
    return collection


def test_pads_in_instances_feel_who_stands_on_them(world, physics):
    """Each pad carries the person on it; a person in the instance stands on the pad of each."""
    physics.frames(6)
    physics.solid("floor", (50, 50, 0.5), (0, 0, -0.5))
    pad = physics.pad("plate", (0.3, 0.3, 0.005))
    seat = physics.pad("seat", (0.3, 0.3, 0.005), (2, 0, 0.005))
    cat = physics.carried("Cat", (0.1, 0.1, 0.1), (2, 0, 0.11), 4.0)
    made = into(bpy.data.collections.new("mats"), world, pad, seat, cat)
    instance(world, made, "A", (0, 0, 0))
    instance(world, made, "B", (10, 0, 0)).rotation_euler = (0, 0, 0.5)
    physics.carried("Ann", (0.15, 0.1, 0.85), (0.05, -0.04, 0.86), 70.0)
    physics.carried("Bob", (0.15, 0.1, 0.85), (10.0, 0, 0.86), 80.0)
    read = physics.run()
    for name, mass in (("A/plate", 70), ("B/plate", 80), ("A/seat", 4), ("B/seat", 4)):
        assert read[name].known(after=2) == pytest.approx(mass * 9.81, rel=2e-3), name
    assert set(read["A/plate"].partners) == {"Ann"}
    assert set(read["B/plate"].partners) == {"Bob"}


@pytest.mark.parametrize("method", ["FOUR_WALL", "ILLUMINANCE"])
def test_a_light_sensor_in_an_instance_is_not_in_its_housings_shade(world, method):
    """It reads the same as a sensor of the scene, whose housing gives no shade either."""
    lamp = bpy.data.lights.new("lamp", "SUN")
    lamp.energy = 2.0
    world.link("lamp", lamp).rotation_euler.y = radians(-45)
    sensor = world.sensor("LIGHT", "Light", method=method, samples=16, update_rate=24.0)
    sensor.rotation_euler.x = radians(180)
    housing = world.box((0.3, 0.3, 0.3), name="housing")
    housing.parent = sensor
    plain = world.sensor("LIGHT", "Plain", method=method, samples=16)
    plain.rotation_euler.x, plain.location.x = radians(180), 50
    for x in (0, 50):
        world.box((0.1, 60, 10), (x + 3, 0, 0), "wall")
    inner = into(bpy.data.collections.new("inner"), world, sensor, housing)
    outer = bpy.data.collections.new("outer")
    into(outer, world, instance(world, inner, "kit", (0, 0, 0)))
    instance(world, inner, "A", (0, 0, 0))
    instance(world, outer, "B", (0, 20, 0))
    world.update()
    field = "illuminance_lux" if method == "ILLUMINANCE" else "luminance_percent"
    recording = world.run(1, 1)
    wanted = world.series(recording, "Plain", field)[0]
    assert wanted > 1.0
    for name in ("A/Light", "B/kit/Light"):
        found = world.series(recording, name, field)[0]
        assert found == pytest.approx(wanted, rel=0.2), name


def test_a_recording_is_stale_once_an_instance_is_moved_or_its_sensor_set(flats):
    ops.simulate()
    assert ops.export_events.poll()
    bpy.data.objects["B"].location.z += 1
    flats.update()
    assert not ops.export_events.poll()
    ops.simulate()
    bpy.data.objects["Door"].angen_sensor.optical_switch.threshold = 0.15
    flats.update()
    assert not ops.export_events.poll()
