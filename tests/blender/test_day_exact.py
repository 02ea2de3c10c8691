# SPDX-License-Identifier: GPL-3.0-or-later
"""Both sample homes: a random stretch of a random day reads, to the bit, what one does that
evaluates every frame and has all its keys at once."""

from __future__ import annotations

from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
START = date(2026, 3, 2)
# s: on each side of a moment at which everybody comes to rest, for at least as long.
AROUND = 8.0
# Light is left out: Cycles would take minutes.
KINDS = {"PIR", "OPTICAL_SWITCH", "PRESSURE", "CONTACT"}


# s of a day in which somebody gets up, and of one in which somebody leaves for long.
MORNING, OUT = (24_000.0, 27_000.0), (25_000.0, 77_500.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("home", "week", "between"),
    [
        ("angen.blend", "week.toml", MORNING),
        ("atelier.blend", "atelier_week.toml", MORNING),
        ("angen.blend", "story.toml", OUT),
    ],
)
def test_keys_change_nothing_while_nobody_moves(
    home: str,
    week: str,
    between: tuple[float, float],
    addon_part: Callable[[str], Any],
    empty_scene: Any,
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / home), load_ui=False)
    run, scene = addon_part("residents.blender.run"), bpy.context.scene
    household = run.Household(scene, [], run.Plan.read(SAMPLES / week), START, 1)
    acted = household.acted(0)
    with household.keyed() as keys, addon_part("residents.blender.run").at_ten_frames(scene):
        keys.show(acted, *between)
        still = addon_part("angen_addon.runtime.skipping").find(scene, {"RAYS"})
    assert not still.reasons
    moving = np.clip(acted.spans(*between), *between)
    # A frame before each movement, and up to two after it.
    most = float(np.diff(moving).sum()) + 0.3 * len(moving)
    assert 0.0 < float(np.diff(still.busy).sum()) / 10.0 < most + 1.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1])
@pytest.mark.parametrize(
    ("home", "week"), [("angen.blend", "week.toml"), ("atelier.blend", "atelier_week.toml")]
)
def test_a_random_stretch_reads_what_every_frame_of_it_does(
    home: str,
    week: str,
    seed: int,
    addon_part: Callable[[str], Any],
    monkeypatch: pytest.MonkeyPatch,
    empty_scene: Any,
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / home), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    run, living = addon_part("residents.blender.run"), addon_part("residents.blender.run")
    sensors = [
        s
        for s in addon_part("angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
        if s.kind.identifier in KINDS
    ]
    household = run.Household(scene, sensors, run.Plan.read(SAMPLES / week), START, seed)
    random = np.random.default_rng(seed)
    number = int(random.integers(7))
    spans = household.acted(number).spans(3600.0, 82_800.0)
    rests = spans[1:, 0] - spans[:-1, 1]
    middle = float(random.choice(spans[:-1, 1][rests > AROUND]))
    told = f"{home}, seed {seed}, day {number}, {middle:.1f} s"
    # Detectors settle in fewer frames than days have before midnight.
    for module in (living, addon_part("residents.days.rows")):
        monkeypatch.setattr(module, "LEAD_S", 10.0)

    def stretch() -> tuple[Any, Any]:
        with household.keyed() as keys:
            between = middle - AROUND, middle + AROUND
            what = household.acted(number), household.residents, keys, number, between
            day = living.DayRun(scene, sensors, *what)
            *_, last = day.progress()
        return day, last

    monkeypatch.setattr(living, "MOST_MOVEMENT", 3.0)
    found, steps = stretch()
    stillness = addon_part("angen_addon.runtime.skipping")
    every = stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    monkeypatch.setattr(stillness, "find", lambda *_: every)
    monkeypatch.setattr(living, "MOST_MOVEMENT", 1e9)
    plain, plain_steps = stretch()
    assert steps.evaluated < plain_steps.evaluated == plain_steps.steps == steps.steps, told
    assert set(plain.recording.tracks) == {sensor.name for sensor in sensors}, told
    differ = [n for n, t in plain.recording.tracks.items() if found.recording.tracks[n] != t]
    assert not differ, f"{differ}: {told}"
    assert plain.events == found.events, told
    # Something was there to be seen.
    seen = [n for n, t in plain.recording.tracks.items() if np.asarray(t.active).any()]
    assert seen, told
