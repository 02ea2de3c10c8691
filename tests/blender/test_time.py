# SPDX-License-Identifier: GPL-3.0-or-later
"""Time in the scene: sub-frames, playing, jumping and scrubbing."""

import random

import pytest


def walker(world, last=48):
    """A box that walks past the sensors, there and back."""
    box = world.box((0.4, 0.4, 1.8), name="walker")
    box.rotation_euler.y = 0.1
    world.key(box, "location", {1: (-2, 0, -1.5), last / 2: (2, 0, -1.5), last: (-2, 0, -1.5)})
    return box


def shown(sensor):
    return bool(sensor.angen_sensor.active), sensor.angen_sensor.value


def recorded(recording, name, frame):
    track = recording.tracks[name]
    index = track.at(frame)
    return bool(track.active[index]), track.value[index]


@pytest.fixture
def crossing(world):
    """A card of 1 cm that crosses a beam at 1 m/s, in the middle between two frames.

    It is in the beam for 10 ms, of the 42 ms of a frame.
    """
    card = world.box((0.01, 0.1, 0.001), name="card", at=(0, 0, -0.1))
    metres_a_frame = 1 / 24
    place = (10.5 - 1) * metres_a_frame
    start, end = -place, 23 * metres_a_frame - place
    world.key(card, "location", {1: (start, 0, -0.1), 24: (end, 0, -0.1)})
    world.switch(update_rate=1000.0, threshold=0.3)
    world.scene.frame_end = 24
    return world


def test_a_card_between_two_frames_is_missed_without_substeps(crossing, each_caster):
    log = crossing.log(crossing.run())
    assert [row[1:] for row in log] == [["1", "switch", "OPTICAL_SWITCH", "open", "1"]]


@pytest.mark.parametrize("substeps", [5, 8, 16])
def test_a_card_between_two_frames_is_found_with_substeps(crossing, substeps):
    crossing.scene.angen_substeps = substeps
    log = crossing.log(crossing.run())
    assert [row[5] for row in log] == ["1", "0", "1"]
    # Its edges pass at frame 10.5 ± 0.12; the log tells the first sub-frame at or after.
    for row, crosses in zip(log[1:], (10.38, 10.62), strict=True):
        frame, time = float(row[1]), float(row[0])
        assert crosses <= frame < crosses + 1 / substeps
        assert time == pytest.approx((frame - 1) / 24, abs=1e-6)
        assert float(row[1]) * substeps == pytest.approx(round(frame * substeps), abs=1e-4)
    assert any("." in row[1] for row in log)


@pytest.mark.parametrize("start", [1, 10, 25])
def test_a_part_of_a_run_has_the_readings_of_the_whole(world, start):
    """t = 0 stays at the scene's start; without a scan to compare with there is no movement."""
    walker(world)
    world.switch(update_rate=7.0, threshold=0.3, range_max=3.0, noise_sigma=0.01)
    whole, part = world.run(), world.run(start, 40)
    track = whole.tracks["switch"]
    first = next(i for i, frame in enumerate(track.frames) if frame >= start)
    last = next(i for i, frame in enumerate(track.frames) if frame > 40)
    assert list(part.tracks["switch"].frames) == list(track.frames[first:last])
    assert list(part.tracks["switch"].times) == list(track.times[first:last])
    assert list(part.tracks["switch"].value) == list(track.value[first:last])


def test_two_runs_are_equal_to_the_bit(world, figure):
    walker(world)
    world.pir(noise_sigma=0.02, rays=40)
    world.switch(noise_sigma=0.02, range_max=3.0)
    first, second = world.run(), world.run()
    assert first == second
    assert world.log(first) == world.log(second)
    assert len(set(first.tracks["switch"].value)) > 9, "there was noise"
    figure(f"0 of {sum(len(track) for track in first.tracks.values())} readings differ")


def test_another_sensor_changes_nothing(world):
    walker(world)
    world.pir(noise_sigma=0.02, rays=40)
    alone = world.run().tracks["pir"]
    world.pir("a pir before it", noise_sigma=0.02)
    world.switch("a switch after it", update_rate=3.0, noise_sigma=0.1)
    assert world.run().tracks["pir"] == alone


