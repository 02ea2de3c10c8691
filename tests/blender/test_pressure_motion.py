# SPDX-License-Identifier: GPL-3.0-or-later
"""The force on pads under simulated bodies that move: drops, rolling, lifts, and how time runs."""

import math

import numpy as np
import pytest
from pressure_scenes import G
from tiers import mostly_slow

IMPULSE = 2e-3


def impulse_error(physics, pad, body, mass):
    """Relative error of the whole impulse by the momentum theorem: Σ F·Δt = m·g·T + m·Δv.

    The reading of frame 2 is the force from frame 1.5 on: by then the body falls already.
    """
    force = pad.known()
    physics.scene.angen_live = False
    heights = []
    for frame in (1, 2):
        physics.scene.frame_set(frame)
        heights.append(physics.place_of(body)[2])
    fps = physics.scene.render.fps / physics.scene.render.fps_base
    fps /= physics.rigid.time_scale
    exact = mass * (G * len(force) / fps + (heights[0] - heights[1]) * fps)
    return abs(force.sum() / fps / exact - 1.0)


@pytest.mark.parametrize("fps", mostly_slow([24, 60], 24))
@pytest.mark.parametrize("bounce", [0.0, 0.5])
@pytest.mark.parametrize("height", mostly_slow([0.1, 0.5, 2.0], 0.5))
def test_impulse_of_a_drop(physics, height, bounce, fps):
    """Momentum theorem: from rest to rest the pad gives m·g·T, whatever happens between."""
    physics.frames(int((1.6 + 2.0 * math.sqrt(height) * (1 + 2 * bounce)) * fps), fps)
    physics.floor(bounce=bounce)
    physics.pad(kind="PASSIVE", body={"bounce": bounce})
    at = (0, 0, 0.11 + height)
    box = physics.body("box", (0.1, 0.1, 0.1), at, 2.0, bounce=bounce, linear_damping=0.0)
    pad = physics.read()
    force = pad.known()
    assert pad.residual.max() < 0.02
    assert force[-5:] == pytest.approx(2 * G, rel=1e-3), "it came to rest"
    assert impulse_error(physics, pad, box, 2.0) < IMPULSE
    landing = math.sqrt(2 * height / G)
    assert force[: int(landing * fps) - 2] == pytest.approx(0.0, abs=0.02), "nothing while it falls"
    assert force.max() > 20 * G * math.sqrt(height) / 24 * fps / 10


def test_a_body_that_falls_past_the_pad(physics):
    physics.floor()
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0.3, 0, 0.6), 2.0)
    assert physics.read().known() == pytest.approx(0.0, abs=1e-6)


def roll(physics, shape):
    """A round body that rolls along x down a slope of 3°, and its force on a level floor."""
    physics.frames(40)
    tilt = math.radians(3)
    physics.scene.gravity = (9.81 * math.sin(tilt), 0, -9.81 * math.cos(tilt))
    body = physics.round(shape, (-0.25, 0, 0.1), radius=0.1, half_height=0.3)
    if shape != "SPHERE":
        body.rotation_euler = (math.pi / 2, 0, 0)
    physics.rigid_body(body, shape=shape, mass=4.0, friction=0.5)
    return body, 4 * G * math.cos(tilt)


@pytest.mark.parametrize("shape", mostly_slow(["SPHERE", "CAPSULE", "CYLINDER"], "SPHERE"))
def test_rolling_on_a_pad(physics, shape):
    body, weight = roll(physics, shape)
    physics.pad(half=(1, 1, 0.25), at=(0, 0, -0.25), kind="PASSIVE")
    physics.scene.angen_live = False
    pad = physics.read()
    assert pad.known(after=2) == pytest.approx(weight, rel=0.01)
    physics.scene.frame_set(40)
    assert physics.place_of(body)[0] > 0.1, "it rolled"
    # The centre of pressure follows it.
    assert pad.cop[-1, 0] == pytest.approx(physics.place_of(body)[0], abs=0.002)


