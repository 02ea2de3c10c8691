# SPDX-License-Identifier: GPL-3.0-or-later
"""Pads on, in and below the beds and seats of both sample homes weigh the resident who uses them.

Of a body's mass, trunk, arms and thighs are 82 %, head and neck 7 %, shanks and feet 11 % (de Leva,
*Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters*, J. Biomech. 29, 1996; men).
"""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from day_home import part
from pressure_scenes import CORNERS, FACES

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
G = 9.81
ANGEN, ATELIER = ("angen.blend", "Person rig", 70.0), ("atelier.blend", "Karin", 68.0)
# On a bed, a metre square below the hips: trunk, arms, thighs, and some of the rest.
BED, BED_SHARE = (1.0, 1.0, 0.01), (0.75, 0.95)
# On a seat: without the feet, and what the thighs and the back rest on beside the pad.
SEAT, SEAT_SHARE = (0.36, 0.36, 0.01), (0.6, 0.95)
ROUTINE = """
schema = 1
[person.a]
resident = "{0}"
begins = "Rest"
[activity.Rest]
do = ["{1} {2}"]
[[plan]]
person = "a"
entries = [{{ at = "00:01", activity = "Rest", until = "01:00" }}]
"""
# Home, mark, size of the pad, and its heights above the place where the hips rest, in m.
CASES = {
    "bed with mattress and duvet": (ANGEN, "Bed", BED, (0.0, -0.04, -0.08, -0.26)),
    "chair": (ANGEN, "Kitchen chair 1", SEAT, (0.0, -0.005, -0.03)),
    "sofa": (ANGEN, "Sofa east", SEAT, (0.0,)),
    "toilet": (ANGEN, "Toilet", SEAT, (0.0, -0.005)),
    "bed of one mesh": (ATELIER, "Bed of Karin", BED, (0.0, -0.03, -0.08)),
    "chair in the studio": (ATELIER, "Chair west", SEAT, (0.0, -0.005, -0.03)),
    "sofa in the studio": (ATELIER, "Sofa south", SEAT, (0.0, -0.03)),
    "toilet in the studio": (ATELIER, "Toilet", SEAT, (0.0, -0.005, -0.03)),
}


def readings(home: tuple[str, str, float], mark: str, size: Any, heights: Any) -> list[Any]:
    """Return, by height of a pad, its force as a share of the resident's weight, and problems.

    The resident is at the place of the mark during ten seconds.
    """
    run, sensors = part("residents.blender.run"), part("angen_addon.scene.sensors")
    file, resident, mass = home
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / file), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    bed = bpy.data.objects[mark].angen_place.use == "LIE"
    plan = run.Plan.from_text(ROUTINE.format(resident, "lie" if bed else "sit", mark), "routine")
    corners = (CORNERS + [0.0, 0.0, 1.0]) * np.array(size) / 2.0
    mesh = bpy.data.meshes.new("Pad")
    mesh.from_pydata(corners.tolist(), [], FACES.tolist())
    pad = bpy.data.objects.new("Pad", mesh)
    scene.collection.objects.link(pad)
    pad.location, pad.angen_sensor.kind = (0.0, 0.0, -9.0), "PRESSURE"
    bpy.context.view_layer.update()
    chosen = [s for s in sensors.all_sensors(bpy.context.view_layer) if s.name == "Pad"]
    household = run.HouseholdDays(scene, chosen, plan, date(2026, 3, 2), 1)
    place, found = household.places.places[mark], []
    for height in heights:
        pad.location, pad.rotation_euler.z = place.target + [0.0, 0.0, height], place.yaw
        bpy.context.view_layer.update()
        with household.keyed() as keys:
            what = household.acted(0), household.residents, keys, 0, (0.0, 10.0)
            day = run.DayRun(scene, household.sensors, *what)
            for _ in day.progress():
                pass
        track = day.recording.tracks["Pad"]
        # Of all but the first update, whose motion is unknown.
        problems = set(list(track.columns["problem"])[1:]) - {""}
        found.append((float(track.columns["force_n"][len(track) - 3]) / (mass * G), problems))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_pad_weighs_who_uses_a_place(case: str, empty_scene: Any) -> None:
    home, mark, size, heights = CASES[case]
    found = readings(home, mark, size, heights)
    assert not any(problems for _, problems in found), found
    shares = [share for share, _ in found]
    least, most = BED_SHARE if size is BED else SEAT_SHARE
    assert least < min(shares) and max(shares) < most, shares
    assert max(shares) - min(shares) < 0.06, "a cover changes little"
