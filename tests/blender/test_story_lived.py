# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample home's story as a routine: the engine of days simulates it in the shipped file."""

from datetime import date
from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene import sensors
from bl_ext.user_default.angen_sensors.residents.blender import run
from bl_ext.user_default.angen_sensors.residents.body.solve import solve
from mathutils import Vector

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
BEGINS, LASTS = 21.5 * 3600, 172.0
# The evening is simulated for so long, until the resident leaves the kitchen.
SENSED = 63.0
ACTIVITIES = ["Coming home", "A rest", "Bathroom", "To bed"]
ROOMS = ["living room", "living room", "bathroom", "bedroom"]
STAY_ON = ("Lamp hall", "Lamp living room", "Lamp bedroom")
SWINGS = [
    *("entrance", "entrance", "kitchen", "Fridge door", "Fridge door", "kitchen"),
    *("bathroom", "bathroom", "closet", "closet", "bedroom", "bedroom"),
]


@pytest.fixture(scope="module")
def household():
    """Return the residents of the sample home by its story, with its doors and kitchen."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / "angen.blend"), load_ui=False)
    bpy.context.scene.angen_live = False
    plan = run.Plan.read(SAMPLES / "story.toml")
    told = [
        sensor
        for sensor in sensors.all_sensors(bpy.context.view_layer)
        if sensor.kind.identifier == "OPTICAL_SWITCH" or sensor.name == "PIR kitchen"
    ]
    yield run.HouseholdDays(bpy.context.scene, told, plan, date(2026, 3, 2), 1)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def lived(household, keys):
    """Return the day, as far as it was simulated."""
    running = household.run(0, keys, (BEGINS, BEGINS + SENSED))
    while True:
        try:
            next(running)
        except StopIteration as end:
            return end.value


@pytest.mark.slow
def test_the_evening_is_lived_and_sensed(household):
    acted = household.acted(0)
    swings = sorted(
        (swing.start, name.removeprefix("Door "))
        for name, found in acted.swings.items()
        for swing in found
        if swing.start >= BEGINS
    )
    # She shuts again what she opens.
    assert [name for _, name in swings] == SWINGS
    # The fridge, to its front.
    assert acted.swings["Fridge door"][0].after == pytest.approx(-1.8326, abs=1e-4)
    lit = {switch.object: switch.on for switch in acted.switches}
    assert lit == dict.fromkeys(STAY_ON, True) | dict.fromkeys(
        ("Lamp kitchen", "Lamp bathroom"), False
    )

    with household.keyed() as keys:
        day = lived(household, keys)
    done = [one for one in day.activities if one.start >= BEGINS * 1e6]
    assert [one.activity for one in done] == ACTIVITIES
    assert [one.room for one in done] == ROOMS
    opened = [e for e in day.events if (e.kind, e.value) == ("OPTICAL_SWITCH", True)]
    assert [e.sensor for e in opened] == ["Switch entrance", "Switch kitchen"]
    assert {(e.person, e.because.split()[0]) for e in opened} == {("anna", "Flag")}
    moved = [e.time for e in day.events if (e.kind, e.value) == ("PIR", True)]
    # From the opening of the kitchen's door until it is shut behind her.
    through = [s for s in acted.swings["Door kitchen"] if s.start >= BEGINS]
    assert through[0].start < moved[0] / 1e6 < moved[-1] / 1e6 < through[-1].end + 1.0


@pytest.mark.slow
def test_the_animation_in_the_file_is_the_evening(household):
    acted, scene = household.acted(0), bpy.context.scene
    rig, line = bpy.data.objects["Person rig"], acted.bodies["anna"]
    for frame in range(1, scene.frame_end, 83):
        scene.frame_set(frame)
        at = solve(line.poses(np.array([BEGINS + (frame - 1) / scene.render.fps]))).at
        for bone in ("head", "hand.L", "hand.R", "foot.L", "foot.R"):
            there = np.array(rig.matrix_world @ rig.pose.bones[bone].head)
            assert there == pytest.approx(at[bone][0], abs=0.006), f"{bone} at frame {frame}"


@pytest.mark.slow
def test_she_drinks_from_the_bottle_and_leaves_it_on_the_table(household):
    acted, scene = household.acted(0), bpy.context.scene
    bottle, rig = bpy.data.objects["Bottle"], bpy.data.objects["Person rig"]
    (first,) = acted.sips["Bottle"]
    drinks, ends = (first.start + first.end) / 2, BEGINS + LASTS
    with household.keyed() as keys:
        keys.show(acted, drinks - 5.0, drinks + 5.0)
        scene.frame_set(round(1 + 10 * drinks))
        mouth = rig.matrix_world @ rig.pose.bones["head"].head
        neck = bottle.matrix_world @ Vector((0.0, 0.0, 0.23))
        assert (neck - mouth).length < 0.2
        assert bottle.matrix_world.to_3x3().col[2].z < 0.3
        keys.show(acted, ends - 5.0, ends)
        scene.frame_set(round(1 + 10 * ends))
        assert tuple(bottle.matrix_world.translation) == pytest.approx((8.8, 5.24, 0.47), abs=1e-3)
        assert bottle.matrix_world.to_3x3().col[2].z == pytest.approx(1.0)
