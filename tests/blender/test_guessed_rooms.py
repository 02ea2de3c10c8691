# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms of places: set, told by a collection or a volume, or guessed and said to be so."""

import bpy
import pytest


@pytest.fixture
def studio(world, addon_part):
    """One open room of 6 x 4 m with a detector at each end, and a table and two chairs between."""
    world.box((6, 4, 0.1), (3, 2, -0.05), "Floor")
    for name, x, room in (("PIR a", 0.3, "sleeping"), ("PIR b", 5.7, "kitchen")):
        sensor = world.sensor("PIR", name)
        sensor.location, sensor.angen_sensor.room = (x, 2, 2.2), room
    for name, x in (("Chair 1", 2.3), ("Chair 2", 3.7)):
        world.box((0.4, 0.4, 0.45), (x, 2, 0.225), name).angen_place.use = "SIT"

    def rooms():
        depsgraph = world.update()
        found = addon_part("residents.blender.places").read_places(world.scene, depsgraph)
        return {name: (p.room, p.room_guessed) for name, p in found.places.items()}

    return rooms


def test_rooms_between_which_is_no_wall_are_guessed(studio, addon_part):
    assert all(guessed for _, guessed in studio().values())
    checks = addon_part("angen_addon.doctor").CHECKS
    home = addon_part("angen_addon.doctor").Examined(
        bpy.context.scene, bpy.context.view_layer, bpy.context.evaluated_depsgraph_get()
    )
    ((text, _, objects),) = checks["rooms"](home)
    assert "'Chair 1', 'Chair 2'" in text and objects == ("Chair 1", "Chair 2")


def test_a_room_that_is_set_or_named_by_a_collection_is_not_guessed(studio):
    bpy.data.objects["Chair 1"].angen_place.room = "dining"
    kitchen = bpy.data.collections.new("Kitchen")
    bpy.context.scene.collection.children.link(kitchen)
    kitchen.objects.link(bpy.data.objects["Chair 2"])
    assert studio() == {"Chair 1": ("dining", False), "Chair 2": ("kitchen", False)}


def test_a_volume_that_marks_a_room_counts(studio, world):
    volume = world.box((6, 4, 2.5), (3, 2, 1.25), "dining")
    volume.angen_ignored, volume.display_type = True, "WIRE"
    assert set(studio().values()) == {("dining", False)}
