# SPDX-License-Identifier: GPL-3.0-or-later
"""Swept switches while frames play, in parts of runs, and what is told of them."""

import numpy as np
import pytest
from beam_scenes import FRAME, card_past, closed_at


def shown(obj):
    return bool(obj.angen_sensor.active), obj.angen_sensor.value


@pytest.mark.parametrize("rate", [24.0, 10.0, 3.0])
def test_playing_shows_what_a_run_records(world, swept, rate):
    card_past(world)
    card_past(world, name="another", at=17.5)
    obj = swept(update_rate=rate)
    recording = world.run()
    track = recording.tracks["switch"]
    assert closed_at(world, recording)
    for frame in range(1, 25):
        world.scene.frame_set(frame)
        index = track.at(frame)
        assert shown(obj) == (bool(track.active[index]), pytest.approx(track.value[index]))


def test_a_jump_is_no_movement(world, swept):
    card_past(world)
    obj = swept()
    for frame in (1, 2, 20, 5, 15, 9, 12, 11, 10):
        world.scene.frame_set(frame)
        assert shown(obj)[0], frame
    world.scene.frame_set(11)
    assert not shown(obj)[0]


def test_moving_something_while_paused_is_no_movement(world, swept):
    card = world.box((0.01, 0.1, 0.001), at=(-0.1, 0, -0.1), name="card")
    obj = swept()
    world.scene.frame_set(5)
    world.scene.frame_set(6)
    card.location.x = 0.1
    world.update()
    world.scene.frame_set(6)
    assert shown(obj)[0]
    world.scene.frame_set(7)
    assert shown(obj)[0]


def test_a_part_of_a_run_and_other_sensors_change_nothing(world, swept):
    card_past(world, at=17.5)
    swept(update_rate=10.0)
    alone = world.run()
    world.pir()
    swept("another", update_rate=24.0)
    beside = world.run()
    assert beside.tracks["switch"] == alone.tracks["switch"]
    part = world.run(10, 24)
    at = [alone.tracks["switch"].at(f) for f in part.tracks["switch"].frames]
    assert [alone.tracks["switch"].active[i] for i in at] == list(part.tracks["switch"].active)


@pytest.mark.parametrize("rate", [2.0, 10.0, 24.0, 60.0])
@pytest.mark.parametrize("substeps", [1, 3])
def test_from_its_second_update_on_a_part_tells_what_the_whole_run_does(
    world, swept, rate, substeps
):
    world.scene.angen_substeps = substeps
    for at in (4.5, 8.2, 11.5, 13.3, 17.9, 22.4):
        card_past(world, width=0.004, name=f"card {at}", at=at)
    swept(update_rate=rate, aperture_rays=5, aperture=0.002)
    world.scene.frame_end = 48
    whole = world.run().tracks["switch"]
    assert 0 in whole.active
    for first in (2, 5, 9, 14):
        part = world.run(first, 48).tracks["switch"]
        assert len(part.frames) > 1
        skipped = len(whole.frames) - len(part.frames)
        for name in ("frames", "active", "value"):
            told, expected = list(getattr(part, name)), list(getattr(whole, name))
            assert told[1:] == expected[skipped + 1 :], (first, name)


def test_swept_may_be_keyed(world, swept):
    for i, at in enumerate((6.5, 16.5)):
        card_past(world, name=f"card {i}", at=at)
    obj = swept()
    world.key(obj, "angen_sensor.optical_switch.swept", {1: False, 12: True}, "CONSTANT")
    assert closed_at(world, world.run()) == [17]


def test_not_swept_the_frames_between_updates_are_not_evaluated(world, swept, monkeypatch):
    swept(update_rate=1.0, swept=False)
    world.scene.frame_end = 72
    frames = []

    def note(scene, depsgraph):
        frames.append(scene.frame_current)

    world.bpy.app.handlers.frame_change_post.append(note)
    try:
        world.run()
    finally:
        world.bpy.app.handlers.frame_change_post.remove(note)
    assert frames[:3] == [1, 25, 49]
    assert len(frames) <= 4


def test_its_beam_is_shown_and_planned_as_unswept(world, swept, addon_part):
    """The floor plan lists rays without casting them."""
    all_rays = addon_part("angen_addon.runtime.sensor_runner").all_rays
    clock = addon_part("angen_addon.runtime.time_base").clock_of(world.scene)
    seen = []
    for name, on in (("switch", True), ("unswept", False)):
        obj = swept(name, swept=on, aperture_rays=3, aperture=0.001)
        sensor = next(s for s in world.sensors() if s.object == obj)
        seen.append(all_rays(sensor, clock, world.update()))
    assert seen[0].parameters.swept
    assert np.array_equal(seen[0].rays(1.0).directions, seen[1].rays(1.0).directions)
    assert len(seen[0].rays(1.0).reach) == 3


def test_what_went_through_is_named(world, swept, addon_part, each_caster):
    card_past(world, name="Card")
    obj = swept(update_rate=12.0)
    recording = world.run()
    sensor = next(s for s in world.sensors() if s.object == obj)
    explain = addon_part("angen_addon.explain.explain").explain
    track = recording.tracks["switch"]
    index = list(track.frames).index(11)
    told = {i: explain(world.scene, sensor, recording, i) for i in (index - 1, index, index + 1)}
    assert not any(found.doubt for found in told.values())
    # It comes in 5 mm before frame 10.5.
    assert told[index].headline == (
        "Closed: 'Card' went through the beam 0.100 m from the sensor, 0.026 s before this update"
    )
    assert told[index].cause.now.ago == pytest.approx((0.5 + 0.005 * 24) * FRAME, abs=1e-5)
    assert "nothing within" in dict(told[index].facts)["Before"]
    assert told[index + 1].headline.startswith("Open: 'Card' no longer breaks the beam")
    assert "'Card' at" in dict(told[index + 1].facts)["Before"]
    assert told[index - 1].headline.startswith("Open: nothing")
