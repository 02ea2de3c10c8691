# SPDX-License-Identifier: GPL-3.0-or-later
"""A day in a home: its readings are those of every frame, its events tell who and what made them,
and its truth does not contradict them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import day_home
import numpy as np
import pytest
from tiers import mostly_slow


@pytest.fixture
def short_days(
    monkeypatch: pytest.MonkeyPatch, addon_part: Callable[[str], Any], request: Any
) -> float:
    """Days of some minutes, cut where there is more than some seconds of movement."""
    seconds: float = getattr(request, "param", 400.0)
    for name in ("residents.days.truth", "residents.days.rows", "residents.blender.run"):
        monkeypatch.setattr(addon_part(name), "DAY_S", seconds)
    monkeypatch.setattr(addon_part("residents.blender.run"), "MOST_MOVEMENT", 6.0)
    return seconds


def run(world: Any, acted: Any, number: int = 0, keys: Any = None) -> Any:
    living = day_home.part("residents.blender.run")
    residents = {"anna": world.bpy.data.objects["anna"]}
    keys = keys or day_home.BoxKeys()
    what = acted, residents, keys, number
    day = living.DayRun(world.scene, world.sensors(), *what)
    *_, last = day.progress()
    day.steps = last
    return day


@pytest.mark.parametrize("seed", mostly_slow(range(2), 1))
def test_a_day_reads_what_every_frame_of_it_does(
    world: Any,
    seed: int,
    short_days: float,
    addon_part: Callable[[str], Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    day_home.build(world)
    acted = day_home.acted(seed, day=short_days)
    keys = day_home.BoxKeys()
    found = run(world, acted, seed, keys)
    assert len(keys.shown) > 3 and found.steps.evaluated < 0.2 * found.steps.steps

    stillness = addon_part("angen_addon.runtime.skipping")
    every = stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    monkeypatch.setattr(stillness, "find", lambda *_: every)
    monkeypatch.setattr(addon_part("residents.blender.run"), "MOST_MOVEMENT", 1e9)
    whole = day_home.BoxKeys()
    plain = run(world, acted, seed, whole)
    assert len(whole.shown) == 1 and plain.steps.evaluated == plain.steps.steps
    assert plain.recording.tracks == found.recording.tracks
    assert plain.events == found.events
    assert {e.sensor for e in found.events if e.time} == set(found.recording.tracks)


@pytest.mark.parametrize(
    ("ways", "short_days"),
    [(7, 240.0), pytest.param(12, 400.0, marks=pytest.mark.slow)],
    ids=["short", "long"],
    indirect=["short_days"],
)
def test_each_event_has_the_cause_that_explain_names(
    world: Any,
    ways: int,
    short_days: float,
    addon_part: Callable[[str], Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What the run met itself is what is found by going back."""
    day_home.build(world)
    living = addon_part("residents.blender.run")
    lead = addon_part("residents.days.rows").LEAD_S
    monkeypatch.setattr(living, "MOST_MOVEMENT", 1e9)
    day = run(world, day_home.acted(3, ways, short_days))
    explain = addon_part("angen_addon.explain.explain").explain
    compared: dict[str, set[str]] = {}
    with living.at_ten_frames(world.scene):
        for event in day.events:
            track = day.recording.tracks[event.sensor]
            index = int(np.argmin(np.abs(np.asarray(track.times) - event.time / 1e6 - lead)))
            if event.time and (track.active[index] or event.field != "moved"):
                sensor = next(s for s in world.sensors() if s.name == event.sensor)
                found = explain(world.scene, sensor, day.recording, index)
                assert event.because == found.because, (event, found.as_text())
                compared.setdefault(event.sensor, set()).add(event.because)
    assert set(compared) == set(day.recording.tracks) and "anna" in compared["scan"]


def test_each_event_tells_who_and_what_made_it(world: Any, short_days: float) -> None:
    day_home.build(world)
    acted = day_home.acted(1, day=short_days)
    found = [e for e in run(world, acted).events if e.time]
    moved = [e for e in found if e.field == "moved"]
    assert {(e.because, e.person) for e in moved if e.value} <= {
        ("anna", "anna"),
        ("door", "anna"),
    }
    assert {(e.because, e.person) for e in moved if not e.value} == {("", "anna")}
    assert {e.because for e in found if e.sensor == "switch"} == {"door"}
    assert {e.because for e in found if e.sensor == "pad"} == {"anna"}
    lit = [e for e in found if e.sensor == "lux"]
    assert {"lamp", "lamp 2"} <= {e.because for e in lit} <= {"lamp", "lamp 2", ""}
    # What lies under somebody, as a cushion over a pad, is that person's matter.
    cushion = world.box((0.4, 0.4, 0.1), (0.4, 0.0, 0.5), "cushion")
    world.bpy.context.view_layer.update()
    acted.bodies["anna"].points[:] = (0.4, 0.0, 0.7)
    causes = day_home.part("residents.blender.causes").Causes
    found_out = causes(world.scene, [], None, acted, {"anna": world.bpy.data.objects["anna"]}, 0.0)
    assert found_out.person_of("cushion", 200.0) == "anna"
    cushion.location.x = 1.0
    world.bpy.context.view_layer.update()
    assert found_out.person_of("cushion", 200.0) == ""
    # Nobody but its owner moves a walking frame.
    anna = world.bpy.data.objects["anna"]
    anna.angen_resident.walking_frame = world.box((0.4, 0.4, 0.9), (2.0, 1.0, 0.5), "frame")
    found_out = causes(world.scene, [], None, acted, {"anna": anna}, 0.0)
    assert found_out.person_of("frame", 200.0) == "anna"
    # Truth and data agree: whatever moves, somebody moves at that time.
    spans = acted.spans(0.0, short_days)
    for event in moved:
        if event.value:
            time = event.time / 1e6
            assert ((spans[:, 0] <= time) & (time <= spans[:, 1] + 1.5)).any(), event
