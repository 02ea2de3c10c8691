# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind that queries nothing of the scene: it only reads its own pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..kind import Field, Kind, Preset
from ..model import Model, Reading, Update
from ..parameters import Parameters, parameter


@dataclass(frozen=True)
class InclinometerParameters(Parameters):
    limit: float = parameter(0.5, "Limit", "It has tipped over beyond this angle", unit="rad")
    report_step: float = parameter(0.1, "Report step", "Least change of the log", unit="rad")


class Inclinometer(Model):
    def update(self, parameters: InclinometerParameters, update: Update) -> Reading:
        tilt = math.acos(max(-1.0, min(1.0, float(update.pose.axes[2, 2]))))
        tipped = tilt > parameters.limit
        return Reading(tipped, tilt, {"tilt_rad": tilt, "tipped": tipped})


TILT = Field("tilt_rad", float, "rad", 0, step="report_step", quantity="tilt")
KIND = Kind(
    "INCLINOMETER",
    91,
    "Inclinometer",
    "Tells how far it is from upright",
    "DRIVER_ROTATIONAL_DIFFERENCE",
    "inclinometer",
    24.0,
    "Tipped",
    "Upright",
    InclinometerParameters,
    events=(Field("tipped", bool, quantity="tipping"), TILT),
    samples=(TILT, Field("tipped", bool)),
    model=Inclinometer,
    presets=(Preset("SHORT", "Touchy", {"limit": 0.25}, "a data sheet"),),
)
