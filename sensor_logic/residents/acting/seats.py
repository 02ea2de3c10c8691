# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where the hips of a sitting person go."""

from __future__ import annotations

import math

import numpy as np

from ...model import Array
from ..places import LIE, Place


def seat_of(place: Place) -> tuple[Array, float]:
    """What carries the hips (3,), and the yaw of who sits there; at a bed, on its edge."""
    if place.use != LIE:
        return place.target, place.yaw
    up = np.array([math.cos(place.yaw), math.sin(place.yaw)])
    off = (place.at - place.target)[:2]
    across = off - (off @ up) * up
    if math.hypot(*across) < 0.2:
        across = off
    ahead = across / max(math.hypot(*across), 1e-9)
    yaw = math.atan2(ahead[1], ahead[0])
    if place.edge is not None:
        return place.edge, yaw
    seat = np.array(place.target)
    seat[:2] += ahead * min(0.45, max(math.hypot(*across) - 0.5, 0.0))
    return seat, yaw
