# SPDX-License-Identifier: GPL-3.0-or-later
"""Days of a routine warm what residents use, and know of earlier uses of the day."""

from datetime import date

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import stillness
from bl_ext.user_default.angen_sensors.angen_addon.scene.surfaces import warmth
from bl_ext.user_default.angen_sensors.residents.blender import run
from bl_ext.user_default.angen_sensors.residents.days.rows import frame_at
from bl_ext.user_default.angen_sensors.sensor_logic.heat import HEATS, warm_share
from bl_ext.user_default.angen_sensors.sensor_logic.kind import WARMTH


def test_a_later_part_of_the_day_knows_what_was_warm(lived_home):
    scene, seat, heat = bpy.context.scene, bpy.data.objects["Seat"], HEATS["RADIATOR"]
    seat.angen_heat.sort = "RADIATOR"
    plan = run.Plan.read(lived_home.parent / "week.toml")
    household = run.HouseholdDays(scene, [], plan, date(2026, 3, 2), 1)
    acted = household.acted(0)
    ((start, end),) = acted.times_in_use()["Seat"]
    with run.at_ten_frames(scene), household.keyed() as keys:
        for time in (start - 60.0, (start + end) / 2, end + 1800.0):
            keys.show(acted, time - 50.0, time + 50.0)
            scene.frame_set(frame_at(time))
            wanted = warm_share(heat, [(start, end)], time)
            assert warmth.share_in_use(seat, heat, scene) == pytest.approx(wanted, abs=1e-3)
        # While it cools down a run looks again, and only for sensors of warmth.
        cooling = range(frame_at(end + 1800.0), frame_at(end + 2400.0))
        fresh = [
            stillness.find_stillness(scene, needs).fresh(cooling, [0.0] * len(cooling)).sum()
            for needs in ({WARMTH}, set())
        ]
        assert fresh[0] > fresh[1] + 3
    assert not seat.angen_use.in_use
