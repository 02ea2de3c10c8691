# SPDX-License-Identifier: GPL-3.0-or-later
"""Where nothing moves nothing is evaluated, and every reading is what it is without that."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from restless_scenes import SCENES
from tiers import mostly_slow


def run(world: Any) -> tuple[Any, int, int]:
    """The recording, and at how many of the steps the scene was evaluated."""
    from_part = world.part
    recording = from_part("sensor_logic.recording.tracks").Recording()
    made = from_part("angen_addon.runtime.simulation").simulate(
        world.scene, world.sensors(), world.scene.frame_start, world.scene.frame_end, recording
    )
    progress = list(made)[-1]
    return recording, progress.evaluated, progress.steps


@contextmanager
def somebody_else_follows_frames(bpy: Any) -> Iterator[None]:
    """A handler of other code, which may change anything: then every frame is evaluated."""

    def act(*_: Any) -> None:
        pass

    bpy.app.handlers.frame_change_pre.append(act)
    try:
        yield
    finally:
        bpy.app.handlers.frame_change_pre.remove(act)


@pytest.mark.parametrize(
    "name",
    mostly_slow(SCENES, *(set(SCENES) - {"hair_that_grows", "loads_on_pads_of_many_rates"})),
)
def test_every_reading_is_as_without_skipping(
    name: str, world: Any, tmp_path: Path, addon_part: Any, fcurves: Any
) -> None:
    world.part, world.curves_of = addon_part, fcurves
    build, skips = SCENES[name]
    build(world, tmp_path)
    with somebody_else_follows_frames(world.bpy):
        plain, all_evaluated, steps = run(world)
    recording, evaluated, again = run(world)
    assert all_evaluated == steps == again
    readings = [v for t in plain.tracks.values() for v in t.value if not math.isnan(v)]
    assert len(set(readings)) > 1, "nothing that a wrong skip would spoil"
    assert recording.tracks == plain.tracks
    assert (evaluated < steps / 1.3) == skips, f"{evaluated} of {steps}"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("strips", "; nothing moved at 85 % of the steps\n"),
        ("a_driver_on_the_frame", "; every step was evaluated: a driver of 'wall' may follow the"),
        ("cycles_of_keys", "keys of 'wall' go on without end (modifiers, extrapolation)\n"),
    ],
)
def test_the_closing_line_tells_what_was_skipped_or_why_nothing_was(
    name: str, words: str, world: Any, tmp_path: Path, addon_part: Any, fcurves: Any
) -> None:
    world.part, world.curves_of = addon_part, fcurves
    SCENES[name][0](world, tmp_path)
    said = io.StringIO()
    line = addon_part("angen_addon.commands.home").ProgressLine(said, False)
    recording = addon_part("sensor_logic.recording.tracks").Recording()
    simulate = addon_part("angen_addon.runtime.simulation").simulate
    for progress in simulate(world.scene, world.sensors(), 1, 48, recording):
        line.show(progress)
    line.finish(2.0, 48)
    assert words in said.getvalue()
