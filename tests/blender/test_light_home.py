# SPDX-License-Identifier: GPL-3.0-or-later
"""The seven light sensors of the sample home follow its lamps and its doors."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from light_stage import measure, part

HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"


@pytest.fixture
def home(addon):
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    bpy.context.scene.angen_live = False
    yield bpy.context.scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def sensors(**asked):
    return [
        part("light.probe").LightRequest(o.name, np.array(o.matrix_world, np.float64), **asked)
        for o in bpy.context.scene.objects
        if o.angen_sensor.kind == "LIGHT"
    ]


@pytest.mark.slow
def test_each_sensor_follows_the_lamp_of_its_room(home):
    asked = sensors(samples=64, exposure=1.0)
    for room in ("living room", "kitchen", "bedroom", "bathroom"):
        lamp = bpy.data.objects[f"Lamp {room}"].data
        lamp.animation_data_clear()
        found = []
        for energy in (0.0, 40.0):
            lamp.energy = energy
            found.append(measure(*asked)[f"Light sensor {room}"].luminance_percent)
        assert found[1] > found[0] + 2.0, room


@pytest.mark.slow
@pytest.mark.parametrize("method", ["FOUR_WALL", "ILLUMINANCE"])
def test_a_reading_does_not_depend_on_the_other_sensors(home, method):
    asked = sensors(samples=32, method=method)
    together = measure(*asked)
    for alone in asked:
        assert measure(alone)[alone.name] == together[alone.name]
