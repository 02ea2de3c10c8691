# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion detector by whichever of its two models its parameters choose."""

from __future__ import annotations

from .model import Reading, Update
from .pir import PirParameters, RangeScan
from .pyroelectric.detector import PyroelectricDetector


class MotionDetector:
    """One detector. Where the model is changed, it starts anew."""

    def __init__(self) -> None:
        self._model = ""
        self._sensing: RangeScan | PyroelectricDetector

    def update(self, parameters: PirParameters, update: Update) -> Reading:
        if parameters.model != self._model:
            self._model = parameters.model
            pyroelectric = parameters.model == "PYROELECTRIC"
            self._sensing = PyroelectricDetector() if pyroelectric else RangeScan()
        return self._sensing.update(parameters, update)
