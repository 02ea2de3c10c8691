# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial distance sensors.

Data sheets give bounds of a reading's error; a third of a bound serves as the standard deviation.
"""

from __future__ import annotations

import math
from typing import Any

from ...kind import Preset

# The side of a square whose diagonal the data sheet of the VL53L1X gives, 27°.
SIDE_OF_27 = 2.0 * math.atan(math.tan(math.radians(27.0) / 2.0) / math.sqrt(2.0))


def _part(identifier: str, label: str, source: str, **values: Any) -> Preset:
    """A preset. All set the same parameters, so that each fully replaces another."""
    common = {
        "target": "MATERIAL",
        "zones_across": 1,
        "zones_up": 1,
        "rays": 5,
        "echo": "MEAN",
        "noise_sigma": 0.0,
        "noise_growth": 0.0,
        "resolution": 0.001,
    }
    return Preset(identifier, label, {**common, **values}, source)


PRESETS: tuple[Preset, ...] = (
    _part(
        "VL53L1X",
        "ST VL53L1X (long distance mode)",
        "ST, VL53L1X data sheet DocID031281 (27° from corner to corner) and the user's manual of "
        "STEVAL-BCN002V1, p. 21: in the dark 1.7 to 3.6 m for targets of 17 to 88 %, 40 mm at "
        "least, ±20 mm, of which a third is taken as the standard deviation",
        range_min=0.04,
        range_max=3.6,
        range_grey=1.7,
        horizontal_fov=SIDE_OF_27,
        vertical_fov=SIDE_OF_27,
        noise_sigma=0.02 / 3,
    ),
    _part(
        "VL53L5CX",
        "ST VL53L5CX (8 × 8 zones, 15 Hz)",
        "ST, VL53L5CX data sheet DS13754, tables 2 and 18: 45° × 45°, inner zones in the dark "
        "3.5 m white and 1.3 m grey. Its noise is taken from the ±11 mm and ±5 % of the VL53L8CX "
        "(DS14161), as three standard deviations",
        range_min=0.02,
        range_max=3.5,
        range_grey=1.3,
        horizontal_fov=math.radians(45.0),
        vertical_fov=math.radians(45.0),
        zones_across=8,
        zones_up=8,
        rays=3,
        echo="STRONGEST",
        noise_sigma=0.011 / 3,
        noise_growth=0.05 / 3,
    ),
    _part(
        "HC_SR04",
        "HC-SR04 (ultrasound)",
        "HC-SR04 data sheet: 2 cm to 4 m, 15°, up to 3 mm; what it meets throws sound back "
        "whatever its colour. Where the first echo is not enough, the next one counts",
        range_min=0.02,
        range_max=4.0,
        range_grey=4.0,
        horizontal_fov=math.radians(15.0),
        vertical_fov=math.radians(15.0),
        echo="FIRST",
        noise_sigma=0.003,
        resolution=0.003,
    ),
)
