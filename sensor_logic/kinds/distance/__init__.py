# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance sensor: time of flight or ultrasound, in one zone or many."""

from __future__ import annotations

from ...kind import RAYS, REFLECTANCE, Field, Kind
from .model import DistanceSensor
from .parameters import DistanceParameters
from .presets import PRESETS

DISTANCE = Field("distance_m", float, "m", 3, step="report_step", quantity="distance")
NEAR = Field("near", bool, quantity="proximity")
KIND = Kind(
    "DISTANCE",
    5,
    "Distance sensor",
    "Distance sensor: time of flight or ultrasound",
    "DRIVER_DISTANCE",
    "distance",
    10.0,
    "Near",
    "Clear",
    DistanceParameters,
    events=(NEAR, DISTANCE),
    samples=(DISTANCE, NEAR, Field("zones_m", str, quantity="distances")),
    model=DistanceSensor,
    needs={RAYS: (), REFLECTANCE: (("target", "MATERIAL"),)},
    in_room=True,
    presets=PRESETS,
)
