# SPDX-License-Identifier: GPL-3.0-or-later
"""The force on pads under moving simulated bodies: drops, rolling, lifts, time and the cache."""

import math

import numpy as np
import pytest
from pressure_scenes import NOT_YET, G, live_problem
from tiers import mostly_slow

IMPULSE = 2e-3


def impulse_error(physics, pad, body, mass):
    """Return the relative error of the impulse by the momentum theorem: Σ F·Δt = m·g·T + m·Δv.

    The reading of frame 2 is the force from frame 1.5 on, when the body falls already.
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
    """Momentum theorem: from rest to rest the pad gives m·g·T, whatever happens in between."""
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


def roll(physics, shape):
    """Return the force on a level floor of a round body that rolls along x down a slope of 3°."""
    physics.frames(40)
    tilt = math.radians(3)
    physics.scene.gravity = (9.81 * math.sin(tilt), 0, -9.81 * math.cos(tilt))
    body = physics.round(shape, (-0.25, 0, 0.1), radius=0.1, half_height=0.3)
    if shape != "SPHERE":
        body.rotation_euler = (math.pi / 2, 0, 0)
    physics.rigid_body(body, shape=shape, mass=4.0, friction=0.5)
    return body, 4 * G * math.cos(tilt)


@pytest.mark.parametrize("shape", mostly_slow(["SPHERE", "CAPSULE", "CYLINDER"], "CYLINDER"))
def test_rolling_across_a_pad(physics, shape):
    """A pad flush with the floor: all of the weight on it, none before and after."""
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
    """A box on a plate that moves up and down: m(g + a), by the rms of the error.

    The plate carries the pad, 0.1 m at 1 Hz: 5 kg give ± 19.7 N.
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


def test_frame_rate_base(physics):
    physics.scene.render.fps, physics.scene.render.fps_base = 30, 1.001
    physics.on_floor(45, 30)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.31), 2.0, linear_damping=0.0)
    assert impulse_error(physics, physics.read(), box, 2.0) < IMPULSE


@pytest.mark.parametrize("time_scale", mostly_slow([0.25, 0.5, 2.0], 0.5, 2.0))
def test_time_scale(physics, time_scale):
    """The engine's own time: the same drop, slower or faster.

    There is no force during the fall, and the weight on average.
    """
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


def weigh(share):
    return lambda physics: setattr(physics.rigid.effector_weights, *share)


GRAVITY = {
    "Moon": (lambda physics: setattr(physics.scene, "gravity", (0, 0, -1.62)), 1.62),
    "Jupiter": (lambda physics: setattr(physics.scene, "gravity", (0, 0, -24.8)), 24.8),
    "gravity's weight": (weigh(("gravity", 0.5)), G / 2),
    "weight of all fields": (weigh(("all", 0.5)), G / 2),
    "none": (lambda physics: setattr(physics.scene, "use_gravity", False), 0.0),
}


@pytest.mark.parametrize("name", GRAVITY)
def test_other_gravity(physics, name):
    change, gravity = GRAVITY[name]
    physics.floor()
    change(physics)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    assert physics.read().known() == pytest.approx(5 * gravity, rel=1e-3, abs=0.05)


@pytest.mark.parametrize("axis", [0, 1], ids="xy")
@pytest.mark.parametrize("sign", mostly_slow([-1, 1], 1))
def test_gravity_along_another_axis(physics, axis, sign):
    """The floor is a wall; the pad hangs on it and faces away from it."""
    gravity = np.zeros(3)
    gravity[axis] = sign * G
    physics.scene.gravity = gravity
    away = -gravity / G
    turned = {0: (0, -sign * math.pi / 2, 0), 1: (sign * math.pi / 2, 0, 0)}[axis]
    physics.pad(at=0.005 * away, kind="PASSIVE", place={"rotation_euler": turned})
    physics.body("box", (0.1, 0.1, 0.1), 0.11 * away, 5.0)
    assert physics.read().known() == pytest.approx(5 * G, rel=1e-3)


