# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial force-sensing resistors, each with its load resistor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...kind import Preset

# The sheet covers the whole series with one curve and one table: "one standard deviation/mean,
# at 1000 g", hysteresis on average, drift as an upper bound.
PDS_10004 = "Interlink FSR 400 series data sheet, PDS-10004"
FSR_400_SERIES = {
    "resistor": "FSR_402",
    "force_min": 0.2,
    "force_max": 20.0,
    "unloaded_resistance": 10e6,
    "hysteresis": 0.10,
    "drift": 0.05,
    "part_spread": 0.06,
    "repeatability": 0.02,
}
IDEAL = {"hysteresis": 0.0, "drift": 0.0, "part_spread": 0.0, "repeatability": 0.0}
FSR_402 = {**FSR_400_SERIES, "area": 1.267e-4}


def _with_load(part: Mapping[str, Any], ohms: float) -> dict[str, Any]:
    """A part in a divider with this load resistor at 5 V, the voltage of Interlink's figures."""
    return {**part, "load_resistor": ohms, "supply_voltage": 5.0}


PRESETS: tuple[Preset, ...] = (
    Preset(
        "FSR_402_IDEAL",
        "FSR 402, ideal part, 10 kΩ",
        _with_load({**FSR_402, **IDEAL}, 10_000.0),
        f"typical curve alone, {PDS_10004}",
    ),
    Preset(
        "FSR_402",
        "FSR 402, 10 kΩ",
        _with_load(FSR_402, 10_000.0),
        f"{PDS_10004}; load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "FSR_402_3K3",
        "FSR 402, 3.3 kΩ (heavy loads)",
        _with_load(FSR_402, 3_300.0),
        f"{PDS_10004}; load resistor of SparkFun's Force Sensitive Resistor Hookup Guide",
    ),
    Preset(
        "FSR_402_47K",
        "FSR 402, 47 kΩ (force switch)",
        _with_load(FSR_402, 47_000.0),
        f"{PDS_10004}; load resistor of the threshold switch in Interlink's FSR Integration Guide",
    ),
    Preset(
        "FSR_402_100K",
        "FSR 402, 100 kΩ (light touch)",
        _with_load(FSR_402, 100_000.0),
        f"{PDS_10004}; load resistor for less than 100 g of Sensitronics' note AN-1",
    ),
    Preset(
        "FSR_400",
        "FSR 400, 10 kΩ",
        _with_load({**FSR_400_SERIES, "area": 2.043e-5}, 10_000.0),
        f"5.1 mm diameter, {PDS_10004}; load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "FSR_406",
        "FSR 406, 10 kΩ",
        _with_load({**FSR_400_SERIES, "area": 1.452e-3}, 10_000.0),
        f"38.1 mm square, {PDS_10004}; load resistor of Adafruit's FSR guide",
    ),
)
