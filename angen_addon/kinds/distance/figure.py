# SPDX-License-Identifier: GPL-3.0-or-later
"""What a distance sensor sees: where each of its zones ends."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....sensor_logic.kinds.distance.model import zone_rays
from ....sensor_logic.model import Array
from ...view.overlay.figures import Figure, ends_of, pairs
from ...view.sight import Rays, Sight

# Of a plane across the axis: rays from side to side that the plan shows.
ACROSS = 25


def rays(sight: Sight, metres: float) -> Rays:
    """The corners of each zone, a row a zone, from the upper left one round."""
    corners = replace(sight.parameters, rays=2)
    origins, ways, reach = zone_rays(corners, sight.pose)
    # Rays go through the middles of cells: out to the edges of their zone.
    zones = sight.parameters.zones_across * sight.parameters.zones_up
    order = (np.arange(zones)[:, None] * 4 + [0, 1, 3, 2]).ravel()
    outward = _outward(ways, sight)[order]
    return Rays(origins[order] / metres, outward, reach[order] / metres, zones)


def _outward(ways: Array, sight: Sight) -> Array:
    axes = sight.pose.axes
    local = ways @ axes
    flat = (local[:, :2] / -local[:, 2:]).reshape(-1, 4, 2)
    middle = flat.mean(axis=1, keepdims=True)
    local = np.column_stack(
        [(middle + (flat - middle) * 2.0).reshape(-1, 2), np.full(len(ways), -1.0)]
    )
    world: Array = local @ axes.T
    return world / np.linalg.norm(world, axis=1)[:, None]


def plan_rays(sight: Sight, metres: float) -> Rays:
    """A level fan as wide as all zones together."""
    wide = replace(sight.parameters, zones_across=1, zones_up=1, rays=ACROSS)
    origins, ways, reach = zone_rays(wide, sight.pose)
    level = slice(ACROSS * (ACROSS // 2), ACROSS * (ACROSS // 2 + 1))
    return Rays(origins[level] / metres, ways[level], reach[level] / metres)


def figure(seen: Any, metres: float) -> Figure:
    """A frame where each zone ends, filled where all its corners meet something; and the edges of
    all zones together."""
    drawn = Figure()
    starts, ends, met = ends_of(seen, metres)
    for corners, hits in zip(ends, met, strict=True):
        hit = bool(np.all(hits))
        edges = pairs(corners, np.roll(corners, -1, axis=0))
        drawn.add("outline" if hit else "limit", edges)
        if hit:
            drawn.fill("pad", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    across, up = seen.parameters.zones_across, seen.parameters.zones_up
    outer = ((0, 0), (across - 1, 1), (across * up - 1, 2), (across * (up - 1), 3))
    for zone, corner in outer:
        drawn.add("edge", (starts[zone, corner], ends[zone, corner]))
    return drawn
