# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws where each zone of a distance sensor ends."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....sensor_logic.kinds.distance.model import zone_rays
from ....sensor_logic.model import Array, Pose
from ...runtime.trace import RaysMet, SensorRays, Trace
from ...view.overlay.figures import Figure, corners_of, pairs

# Number of rays from side to side in the plan.
ACROSS = 25


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """A level fan as wide as all zones together."""
    wide = replace(sight.parameters, zones_across=1, zones_up=1, rays=ACROSS)
    origins, directions, reach = zone_rays(wide, sight.pose)
    level = slice(ACROSS * (ACROSS // 2), ACROSS * (ACROSS // 2 + 1))
    return SensorRays(origins[level] / metres, directions[level], reach[level] / metres)


def zones_figure(seen: Any, number: int, met: RaysMet, metres: float) -> Figure:
    """A frame where each zone ends, filled where all its rays meet something; and the edges of all
    zones together."""
    drawn = Figure()
    across, up = seen.parameters.zones_across, seen.parameters.zones_up
    corners = zone_corners(seen.parameters, seen.pose)
    ends = corners_of(met, seen.pose.origin, corners, metres)
    hits = np.all((met.ranges < met.reach).reshape(len(corners), -1), axis=1).tolist()
    for zone, hit in zip(ends, hits, strict=True):
        edges = pairs(zone, np.roll(zone, -1, axis=0))
        drawn.add("outline" if hit else "limit", edges)
        if hit:
            drawn.fill("pad", (zone[[0, 1, 2]], zone[[0, 2, 3]]))
    outer = ((0, 0), (across - 1, 1), (across * up - 1, 2), (across * (up - 1), 3))
    for one, corner in outer:
        drawn.add("edge", (seen.pose.origin / metres, ends[one, corner]))
    return drawn


def zone_corners(parameters: Any, pose: Pose) -> Array:
    """(zones, 4, 3): unit vectors along the edges of each zone, from the upper left one round."""
    across, up = parameters.zones_across, parameters.zones_up
    x = np.tan(parameters.horizontal_fov / 2) * np.linspace(-1.0, 1.0, across + 1)
    y = -np.tan(parameters.vertical_fov / 2) * np.linspace(-1.0, 1.0, up + 1)
    column, row = np.arange(across * up) % across, np.arange(across * up) // across
    corners = [(column + a, row + b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    directions = np.stack([np.stack([x[a], y[b], np.full(len(a), -1.0)], 1) for a, b in corners], 1)
    world = directions @ pose.axes.T
    found: Array = world / np.linalg.norm(world, axis=-1, keepdims=True)
    return found