def test_animated_gravity_is_followed(physics):
    """Growing gravity counts at once, while the box stays at rest."""
    physics.on_floor(20)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    gravity = {1: (0, 0, -9.81), 20: (0, 0, -19.62)}
    physics.world.key(physics.scene, "gravity", gravity)
    force = physics.read().known(after=2)
    exact = 5 * G * (1 + np.arange(2, 20) / 19)
    assert force == pytest.approx(exact, rel=2e-3)


# The rigid-body cache, jumps of the playhead, repeated runs, and pads that cannot be read


EXACT = 1e-3


@pytest.fixture
def resting(physics):
    """Add 5 kg at rest on a pad, 30 frames."""
    physics.floor()
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    return physics


@pytest.fixture
def falling(physics):
    """Let 5 kg fall on a pad and stay there, 30 frames."""
    physics.floor()
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.41), 5.0)
    return physics


# Runs


@pytest.mark.parametrize("start", [1, 17, 40])
def test_a_run_puts_everything_back(falling, start):
    """Settings of the cache, of the world, and the frame, wherever the playhead was."""
    scene, rigid = falling.scene, falling.rigid
    rigid.point_cache.frame_start, rigid.point_cache.frame_end = 1, 77
    rigid.substeps_per_frame, rigid.solver_iterations, rigid.time_scale = 7, 13, 0.5
    scene.frame_set(start)

    def state():
        cache = rigid.point_cache
        world = [rigid.substeps_per_frame, rigid.solver_iterations, rigid.time_scale, rigid.enabled]
        names = ("frame_start", "frame_end", "frame_step", "is_baked", "use_disk_cache")
        frames = [scene.frame_current, scene.frame_start, scene.frame_end]
        return world + [getattr(cache, name) for name in names] + frames

    before = state()
    falling.run()
    assert state() == before
    falling.run(5, 9)
    assert state() == before


def test_a_run_steps_from_the_start_of_the_cache(falling):
    """A late part of a scene that was never played reads as in the whole run."""
    part = falling.run(12, 15)["pad"]
    falling.rigid.point_cache.frame_end = 999  # clears the cache
    whole = falling.read()
    assert part.force == pytest.approx(whole.force[11:15], rel=1e-9)
    assert part.valid.all()


def test_a_cache_that_starts_before_the_scene(falling):
    """The scene begins at frame 20, when the box lies there already."""
    falling.rigid.point_cache.frame_start = 1
    falling.scene.frame_start, falling.scene.frame_end = 25, 32
    pad = falling.read()
    assert pad.frames[0] == 25
    assert pad.known(after=25) == pytest.approx(5 * G, rel=EXACT)


def test_a_mass_edited_after_a_run_counts_in_the_next(resting):
    assert resting.read().known() == pytest.approx(5 * G, rel=EXACT)
    resting.bpy.data.objects["box"].rigid_body.mass = 8.0
    pad = resting.read()
    assert pad.known() == pytest.approx(8 * G, rel=EXACT)
    assert pad.force.max() < 8.1 * G


def test_a_cache_shorter_than_the_scene(resting):
    resting.rigid.point_cache.frame_end = 15
    pad = resting.read()
    assert pad.valid[1:13].all()
    late = pad.frames > 16
    assert not pad.valid[late].any()
    assert all("cache ends at frame 15" in reason for reason in pad.problem[17:])
    assert pad.force.max() < 5.1 * G


def test_a_baked_cache_is_used_as_it_is(falling):
    """It is neither stepped again nor cleared; the readings are the same."""
    free = falling.read()
    cache = falling.rigid.point_cache
    cache.frame_end = 40
    with falling.bpy.context.temp_override(point_cache=cache):
        falling.bpy.ops.ptcache.bake(bake=True)
    assert cache.is_baked
    falling.scene.frame_set(7)
    baked = falling.read()
    assert cache.is_baked and falling.scene.frame_current == 7
    assert baked.force == pytest.approx(free.force, abs=1e-3 * free.force.max())
    assert baked.valid.tolist() == free.valid.tolist()


