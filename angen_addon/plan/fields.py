# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where a sensor stands and what it sees, with the rays that its own model casts."""

from __future__ import annotations

from typing import Any

import numpy as np
from mathutils.geometry import convex_hull_2d

from ...sensor_logic.model import Array
from ...sensor_logic.report.facts import SensorInPlan
from ..kinds import appearance_of
from ..runtime.sensor_runner import all_rays
from ..runtime.time_base import clock_of
from ..runtime.trace import SensorRays
from ..scene.home import EvaluatedHome
from ..scene.instances import Uid
from ..scene.sensors import Sensor

BUNDLE = 0


def placed(home: EvaluatedHome, sensor: Sensor) -> tuple[Uid, SensorInPlan] | None:
    """The sensor with its session uid, its `height` in the world; None while it is switched off.
    Raises AngenError."""
    sight = all_rays(sensor, clock_of(home.depsgraph.scene), home.depsgraph)
    if sight is None:
        return None
    appearance = appearance_of(sensor.kind)
    rays = appearance.plan_rays(sight, home.metres)
    fans: list[Array] = []
    beams: list[Array] = []
    if len(rays.origins):
        segments = _segments(home, sensor, rays)
        if rays.apart or np.ptp(rays.directions, axis=0).max() < 1e-9:
            beams = [*segments]
        else:
            rows = rays.rows if len(segments) % rays.rows == 0 else 1
            fans = [*segments[:, 1].reshape(rows, -1, 2)]
    pose = sight.pose
    return sensor.uid, SensorInPlan(
        sensor.name,
        pose.origin[:2].copy(),
        -pose.axes[:2, 2],
        float(pose.origin[2]),
        tuple(fans),
        tuple(beams),
        _outline(home, sensor) if appearance.outlined else None,
    )


def _segments(home: EvaluatedHome, sensor: Sensor, rays: SensorRays) -> Array:
    """(n, 2, 2) in m: start and end of each ray as seen from above."""
    ranges = home.caster.cast(sensor.uid, BUNDLE, rays.origins, rays.directions, rays.reach)
    ends = rays.origins + rays.directions * ranges[:, None]
    return np.stack([rays.origins[:, :2], ends[:, :2]], axis=1) * home.metres


def _outline(home: EvaluatedHome, sensor: Sensor) -> Any:
    """(n, 2) in m: the hull, seen from above, of a pad and what belongs to it; None of an empty."""
    own = home.caster.solids.owned_by(sensor.uid)
    points = [surface.points[:, :2] for surface in home.surfaces(own)]
    if not points:
        return None
    flat = np.concatenate(points)
    flat = flat[np.isfinite(flat).all(axis=1)]
    hull = convex_hull_2d([tuple(p) for p in flat.tolist()]) if len(flat) else []
    return flat[hull] if len(hull) > 2 else None
