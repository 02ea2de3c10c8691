# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensors that can be bought: values of `LightParameters`, each with its source.

Only what a part decides is listed; where a data sheet gives a range, its middle is taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

GL55 = "GL55 series data sheet (light resistance at 10 lx, 2854 K; γ ± 0.1)"


@dataclass(frozen=True)
class Part:
    """Name as bought, the parameters it sets, and where these are from."""

    name: str
    values: dict[str, Any]
    source: str


def _resistor(
    name: str, kilo: tuple[float, float], dark_mega: float, gamma: float, rise_ms: float
) -> Part:
    low, high = kilo
    values = {
        "method": "ILLUMINANCE",
        "output": "RESISTOR",
        "resistance_10lux": 500.0 * (low + high),
        "dark_resistance": dark_mega * 1e6,
        "gamma": gamma,
        "rise_time": rise_ms / 1000.0,
        "fall_time": 0.03,
    }
    return Part(name, values, f"{low:g}–{high:g} kΩ, {GL55}")


def _digital(name: str, step: float, full: float, seconds: float, source: str) -> Part:
    values = {
        "method": "ILLUMINANCE",
        "output": "DIGITAL",
        "lux_step": step,
        "lux_max": full,
        "integration_time": seconds,
    }
    return Part(name, values, source)


PARTS: tuple[Part, ...] = (
    _resistor("GL5516", (5.0, 10.0), 0.5, 0.5, 30.0),
    _resistor("GL5528", (8.0, 20.0), 1.0, 0.7, 20.0),
    _resistor("GL5537-1", (20.0, 30.0), 2.0, 0.6, 20.0),
    _resistor("GL5537-2", (30.0, 50.0), 3.0, 0.7, 20.0),
    _resistor("GL5539", (50.0, 100.0), 5.0, 0.8, 20.0),
    _resistor("GL5549", (100.0, 200.0), 10.0, 0.9, 20.0),
    _digital(
        "BH1750FVI",
        1.0 / 1.2,
        65535.0 / 1.2,
        0.12,
        "ROHM BH1750FVI data sheet: H-resolution mode, 1.2 counts a lux, 16 bit, 120 ms typical",
    ),
    _digital(
        "TSL2561",
        0.1,
        40_000.0,
        0.402,
        "ams TAOS TSL2560/TSL2561 data sheet: 0.1 to 40 000 lx, 402 ms nominal integration; "
        "the step of 0.1 lx is that of the low end, with 16× gain",
    ),
    _digital(
        "VEML7700",
        0.0576,
        0.0576 * 65535,
        0.1,
        "Vishay VEML7700 data sheet and application note: gain 1, 100 ms, 0.0576 lx a count, "
        "16 bit",
    ),
)
