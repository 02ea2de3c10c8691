# SPDX-License-Identifier: GPL-3.0-or-later
"""A routine that `angen learn` wrote is acted in the sample home."""

from __future__ import annotations

from datetime import date, timedelta
from pathlib import Path
from typing import Any

import bpy
import pytest
from bl_ext.user_default.angen_sensors.residents.blender import learn, run
from bl_ext.user_default.angen_sensors.residents.days.truth import DAY_S

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
START = date(2026, 3, 2)
# What is done on each invented day: start, duration in minutes, and what `week.toml` calls it.
DAY = (
    (0, 415, "Sleeping"),
    (417, 3, "Toilet"),
    (420, 6, "Grooming"),
    (430, 15, "Meal preparation"),
    (446, 20, "Eating"),
    (480, 300, "Working"),
    (785, 4, "Snack"),
    (800, 240, "Relaxing"),
    (1045, 5, "Toilet"),
    (1060, 370, "Watching television"),
    (1432, 8, "Sleeping"),
)


@pytest.mark.slow
def test_a_learnt_day_is_acted_in_the_sample_home(tmp_path: Path, empty_scene: Any) -> None:
    rows = ["start,end,activity"]
    for number in range(10):
        for at, lasts, name in DAY:
            start = f"{START + timedelta(number)}T{at // 60:02d}:{at % 60:02d}"
            end = f"{START + timedelta(number + (at + lasts) // 1440)}"
            end += f"T{(at + lasts) % 1440 // 60:02d}:{(at + lasts) % 60:02d}"
            rows.append(f"{start},{end},{name}")
    log, routine = tmp_path / "log.csv", tmp_path / "learnt.toml"
    log.write_text("\n".join(rows))
    words = [str(log), "--out", str(routine), "--routine", str(SAMPLES / "week.toml")]
    assert learn.main(words, "angen") == 0
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / "angen.blend"), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    household = run.HouseholdDays(scene, [], run.Plan.read(routine), START, 1)
    acted = household.acted(0)
    done = [one.activity for one in acted.activities if 0.0 < one.end < DAY_S]
    assert {"Sleeping", "Eating", "Working"} <= set(done)
    assert household.take_notes() == []
