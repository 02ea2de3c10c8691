# SPDX-License-Identifier: GPL-3.0-or-later
"""The office of Ouadjaout, Lasla, Djenouri and Zizoua, "On the Effect of Sensing-holes in PIR-based
Occupancy Detection Systems" (SENSORNETS 2016): how many detectors does a desk need?

Published: 3.3 × 2.4 m, points 0.3 m apart (11 × 8), Panasonic EKMB detectors, a point is covered
where it lies in a detection zone; the best single detector covers nearly 63 % of the desk, three
cover all of it. Ours where nothing is published: the desk's place and size, heights, where
detectors may hang, and the zones themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from angen_sensors.sensor_logic.coverage.detect import WarmView
from angen_sensors.sensor_logic.coverage.detectors import Walker
from angen_sensors.sensor_logic.coverage.grid import choose
from angen_sensors.sensor_logic.coverage.motions import DIRECTIONS, HEADINGS, MOTIONS, Start
from angen_sensors.sensor_logic.kinds.pir.lenses import zone_rays
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import (
    STEFAN_BOLTZMANN,
    response_of,
    threshold_of,
    zones_of,
)
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.wording import ZERO_CELSIUS

Array = np.typing.NDArray[np.float64]
STEP, POINTS = 0.3, (11, 8)
CEILING, DESK_TOP, OVER_DESK = 2.7, 0.75, 0.15
# Points of the desk: 1.8 × 0.9 m against the middle of a long wall.
DESK = (slice(3, 9), slice(0, 3))
# Detectors hang at the points of the grid, looking down, turned by multiples of 15°.
ROLLS = tuple(math.radians(a) for a in range(0, 90, 15))
LENS = PirParameters(model="PYROELECTRIC", lens="EKMC1601111", range_max=5.0)
COUNTS = (1, 2, 3)
AMBIENT = 20.0 + ZERO_CELSIUS


def measure() -> dict[str, Any]:
    """Shares of the desk by the number of detectors: by zones, as published, and by an arm."""
    return {
        "zones": _shares(_in_zones),
        "arm": _shares(_by_an_arm),
        "desk_points": len(_points(0.0)[DESK].reshape(-1, 3)),
        "candidates": POINTS[0] * POINTS[1] * len(ROLLS),
    }


def _points(height: float) -> Array:
    x, y = np.meshgrid(*((np.arange(n) + 0.5) * STEP for n in POINTS), indexing="ij")
    return np.stack([x, y, np.full(x.shape, height)], axis=-1)


def _shares(covers: Callable[[Array, Array], Array]) -> list[dict[str, float]]:
    desk = _points(0.0)[DESK].reshape(-1, 3)
    sets = []
    for place in _points(CEILING).reshape(-1, 3):
        for roll in ROLLS:
            top = np.array([math.cos(roll), math.sin(roll), 0.0])
            up = np.array([0.0, 0.0, 1.0])
            sets.append(covers(np.column_stack([np.cross(top, up), top, up]), desk - place))
    found = []
    for count in COUNTS:
        choice = choose(np.array(sets), count)
        found.append(
            {
                "count": count,
                "share": choice.covered / len(desk),
                "bound": choice.bound / len(desk),
            }
        )
    return found


def _in_zones(axes: Array, towards: Array) -> Array:
    """Whether points of the desk's top, seen from the detector, lie in a zone."""
    local = (towards + np.array([0.0, 0.0, DESK_TOP])) @ axes
    inside = np.zeros(len(local), bool)
    for zone in zones_of(LENS):
        up = np.cross(zone.right, zone.axis)
        depth = local @ zone.axis
        across, along = np.abs(local @ zone.right), np.abs(local @ up)
        inside |= (
            (depth > 0.0)
            & (across <= depth * math.tan(zone.width / 2))
            & (along <= depth * math.tan(zone.height / 2))
        )
    return inside


def _by_an_arm(axes: Array, towards: Array) -> Array:
    """Whether an arm that turns by 90° over the point is noticed from half of its bearings."""
    local = zone_rays(zones_of(LENS), LENS.zone_rays)
    directions = local.directions @ axes.T
    walker = Walker()
    warm = (walker.celsius + ZERO_CELSIUS) ** 4 - AMBIENT**4
    view = WarmView(
        np.zeros(3),
        directions,
        local.weights,
        np.full(len(directions), 50.0),
        np.zeros(len(directions)),
        STEFAN_BOLTZMANN * walker.emissivity * warm,
        0.05,
        response_of(LENS),
        threshold_of(LENS),
        0.1,
    )
    arm = MOTIONS["ARM"].at_height(DESK_TOP + OVER_DESK)
    count = len(towards)
    start = Start(
        np.repeat(towards, DIRECTIONS, axis=0),
        np.tile(HEADINGS, count),
        np.full(count * DIRECTIONS, arm.step),
    )
    noticed = view.strengths(arm, start).reshape(count, DIRECTIONS) > 1.0
    return np.asarray(noticed.mean(axis=1) >= 0.5)