@pytest.mark.parametrize("shape", mostly_slow(["SPHERE", "CAPSULE", "CYLINDER"], "CYLINDER"))
def test_rolling_across_a_pad(physics, shape):
    """A pad set flush into the floor: on it all of the weight, before and after it none."""
    body, weight = roll(physics, shape)
    physics.floor()
    physics.pad(half=(0.1, 1, 0.005), at=(0, 0, -0.005))
    physics.scene.angen_live = False
    pad = physics.read()
    where = []
    for frame in pad.frames.tolist():
        physics.scene.frame_set(int(frame))
        where.append(physics.place_of(body)[0])
    where, force = np.array(where)[pad.frames > 2], pad.known(after=2)
    on, off = np.abs(where) < 0.09, np.abs(where) > 0.11
    assert on.sum() > 5 and (where > 0.11).any() and (where < -0.11).any()
    assert force[on] == pytest.approx(weight, rel=0.01)
    assert force[off] == pytest.approx(0.0, abs=0.01 * weight)


@pytest.mark.parametrize(("fps", "most"), mostly_slow([(24, 0.5), (60, 0.15)], (24, 0.5)))
def test_kinematic_lift(physics, fps, most):
    """A box on a plate that goes up and down: m(g + a), the root of the mean square of the error.

    The plate carries the pad, 0.1 m at 1 Hz: 5 kg feel ± 19.7 N.
    """
    last = 2 * fps
    physics.frames(last, fps)
    pad = physics.pad(kind="PASSIVE", half=(0.3, 0.3, 0.05), at=(0, 0, 0), body={"kinematic": True})
    frames = range(-2, last + 4)
    turn = 2 * math.pi / fps
    heights = {f: (0, 0, 0.05 * (1 - math.cos(turn * (f - 1)))) for f in frames}
    heights.update({f: (0, 0, 0) for f in frames if f < 1})
    physics.world.key(pad, "location", heights)
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.15), 5.0, linear_damping=0.0)
    readings = physics.read()
    force = readings.known(after=4)
    time = readings.times[readings.frames > 4]
    exact = 5 * (G + 0.05 * (2 * math.pi) ** 2 * np.cos(2 * math.pi * time))
    assert math.sqrt(np.square(force - exact).mean()) < most
    assert np.ptp(force) > 18


# How time and gravity run


@pytest.mark.parametrize("fps", mostly_slow([12, 25, 30, 50, 120], 12, 50))
def test_frame_rates(physics, figure, fps):
    physics.on_floor(20, fps)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    known = physics.read().known()
    figure(np.abs(np.asarray(known) / (5 * G) - 1).max(), "of the force")
    assert known == pytest.approx(5 * G, rel=1e-3)


@pytest.mark.parametrize("fps", mostly_slow([12, 120], 12))
def test_drop_at_the_ends_of_the_frame_rates(physics, fps):
    physics.frames(int(1.2 * fps), fps)
    physics.floor()
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.31), 2.0, linear_damping=0.0)
    assert impulse_error(physics, physics.read(), box, 2.0) < IMPULSE


def test_frame_rate_base(physics):
    physics.scene.render.fps, physics.scene.render.fps_base = 30, 1.001
    physics.on_floor(45, 30)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.31), 2.0, linear_damping=0.0)
    assert impulse_error(physics, physics.read(), box, 2.0) < IMPULSE


@pytest.mark.parametrize("time_scale", mostly_slow([0.25, 0.5, 2.0], 0.5, 2.0))
def test_time_scale(physics, time_scale):
    """The engine's own time: the same drop, slower or faster. No force while it falls, and over
    the whole the weight."""
    last = int(1.2 * 24 / time_scale)
    physics.on_floor(last)
    physics.rigid.time_scale = time_scale
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.31), 2.0, linear_damping=0.0)
    pad = physics.read()
    force = pad.known()
    assert force[: int(0.15 * 24 / time_scale)] == pytest.approx(0.0, abs=0.02)
    assert force[-4:] == pytest.approx(2 * G, rel=1e-3)
    assert impulse_error(physics, pad, box, 2.0) < IMPULSE


