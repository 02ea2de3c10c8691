# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion detector: it senses by the one of its two models that its parameters choose."""

from __future__ import annotations

from ...model import Model, Readings, Updates
from .pyroelectric.detector import PyroelectricDetector
from .range_scan import PirParameters, RangeScan


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
