# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that are dragged from the Asset Browser: they look out of their surface, and know it.

There is no window here: Blender's own drop is done by its rule (`view3d_ob_drop_matrix_from_snap`),
with the operator and the matrix that a drag gives it.
"""

import math

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.authoring import dropped as part
from bl_ext.user_default.angen_sensors.angen_addon.authoring.presets import (
    find_preset,
    new_sensor,
    select_only,
)
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS as kinds
from mathutils import Matrix, Vector

SURFACES = {
    "north": ((1.0, 4.0, 1.5), (0, -1, 0)),
    "east": ((5.0, 1.0, 1.5), (-1, 0, 0)),
    "south": ((2.0, 0.0, 1.2), (0, 1, 0)),
    "west": ((0.0, 2.0, 1.2), (1, 0, 0)),
    "floor": ((2.0, 2.0, 0.0), (0, 0, 1)),
    "ceiling": ((2.0, 2.0, 2.5), (0, 0, -1)),
}


def asset(kind, preset="", name="asset"):
    """Return a new sensor at the origin, as an appended asset."""
    sensor = new_sensor(bpy.context, kind, find_preset(kinds[kind], preset) if preset else None)
    sensor.name = name
    bpy.context.view_layer.update()
    return sensor


def drop_matrix(obj, point, normal, roll=0.0):
    """Return where Blender drops an object: its bounding box stands on the surface, +Z outwards.

    Its X and Y are those of the wall's object, in any order: the object can be rolled.
    """
    turned = Vector(normal).to_track_quat("Z", "Y").to_matrix() @ Matrix.Rotation(roll, 3, "Z")
    low, high = (Vector(map(of, zip(*obj.bound_box, strict=True))) for of in (min, max))
    under = Vector(((low.x + high.x) / 2, (low.y + high.y) / 2, low.z))
    size = obj.matrix_basis.to_scale()
    matrix = turned.to_4x4() @ Matrix.Diagonal((*size, 1.0))
    return Matrix.Translation(Vector(point) - matrix @ under) @ matrix


def drop(obj, point, normal, roll=0.0):
    """Drop an object on a surface, as at the end of a drag from the Asset Browser."""
    select_only(bpy.context, obj)
    matrix = drop_matrix(obj, point, normal, roll)
    columns = [list(column) for column in matrix.transposed()]
    done = bpy.ops.object.transform_to_mouse(
        "EXEC_DEFAULT", True, session_uid=obj.session_uid, matrix=columns
    )
    assert done == {"FINISHED"}
    bpy.context.view_layer.update()
    return matrix


def depths(obj, point, normal):
    """Return how far (m) the vertices of the housing's faces are in front of a surface."""
    solid = {i for face in obj.data.polygons for i in face.vertices}
    ahead = Vector(normal)
    return [(obj.matrix_basis @ obj.data.vertices[i].co - Vector(point)).dot(ahead) for i in solid]


@pytest.mark.parametrize("roll", [0, 90, 180, 270])
@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("kind", ["PIR", "DISTANCE", "PRESENCE_RADAR", "THERMAL_ARRAY", "LIGHT"])
def test_what_looks_has_its_back_on_the_surface_and_looks_out(world, kind, surface, roll):
    world.hall(5, 4, 2.5)
    point, normal = SURFACES[surface]
    sensor = asset(kind, kinds[kind].presets[0].identifier)
    drop(sensor, point, normal, math.radians(roll))
    axes = sensor.matrix_basis
    assert (axes.col[2].xyz + Vector(normal)).length < 1e-5, "looks out"
    if normal[2] == 0:
        assert axes.col[1].z == pytest.approx(1.0), "upright"
    assert min(depths(sensor, point, normal)) == pytest.approx(0.0, abs=1e-5), "its back touches"
    beside = sensor.matrix_basis.translation - Vector(point)
    assert (beside - beside.dot(Vector(normal)) * Vector(normal)).length < 1e-5, "at the mouse"


@pytest.mark.parametrize("surface", ["floor", "north"])
def test_a_pad_lies_and_a_switch_stands_on_the_surface(world, surface):
    world.hall(5, 4, 2.5)
    point, normal = SURFACES[surface]
    pad, switch = asset("PRESSURE", "FSR_402"), asset("OPTICAL_SWITCH", "TCST1103")
    for sensor in (pad, switch):
        drop(sensor, point, normal, math.pi / 2)
        assert min(depths(sensor, point, normal)) == pytest.approx(0.0, abs=1e-5)
    assert (pad.matrix_basis.col[2].xyz - Vector(normal)).length < 1e-5
    assert (switch.matrix_basis.col[1].xyz + Vector(normal)).length < 1e-5


