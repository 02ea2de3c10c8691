# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensor: luminance of four walls, or illuminance."""

from __future__ import annotations

from ...kind import LIGHT, Field, Kind
from .model import FOUR_WALL, ILLUMINANCE, LightParameters, LightSensor
from .presets import PRESETS

PERCENT = Field(
    "luminance_percent", float, "%", 1, step="report_step", quantity="luminance", **FOUR_WALL
)
LUX = Field(
    "illuminance_lux", float, "lx", step="report_step", quantity="illuminance", **ILLUMINANCE
)
KIND = Kind(
    "LIGHT",
    4,
    "Light sensor",
    "Light sensor: luminance or illuminance",
    "LIGHT_SUN",
    "light",
    1.0,
    "Lit",
    "Dark",
    LightParameters,
    events=(
        PERCENT,
        LUX,
        Field("lit", bool, quantity="light"),
    ),
    samples=(
        PERCENT,
        LUX,
        Field("resistance_ohm", float, "Ω"),
        Field("voltage_v", float, "V", 2),
        Field("lit", bool),
    ),
    model=LightSensor,
    needs={LIGHT: ()},
    in_room=True,
    presets=PRESETS,
)
