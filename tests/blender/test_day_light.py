# SPDX-License-Identifier: GPL-3.0-or-later
"""Light by Cycles on a day in the sample home: what is read at a frame depends neither on which
stretches the day is cut into, nor on when the run began, nor on the other sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"
START = date(2026, 3, 2)
# s: somebody walks all the time; the sun moves at NEXT.
BEGIN, NEXT, END = 38_391.0, 38_400.0, 38_408.0
# s: the bathroom's lamp goes off; somebody walks until LEFT.
OFF, LEFT = 80_626.0, 80_650.0
FRAME = 1 + 10 * round(NEXT)
SENSORS = "Light sensor bedroom", "Light sensor kitchen"


@pytest.fixture
def references() -> dict[Any, bytes]:
    """What light paths found for references, of the stretches since it was cleared."""
    return {}


@pytest.fixture
def lived(
    addon_part: Callable[[str], Any],
    monkeypatch: pytest.MonkeyPatch,
    empty_scene: Any,
    references: dict[Any, bytes],
) -> Callable[..., Any]:
    """Readings of light by sensor and s, of a stretch of a day."""
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live, scene.angen_light_reference = False, 1024
    run, living = addon_part("residents.blender.run"), addon_part("residents.blender.run")
    every = addon_part("angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
    plan = run.Plan.read(HOME.with_name("week.toml"))
    # What is done does not depend on the sensors.
    household = run.Household(scene, every, plan, START, 1)
    acted = household.acted(0)
    # A light sensor's part follows for seconds; here what light there is counts.
    for module in (living, addon_part("residents.days.rows")):
        monkeypatch.setattr(module, "LEAD_S", 4.0)
    monkeypatch.setattr(living, "TILTS_BACK", 1)
    light = addon_part("angen_addon.scene.light.cycles").CyclesLight
    close = light.close

    def closed(self: Any) -> None:
        for (pixels, _, frame, only), sums in self._references.items():
            names = [bits[1][0].split("'")[1] for bits in pixels[1]]
            for paths, found in sums.items():
                references[frame, paths, str(names), only] = found.tobytes()
        close(self)

    monkeypatch.setattr(light, "close", closed)

    def live(
        begin: float = BEGIN,
        end: float = END,
        names: Sequence[str] = SENSORS,
        most: float = 1e9,
    ) -> Any:
        monkeypatch.setattr(living, "MOST_MOVEMENT", most)
        sensors = [s for s in every if s.name in names]
        for sensor in sensors:
            light = sensor.settings.light
            light.samples, light.report_step = 64, 0.1
        with (
            household.keyed() as keys,
            addon_part("residents.blender.daylight").Daylight(scene, sensors, START),
        ):
            what = acted, household.residents, keys, 0, (begin, end), False
            day = living.DayRun(scene, sensors, *what)
            *_, _ = day.progress()
        assert "angen_light_begins" not in scene
        return readings(day.recording.tracks)

    return live


def readings(tracks: Any) -> dict[str, dict[float, float]]:
    return {
        name: dict(zip(np.asarray(track.frames), np.asarray(track.value), strict=True))
        for name, track in tracks.items()
    }


@pytest.mark.slow
def test_readings_are_of_their_frames_alone(lived: Any, references: dict[Any, bytes]) -> None:
    found = lived()
    known = dict(references)
    # The home before midnight, and when the sun moved, the second time with somebody about.
    assert {key[0] for key in known} == {-1199, FRAME - 6000, FRAME}
    assert lived(most=3.0) == found
    for name in SENSORS:
        assert lived(names=[name]) == {name: found[name]}
    references.clear()
    for begin, end in ((NEXT + 4.0, END), (BEGIN, NEXT - 4.0)):
        part = lived(begin, end)
        for name in SENSORS:
            assert len(part[name]) >= 8
            assert part[name].items() <= found[name].items(), (name, begin)
    assert references.items() <= known.items()
    assert FRAME in {key[0] for key in references}
    assert all(len(set(found[name].values())) > 1 for name in SENSORS)


@pytest.mark.slow
def test_a_run_that_begins_with_a_lamp_off_reads_what_one_does_in_which_it_was_on(
    lived: Any, references: dict[Any, bytes]
) -> None:
    """Cycles sends light paths to lamps by how bright they become."""
    found = lived(OFF - 6.0, LEFT)
    known = dict(references)
    references.clear()
    later = lived(OFF + 6.0, LEFT)
    assert references and references.items() <= known.items()
    for name in SENSORS:
        assert len(later[name]) >= 8
        assert later[name].items() <= found[name].items(), name
