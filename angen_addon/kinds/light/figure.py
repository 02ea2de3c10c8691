# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws what a light sensor looks at: four views, or the lobe before its face."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....sensor_logic.model import Pose
from ...runtime.answers import light_request
from ...runtime.trace import RaysMet, SensorRays, Trace
from ...scene.light.four_walls import view_rays
from ...view.overlay.figures import ROUND, Figure, circle, dashes, ends_of, pairs

# m: how far the lobe of an illuminance sensor is drawn.
LOBE = 0.25


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """Each view as its axis: the views are narrow."""
    if sight.parameters.method != "FOUR_WALL":
        return sight.rays(metres)
    request = light_request(sight.sensor, sight.parameters, sight.pose, metres, False)
    origins, directions, reach = (part[:, 0] for part in view_rays(request))
    return SensorRays(origins, directions, reach, apart=True)


def figure(seen: Any, metres: float) -> Figure:
    """Draws for a face how much light counts from each direction, its cosine; for views see
    `view_figure`."""
    if seen.parameters.method == "FOUR_WALL":
        return Figure()
    return _lobe(seen.pose, metres)


def view_figure(seen: Any, number: int, met: RaysMet, metres: float) -> Figure:
    """The axis of a view and its picture where it ends."""
    drawn = Figure()
    (start,), (end,), _ = ends_of(met, metres)
    drawn.add("dark", dashes(seen.pose.origin / metres, start[0]))
    drawn.add("axis", (start[0], end[0]))
    corners, feet = end[1:], start[1:]
    drawn.add("edge", pairs(feet, corners))
    drawn.add("picture", pairs(corners, np.roll(corners, -1, axis=0)))
    drawn.fill("picture", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return drawn


def _lobe(pose: Pose, metres: float) -> Figure:
    drawn = Figure()
    angles = np.linspace(-math.pi / 2, math.pi / 2, ROUND + 1)
    for side in (0, 1):
        directions = np.outer(np.sin(angles), pose.axes[:, side]) - np.outer(
            np.cos(angles), pose.axes[:, 2]
        )
        curve = (pose.origin + directions * np.cos(angles)[:, None] * LOBE) / metres
        drawn.add("axis", pairs(curve[:-1], curve[1:]))
    ring = circle(pose.origin / metres, pose.axes[:, 0], pose.axes[:, 1], LOBE / 4 / metres)
    drawn.add("edge", pairs(ring, np.roll(ring, -1, axis=0)))
    return drawn
