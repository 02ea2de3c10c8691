# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial light sensors, and the thesis's.

A preset sets only what the part determines and its source gives; of a range, the middle.
"""

from __future__ import annotations

from typing import Any

from ...kind import Preset

MANUAL = (
    "GL55 Series CdS Photoresistor Manual, p. 2 (10 lx of 2856 K after 2 h at 400 to 600 lx; dark "
    "10 s after 10 lx; gamma = lg(R10/R100)); its rows bear no names and are taken in their order"
)
CURVE = (
    "resistances as traded (10 lx; dark); gamma from the curve lux = a / ohm^b of the "
    "Arduino-Light-Dependent-Resistor-Library by Quentin Comte-Gaz, 1/b; no response times known"
)


def _part(name: str, values: dict[str, Any], source: str) -> Preset:
    return Preset(name.upper().replace("-", "_"), name, values, source)


def _resistor(
    name: str, kilo: tuple[float, float], dark_mega: float, gamma: float, rise_fall_ms: Any = ()
) -> Preset:
    low, high = kilo
    values = {
        "method": "ILLUMINANCE",
        "output": "RESISTOR",
        "resistance_10lux": 500.0 * (low + high),
        "dark_resistance": dark_mega * 1e6,
        "gamma": gamma,
    }
    for key, ms in zip(("rise_time", "fall_time"), rise_fall_ms, strict=False):
        values[key] = ms / 1000.0
    source = MANUAL if rise_fall_ms else CURVE
    return _part(name, values, f"{low:g}–{high:g} kΩ: {source}")


def _digital(name: str, step: float, full: float, seconds: float, source: str) -> Preset:
    values = {
        "method": "ILLUMINANCE",
        "output": "DIGITAL",
        "lux_step": step,
        "lux_max": full,
        "integration_time": seconds,
    }
    return _part(name, values, source)


PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "Thesis (Gazebo cameras, four walls)",
        {
            "method": "FOUR_WALL",
            "clip_start": 0.5,
            "clip_end": 5.0,
            "field_of_view": 0.02,
            "noise_sigma": 0.0,
        },
        "camera sensor of the thesis's Gazebo plugin",
    ),
    _resistor("GL5516", (5.0, 10.0), 0.5, 0.5, (30.0, 30.0)),
    _resistor("GL5528", (10.0, 20.0), 1.0, 0.6, (20.0, 30.0)),
    _resistor("GL5537-1", (20.0, 30.0), 2.0, 0.6, (20.0, 30.0)),
    _resistor("GL5537-2", (30.0, 50.0), 3.0, 0.85),
    _resistor("GL5539", (50.0, 100.0), 5.0, 0.8, (20.0, 30.0)),
    _resistor("GL5549", (100.0, 200.0), 10.0, 0.78),
    _digital(
        "BH1750FVI",
        1.0 / 1.2,
        65535.0 / 1.2,
        0.12,
        "ROHM BH1750FVI technical note, 2009.04 Rev. B: H-resolution mode, 1.2 counts a lux "
        "typical, 16 bit, 120 ms typical",
    ),
    _digital(
        "TSL2561",
        0.1,
        40_000.0,
        0.402,
        "0.1 to 40 000 lx and 402 ms as in Raspberry Connect's description of the breakout "
        "board; the step is the least light that it tells apart, at its high gain",
    ),
    _digital(
        "VEML7700",
        0.0576,
        0.0576 * 65535,
        0.1,
        "drivers of Adafruit (Adafruit_VEML7700) and ESPHome: 0.0036 lx a count at gain 2 and "
        "800 ms, so 0.0576 lx at gain 1 and 100 ms, 16 bit; others say 0.0042 instead of 0.0036",
    ),
)
