# SPDX-License-Identifier: GPL-3.0-or-later
"""Pad that feels what presses on it."""

from __future__ import annotations

from ...kind import FORCES, Field, Kind
from .model import PressurePad
from .parameters import PressureParameters
from .presets import PRESETS

FORCE = Field("force_n", float, "N", 2, step="report_step", quantity="force")
KIND = Kind(
    "PRESSURE",
    3,
    "Pressure sensor",
    "Pressure sensor under furniture",
    "TRIA_DOWN_BAR",
    "pressure",
    1.0,
    "Pressed",
    "Free",
    PressureParameters,
    events=(
        Field("pressed", bool, quantity="occupancy"),
        FORCE,
        Field("partners", str, quantity="names"),
        Field("valid", bool, quantity="validity"),
    ),
    samples=(
        FORCE,
        Field("pressed", bool),
        Field("valid", bool),
        Field("residual", float),
        Field("resistance_ohm", float, "Ω"),
        Field("voltage_v", float, "V", 2),
        Field("adc", int),
        Field("partners", str),
        Field("cop_x_m", float, "m", 3),
        Field("cop_y_m", float, "m", 3),
        Field("problem", str),
    ),
    model=PressurePad,
    needs={FORCES: ()},
    presets=PRESETS,
)
