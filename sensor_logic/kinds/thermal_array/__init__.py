# SPDX-License-Identifier: GPL-3.0-or-later
"""Infrared array: a picture of temperatures with few pixels, which detects people without motion.

- Model: array.py, device.py (noise and drift), parameters.py, presets.py.
- Scene: the temperature at the hits of rays by `Warmth` in angen_addon/scene/surfaces/warmth.py.
- Window: angen_addon/kinds/thermal_array/; coverage maps: coverage.py.
- Physics: docs/thermal_array.md.
- Tests: tests/pure/test_thermal_array.py, tests/blender/test_thermal_array.py.
"""

from __future__ import annotations

from ...kind import WARMTH, Field, Kind
from .array import ThermalArray
from .coverage import view
from .parameters import ThermalArrayParameters
from .pixel_evidence import FIELDS, cause
from .presets import PRESETS

OCCUPIED = Field(
    "occupied",
    bool,
    quantity="occupancy",
    tip="Whether enough pixels are warm, or were within the hold time",
)
HIGHEST = Field(
    "max_c",
    float,
    "°C",
    1,
    step="report_step",
    quantity="temperature",
    tip="Temperature of the warmest pixel",
)
WARM = Field(
    "warm_pixels",
    int,
    quantity="warm pixels",
    tip="Number of pixels that exceed the background by more than the threshold",
)
KIND = Kind(
    "THERMAL_ARRAY",
    7,
    "Thermal array",
    "Infrared array: detects people by their warmth, also at rest",
    "IMAGE_DATA",
    "thermal_array",
    10.0,
    "Occupied",
    "Empty",
    ThermalArrayParameters,
    events=(OCCUPIED, WARM, HIGHEST),
    samples=(
        HIGHEST,
        OCCUPIED,
        WARM,
        Field(
            "mean_c", float, "°C", 1, quantity="temperature", tip="Mean temperature of all pixels"
        ),
        Field(
            "frame_c",
            str,
            "°C",
            optional=True,
            used_when=(("keep_frames", True),),
            quantity="frame",
            shape=("columns", "rows"),
            tip="Temperatures of all pixels, row by row from the upper left, with semicolons",
        ),
    ),
    evidence=FIELDS,
    cause=cause,
    model=ThermalArray,
    needs={WARMTH: ()},
    in_room=True,
    presets=PRESETS,
    part="AMG8833",
    view=view,
)
