# SPDX-License-Identifier: GPL-3.0-or-later
"""Rebuild the measured situations of force resistors and light sensors.

The rows are in measured_force_light.csv. Sensors are placed with their presets, as a user would.
"""

from __future__ import annotations

import statistics
from typing import Any

import bpy
import numpy as np

from .common import box_mesh, link, new_scene, run, sensors_of

# In kg, and the half side in m of what presses: a fingertip, or a weight larger than the part.
LOADS = {"F402_1": (0.5, 0.005), "F402_2": (0.75, 0.005), "F402_3": (0.75, 0.03)}
# Devices differ by the part spread: the median of so many is compared.
DEVICES = 5
# In m: a square field of LEDs whose size is fitted to the row LED1, and the heights measured.
LAMP, HEIGHTS = 0.8, {"": 0.21, "LED1": 0.51, "LED2": 0.81, "LED3": 1.11}


def simulate(quick: bool) -> dict[str, float]:
    """Return the simulated figure of each row by its id; `quick` takes fewer light paths."""
    return {**_force(), **_chamber(256 if quick else 4096), "LUX": _noise(100 if quick else 500)}


def _place(kind: str, preset: str, at: tuple[float, float, float], name: str) -> Any:
    bpy.ops.angen.sensor_place(kind=kind, preset=preset, location=at, normal=(0.0, 0.0, 1.0))
    bpy.context.object.name = name
    return bpy.context.object.angen_sensor


def _force() -> dict[str, float]:
    scene = new_scene(24, 6)
    for row, (key, (mass, half)) in enumerate(LOADS.items()):
        for device in range(DEVICES):
            place = 0.5 * row, 0.5 * device
            _place("PRESSURE", "FSR_402", (*place, 0.0), f"{key} {device}").update_rate = 24.0
            pad = bpy.context.object
            top = max((pad.matrix_world @ v.co).z for v in pad.data.vertices)
            load = link(f"load {key} {device}", box_mesh([((half,) * 3, (0, 0, half))]))
            load.location = (*place, top)
            load.angen_load.mass = mass
    _, recording = run(scene, sensors_of(), 1, 6)
    found: dict[str, float] = {}
    for key in LOADS:
        tracks = [recording.tracks[f"{key} {device}"] for device in range(DEVICES)]
        found[key] = statistics.median(track.columns["resistance_ohm"][3] for track in tracks)
    return found


def _lamp(at: float, watts: float) -> None:
    data = bpy.data.lights.new("lamp", "AREA")
    data.energy, data.size = watts, LAMP
    link("lamp", data, (0.0, 0.0, at))


def _chamber(samples: int) -> dict[str, float]:
    """Return the light below a lamp between black walls, as shares of that at 21 cm."""
    scene = new_scene(24, 1)
    _lamp(0.0, 1.0)
    for key, height in HEIGHTS.items():
        lux = _place("LIGHT", "BH1750FVI", (0.0, 0.0, -height), f"lux {key}").light
        lux.noise_share, lux.lux_step, lux.samples = 0.0, 0.0, samples
    _, recording = run(scene, sensors_of(), 1, 1)
    light = {
        key: float(recording.tracks[f"lux {key}"].columns["illuminance_lux"][0]) for key in HEIGHTS
    }
    return {key: light[key] / light[""] for key in HEIGHTS if key}


def _noise(updates: int) -> float:
    """Return the standard deviation of lux readings in percent of them, from successive ones."""
    scene = new_scene(1, updates)
    _lamp(2.0, 1.5)
    _place("LIGHT", "BH1750FVI", (0.0, 0.0, 0.8), "lux").update_rate = 1.0
    _, recording = run(scene, sensors_of(), 1, updates)
    lux = np.array(recording.tracks["lux"].columns["illuminance_lux"][:], float)
    return float(100.0 * np.diff(lux).std() / np.sqrt(2.0) / lux.mean())