def test_a_dropped_distance_sensor_reads_the_wall_across_the_room(world):
    world.hall(5, 4, 2.5)
    sensor = asset("DISTANCE", "VL53L1X")
    drop(sensor, *SURFACES["north"], math.pi / 2)
    _, directions, ranges = world.rays(sensor)
    level = abs(directions[:, 2]) < 0.02
    assert 3.7 < max(ranges[level]) < 4.0 and min(ranges) > 1.0


def test_a_sensor_stays_where_the_user_moves_it_after_the_drop(world):
    world.hall(5, 4, 2.5)
    sensor = asset("PIR")
    drop(sensor, *SURFACES["north"])
    moved = sensor.matrix_basis.copy()
    moved.translation.x += 0.5
    sensor.matrix_basis = moved
    bpy.context.view_layer.update()
    assert part._is_same(sensor.matrix_basis, moved)


@pytest.mark.parametrize("kind", ["PIR", "PRESSURE"])
def test_undo_that_brings_the_dropped_pose_back_places_the_sensor_again(world, kind):
    """Blender stores its step of undo before the sensor is placed."""
    world.hall(5, 4, 2.5)
    world.sensor("LIGHT", "lamp sensor", room="hall").location = (1, 2, 1)
    sensor = asset(kind)
    raw = drop(sensor, *SURFACES["floor"])
    placed = sensor.matrix_basis.copy()
    assert sensor.angen_sensor.room == "hall"
    # As Blender's undo does: the state of the drop, and no list of operators.
    operators = bpy.context.window_manager.operators
    sensor.matrix_basis, sensor.angen_sensor.room = raw, ""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(part, "_operators", list)
        part.note_edit(world.scene)
    assert len(operators) and part._is_same(sensor.matrix_basis, placed)
    assert sensor.angen_sensor.room == "hall"
    part.note_edit(world.scene)
    assert part._is_same(sensor.matrix_basis, placed)


def test_a_room_that_the_user_empties_stays_empty(world):
    world.hall(5, 4, 2.5)
    world.sensor("LIGHT", "lamp sensor", room="hall").location = (1, 2, 1)
    for kind in ("PIR", "PRESSURE"):
        sensor = asset(kind)
        drop(sensor, *SURFACES["floor"])
        sensor.angen_sensor.room = ""
        part.note_edit(world.scene)
        assert sensor.angen_sensor.room == ""


def test_other_objects_stay_as_dropped(world):
    world.hall(5, 4, 2.5)
    vase = world.box((0.1, 0.1, 0.3), name="vase")
    world.update()
    raw = drop(vase, *SURFACES["north"])
    assert (vase.matrix_basis.translation - raw.translation).length < 1e-6
    assert (vase.matrix_basis.col[2].xyz - raw.col[2].xyz).length < 1e-6


def test_a_dropped_sensor_has_its_real_size_in_centimetres(world):
    sensor = asset("PIR", "EKMC1601111")
    size = max(sensor.dimensions)
    world.scene.unit_settings.scale_length = 0.01
    world.hall(500, 400, 250)
    drop(sensor, (100, 400, 150), (0, -1, 0), math.pi / 2)
    assert max(sensor.dimensions) * 0.01 == pytest.approx(size, rel=1e-5)
    assert min(depths(sensor, (100, 400, 150), (0, -1, 0))) == pytest.approx(0.0, abs=1e-3)


def test_a_sensor_of_the_users_own_library_keeps_scale_and_mesh(world):
    world.hall(5, 4, 2.5)
    sensor = world.sensor("DISTANCE", "own", world.box((0.1, 0.1, 0.04)))
    sensor.scale = (2, 1, 1)
    world.update()
    drop(sensor, *SURFACES["east"], math.pi / 2)
    assert tuple(sensor.matrix_basis.to_scale()) == pytest.approx((2, 1, 1))
    assert (sensor.matrix_basis.col[2].xyz - Vector((1, 0, 0))).length < 1e-5
    assert min(depths(sensor, *SURFACES["east"])) == pytest.approx(0.0, abs=1e-5)
