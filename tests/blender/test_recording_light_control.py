# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample of the light control: a lamp on a driver that reads the detector's output, recorded,
baked, and kept in the file."""

from importlib import import_module
from pathlib import Path

import bpy
import pytest

ADDON = "bl_ext.user_default.angen_sensors"
SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "light_control.blend"
LAST = 330
# Of the story: comes in, stands still for longer than the hold time.
ON, OFF = 141, 285


@pytest.fixture
def room(addon):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE))
    sensor = bpy.data.objects["Light sensor room"].angen_sensor
    sensor.light.engine, sensor.light.samples = "CYCLES", 16
    bpy.context.scene.frame_end = LAST
    return bpy.context.scene


def energy(frame):
    bpy.context.scene.frame_set(frame)
    lamp = bpy.data.lights["Lamp"]
    return lamp.evaluated_get(bpy.context.evaluated_depsgraph_get()).energy


def changes(name, field):
    state = import_module(f"{ADDON}.angen_addon.runtime.state")
    track = state.CACHE.recording(bpy.context.scene).tracks[name]
    column = list(track.columns[field])
    return [
        (int(track.frames[i]), bool(value))
        for i, value in enumerate(column)
        if i == 0 or value != column[i - 1]
    ]


def test_the_detector_switches_the_lamp_and_the_light_sensor_sees_it(room, tmp_path):
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    assert changes("PIR room", "moved") == [(1, False), (ON, True), (OFF, False)]
    # It looks twice a second; a driver shows a reading from the next frame on.
    assert changes("Light sensor room", "lit") == [(1, False), (145, True), (289, False)]
    lit = {ON + 20: 20.0, OFF + 20: 0.0, ON - 1: 0.0, OFF - 2: 20.0}
    assert {frame: energy(frame) for frame in lit} == pytest.approx(lit)
    path = str(tmp_path / "recorded.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert {frame: energy(frame) for frame in lit} == pytest.approx(lit)
    assert bpy.ops.angen.bake_keyframes() == {"FINISHED"}
    bpy.ops.angen.clear_recording()
    bpy.context.scene.angen_live = False
    assert {frame: energy(frame) for frame in lit} == pytest.approx(lit)
