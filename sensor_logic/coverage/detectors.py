# SPDX-License-Identifier: GPL-3.0-or-later
"""The kind of sensor that coverage maps and proposed places are for.

This module imports from that kind what coverage needs. No other module of `coverage` imports from a
kind.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..kinds import KINDS
from ..kinds.pir.lenses import zone_rays
from ..kinds.pir.pyroelectric import (
    SAMPLE_EVERY,
    SIGHT,
    STEFAN_BOLTZMANN,
    Response,
    filtered,
    radiosity,
    response_of,
    threshold_of,
    zones_of,
)
from ..kinds.pir.range_scan import PirParameters, fan_directions

DETECTOR = KINDS["PIR"]


@dataclass(frozen=True)
class Walker:
    """A walking person as an upright cylinder; the default is an adult.

    `height` and `radius` are in m, `speed` in m/s. `celsius` is the mean temperature of the surface
    of skin and clothing.
    """

    height: float = 1.7
    radius: float = 0.2
    speed: float = 1.0
    celsius: float = 29.0
    emissivity: float = 0.95


__all__ = [
    "DETECTOR",
    "SAMPLE_EVERY",
    "SIGHT",
    "STEFAN_BOLTZMANN",
    "PirParameters",
    "Response",
    "Walker",
    "fan_directions",
    "filtered",
    "radiosity",
    "response_of",
    "threshold_of",
    "zone_rays",
    "zones_of",
]
