# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sits still in the sample home: present for a radar and a thermal array, absent for a PIR."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.api.home import Home

HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"
# s of the story: the resident sits, and nothing of her moves for three seconds.
STILL = 85.2, 88.2
STATES = {"PIR living room": "moved", "Radar": "presence", "Array": "occupied"}


@pytest.mark.slow
def test_who_sits_still_in_the_living_room_is_there_for_radar_and_array_alone():
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    with Home.open(HOME) as home:
        home.add("PRESENCE_RADAR", name="Radar", at=(9.67, 6.2, 2.35), look=(0, 0, -1),
                 preset="LD2410")  # fmt: skip
        home.add("THERMAL_ARRAY", name="Array", at=(9.67, 6.0, 2.35), look=(0, 0, -1),
                 preset="MLX90640_BAA")  # fmt: skip
        run = home.simulate(sensors=list(STATES))
        on = {}
        for name, field in STATES.items():
            samples = run.samples(name)
            within = (samples["time_s"] >= STILL[0]) & (samples["time_s"] < STILL[1])
            on[name] = np.asarray(samples[field], bool)[within]
    assert on["Radar"].all() and on["Array"].all()
    assert not on["PIR living room"].any()
