# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the outline of a pad, and the force on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ....sensor_logic.model import Pose
from ...view.overlay.figures import OFF_SURFACE, Figure, circle, pairs, triangles

# Of the reading, what the arrow is drawn from.
FIELDS = ("force_n", "cop_x_m", "cop_y_m")
# m a newton, and the least and the longest arrow.
ARROW_PER_N, LEAST_ARROW, LONGEST_ARROW = 0.001, 0.06, 1.2


def figure(seen: Any, metres: float) -> Figure:
    """The outline of the pad; the force is the reading's: see `force_figure`."""
    drawn = Figure()
    if seen.outline is not None:
        corners = seen.outline
        drawn.add("pad", pairs(corners, np.roll(corners, -1, axis=0)))
        drawn.fill("pad", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return drawn


def force_figure(pose: Pose, metres: float, force: float, centre: tuple[float, float]) -> Figure:
    """An arrow that presses on a pad at its centre of pressure (m, along the pad's axes), as long
    as the force (N); and a dot there."""
    drawn = Figure()
    x, y, z = pose.axes.T
    place = (pose.origin + x * centre[0] + y * centre[1] + z * OFF_SURFACE) / metres
    length = min(max(force * ARROW_PER_N, LEAST_ARROW), LONGEST_ARROW) / metres
    width = min(length / 3, 0.04 / metres)
    tail, neck = place + z * length, place + z * width * 1.6
    drawn.add("force", (tail, neck))
    for side in (x, y):
        drawn.fill("force", (place, neck - side * width * 0.6, neck + side * width * 0.6))
    dot = circle(place, x, y, 0.02 / metres)
    drawn.fill("force", triangles(np.broadcast_to(place, dot.shape), dot, np.roll(dot, 1, 0)))
    ring = circle(place, x, y, 0.035 / metres)
    drawn.add("force", pairs(ring, np.roll(ring, -1, axis=0)))
    return drawn


def force_of_reading(pose: Pose, fields: Mapping[str, Any], metres: float) -> Figure | None:
    """The arrow of a reading, where its centre is known."""
    centre = fields["cop_x_m"], fields["cop_y_m"]
    if not all(math.isfinite(c) for c in centre):
        return None
    return force_figure(pose, metres, fields["force_n"], centre)