def test_time_scale_zero_is_at_rest(physics):
    physics.on_floor(8)
    physics.rigid.time_scale = 0.0
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 2.0)
    assert physics.read().known() == pytest.approx(2 * G, rel=1e-3)


@pytest.mark.parametrize("substeps", mostly_slow([1, 2, 30], 1, 30))
@pytest.mark.parametrize("iterations", mostly_slow([5, 50], 5))
def test_substeps_and_iterations(physics, substeps, iterations):
    physics.on_floor(20)
    physics.rigid.substeps_per_frame, physics.rigid.solver_iterations = substeps, iterations
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    physics.body("upper", (0.05, 0.05, 0.05), (0, 0, 0.26), 2.0)
    assert physics.read().known() == pytest.approx(7 * G, rel=1e-3)


@pytest.mark.parametrize("substeps", [2, 5])
def test_sensor_substeps(physics, substeps):
    """Between frames the pad has the force of the frame before."""
    physics.frames(10)
    physics.scene.angen_substeps = substeps
    physics.floor()
    physics.pad(kind="PASSIVE", update_rate=24.0 * substeps)
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    pad = physics.read()
    assert len(pad.frames) == 10 * substeps
    assert pad.known(after=2) == pytest.approx(5 * G, rel=1e-3)


@pytest.mark.parametrize("rate", mostly_slow([0.7, 1.0, 10.0, 100.0], 0.7, 100.0))
def test_update_rates(physics, rate):
    physics.on_floor(48)
    physics.pad(kind="PASSIVE", update_rate=rate)
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    pad = physics.read()
    exact = np.arange(len(pad.times)) / min(rate, 24.0)
    assert pad.times == pytest.approx(exact, abs=0.05)
    assert pad.known(after=2) == pytest.approx(5 * G, rel=1e-3)


@pytest.mark.parametrize("gravity", [1.62, 24.8], ids=["Moon", "Jupiter"])
def test_other_gravity(physics, gravity):
    physics.scene.gravity = (0, 0, -gravity)
    physics.floor()
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    assert physics.read().known() == pytest.approx(5 * gravity, rel=1e-3)


def test_gravity_of_the_effector_weights(physics):
    physics.floor()
    physics.rigid.effector_weights.gravity = 0.5
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    assert physics.read().known() == pytest.approx(5 * G / 2, rel=1e-3)


def test_no_gravity(physics):
    physics.scene.use_gravity = False
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    assert physics.read().known() == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("axis", [0, 1], ids="xy")
@pytest.mark.parametrize("sign", mostly_slow([-1, 1], 1))
def test_gravity_along_another_axis(physics, axis, sign):
    """The floor is a wall; the pad hangs on it and looks out of it."""
    gravity = np.zeros(3)
    gravity[axis] = sign * G
    physics.scene.gravity = gravity
    away = -gravity / G
    turned = {0: (0, -sign * math.pi / 2, 0), 1: (sign * math.pi / 2, 0, 0)}[axis]
    physics.pad(at=0.005 * away, kind="PASSIVE", place={"rotation_euler": turned})
    physics.body("box", (0.1, 0.1, 0.1), 0.11 * away, 5.0)
    assert physics.read().known() == pytest.approx(5 * G, rel=1e-3)


def test_animated_gravity_is_followed(physics):
    """Gravity that grows is felt at once; the box is at rest all along."""
    physics.on_floor(20)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    scene = physics.scene
    for frame, size in ((1, -9.81), (20, -19.62)):
        scene.gravity[2] = size
        scene.keyframe_insert("gravity", index=2, frame=frame)
    for curve in scene_curves(scene):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    force = physics.read().known(after=2)
    exact = 5 * G * (1 + np.arange(2, 20) / 19)
    assert force == pytest.approx(exact, rel=2e-3)


def scene_curves(scene):
    action = scene.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [c for la in action.layers for s in la.strips for b in s.channelbags for c in b.fcurves]