# Live


def shown(physics):
    return physics.bpy.data.objects["pad"].angen_sensor.value


def test_following_the_playhead_leaves_the_cache_alone(falling):
    """Playback after a run shows the poses of the run."""
    box = falling.bpy.data.objects["box"]
    box.rigid_body.friction = 0.0
    falling.scene.gravity[0] = 2.0
    falling.read()
    falling.scene.angen_live = False
    falling.scene.frame_set(1)

    def places():
        found = []
        for frame in range(1, 31):
            falling.scene.frame_set(frame)
            found.append(falling.place_of(box).tolist())
        return found

    quiet = places()
    falling.scene.angen_live = True
    assert places() == quiet
    assert not falling.rigid.point_cache.is_outdated
    assert falling.bpy.ops.angen.simulate() == {"FINISHED"}
    assert places() == quiet, "nor does scrubbing a recording"


def test_jumps_of_the_playhead_are_no_spikes(falling):
    """After a jump the force is unknown until three frames in a row were evaluated."""
    falling.read()
    highest = 0.0
    for frames in ((1, 2, 3), (28, 29, 30), (12, 13, 14), (25,), (3,), (27, 28, 29, 30)):
        for number, frame in enumerate(frames):
            falling.scene.frame_set(frame)
            if number == 0:
                assert live_problem("pad").endswith(NOT_YET) or "explain" in live_problem("pad")
            if frame < 5 or frame > 24:
                highest = max(highest, shown(falling))
    assert highest < 5.1 * G
    assert shown(falling) == pytest.approx(5 * G, rel=EXACT)
    assert not live_problem("pad")


def test_a_cold_jump_is_not_valid(falling):
    """Without a simulation Blender shows the body at its start."""
    falling.scene.frame_set(20)
    assert live_problem("pad")
    falling.scene.frame_set(21)
    falling.scene.frame_set(22)
    assert live_problem("pad"), "frames after a cold jump are not simulated either"
    assert shown(falling) < 1.0


def test_an_edited_mass_makes_the_cache_stale(resting):
    """Live: the old poses with the new mass are not valid, and give no spike."""
    for frame in range(1, 20):
        resting.scene.frame_set(frame)
    resting.bpy.data.objects["box"].rigid_body.mass = 50.0
    for frame in range(20, 26):
        resting.scene.frame_set(frame)
        assert shown(resting) < 50 * G * 1.01
        if resting.rigid.point_cache.is_outdated:
            assert "out of date" in live_problem("pad")
    for frame in range(1, 8):
        resting.scene.frame_set(frame)
    assert shown(resting) == pytest.approx(50 * G, rel=EXACT)
    assert not live_problem("pad")


def test_moving_a_body_while_paused_is_no_spike(resting):
    for frame in range(1, 11):
        resting.scene.frame_set(frame)
    resting.bpy.data.objects["box"].location.z = 0.3
    resting.world.update()
    for frame in (11, 12, 13):
        resting.scene.frame_set(frame)
        assert shown(resting) < 5.1 * G


# Pads that cannot be read


def test_a_pad_without_a_mesh_says_so(resting):
    empty = resting.world.link("empty", None, (0, 0, 0.01))
    resting.sense(empty)
    read = resting.run()
    read["empty"].never_valid("empty", "no surface", after=0)
    assert read["pad"].known() == pytest.approx(5 * G, rel=EXACT), "the other is not harmed"


def test_a_pad_of_no_size_is_refused(resting):
    from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError

    resting.bpy.data.objects["pad"].scale = (1, 1, 0)
    with pytest.raises(AngenError, match=r"'pad'.*scale"):
        resting.run()
