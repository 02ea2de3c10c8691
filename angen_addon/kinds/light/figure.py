# SPDX-License-Identifier: GPL-3.0-or-later
"""What a light sensor looks at: four views, or all that is before its face."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....sensor_logic.model import Array, Pose
from ...scene.light.eevee import NEAREST_CLIP, WALLS, WIDEST
from ...view.overlay.figures import CORNERS, ROUND, Figure, circle, dashes, ends_of, pairs
from ...view.sight import Rays, Sight

# m: how far the lobe of an illuminance sensor is drawn.
LOBE = 0.25
RAYS_A_VIEW = 1 + len(CORNERS)


def rays(sight: Sight, metres: float) -> Rays:
    """The axis and the corners of each of its views; none of a face."""
    return four_views(sight.request) if sight.request.method == "FOUR_WALL" else sight.rays


def plan_rays(sight: Sight, metres: float) -> Rays:
    """Each view as its axis, the first of its rays: the views are narrow."""
    seen = rays(sight, metres)
    axes = slice(None, None, RAYS_A_VIEW)
    return Rays(seen.origins[axes], seen.directions[axes], seen.reach[axes], apart=True)


def four_views(request: Any) -> Rays:
    """The rays of what a light sensor asks (a LightRequest): a row a view along −Z, −X, +Z, +X.

    They start on the plane at clip_start and reach that at clip_end.
    """
    t = math.tan(min(request.field_of_view, WIDEST) / 2)
    ways = np.array([(0.0, 0.0, -1.0), *((a * t, b * t, -1.0) for a, b in CORNERS)])
    turned = np.concatenate([ways @ _turn(wall).T for wall in range(WALLS)])
    world = turned @ request.matrix[:3, :3].T
    size = np.linalg.norm(world, axis=1)
    start = max(request.clip_start, NEAREST_CLIP)
    origins = request.matrix[:3, 3] + world * start
    return Rays(origins, world / size[:, None], (request.clip_end - start) * size, WALLS)


def _turn(wall: int) -> Array:
    """The rotation (3, 3) of a view: quarter turns about Y."""
    c, s = round(math.cos(wall * math.pi / 2)), round(math.sin(wall * math.pi / 2))
    return np.array([(c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)])


def figure(seen: Any, metres: float) -> Figure:
    """Four views, each an axis and its picture where it ends; or, of a face, how much light counts
    from where: the cosine."""
    if not len(seen.rays.reach):
        return _lobe(seen.pose, metres)
    drawn = Figure()
    starts, ends, _ = ends_of(seen, metres)
    middle = seen.pose.origin / metres
    for start, end in zip(starts, ends, strict=True):
        drawn.add("dark", dashes(middle, start[0]))
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
        ways = np.outer(np.sin(angles), pose.axes[:, side]) - np.outer(
            np.cos(angles), pose.axes[:, 2]
        )
        curve = (pose.origin + ways * np.cos(angles)[:, None] * LOBE) / metres
        drawn.add("axis", pairs(curve[:-1], curve[1:]))
    ring = circle(pose.origin / metres, pose.axes[:, 0], pose.axes[:, 1], LOBE / 4 / metres)
    drawn.add("edge", pairs(ring, np.roll(ring, -1, axis=0)))
    return drawn
