# SPDX-License-Identifier: GPL-3.0-or-later
"""The room of a sensor: a field, with the rooms of the file to choose from."""

import bpy
import pytest

ops = bpy.ops.angen


@pytest.fixture
def listed(world, addon_part):
    """The rooms by sensor as `list` and the report tell them."""

    def rooms():
        describe = addon_part("angen_addon.output.describe").describe
        return {s.name: describe(s)["room"] for s in world.sensors()}

    return rooms


def test_the_room_is_a_field_and_the_property_of_older_files_still_counts(world, listed):
    world.switch("new").angen_sensor.room = "Hall"
    world.switch("old")["room"] = "Kitchen"
    both = world.switch("both")
    both["room"], both.angen_sensor.room = "Attic", "Cellar"
    world.switch("none")
    assert listed() == {"new": "Hall", "old": "Kitchen", "both": "Cellar", "none": ""}


def test_the_field_offers_the_rooms_of_the_file(world, addon_part):
    world.switch("a").angen_sensor.room = "Hall"
    world.switch("b")["room"] = "kitchen"
    world.switch("c").angen_sensor.room = "Hall"
    mark = world.box((1, 1, 1))
    mark.angen_ignored, mark.angen_sensor.room = True, "Alcove"
    known = addon_part("angen_addon.scene.sensors").known_rooms
    assert known(None, None, "") == ["Alcove", "Hall", "kitchen"]
    assert known(None, None, "L") == ["Alcove", "Hall"]


def test_noting_the_room_keeps_the_recording(world):
    sensor = world.switch("door")
    world.update()
    ops.simulate()
    sensor.angen_sensor.room = "Hall"
    world.update()
    assert ops.export_events.poll()


def test_a_sensor_keeps_its_room_in_a_file(world, tmp_path, listed):
    world.switch("door").angen_sensor.room = "Hall"
    path = str(tmp_path / "home.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert listed() == {"door": "Hall"}
