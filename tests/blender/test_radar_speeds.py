# SPDX-License-Identifier: GPL-3.0-or-later
"""Speeds that radars measure over their integration time, at any update rate and in any way."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import Exchange, simulate
from bl_ext.user_default.angen_sensors.angen_addon.scene import capture as batches
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording

FPS = 60


def radar(world, name="radar", rate=10.0, at=(0, 0, 0), **settings):
    """Add a radar that looks along −Z."""
    world.scene.render.fps = FPS
    return world.sensor(
        "PRESENCE_RADAR", name, world.link(name, None, at), update_rate=rate, **settings
    )


def fan(world):
    """Add four blades that turn about X, 2 m before the radar: ten turns a second."""
    size = (0.4, 0.6, 0.05)
    blades = world.box(size, (0, 0, -2), "Fan")
    across = world.box((size[0], size[2], size[1]), (0, 0, -2), "Across")
    for one in (blades, across):
        turns = {1: (0, 0, 0), 1 + 2 * FPS: (2 * math.tau * 10, 0, 0)}
        world.key(one, "rotation_euler", turns, "LINEAR")
    return blades


def rocking(world):
    """Add a person who rocks by ±0.1 m once a second, with 0.618 m/s in the 0.1 s before 1 s."""
    body = world.box((0.4, 1.7, 0.2), (0, 0, -2), "Anna")
    turns = {1 + i: math.tau * (i / FPS + 0.05) for i in range(4 * FPS)}
    places = {frame: (0, 0, -2 + 0.1 * math.sin(turn)) for frame, turn in turns.items()}
    world.key(body, "location", places, "LINEAR")
    return body


def fastest(found, name="radar"):
    """Return the largest speed at each update."""
    return [np.abs(one.speed).max() for (of, _), one in sorted(found.items()) if of == name]


def test_a_fan_moves_for_a_radar_at_the_rate_of_its_turns(world, echoes):
    fan(world)
    radar(world)
    world.run(1, FPS)
    speeds = fastest(echoes)
    assert speeds[0] == 0.0 and len(speeds) == 10
    # The tips move at 19 m/s; over a sixth of a turn, at 3/π of that.
    assert min(speeds[1:]) > 5.0 and max(speeds) < 19.0
    assert {one.speed.shape[0] for (_, step), one in echoes.items() if step} == {6}


@pytest.mark.parametrize("rate", [1.0, 2.0, 10.0])
def test_who_rocks_has_the_same_speed_at_every_update_rate(world, echoes, rate):
    rocking(world)
    radar(world, rate=rate)
    world.run(1, 3 * FPS)
    each = [one.speed.mean(axis=0) for (_, step), one in sorted(echoes.items()) if step % 60 == 0]
    assert len(each) == 3 and not each[0].any()
    for one in each[1:]:
        assert np.abs(one).max() == pytest.approx(0.618, abs=0.002)


def same(first, second):
    assert first.keys() == second.keys() and first
    for key, one in first.items():
        assert np.array_equal(one.speed, second[key].speed), key
        # Live, a mesh that bends is not known to do so at the first frame: another ray cast.
        assert one.ranges == pytest.approx(second[key].ranges, abs=0.0 if key[1] else 1e-6), key


def moving_home(world):
    """Add what turns, rocks, bends and begins late, and radars of several rates and times."""
    fan(world)
    rocking(world)
    cloth = world.box((0.5, 0.5, 0.5), (1, 0, -2), "Bends")
    cloth.shape_key_add(name="Basis")
    key = cloth.shape_key_add(name="Nearer", from_mix=False)
    for point in key.data:
        point.co.z += 0.3
    for frame, value in ((1, 0.0), (40, 1.0), (90, 0.2)):
        key.value = value
        cloth.data.shape_keys.keyframe_insert('key_blocks["Nearer"].value', frame=frame)
    late = world.box((0.5, 0.5, 0.5), (-1, 0, -2), "Late")
    world.key(late, "location", {50: (-1, 0, -2), 70: (-1, 0, -3)}, "LINEAR")
    radar(world)
    radar(world, "slow", 1.7, integration_time=0.25)
    radar(world, "long", 12.0, integration_time=0.4)
    radar(world, "short", 7.0, integration_time=0.005)


def test_batches_of_any_size_give_the_same(world, echoes, monkeypatch):
    moving_home(world)
    world.run(1, 100)
    whole = dict(echoes)
    assert {one.speed.shape[0] for (name, _), one in whole.items() if name == "long"} == {
        1, 5, 10, 15, 20, 24,
    }  # fmt: skip
    assert {one.speed.shape[0] for (name, _), one in whole.items() if name == "short"} == {1}
    for most in (1, 2, 7):
        echoes.clear()
        monkeypatch.setattr(batches, "MOST_FRAMES", most)
        world.run(1, 100)
        same(whole, echoes)


def test_live_playback_gives_what_a_run_does(world, echoes, field):
    moving_home(world)
    world.run(1, 100)
    whole = dict(echoes)
    echoes.clear()
    for frame in range(1, 101):
        world.scene.frame_set(frame)
    same(whole, echoes)


def test_after_a_jump_the_first_update_has_no_speeds(world, echoes, field):
    moving_home(world)
    for frame in (1, 2, 3, 60, 61, 62, 63, 64, 65, 66, 67):
        world.scene.frame_set(frame)
    assert not echoes["radar", 59].speed.any()
    assert echoes["radar", 60].speed.shape[0] == 1, "since the step of the jump"
    assert echoes["radar", 66].speed.shape[0] == 6


def test_only_the_steps_within_the_integration_time_are_evaluated(world, echoes):
    rocking(world)
    radar(world, rate=1.0)
    frames = []

    def note(scene, depsgraph):
        frames.append(scene.frame_current)

    bpy.app.handlers.frame_change_post.append(note)
    try:
        world.run(1, 2 * FPS + 1)
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    assert {*frames} == {1, *range(55, 62), *range(115, 122)}


def test_an_explanation_has_the_speed_of_the_run(world, echoes):
    rocking(world)
    radar(world, rate=2.0, fading=False)
    recording = world.run(1, 3 * FPS)
    (sensor,) = world.sensors()
    speeds = np.abs(echoes["radar", 60].speed)
    echoes.clear()
    found = explain(world.scene, sensor, recording, 2)
    assert not found.doubt and "moves" in found.headline
    told = float(dict(found.facts)["Speed"].split()[0])
    assert 0.0 < told <= speeds.max() + 0.005
    assert not echoes, "an explanation casts nothing again"


def test_an_exchange_of_keyframes_within_the_integration_time_changes_nothing(world, echoes):
    moving_home(world)
    world.run(1, 100)
    whole = dict(echoes)
    echoes.clear()
    body = bpy.data.objects["Anna"].animation_data

    def put():
        body.action = body.action.copy()

    recording = Recording()
    exchanges = [Exchange(frame, put) for frame in (34, 57)]
    for _ in simulate(world.scene, world.sensors(), 1, 100, recording, exchanges):
        pass
    same(whole, echoes)


@pytest.mark.parametrize("substeps", [1, 3])
def test_a_later_start_gives_the_same_once_the_integration_time_has_passed(world, echoes, substeps):
    world.scene.angen_substeps = substeps
    moving_home(world)
    world.run(1, 90)
    whole = dict(echoes)
    echoes.clear()
    world.run(20, 90)
    late = {key: one for key, one in echoes.items() if key[1] >= (20 + 31) * substeps}
    same({key: whole[key] for key in late}, late)
