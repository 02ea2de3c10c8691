# SPDX-License-Identifier: GPL-3.0-or-later
"""Passive infrared motion detector."""

from __future__ import annotations

from ...kind import RAYS, WARMTH, Field, Kind
from ...model import Model, Readings, Updates
from ...wording import OF_THRESHOLD
from .presets import PRESETS
from .pyroelectric import PyroelectricDetector
from .range_scan import PYRO, SCAN, PirParameters, RangeScan

# The motion detector: it senses by the one of its two models that its parameters choose.


class MotionDetector(Model):
    """One detector. Its state starts anew where its model is changed."""

    def __init__(self) -> None:
        self._model = ""
        self._sensing: RangeScan | PyroelectricDetector

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        if parameters.model != self._model:
            self._model = parameters.model
            pyroelectric = parameters.model == "PYROELECTRIC"
            self._sensing = PyroelectricDetector() if pyroelectric else RangeScan()
        return self._sensing.sense(parameters, updates)


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
