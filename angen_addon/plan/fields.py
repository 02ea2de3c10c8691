# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a sensor stands and what it sees: by its own rays, as its model casts them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from mathutils.geometry import convex_hull_2d

from ...sensor_logic.model import Array
from ...sensor_logic.pyroelectric.detector import zones_of
from ...sensor_logic.pyroelectric.zones import Zone
from ...sensor_logic.report.facts import Placed
from ..instances import Uid
from ..overlay.views import four_views
from ..sensors import Sensor
from ..sight import Rays, Sight, sight_of
from ..station import Station, clock_of
from .home import Home

BUNDLE = 0
RAYS_A_ZONE = 5


def placed(home: Home, sensor: Sensor) -> tuple[Uid, Placed] | None:
    """The sensor with its session uid, its `height` in the world; None while it is switched off.
    Raises SensorError."""
    sight = _sight(home, sensor)
    if sight is None:
        return None
    fans: list[Array] = []
    beams: list[Array] = []
    rays = sight.rays
    if sight.request is not None and sight.request.method == "FOUR_WALL":
        # Each view as its axis, the first of its rays: the views are narrow.
        views = four_views(sight.request)
        axes = slice(None, None, len(views.origins) // views.rows)
        rays = Rays(views.origins[axes], views.directions[axes], views.reach[axes])
        beams = [*_segments(home, sensor, rays)]
    elif len(rays.origins):
        segments = _segments(home, sensor, rays)
        if np.ptp(rays.directions, axis=0).max() < 1e-9:
            beams = [*segments]
        else:
            rows = rays.rows if len(segments) % rays.rows == 0 else 1
            fans = [*segments[:, 1].reshape(rows, -1, 2)]
    pose = sight.pose
    return sensor.uid, Placed(
        sensor.name,
        pose.origin[:2].copy(),
        -pose.axes[:2, 2],
        float(pose.origin[2]),
        tuple(fans),
        tuple(beams),
        _outline(home, sensor) if sensor.kind.motion else None,
    )


def _sight(home: Home, sensor: Sensor) -> Sight | None:
    """What the sensor looks with; of a pyroelectric detector each zone as a level fan as wide as
    the zone, as far as the detection distance of its datasheet."""
    station = Station(sensor, clock_of(home.depsgraph.scene))
    nothing_is_asked: Any = None
    taken = station.take(0, 0, home.depsgraph, nothing_is_asked)
    if taken is None:
        return None
    parameters, pose = taken.parameters, taken.update.pose
    if getattr(parameters, "model", "") != "PYROELECTRIC":
        return sight_of(station, home.depsgraph)
    zones = zones_of(parameters)
    ways = np.array([_across(zone) for zone in zones]).reshape(-1, 3)
    directions = ways @ pose.axes.T
    origins = np.broadcast_to(pose.origin / home.metres, directions.shape)
    reach = np.full(len(directions), parameters.range_max / home.metres)
    return Sight(parameters, pose, Rays(origins, directions, reach, len(zones)))


def _across(zone: Zone) -> list[tuple[float, float, float]]:
    """Unit vectors from side to side of a zone at its middle height, in the sensor's frame."""
    level, rise = math.cos(zone.elevation), math.sin(zone.elevation)
    sides = np.linspace(-zone.width / 2, zone.width / 2, RAYS_A_ZONE) + zone.azimuth
    return [(-math.sin(a) * level, rise, -math.cos(a) * level) for a in sides.tolist()]


def _segments(home: Home, sensor: Sensor, rays: Rays) -> Array:
    """(n, 2, 2) in m: start and end of each ray as seen from above."""
    ranges = home.caster.cast(sensor.uid, BUNDLE, rays.origins, rays.directions, rays.reach)
    ends = rays.origins + rays.directions * ranges[:, None]
    return np.stack([rays.origins[:, :2], ends[:, :2]], axis=1) * home.metres


def _outline(home: Home, sensor: Sensor) -> Any:
    """(n, 2) in m: the hull, seen from above, of a pad and what belongs to it; None of an empty."""
    own = home.caster.solids.owned_by(sensor.uid)
    points = [surface.points[:, :2] for surface in home.surfaces(own)]
    if not points:
        return None
    flat = np.concatenate(points)
    flat = flat[np.isfinite(flat).all(axis=1)]
    hull = convex_hull_2d([tuple(p) for p in flat.tolist()]) if len(flat) else []
    return flat[hull] if len(hull) > 2 else None
