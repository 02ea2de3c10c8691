# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor's own objects never stop its beam; a flag in a narrow gap always does."""

import math

import numpy as np
import pytest
from mathutils import Matrix

PLACES = {"origin": (0, 0, 0), "1 km": (1000, -300, 20), "10 km": (7000, 7000, -1000)}
# How far off a range may be where single precision stores places this coarsely (m).
ROUNDING = {"origin": 5e-6, "1 km": 2e-4, "10 km": 2e-3}
PARENTS = {
    "none": None,
    "small": Matrix.Diagonal((1e-3, 1e-3, 1e-3, 1)),
    "large": Matrix.Diagonal((1e3, 1e3, 1e3, 1)),
    "mirrored": Matrix.Diagonal((-1, 1, 1, 1)),
    "uneven": Matrix.Diagonal((0.1, 30, 2, 1)),
    "sheared": Matrix(((1, 0.4, 0.2, 0), (0, 1, 0.3, 0), (0, 0, 1, 0), (0, 0, 0, 1))),
}


def put_under(world, parent_matrix, place):
    """A parent at `place` with a matrix of its own, or None."""
    parent = world.link("parent", None)
    # A matrix with shear needs two objects: their rotation between two scales.
    if parent_matrix is not None:
        parent.matrix_parent_inverse = parent_matrix
        top = world.link("top", None, place)
        parent.parent = top
    else:
        parent.location = place
    return parent


def housing(world, sensor):
    """A box about the sensor, a lid before it as the box's child: both in the beam's way."""
    box = world.box((0.02, 0.02, 0.02), name="box")
    lid = world.box((0.02, 0.02, 0.001), at=(0, 0, -0.05), name="lid")
    box.parent, lid.parent = sensor, box


@pytest.mark.parametrize("kind", PARENTS)
@pytest.mark.parametrize("place", PLACES)
def test_the_housing_of_a_parented_sensor(world, figure, place, kind):
    parent = put_under(world, PARENTS[kind], PLACES[place])
    sensor = world.switch()
    sensor.parent = parent
    housing(world, sensor)
    world.update()
    wall = world.wall(0.3)
    pose = sensor.matrix_world
    ahead = -(pose.to_3x3() @ Matrix.Identity(3).col[2]).normalized()
    wall.matrix_world = (
        Matrix.Translation(pose.translation + ahead * 0.3)
        @ ahead.to_track_quat("Z", "Y").to_matrix().to_4x4()
    )
    world.update()
    found = world.range(sensor)
    figure(abs(found - 0.3), "m")
    assert found == pytest.approx(0.3, abs=ROUNDING[place])


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("place", PLACES)
def test_a_sensor_that_is_a_mesh_itself(world, place, scale):
    """Whatever its own scale: lengths of the sensor stay metres."""
    box = world.box((0.1, 0.1, 0.1), at=PLACES[place], name="housing")
    box.scale = (scale, scale, scale)
    sensor = world.switch(obj=box)
    wall = world.wall(0.3)
    wall.location = [a + b for a, b in zip(PLACES[place], (0, 0, -0.3), strict=True)]
    assert world.range(sensor) == pytest.approx(0.3, abs=ROUNDING[place])


def test_with_the_reference_caster_too(world):
    world.scene.angen_ray_caster = "SCENE"
    sensor = world.switch()
    housing(world, sensor)
    world.wall(0.3)
    assert world.range(sensor) == pytest.approx(0.3, abs=2e-5)


def test_another_sensors_housing_stops_the_beam(world, each_caster):
    sensor, other = world.switch(), world.switch("other")
    housing(world, sensor)
    other.location.z = -0.2
    housing(world, other)
    assert world.range(sensor) == pytest.approx(0.19, abs=2e-5)


def test_the_sensors_parent_stops_the_beam(world, each_caster):
    """A switch on a door frame: the frame is not the sensor's own."""
    frame = world.box((0.2, 0.2, 0.02), at=(0, 0, -0.1), name="frame")
    sensor = world.switch()
    sensor.parent = frame
    sensor.matrix_parent_inverse = Matrix.Translation((0, 0, 0.1))
    assert world.range(sensor) == pytest.approx(0.09, abs=2e-5)


GAP = {"threshold": 0.005, "range_max": 0.02, "range_min": 0.0005}


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("place", PLACES)
def test_a_flag_of_half_a_millimetre_in_a_gap_of_five(world, place, scale):
    """Two housings 5 mm apart, the flag in the middle, on a door that is parented and scaled."""
    door = world.link("door", None, PLACES[place])
    door.scale = (scale, scale, scale)
    sensor = world.switch(**GAP)
    receiver = world.box((0.01, 0.01, 0.01), at=(0, 0, -0.010), name="receiver")
    flag = world.box((0.02, 0.02, 0.0005), at=(0, 0, -0.0025), name="flag")
    for obj in (sensor, receiver, flag):
        obj.parent = door
        obj.matrix_parent_inverse = Matrix.Scale(1 / scale, 4)
    housing(world, sensor)
    reads = world.range(sensor)
    assert reads < 0.005, "the flag is in the gap"
    if place == "origin":
        assert reads == pytest.approx(0.00225, abs=5e-6)
    flag.hide_viewport = True
    reads = world.range(sensor)
    # The receiver is 5 mm off, as exactly as single precision can place it there.
    assert reads == pytest.approx(0.005, abs=ROUNDING[place])


@pytest.mark.parametrize("place", PLACES)
def test_a_flag_that_is_modelled_far_from_its_origin(world, place):
    """As where a user applied the location: vertices far away, the object at the origin."""
    offset = PLACES[place]
    sensor = world.switch(**GAP)
    sensor.location = offset
    flag = world.box((0.02, 0.02, 0.0005), name="flag")
    flag.data.transform(Matrix.Translation((offset[0], offset[1], offset[2] - 0.004)))
    # The range to where single precision stored the vertices is exact wherever that is.
    surface = max(vertex.co.z for vertex in flag.data.vertices)
    assert world.range(sensor) == pytest.approx(sensor.location.z - surface, abs=5e-6)


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("place", PLACES)
def test_a_slanted_card_far_from_its_origin(world, figure, place, turn):
    """A triangle modelled far away, met where its plane is, from the stored vertices."""
    offset = PLACES[place]
    sensor = world.switch()
    sensor.location = offset
    corners = [(-0.2, -0.2, -0.3), (0.3, -0.2, -0.25), (0.0, 0.3, -0.2)]
    points = [tuple(a + b for a, b in zip(c, offset, strict=True)) for c in corners]
    card = world.link("card", world.mesh(points, [(0, 1, 2)]))
    world.update()
    a, b, c = (np.array(vertex.co, np.float64) for vertex in card.data.vertices)
    normal = np.cross(b - a, c - a)
    place_of = np.array(sensor.matrix_world.translation, np.float64)
    expected = (normal @ (place_of - a)) / normal[2]
    sensor.rotation_euler.z = turn
    found = world.range(sensor)
    figure(abs(found - expected), "m")
    assert found == pytest.approx(expected, abs=5e-6)


@pytest.mark.parametrize("angle", [0, 30, 45])
def test_the_beam_passes_a_slit_beside_the_flag(world, each_caster, angle):
    """Half a millimetre free on the flag's side is enough for the beam."""
    sensor = world.switch(**GAP)
    sensor.rotation_euler.z = math.radians(angle)
    world.box((0.02, 0.02, 0.0005), at=(0.0105, 0, -0.0025), name="flag")
    assert world.range(sensor) == pytest.approx(0.02, abs=1e-6)
