# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranges in a closed room against closed form: the exit of each ray from a box."""

import math

import numpy as np
import pytest

SIZE = np.array((5.0, 4.0, 2.6))
TOLERANCE_M = 5e-6
TURNS = [
    (0, 0, 0),
    (math.radians(90), 0, 0),
    (0.3, -1.1, 2.2),
    (-2.0, 0.7, 0.1),
]


def exits(origins, directions, lo, hi):
    """Distance (n,) at which rays from inside a box leave it."""
    with np.errstate(divide="ignore"):
        far = np.maximum((lo - origins) / directions, (hi - origins) / directions)
    return far.min(axis=1)


def turned(x, y, z):
    """The rotation matrix of Blender's XYZ Euler angles."""

    def about(axis, angle):
        i, j = [n for n in range(3) if n != axis]
        matrix, sign = np.eye(3), -1 if axis == 1 else 1
        matrix[i, i] = matrix[j, j] = math.cos(angle)
        matrix[i, j], matrix[j, i] = -sign * math.sin(angle), sign * math.sin(angle)
        return matrix

    return about(2, z) @ about(1, y) @ about(0, x)


def fan(rays, fov, tilts, step):
    """Directions (tilts · rays, 3) in the sensor's frame, from the interface's words."""
    found = []
    for k in range(tilts):
        for i in range(rays):
            azimuth = -fov / 2 + i * fov / (rays - 1)
            found.append(turned(-k * step, 0, 0) @ turned(0, azimuth, 0) @ (0, 0, -1))
    return np.array(found)


@pytest.mark.parametrize("turn", TURNS)
def test_every_range_in_a_room(world, each_caster, turn):
    centre, place = np.array((1.0, -2.0, 1.3)), np.array((2.2, -1.0, 2.0))
    world.box(SIZE, at=centre, name="room")
    sensor = world.pir(rays=40, range_max=50.0, vertical_fov=math.pi, sweep="ALL")
    sensor.location, sensor.rotation_euler = place, turn
    origins, directions, ranges = world.rays(sensor)
    expected = fan(40, math.radians(120), 18, math.radians(10)) @ turned(*turn).T
    np.testing.assert_allclose(directions, expected, atol=5e-7)
    np.testing.assert_allclose(origins, place + 0.05 * expected, atol=5e-7)
    free = exits(np.broadcast_to(place, expected.shape), expected, *corners(centre))
    assert np.abs(ranges + 0.05 - free).max() <= TOLERANCE_M


def corners(centre):
    return centre - SIZE / 2, centre + SIZE / 2


@pytest.mark.parametrize("system", ["METRIC", "NONE"])
def test_every_range_in_a_room_in_centimetres(world, each_caster, figure, system):
    world.scene.unit_settings.system = system
    world.scene.unit_settings.scale_length = 0.01
    metres = 0.01 if system == "METRIC" else 1.0
    world.box(SIZE / metres, name="room")
    sensor = world.pir(rays=120, range_max=50.0, vertical_fov=math.pi, sweep="ALL")
    sensor.location = np.array((0.3, 0.2, -0.1)) / metres
    sensor.rotation_euler = (0.3, -1.1, 2.2)
    origins, directions, ranges = world.rays(sensor)
    expected = exits(origins, directions, -SIZE / 2, SIZE / 2)
    figure(np.abs(ranges - expected).max(), "m")
    assert np.abs(ranges - expected).max() <= TOLERANCE_M
    np.testing.assert_allclose(np.linalg.norm(origins - (0.3, 0.2, -0.1), axis=1), 0.05, atol=1e-6)


def test_ranges_end_at_range_max(world, each_caster):
    world.box(SIZE, name="room")
    sensor = world.pir(rays=120, range_max=1.6)
    origins, directions, ranges = world.rays(sensor)
    free = exits(origins, directions, -SIZE / 2, SIZE / 2)
    np.testing.assert_allclose(ranges, np.minimum(free, 1.6 - 0.05), atol=TOLERANCE_M)
    assert (ranges < 1.5).any() and (free > 1.6).any(), "both cases are in the fan"


def test_what_is_nearer_than_range_min_is_not_seen(world, each_caster):
    world.wall(0.04, "near")
    world.wall(0.3, "far")
    assert world.range(world.switch(range_min=0.05)) == pytest.approx(0.3, abs=TOLERANCE_M)
    assert world.range(world.switch("other", range_min=0.03)) == pytest.approx(0.04, abs=1e-6)


def test_glass_stops_the_beam(world, each_caster):
    glass = world.bpy.data.materials.new("glass")
    glass.use_nodes = True
    shader = next(n for n in glass.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Transmission Weight"].default_value = 1.0
    shader.inputs["Alpha"].default_value = 0.0
    pane, _ = world.box((1, 1, 0.004), at=(0, 0, -0.1), name="pane"), world.wall(0.3)
    pane.data.materials.append(glass)
    assert world.range(world.switch()) == pytest.approx(0.098, abs=TOLERANCE_M)


def test_backfaces_stop_the_beam(world, each_caster, figure):
    wall = world.wall(0.2)
    assert world.range(world.switch()) == pytest.approx(0.2, abs=TOLERANCE_M)
    wall.rotation_euler.x = math.pi
    behind = world.range(world.switch("again"))
    figure(abs(behind - 0.2), "m")
    assert behind == pytest.approx(0.2, abs=TOLERANCE_M)


def test_a_beam_into_the_joint_of_two_panels_does_not_leak(world, each_caster, figure):
    for side in (-0.25, 0.25):
        world.box((0.5, 1, 0.02), at=(side, 0, -0.2))
    found = world.range(world.switch())
    figure(abs(found - 0.19), "m")
    assert found == pytest.approx(0.19, abs=TOLERANCE_M)
