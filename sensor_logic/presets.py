# SPDX-License-Identifier: GPL-3.0-or-later
"""Known parts and settings, as data: what a sensor's parameters are for each of them.

A preset sets the parameters it names and leaves the others alone. Only published figures are
here, each preset with where they are from.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .light_parts import PARTS
from .pyroelectric.lenses import LENS_PRESETS


@dataclass(frozen=True)
class Preset:
    """`identifier` is unique within its `kind` and is never reused, scripts name it."""

    identifier: str
    kind: str
    label: str
    values: Mapping[str, Any]
    source: str


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


def _detector(
    identifier: str,
    label: str,
    source: str,
    *,
    range_max: float,
    horizontal: float,
    below: float = 90.0,
    hold: float = 0.0,
    block: float = 0.0,
    warm_up: float = 0.0,
) -> Preset:
    """A motion detector that can be bought, as a range scan: metres, degrees, seconds.

    All set the same parameters, so that one replaces another; what a source does not give is as
    by default. The fans look level and down to `below`: half of a vertical detection angle.
    """
    values = {
        "model": "RANGE_SCAN",
        "horizontal_fov": math.radians(horizontal),
        "range_max": range_max,
        "vertical_fov": math.radians(below),
        "hold_time": hold,
        "blocking_time": block,
        "warm_up_time": warm_up,
        "retrigger": True,
    }
    if warm_up:
        source += (
            f". It reports nothing for the first {warm_up:g} s: set the warm-up time to 0 for "
            "one that has long been on"
        )
    return Preset(identifier, "PIR", f"{label}, range scan", values, source)


def _slotted(identifier: str, label: str, gap_mm: float, aperture_mm: float, source: str) -> Preset:
    """A slotted switch that can be bought: open where nothing is in its gap.

    Their hysteresis is a ratio of light of about 0.75 (Sharp), which the comparator's levels of
    0.45 and 0.60 have. They answer within microseconds, far less than a frame.
    """
    values = {
        "range_min": 0.0,
        "range_max": gap_mm / 1000,
        "threshold": gap_mm / 1000,
        "aperture_rays": 9 if aperture_mm else 1,
        "aperture": aperture_mm / 1000,
        "hysteresis": 0.15,
        "noise_sigma": 0.0,
    }
    return Preset(identifier, "OPTICAL_SWITCH", label, values, source)


PMOD_PIR = "30 s to stabilize as in Digilent's Pmod PIR reference manual for EKMC1601111"
VISHAY_83764 = "Vishay data sheet TCST1103, TCST1202, TCST1300, document 83764: gap, aperture"
SHARP_GP1A50 = "Sharp GP1A50HR/51HR/52HR/53HR data sheet: gap, slit, hysteresis 0.75 typical"
OMRON_EE_SX67 = "Omron EE-SX47/67 data sheet CSM_EE-SX47/67_DS_E: slot; its aperture is not given"

PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "PIR",
        "Thesis (Gazebo range scan)",
        {
            "model": "RANGE_SCAN",
            "horizontal_fov": math.radians(120),
            "rays": 120,
            "range_min": 0.05,
            "range_max": 4.0,
            "vertical_fov": math.radians(90),
            "vertical_step": math.radians(10),
            "sweep": "SAWTOOTH",
            "threshold": 0.05,
            "noise_sigma": 0.0,
            "hold_time": 0.0,
            "blocking_time": 0.0,
            "warm_up_time": 0.0,
        },
        "range scan of the thesis's Gazebo plugin",
    ),
    _detector(
        "HC_SR501",
        "HC-SR501",
        "HC-SR501 module data sheet: 7 m, cone below 120°, delay from 0.3 s, block time 2.5 s; "
        "1 minute of initialization as at escol.com.my. The delay is the trimmer's shortest",
        range_max=7.0,
        horizontal=120.0,
        below=60.0,
        hold=0.3,
        block=2.5,
        warm_up=60.0,
    ),
    _detector(
        "EKMC1601111",
        "Panasonic EKMC1601111 (5 m)",
        f"Panasonic: 5 m, 94° × 82°; {PMOD_PIR}",
        range_max=5.0,
        horizontal=94.0,
        below=41.0,
        warm_up=30.0,
    ),
    _detector(
        "EKMC1603111",
        "Panasonic EKMC1603111 (12 m)",
        f"Panasonic: 12 m, 102° × 92°; {PMOD_PIR}",
        range_max=12.0,
        horizontal=102.0,
        below=46.0,
        warm_up=30.0,
    ),
    _detector(
        "EKMC1604111",
        "Panasonic EKMC1604111 (wall, 12 m)",
        f"Panasonic: first step 12 m, 105° wide, down to 49° below; {PMOD_PIR}",
        range_max=12.0,
        horizontal=105.0,
        below=49.0,
        warm_up=30.0,
    ),
    _detector(
        "MI_NODE",
        "element14 MI:node PIR (7 m)",
        "element14 MI:node user manual V3.1, p. 23: 7 m, solid angle 110°, high for 2.5 s typical",
        range_max=7.0,
        horizontal=110.0,
        below=55.0,
        hold=2.5,
    ),
    _detector(
        "HAA53",
        "Velleman HAA53 (wall, 14 m)",
        "Velleman HAA53 manual, specifications, wide-angle lens: 14 m, 110° wide, at most 1 minute "
        "of warm-up, on a wall 1.8 to 2.5 m up; how far down it looks is not given",
        range_max=14.0,
        horizontal=110.0,
        warm_up=60.0,
    ),
    *(Preset(p.identifier, "PIR", p.label, p.values, p.source) for p in LENS_PRESETS),
    Preset(
        "THESIS",
        "OPTICAL_SWITCH",
        "Thesis (Gazebo laser switch)",
        {
            "range_min": 0.001,
            "range_max": 0.5,
            "threshold": 0.05,
            "aperture_rays": 1,
            "aperture": 0.0,
            "noise_sigma": 0.0,
        },
        "laser switch of the thesis's Gazebo plugin",
    ),
    _slotted("TCST1103", "Vishay TCST1103 (3.1 mm)", 3.1, 1.0, VISHAY_83764),
    _slotted("TCST1202", "Vishay TCST1202 (3.1 mm, fine)", 3.1, 0.5, VISHAY_83764),
    _slotted("TCST1300", "Vishay TCST1300 (3.1 mm, finest)", 3.1, 0.25, VISHAY_83764),
    _slotted("GP1A51HR", "Sharp GP1A51HR (3 mm)", 3.0, 0.5, SHARP_GP1A50),
    _slotted("GP1A53HR", "Sharp GP1A53HR (5 mm)", 5.0, 0.5, SHARP_GP1A50),
    _slotted("EE_SX670", "Omron EE-SX670 (5 mm)", 5.0, 0.0, OMRON_EE_SX67),
    Preset(
        "FSR_402_IDEAL",
        "PRESSURE",
        "FSR 402, ideal part, 10 kΩ",
        _with_load({**FSR_402, **IDEAL}, 10_000.0),
        f"typical curve alone, {PDS_10004}",
    ),
    Preset(
        "FSR_402",
        "PRESSURE",
        "FSR 402, 10 kΩ",
        _with_load(FSR_402, 10_000.0),
        f"{PDS_10004}; load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "FSR_402_3K3",
        "PRESSURE",
        "FSR 402, 3.3 kΩ (heavy loads)",
        _with_load(FSR_402, 3_300.0),
        f"{PDS_10004}; load resistor of SparkFun's Force Sensitive Resistor Hookup Guide",
    ),
    Preset(
        "FSR_402_47K",
        "PRESSURE",
        "FSR 402, 47 kΩ (force switch)",
        _with_load(FSR_402, 47_000.0),
        f"{PDS_10004}; load resistor of the threshold switch in Interlink's FSR Integration Guide",
    ),
    Preset(
        "FSR_402_100K",
        "PRESSURE",
        "FSR 402, 100 kΩ (light touch)",
        _with_load(FSR_402, 100_000.0),
        f"{PDS_10004}; load resistor for less than 100 g of Sensitronics' note AN-1",
    ),
    Preset(
        "FSR_400",
        "PRESSURE",
        "FSR 400, 10 kΩ",
        _with_load({**FSR_400_SERIES, "area": 2.043e-5}, 10_000.0),
        f"5.1 mm diameter, {PDS_10004}; load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "FSR_406",
        "PRESSURE",
        "FSR 406, 10 kΩ",
        _with_load({**FSR_400_SERIES, "area": 1.452e-3}, 10_000.0),
        f"38.1 mm square, {PDS_10004}; load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "THESIS",
        "LIGHT",
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
    *(
        Preset(part.name.upper().replace("-", "_"), "LIGHT", part.name, part.values, part.source)
        for part in PARTS
    ),
)


def presets_of(kind: str) -> tuple[Preset, ...]:
    """The presets of a kind of sensor, in the order in which a menu shows them."""
    return tuple(preset for preset in PRESETS if preset.kind == kind)
