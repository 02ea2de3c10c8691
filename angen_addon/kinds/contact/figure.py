# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the distances of a door contact's magnet, as rings about it in two planes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...view.overlay.figures import Figure, circle, pairs


def figure(seen: Any, metres: float) -> Figure:
    """Whole rings where the magnet closes the contact, dashed ones where it opens it."""
    drawn = Figure()
    x, y, z = seen.pose.axes.T
    for radius, meaning in (
        (seen.parameters.close_distance, "gate"),
        (seen.parameters.open_distance, "limit"),
    ):
        for side in (y, z):
            ring = circle(seen.pose.origin / metres, x, side, radius / metres)
            lines = pairs(ring, np.roll(ring, -1, axis=0))
            drawn.add(meaning, lines if meaning == "gate" else lines[::2])
    return drawn
