# SPDX-License-Identifier: GPL-3.0-or-later
"""A couple with one bed or chair marked for both, by `angen day` and by the package."""

from __future__ import annotations

import csv

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command as run
from day_home import part
from mathutils import Vector

ROUTINE = """
schema = 1
[person.anna]
resident = "Anna"
begins = "Rest"
[person.bo]
resident = "Bo"
begins = "Stand"
[activity.Rest]
do = ["{rest}"]
while = []
[activity.Stand]
do = ["stand at Spot"]
[[plan]]
person = "bo"
entries = [{{ at = "01:00", activity = "Rest", until = "23:00" }}]
"""


@pytest.fixture
def flat(world):
    def made(width: float):
        world.hall(5.0, 4.0, 2.6)
        bed = world.box((2.0, width, 0.5), (1.2, 2.9, 0.25), "Bed")
        chair = world.box((0.45, 0.45, 0.45), (4.3, 0.5, 0.225), "Chair")
        world.link("Spot", None, (3.8, 2.5, 0.0)).angen_place.use = "STAND"
        sort = part("residents.body.skeleton").Sort.ADULT
        for name, x in (("Anna", 3.0), ("Bo", 2.0)):
            add = part("residents.blender.settings").add_resident
            add(bpy.context, sort, Vector((x, 1.0, 0.0)), 0.0).name = name
        world.update()
        bed.angen_place.use, bed.angen_place.facing = "LIE", np.pi / 2
        chair.angen_place.use, chair.angen_place.facing = "SIT", -np.pi / 2
        tof = world.sensor("DISTANCE", "over bed", update_rate=0.01)
        tof.location = (1.2, 2.9, 2.5)
        world.update()
        return world

    return made


@pytest.mark.parametrize(
    ("width", "rest", "told"),
    [(1.6, "lie Bed", False), (0.9, "lie Bed", True), (1.6, "sit Chair", True)],
)
def test_both_rest_or_a_line_says_who_waits(flat, tmp_path, capsys, width, rest, told) -> None:
    flat(width)
    path, out = tmp_path / "home.blend", tmp_path / "days"
    (tmp_path / "week.toml").write_text(ROUTINE.format(rest=rest))
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    given = ["day", "--routine", tmp_path / "week.toml", "--start", "2026-03-02", "--out", out]
    assert run([str(text) for text in [*given, "--quiet"]]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if "waits" in line]
    place = rest.split()[1]
    assert len(lines) == told
    assert all(f"'bo' waits 24.0 h from 00:00 for '{place}', which 'anna' uses" in x for x in lines)
    with open(out / "people.csv", encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["person"] == "bo"]
    resting = {"lie Bed": "lying", "sit Chair": "sitting"}[rest]
    assert (resting in {row["posture"] for row in rows}) == (not told)
