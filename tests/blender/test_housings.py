# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings of sensors: other sensors see through them, unless the user makes them solid."""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.instances import has_housing, is_housing
from bl_ext.user_default.angen_sensors.angen_addon.scene.marks import HOUSING_MARK
from panel_layout import drawn

ops = bpy.ops.angen
KINDS = {"PRESENCE_RADAR": "LD2410", "PIR": "", "THERMAL_ARRAY": "", "DISTANCE": ""}


def added(kind, name, preset="", at=(0, 0, 0)):
    """Add a sensor that looks along −Z."""
    ops.sensor_add(kind=kind, preset=preset)
    made = bpy.context.object
    made.name, made.matrix_world.translation = name, at
    made.rotation_euler = (0, 0, 0)
    made.angen_sensor.update_rate = 24.0
    return made


def walker(world):
    body = world.box((0.4, 1.7, 0.2), (0, 0, -2.5), "Anna")
    body.angen_radar.substance, body.angen_breathing.breathes = "BODY", "YES"
    world.warm(body, 33.0)
    world.key(body, "location", {1: (-0.5, 0, -2.5), 25: (0.5, 0, -3.0)}, "LINEAR")


def log(world, name):
    rows = [row for row in world.log(world.run(1, 24)) if row[2] == name]
    # The reference caster begins again behind a housing, and rounds there.
    return [(*row[:-1], round(float(row[-1] or 0), 4)) for row in rows]


@pytest.mark.parametrize("caster", ["FAST", "SCENE"])
@pytest.mark.parametrize("kind", KINDS)
def test_sensors_in_one_place_read_as_if_alone(world, kind, caster):
    world.scene.angen_ray_caster = caster
    walker(world)
    added(kind, "own", KINDS[kind])
    alone = log(world, "own")
    assert len(alone) > 1
    other = added("PRESENCE_RADAR", "other radar", "LD2410")
    added("PIR", "detector", at=(0, 0, -0.01))
    assert log(world, "own") == alone
    other.angen_sensor.housing_solid = True
    other.matrix_world.translation = (0, 0, -0.3)
    other.scale = (3, 3, 1)
    assert log(world, "own") != alone, "the user has made it solid"


def test_a_mesh_that_is_made_a_sensor_stays_solid(world):
    walker(world)
    added("DISTANCE", "own")
    door = world.box((2, 2, 0.05), (0, 0, -1), "Door")
    world.update()
    behind = log(world, "own")
    bpy.context.view_layer.objects.active = door
    ops.sensor_assign(kind="CONTACT")
    assert not has_housing(door) and log(world, "own") == behind
    bpy.data.objects.remove(door)
    assert log(world, "own") != behind


def test_housings_of_files_of_before_are_known_by_their_names_or_their_parents(world):
    named = added("PIR", "detector")
    del named.data[HOUSING_MARK]
    named.data.name = "Motion detector housing.001"
    assert is_housing(named)
    named.data.name = "door"
    assert not is_housing(named) and not has_housing(named)
    empty = world.sensor("PIR", "hung")
    empty.angen_sensor.kind = "PIR"
    body = world.box((0.1, 0.1, 0.1), (0, 0, 0), "body")
    assert not is_housing(body)
    body.parent = empty
    assert is_housing(body) and has_housing(empty)
    empty.angen_sensor.housing_solid = True
    assert not is_housing(body) and has_housing(empty)


def test_live_readings_follow_the_option_and_the_kind(world, field):
    own = added("DISTANCE", "own")
    other = added("PIR", "detector", at=(0, 0, -0.5))
    world.wall(2.0)

    def read(frame):
        field(frame)
        return own.angen_sensor.value

    assert read(1) == pytest.approx(2.0, abs=0.03)
    other.angen_sensor.housing_solid = True
    assert read(2) < 1.9
    other.angen_sensor.housing_solid = False
    assert read(3) == pytest.approx(2.0, abs=0.03)
    other.angen_sensor.kind = "NONE"
    assert read(4) < 1.9, "an ordinary object"


def test_a_swept_switch_is_not_broken_by_a_housing(world, swept):
    swept()
    passing = added("PIR", "detector")
    world.key(passing, "location", {1: (-1, 0, -0.1), 20: (1, 0, -0.1)}, "LINEAR")
    assert all(world.series(world.run(1, 20), "switch", "open"))
    passing.angen_sensor.housing_solid = True
    assert not all(world.series(world.run(1, 20), "switch", "open"))


def test_the_panel_has_the_option_where_there_is_a_housing(world):
    added("PIR", "detector")
    assert "housing_solid" in drawn("ANGEN_PT_physics").props
    bpy.context.view_layer.objects.active = world.sensor("PIR", "hung")
    assert "housing_solid" not in drawn("ANGEN_PT_physics").props


def test_a_light_sensor_reads_the_same_beside_a_detector(world):
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (0, 0, -2))
    lamp.data.energy = 50.0
    made = added("LIGHT", "lux")
    made.angen_sensor.light.method, made.angen_sensor.update_rate = "ILLUMINANCE", 1.0
    alone = world.run(1, 1).tracks["lux"].value
    added("PIR", "detector")
    assert list(world.run(1, 1).tracks["lux"].value) == list(alone)
