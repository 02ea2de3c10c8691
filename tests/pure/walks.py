# SPDX-License-Identifier: GPL-3.0-or-later
"""What a detector would make of people that walk here or there: many walks at once, without a
scene: a second program, which coverage maps are held against."""

from __future__ import annotations

import math

import numpy as np
from angen_sensors.sensor_logic.coverage.detectors import (
    STEFAN_BOLTZMANN,
    Response,
    Walker,
    filtered,
    zone_rays,
)
from angen_sensors.sensor_logic.kinds.pir.lenses import Zones
from angen_sensors.sensor_logic.model import Array, Pose
from angen_sensors.sensor_logic.wording import ZERO_CELSIUS


def peak_signals(
    zones: Zones,
    response: Response,
    pose: Pose,
    starts: Array,
    ends: Array,
    walker: Walker,
    *,
    room_celsius: float = 20.0,
    free: Array | None = None,
    rays: int = 12,
    interval: float = 1.0 / 24.0,
) -> Array:
    """The largest signals (m,), in W per m² of lenslet, either way, of walks from `starts` to
    `ends` (m, 3), points on the floor, world Z up. Above `threshold_of` they are movement.

    A walker stands long, walks straight and stands again. `free` (zones × rays,): how far each
    of `zone_rays(zones, rays)` gets in the empty room, in m.
    """
    local = zone_rays(zones, rays)
    directions = local.directions @ pose.axes.T
    reach = np.full(len(directions), np.inf) if free is None else free
    way = ends - starts
    seconds = np.linalg.norm(way, axis=1) / walker.speed
    steps = math.ceil(float(seconds.max(initial=0.0)) / interval - 1e-9) + 1
    # The signal's peak can come after the last step: the amplifier is slower than its input.
    after = math.ceil((response.thermal + 1.0 / response.high_cut) * 3.0 / interval)
    hot = STEFAN_BOLTZMANN * walker.emissivity / math.pi
    hot *= (walker.celsius + ZERO_CELSIUS) ** 4 - (room_celsius + ZERO_CELSIUS) ** 4
    power = np.empty((steps + after, len(starts)))
    for k in range(steps + after):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(seconds > 0.0, np.minimum(k * interval / seconds, 1.0), 0.0)
        feet = starts + way * share[:, None]
        power[k] = _hits(pose.origin, directions, reach, feet, walker) @ local.weights * hot
    signals: Array = np.abs(filtered(response, power, interval)).max(axis=0)
    return signals


def _hits(origin: Array, directions: Array, reach: Array, feet: Array, walker: Walker) -> Array:
    """Which rays (n,) meet walkers that stand at `feet` (m, 3), nearer than `reach`: 1 or 0,
    (m, n)."""
    across = directions[:, :2]
    towards = feet[:, :2] - origin[:2]
    level = np.maximum(np.einsum("nk,nk->n", across, across), 1e-18)
    nearest = towards @ across.T
    apart = np.einsum("mk,mk->m", towards, towards)[:, None] - walker.radius**2
    inside = nearest**2 - level * apart
    side = (nearest - np.sqrt(np.maximum(inside, 0.0))) / level
    at = origin[2] + side * directions[:, 2] - feet[:, 2:]
    met = (inside >= 0.0) & (side > 0.0) & (at >= 0.0) & (at <= walker.height) & (side < reach)
    # The top, for detectors that look down on it.
    with np.errstate(divide="ignore"):
        down = (feet[:, 2:] + walker.height - origin[2]) / directions[:, 2]
    off = level * down**2 - 2.0 * nearest * down + apart
    met |= (down > 0.0) & (off <= 0.0) & (down < reach)
    hits: Array = met.astype(np.float64)
    return hits
