# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind that casts a ray, in one file: test_new_kind.py puts it into sensor_logic/kinds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kind import RAYS, Field, Kind, Preset
from ..model import Model, Reading, Update
from ..parameters import Parameters, parameter


@dataclass(frozen=True)
class RangerParameters(Parameters):
    reach: float = parameter(4.0, "Reach", "How far it looks", unit="m", minimum=0.1)
    limit: float = parameter(1.0, "Limit", "What is nearer than this is near", unit="m")


class Ranger(Model):
    def update(self, parameters: RangerParameters, update: Update) -> Reading:
        origin, ahead = update.pose.origin[None], -update.pose.axes[:, 2][None]
        distance = float(update.ask(RAYS, 0, origin, ahead, np.array([parameters.reach]))[0])
        near = distance < parameters.limit
        return Reading(near, distance, {"near": near, "distance_m": distance})


KIND = Kind(
    "RANGER",
    90,
    "Ranger",
    "Tells whether something is near",
    "DRIVER_DISTANCE",
    "ranger",
    24.0,
    "Near",
    "Far",
    RangerParameters,
    events=(Field("near", bool, quantity="nearness"),),
    samples=(Field("distance_m", float, "m", 3, quantity="distance"), Field("near", bool)),
    model=Ranger,
    needs={RAYS: ()},
    presets=(Preset("SHORT", "Short ranger", {"reach": 2.5}, "a data sheet"),),
)
