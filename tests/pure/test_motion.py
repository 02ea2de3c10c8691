# SPDX-License-Identifier: GPL-3.0-or-later
"""Inverse dynamics from three poses, against motion in closed form."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.contact import motion
from angen_sensors.sensor_logic.contact.shapes import rotation_about
from hypothesis import given, settings
from hypothesis import strategies as st

DT = 1 / 24
GRAVITY = np.array((0.0, 0.0, -9.81))
UNIT = np.array((1.0, 1.0, 1.0))


def pose(place=(0, 0, 0), axis=(0, 0, 1), angle=0.0, scale=1.0):
    matrix = np.eye(4)
    axis = np.array(axis, float)
    matrix[:3, :3] = rotation_about(axis / np.linalg.norm(axis), angle) * scale
    matrix[:3, 3] = place
    return matrix


def three(place, angle=lambda t: 0.0, axis=(0, 0, 1), dt=DT):
    return [pose(place(t), axis, angle(t)) for t in (-dt, 0.0, dt)]


def test_free_fall_needs_nothing():
    moved = motion.motion(*three(lambda t: (0, 0, -t - 9.81 * t * t / 2)), DT, 0.1)
    assert moved.acceleration == pytest.approx(GRAVITY)
    assert motion.wrench(moved, pose(), 2.0, UNIT, GRAVITY) == pytest.approx(np.zeros(6), abs=1e-9)


def test_rest_needs_the_weight():
    moved = motion.motion(*three(lambda t: (1, 2, 3)), DT, 0.1)
    need = motion.wrench(moved, pose((1, 2, 3)), 5.0, UNIT, GRAVITY)
    assert need == pytest.approx((0, 0, 49.05, 0, 0, 0))


def test_acceleration_and_speed():
    moved = motion.motion(*three(lambda t: (3 * t + t * t, 0, 4 * t * t)), DT, 0.1)
    assert moved.acceleration == pytest.approx((2, 0, 8))
    assert moved.velocity == pytest.approx((3, 0, 0))
    need = motion.wrench(moved, pose(), 2.0, UNIT, GRAVITY)
    assert need[:3] == pytest.approx((4, 0, 2 * (9.81 + 8)))


@pytest.mark.parametrize("damping", [0.0, 0.04, 0.5, 0.9])
def test_damping_is_the_engines(damping):
    """v(t + dt) = v·(1 − d)^dt: with that fall-off no contact force is needed."""
    rate = -math.log(1 - damping)
    dt = 1e-3
    moved = motion.motion(
        *three(lambda t: (2 * (1 - math.exp(-rate * t)) / rate if rate else 2 * t, 0, 0), dt=dt),
        dt,
        0.1,
    )
    need = motion.wrench(moved, pose(), 3.0, UNIT, np.zeros(3), damping)
    assert need[:3] == pytest.approx((0, 0, 0), abs=1e-4)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (1, 2, -1)])
def test_turning(axis):
    """θ = 2t + 3t²/2 about an axis: spin 2, its change 3."""
    moved = motion.motion(*three(lambda t: (0, 0, 0), lambda t: 2 * t + 1.5 * t * t, axis), DT, 1.0)
    unit = np.array(axis) / np.linalg.norm(axis)
    assert moved.spin == pytest.approx(2 * unit)
    assert moved.spin_change == pytest.approx(3 * unit)
    inertia = np.array((0.1, 0.2, 0.3))
    need = motion.wrench(moved, pose(), 1.0, inertia, np.zeros(3))
    gyroscopic = np.cross(2 * unit, inertia * 2 * unit)
    assert need[3:] == pytest.approx(inertia * 3 * unit + gyroscopic)


def test_inertia_turns_with_the_body():
    """A rod along its own x that lies along y is easy to turn about y."""
    moved = motion.RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3), np.array((0, 1.0, 0)), 0.0)
    lying = pose(axis=(0, 0, 1), angle=math.pi / 2)
    need = motion.wrench(moved, lying, 1.0, np.array((0.01, 1.0, 1.0)), np.zeros(3))
    assert need[3:] == pytest.approx((0, 0.01, 0), abs=1e-12)


@pytest.mark.parametrize("speed", [0.0005, 0.009])
def test_the_engines_jitter_is_rest(speed):
    places = [(0, 0, 0), (0, 0, speed * DT), (0, 0, 0)]
    moved = motion.motion(*(pose(place) for place in places), DT, 0.1)
    assert not moved.acceleration.any() and not moved.velocity.any()


def test_faster_than_rest_is_motion():
    places = [(0, 0, 0), (0, 0, 0.02 * DT), (0, 0, 0)]
    moved = motion.motion(*(pose(place) for place in places), DT, 0.1)
    assert moved.acceleration[2] == pytest.approx(-0.04 / DT)


def test_reach_is_the_way_of_a_frame():
    moved = motion.motion(*three(lambda t: (24 * t, 0, 0), lambda t: 12 * t), DT, 0.5)
    assert moved.reach == pytest.approx(1.0 + 0.5 * 0.5)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    st.floats(1e-6, 3.1),
)
def test_rotation_vector(axis, angle):
    unit = np.array(axis) / np.linalg.norm(axis)
    assert motion.rotation_vector(rotation_about(unit, angle)) == pytest.approx(
        angle * unit, rel=1e-6, abs=1e-9
    )


@pytest.mark.parametrize("scale", [1.0, 0.01, -1.0, -2.5])
def test_rotation_of_scaled_and_mirrored_poses(scale):
    turned = pose(axis=(1, 2, 3), angle=0.7, scale=scale)
    assert motion.rotation_of(turned) == pytest.approx(pose(axis=(1, 2, 3), angle=0.7)[:3, :3])


def test_a_mirrored_body_that_stands_still_does_not_turn():
    mirrored = pose() @ np.diag((-1.0, 1, 1, 1))
    moved = motion.motion(mirrored, mirrored, mirrored, DT, 0.1)
    assert not moved.spin.any() and not moved.acceleration.any()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_nowhere_is_not_finite(bad):
    with np.errstate(invalid="ignore"):
        moved = motion.motion(pose(), pose((bad, 0, 0)), pose(), DT, 0.1)
        need = motion.wrench(moved, pose((bad, 0, 0)), 1.0, UNIT, GRAVITY)
    assert not np.isfinite(need).all()
