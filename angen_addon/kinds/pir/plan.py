# SPDX-License-Identifier: GPL-3.0-or-later
"""The rays of a motion detector in the plan."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ....sensor_logic.kinds.pir.pyroelectric.detector import zones_of
from ....sensor_logic.kinds.pir.pyroelectric.zones import Zone
from ...runtime.trace import SensorRays, Trace

RAYS_A_ZONE = 5


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """The rays that its model casts; of a lens, each zone as a level fan as wide as the zone and as
    long as the detection distance in its datasheet."""
    parameters, pose = sight.parameters, sight.pose
    if parameters.model != "PYROELECTRIC":
        return replace(sight.rays(metres), rows=parameters.tilt_count)
    zones = zones_of(parameters)
    directions = np.array([_across(zone) for zone in zones]).reshape(-1, 3)
    directions = directions @ pose.axes.T
    origins = np.broadcast_to(pose.origin / metres, directions.shape)
    reach = np.full(len(directions), parameters.range_max / metres)
    return SensorRays(origins, directions, reach, len(zones))


def _across(zone: Zone) -> list[tuple[float, float, float]]:
    """Unit vectors from side to side of a zone at its middle height, in the sensor's axes."""
    level, rise = math.cos(zone.elevation), math.sin(zone.elevation)
    sides = np.linspace(-zone.width / 2, zone.width / 2, RAYS_A_ZONE) + zone.azimuth
    return [(-math.sin(a) * level, rise, -math.cos(a) * level) for a in sides.tolist()]
