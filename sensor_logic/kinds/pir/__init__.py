# SPDX-License-Identifier: GPL-3.0-or-later
"""Passive infrared motion detector."""

from __future__ import annotations

from ...kind import RAYS, WARMTH, Field, Kind
from ...quantities import OF_THRESHOLD
from .model import MotionDetector
from .presets import PRESETS
from .range_scan import PYRO, SCAN, PirParameters

KIND = Kind(
    "PIR",
    1,
    "Motion detector (PIR)",
    "Passive infrared motion detector",
    "LIGHT_AREA",
    "pir",
    10.0,
    "Motion",
    "Still",
    PirParameters,
    events=(Field("moved", bool, quantity="motion"),),
    samples=(
        Field("angle_rad", float, "rad", 0, **SCAN),
        Field("moved", bool),
        Field("signal", float, OF_THRESHOLD, 0, optional=True, **PYRO),
    ),
    model=MotionDetector,
    needs={RAYS: SCAN["used_when"], WARMTH: PYRO["used_when"]},
    in_room=True,
    presets=PRESETS,
)
