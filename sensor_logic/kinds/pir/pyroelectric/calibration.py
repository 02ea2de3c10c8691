# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparator's threshold, from the detection distance in a data sheet.

Data sheets give the distance at which a standard target is just detected: a plate of the size of a
person's trunk, a few degrees warmer than its surroundings, that crosses the view at walking pace.
The threshold is the largest signal of that crossing. So lenslet area, transmission, responsivity
and gain, which no data sheet gives together, need not be known.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ....model import Array
from ....quantities import ZERO_CELSIUS
from .radiance import STEFAN_BOLTZMANN
from .response import Response, filtered
from .zones import Zone, Zones, zone_rays

# Panasonic's standard target (m) and its speed (m/s), and the room's temperature (K).
WIDTH, HEIGHT, SPEED = 0.25, 0.7, 1.0
ROOM = ZERO_CELSIUS + 20.0
# Rays per zone, sampling interval (s), and the time at rest before and after the crossing (s).
DENSE, INTERVAL, REST = 400, 0.01, 3.0
# m: the target moves this far to both sides of the middle, or as far as its distance if less.
REACH = 3.0


# One entry per set of parameters; without the cache 150 ms more per update.
@lru_cache(maxsize=256)
def threshold(zones: Zones, response: Response, distance: float, contrast: float) -> float:
    """The signal in W per m² of lenslet of the standard target, `contrast` K warmer than the room,
    at `distance` m and the height at which the signal is largest."""
    return crossing_peak(zones, response, distance, contrast)


def crossing_peak(
    zones: Zones, response: Response, distance: float, contrast: float, speed: float = SPEED
) -> float:
    """The largest size of the signal in W per m² of lenslet while the standard target crosses the
    lens's middle at `distance` m and `speed` m/s."""
    heights = sorted({zone.elevation for zone in zones})
    powers = [_crossing(zones, distance, contrast, speed, height) for height in heights]
    return float(np.abs(filtered(response, np.stack(powers, axis=1), INTERVAL)).max())


def _crossing(
    zones: Zones, distance: float, contrast: float, speed: float, elevation: float
) -> Array:
    """The power (k,) during the crossing, for a target perpendicular to the line of sight at
    `elevation` (rad)."""
    rays = zone_rays(zones, DENSE)
    ahead = Zone(0.0, elevation, 0.0, 0.0, 1)
    depth = rays.directions @ ahead.axis
    seen = depth > 1e-3
    scale = distance / depth[seen]
    across = rays.directions[seen] @ ahead.right * scale
    above = rays.directions[seen] @ np.cross(ahead.right, ahead.axis) * scale
    level = np.abs(above) <= HEIGHT / 2
    order = np.argsort(across[level])
    places = across[level][order]
    summed = np.concatenate([[0.0], np.cumsum(rays.weights[seen][level][order])])
    reach = min(distance, REACH)
    middle = np.arange(-reach, reach, speed * INTERVAL)
    still = int(REST / INTERVAL)
    middle = np.concatenate([np.full(still, middle[0]), middle, np.full(still, middle[-1])])
    covered = summed[np.searchsorted(places, middle + WIDTH / 2)]
    covered = covered - summed[np.searchsorted(places, middle - WIDTH / 2)]
    excess = STEFAN_BOLTZMANN * ((ROOM + contrast) ** 4 - ROOM**4) / math.pi
    power: Array = covered * excess
    return power
