# SPDX-License-Identifier: GPL-3.0-or-later
"""A new sensor's Room is filled in, however the sensor is made; coverage splits no room."""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.api.home import Home
from bl_ext.user_default.angen_sensors.angen_addon.scene.home.rooms import room_at
from mathutils import Vector
from test_dropped import asset, drop

SIZE = 4.0


@pytest.fixture(params=["sensors", "places", "floors", "collections", "boxes"])
def home(world, request):
    """Add a kitchen (x from 0 to 4 m) and a hall (4.2 to 8.2 m), and say which is which."""
    for room, x in (("kitchen", 0.0), ("hall", 4.2)):
        name = f"Floor {room}" if request.param == "floors" else "Floor"
        slab = world.box((SIZE, SIZE, 0.1), (x + 2, 2, -0.05), name)
        if request.param == "collections":
            made = world.aside(room.capitalize(), slab)
            world.scene.collection.children.link(made)
        for y in (-0.1, SIZE + 0.1):
            world.box((SIZE + 0.4, 0.2, 2.5), (x + 2, y, 1.25), "Wall")
    for x in (-0.1, 4.1, 8.3):
        world.box((0.2, SIZE, 2.5), (x, 2, 1.25), "Wall")
    for room, x in (("kitchen", 3.0), ("hall", 5.0)):
        if request.param == "boxes":
            box = world.box((SIZE, SIZE, 2.5), (2 if room == "kitchen" else 6.2, 2, 1.25), room)
            box.angen_ignored, box.display_type = True, "WIRE"
        elif request.param == "places":
            world.box((0.5, 0.5, 0.5), (x, 3, 0.25), "Stool").angen_place.room = room
        elif request.param == "sensors":
            world.sensor("LIGHT", f"Light {room}", room=room).location = (x, 3, 2.2)
        else:
            # A sensor that no other sees, so that the floor must tell.
            world.sensor("LIGHT", f"Light {room}", room=room).location = (x, 3, -3)
    world.update()
    return world


def on_surface(point, normal):
    bpy.ops.angen.sensor_place(kind="PIR", location=point, normal=normal)
    return bpy.context.object


def at_the_cursor(point, normal):
    bpy.context.scene.cursor.location = Vector(point) + 0.05 * Vector(normal)
    bpy.ops.angen.sensor_add(kind="PIR")
    return bpy.context.object


def made_of_an_object(point, normal):
    made = bpy.data.objects.new("Detector", None)
    made.location = Vector(point) + 0.05 * Vector(normal)
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    bpy.context.view_layer.update()
    bpy.ops.angen.sensor_assign(kind="PIR")
    return made


def dropped(point, normal):
    made = asset("PIR")
    drop(made, point, normal)
    return made


@pytest.mark.parametrize("way", [on_surface, at_the_cursor, made_of_an_object, dropped])
def test_a_new_sensor_has_the_room_that_it_is_in(home, way):
    for room, x, normal in (("kitchen", 4.0, (-1, 0, 0)), ("hall", 4.2, (1, 0, 0))):
        assert way((x, 1.0, 1.5), normal).angen_sensor.room == room


def test_a_room_that_is_set_stays(home):
    made = asset("PIR")
    made.angen_sensor.room = "pantry"
    drop(made, (4.0, 1.0, 1.5), (-1, 0, 0))
    assert made.angen_sensor.room == "pantry"


def test_without_any_room_none_is_guessed(world):
    world.box((4, 4, 0.1), (0, 0, -0.05), "Floor kitchen")
    world.update()
    assert on_surface((0, 0, 0), (0, 0, 1)).angen_sensor.room == ""


def test_what_stands_between_or_below_tells_no_room(world):
    """A table of another name, the storey below, and a sensor behind a wall."""
    world.hall(4, 4, 2.5)
    world.box((4, 4, 0.1), (2, 2, -3.0), "Floor cellar")
    world.box((1, 1, 0.05), (2, 2, 0.7), "Table")
    world.sensor("LIGHT", "below", room="cellar").location = (2, 2, -1.5)
    world.sensor("LIGHT", "outside", room="garden").location = (2, -1, 1.5)
    depsgraph = world.update()
    assert room_at(depsgraph, Vector((2, 2, 1.5))) == ""
    world.sensor("LIGHT", "inside", room="study").location = (3.5, 3.5, 1.5)
    assert room_at(world.update(), Vector((2, 2, 1.5))) == "study"


def test_the_package_fills_in_the_room(world, tmp_path):
    world.hall(4, 4, 2.5)
    world.sensor("LIGHT", "Light", room="study").location = (3.5, 3.5, 1.5)
    path = str(tmp_path / "home.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    with Home.open(path) as home:
        assert home.add("PIR", at=(1, 0.1, 2), look=(0, 1, 0)).room == "study"
        assert home.add("PIR", at=(1, -3, 2)).room == ""
