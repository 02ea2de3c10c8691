# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen as pictures, as rays along the axis and the corners of each: the four views of a
light sensor, the zones of a lens."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...sensor_logic.model import Array, Pose
from ...sensor_logic.pyroelectric.detector import SIGHT, zones_of
from ..scene_probe.light.eevee import NEAREST_CLIP, WALLS, WIDEST
from ..sight import Rays

# In turn, after the axis.
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
RAYS_A_VIEW = 1 + len(CORNERS)


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


def zones(parameters: Any, pose: Pose, metres: float) -> Rays:
    """The rays of a pyroelectric detector's zones, a row a zone: those that it casts lie within."""
    seen = zones_of(parameters)
    ways = []
    for zone in seen:
        up = np.cross(zone.right, zone.axis)
        x, y = zone.right * math.tan(zone.width / 2), up * math.tan(zone.height / 2)
        ways += [zone.axis, *(zone.axis + a * x + b * y for a, b in CORNERS)]
    world = np.array(ways) @ pose.axes.T
    world /= np.linalg.norm(world, axis=1)[:, None]
    origins = (pose.origin + world * parameters.range_min) / metres
    return Rays(origins, world, np.full(len(world), SIGHT / metres), len(seen))


def _turn(wall: int) -> Array:
    """The rotation (3, 3) of a view: quarter turns about Y."""
    c, s = round(math.cos(wall * math.pi / 2)), round(math.sin(wall * math.pi / 2))
    return np.array([(c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)])
