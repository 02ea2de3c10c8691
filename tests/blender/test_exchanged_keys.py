# SPDX-License-Identifier: GPL-3.0-or-later
"""A run whose keys are exchanged on the way reads, to the bit, what one reads that has all of them
at once, and what one reads that evaluates every frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tiers import mostly_slow

FRAMES = 400


class Story:
    """A body, a door and a lamp that move now and then: a value (n,) for each frame from 0 on."""

    def __init__(self, world: Any, seed: int) -> None:
        random = np.random.default_rng(seed)
        body = world.box((0.4, 0.3, 1.7), (0, 0, 0.95), "body")
        body.angen_load.mass = 70.0
        body.angen_warmth.use_temperature = True
        body.angen_warmth.temperature = 34.0
        door = world.box((0.04, 0.8, 2.0), (2.0, 1.0, 1.0), "door")
        lamp = world.bpy.data.lights.new("lamp", "POINT")
        world.link("lamp", lamp, (0.5, 0.0, 2.4))
        self._world = world
        self._values = [
            (body, "location", 0, self._moves(random, -1.0, 1.5, 12)),
            (body, "location", 1, self._moves(random, -0.5, 0.5, 12)),
            (door, "rotation_euler", 2, self._moves(random, -0.15, 0.15, 8)),
            (lamp, "energy", -1, self._moves(random, 0.0, 80.0, 1)),
        ]

    def _moves(self, random: Any, low: float, high: float, lasting: int) -> Any:
        begins = np.sort(random.choice(np.arange(5, FRAMES - 20, 20), 7, replace=False))
        frames = np.stack([begins, begins + lasting], axis=1).ravel()
        places = random.uniform(low, high, 8)
        values = np.repeat(places, [1, *[2] * 6, 1])
        return np.interp(np.arange(FRAMES + 3), frames, values)

    def keep(self, first: int, last: int) -> None:
        """Keys from a frame to another in place of all that there are."""
        for owner in {owner for owner, *_ in self._values}:
            owner.animation_data_clear()
        for owner, path, index, values in self._values:
            for frame in range(max(first, 0), min(last, FRAMES + 2) + 1):
                if index < 0:
                    setattr(owner, path, values[frame])
                else:
                    getattr(owner, path)[index] = values[frame]
                owner.keyframe_insert(path, index=index, frame=frame)
            if index < 0:
                # As in a day, all stretches tell how bright the lamp becomes.
                setattr(owner, path, values.max())
                owner.keyframe_insert(path, frame=FRAMES + 100)


def sensors(world: Any) -> None:
    world.scene.render.fps, world.scene.frame_end = 10, FRAMES
    world.pir("scan", update_rate=10.0, rays=31).location = (-2, 0, 1)
    world.bpy.data.objects["scan"].rotation_euler = (1.5708, 0, -1.5708)
    warm = world.pir(
        "warm", update_rate=10.0, model="PYROELECTRIC", warm_up_time=3.0, hold_time=1.0
    )
    warm.location, warm.rotation_euler = (-2, 0.5, 1), (1.5708, 0, -1.5708)
    world.switch("switch", update_rate=1.0, range_max=1.0, threshold=0.6).location = (2, 1.3, 2.3)
    pad = world.box((1.2, 1.2, 0.1), (0.4, 0, 0.05), "pad")
    world.sensor("PRESSURE", "pad", pad, update_rate=1.0)
    lux = world.sensor("LIGHT", "lux", update_rate=1.0, method="ILLUMINANCE", samples=4)
    lux.location, lux.rotation_euler = (0.4, 1.2, 0.5), (3.14159, 0, 0)
    # Enough that stands still for what moves to have a scene of its own.
    for number in range(24):
        world.box((0.2, 0.2, 0.2), (number % 6 - 2.5, -3.0, number // 6 * 0.4), "thing")


@pytest.mark.parametrize("seed", mostly_slow(range(2), 0))
def test_exchanged_keys_change_no_reading(
    world: Any, seed: int, addon_part: Callable[[str], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = addon_part("angen_addon.runtime.simulation")
    tracks, clock = addon_part("sensor_logic.recording.tracks"), addon_part("sensor_logic.clock")
    story = Story(world, seed)
    sensors(world)
    cuts = sorted(np.random.default_rng(seed).choice(np.arange(2, FRAMES), 6, replace=False))
    # Time begins before the scene does, as before a midnight.
    before = clock.Clock(-29, 10)

    def run(exchanges: Any) -> Any:
        recording = tracks.Recording()
        made = simulation.simulate(
            world.scene, world.sensors(), -29, FRAMES, recording, exchanges, before
        )
        *_, last = made
        return recording.tracks, last

    story.keep(0, cuts[0] + 1)
    parts = zip(cuts, [*cuts[1:], FRAMES + 2], strict=True)
    exchanged, progress = run(
        [simulation.Exchange(a, lambda a=a, b=b: story.keep(a - 1, b + 1)) for a, b in parts]
    )
    story.keep(0, FRAMES + 2)
    whole, _ = run(())
    stillness = addon_part("angen_addon.runtime.skipping")
    every = stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    monkeypatch.setattr(stillness, "find", lambda *_: every)
    plain, all_of_them = run(())
    assert exchanged == whole == plain
    # Readings there are, nothing else stands still, and what stands still was not evaluated.
    varied = {name: len(set(track.value)) + len(set(track.active)) for name, track in plain.items()}
    assert min(varied.values()) > 2, varied
    assert all_of_them.evaluated == all_of_them.steps == FRAMES + 30
    assert progress.evaluated < 0.8 * progress.steps
    assert plain["scan"].times[0] == 0.0 and plain["scan"].frames[0] == -29.0