def test_another_seed_is_another_noise(world):
    world.wall(0.3)
    world.switch(noise_sigma=0.02)
    first = world.run().tracks["switch"]
    world.scene.angen_seed = 1
    assert not set(world.run().tracks["switch"].value) & set(first.value)


@pytest.mark.parametrize("rate", [24.0, 10.0, 2.7, 100.0])
def test_playing_shows_what_a_run_records(world, rate):
    walker(world)
    sensors = [
        world.pir(update_rate=rate, rays=40, vertical_fov=0.6, hold_time=0.2, noise_sigma=0.001),
        world.switch(update_rate=rate, threshold=1.6, range_max=3.0),
    ]
    recording = world.run()
    for frame in range(1, 49):
        world.scene.frame_set(frame)
        for sensor in sensors:
            active, value = recorded(recording, sensor.name, frame)
            assert shown(sensor) == (active, pytest.approx(value, abs=1e-5)), (sensor.name, frame)
    assert {0, 1} == set(recording.tracks["switch"].active)


def test_playing_in_a_loop_shows_the_same_each_time(world):
    walker(world)
    sensor = world.pir(rays=40)
    first = []
    for turn in range(2):
        for frame in range(1, 49):
            world.scene.frame_set(frame)
            first.append(shown(sensor))
        assert first[:48] == first[-48:], turn
    assert any(active for active, _ in first)


def test_a_jump_is_never_movement(world, figure):
    """Everything moved meanwhile, but no time passed."""
    walker(world)
    sensors = [world.pir(), world.pir("all tilts", sweep="ALL", vertical_fov=0.6, hold_time=5.0)]
    jump = random.Random(3)
    before = 1
    world.scene.frame_set(before)
    for _ in range(40):
        frame = jump.choice([f for f in range(1, 49) if abs(f - before) > 1])
        world.scene.frame_set(frame)
        assert [shown(sensor)[0] for sensor in sensors] == [False, False], (before, frame)
        before = frame
    figure("0 of 40 jumps")


def test_moving_something_while_paused_is_no_movement(world):
    wall = world.wall(2.0, size=20)
    sensor = world.pir()
    world.scene.frame_set(10)
    world.scene.frame_set(11)
    wall.location.z = -1.0
    world.update()
    world.scene.frame_set(12)
    assert not sensor.angen_sensor.active


def test_live_off_leaves_the_outputs_alone(world):
    world.wall(0.02)
    sensor = world.switch()
    world.scene.angen_live = False
    sensor.angen_sensor.active = True
    world.scene.frame_set(5)
    assert sensor.angen_sensor.active
    world.scene.angen_live = True
    world.scene.frame_set(6)
    assert not sensor.angen_sensor.active


def test_scrubbing_shows_what_was_recorded(world):
    walker(world)
    sensors = [world.pir(rays=40, update_rate=10.0), world.switch(threshold=1.6, range_max=3.0)]
    recording = world.run()
    assert world.bpy.ops.angen.simulate() == {"FINISHED"}
    scrub = random.Random(1)
    for _ in range(60):
        frame = scrub.randint(1, 48)
        world.scene.frame_set(frame)
        for sensor in sensors:
            active, value = recorded(recording, sensor.name, frame)
            assert shown(sensor) == (active, pytest.approx(value, abs=1e-5)), (sensor.name, frame)


def test_drivers_follow_the_recording(world):
    """An output drives a lamp, as users do; that must not count as an edit of the scene."""
    walker(world)
    sensor = world.switch(threshold=1.6, range_max=3.0)
    lamp = world.link("lamp", None, at=(9, 9, 9))
    driver = lamp.driver_add("location", 2).driver
    variable = driver.variables.new()
    variable.name, variable.targets[0].id = "active", sensor
    variable.targets[0].data_path = "angen_sensor.active"
    driver.expression = "active * 1.0"
    world.update()
    recording = world.run()
    world.bpy.ops.angen.simulate()
    for frame in (*range(1, 49), 3, 40, 12, 30):
        world.scene.frame_set(frame)
        depsgraph = world.update()
        active, _ = recorded(recording, "switch", frame)
        assert lamp.evaluated_get(depsgraph).matrix_world.translation.z == active, frame
    assert world.bpy.ops.angen.clear_recording.poll(), "the recording is still there"
