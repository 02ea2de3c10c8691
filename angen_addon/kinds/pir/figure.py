# SPDX-License-Identifier: GPL-3.0-or-later
"""What a motion detector sees: its tilts, or the zones of its lens."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kinds.pir.pyroelectric.detector import SIGHT, zones_of
from ....sensor_logic.model import Array, Pose
from ...view.overlay.figures import CORNERS, Figure, ends_of, pairs, straight, triangles
from ...view.sight import Rays, Sight

# Ranges of neighbouring rays that differ by more than this share of the nearer, or by this many
# times the angle between them where that is more, are not on one surface.
JUMP, STEEPEST = 0.15, 4.0
# So many tilts at most are drawn as surfaces.
SHEETS = 4


def rays(sight: Sight, metres: float) -> Rays:
    """Those that it casts; of a lens, the axis and the corners of each zone."""
    if sight.parameters.model == "PYROELECTRIC":
        return zones(sight.parameters, sight.pose, metres)
    return sight.rays


def scans(parameters: Any) -> bool:
    return bool(parameters.model == "RANGE_SCAN")


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


def figure(seen: Any, metres: float) -> Figure:
    """Each tilt as a sheet from the sensor to where its rays end; what is between them is dead. Or
    the zones of its lens."""
    if seen.parameters.model == "PYROELECTRIC":
        return _zones(seen, metres)
    drawn = Figure()
    starts, ends, met = ends_of(seen, metres)
    ranges = seen.ranges.reshape(met.shape)
    drawn.add("edge", pairs(starts[:, 0], ends[:, 0]), pairs(starts[:, -1], ends[:, -1]))
    if ends.shape[1] < 2:
        drawn.add("ray", pairs(starts, ends))
        return drawn
    contour = pairs(ends[:, :-1], ends[:, 1:])
    both = met[:, :-1] & met[:, 1:]
    jump = _jumps(seen, ranges)
    dashed = np.arange(contour.shape[1]) % 2 == 0
    first, last = straight(ends, both & ~jump, metres)
    drawn.add("outline", pairs(ends[:, :-1][first], ends[:, 1:][last]))
    drawn.add("limit", contour[~both & ~jump & dashed])
    drawn.add("edge", contour[jump])
    # Surfaces take the longest to draw: a few of the tilts tell where it sees.
    rows = np.unique(np.linspace(0, len(ends) - 1, SHEETS).round().astype(int))
    starts, ends = starts[rows], ends[rows]
    first, last = straight(ends, np.ones_like(both[rows]), metres)
    drawn.fill("sheet", triangles(starts[:, :-1][first], ends[:, :-1][first], ends[:, 1:][last]))
    return drawn


def _zones(seen: Any, metres: float) -> Figure:
    """Where each zone of a lens ends: filled those of the one element, empty those of the other."""
    drawn = Figure()
    starts, ends, _ = ends_of(seen, metres)
    for zone, start, end in zip(zones_of(seen.parameters), starts, ends, strict=True):
        corners = end[1:]
        drawn.add("ray", (start[0], end[0]))
        drawn.add("picture", pairs(corners, np.roll(corners, -1, axis=0)))
        if zone.polarity > 0:
            drawn.fill("picture", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return drawn


def _jumps(seen: Any, ranges: Array) -> NDArray[np.bool_]:
    """(rows, n − 1): whether neighbouring rays with these ranges (rows, n) end on different things;
    rays stand equally far apart."""
    apart = float(np.linalg.norm(seen.rays.directions[1] - seen.rays.directions[0]))
    near = np.minimum(ranges[:, :-1], ranges[:, 1:])
    found: NDArray[np.bool_] = np.abs(np.diff(ranges, axis=1)) > max(JUMP, STEEPEST * apart) * near
    return found


def scanned_figure(seen: Any, metres: float) -> Figure:
    """The tilt that is scanned now, where there are others."""
    drawn, tilts = Figure(), list(seen.sweep.tilts)
    starts, ends, _ = ends_of(seen, metres, tilts)
    if len(tilts) < seen.rays.rows and ends.shape[1] > 1:
        jump = _jumps(seen, seen.ranges.reshape(seen.rays.rows, -1)[tilts])
        first, last = straight(ends, ~jump, metres)
        drawn.add("now", pairs(ends[:, :-1][first], ends[:, 1:][last]))
        first, last = straight(ends, np.ones_like(jump), metres)
        drawn.fill("now", triangles(starts[:, :-1][first], ends[:, :-1][first], ends[:, 1:][last]))
    return drawn


def lit_figure(seen: Any, metres: float) -> Figure:
    """The rays that saw something move at the last update."""
    drawn, lit = Figure(), seen.sweep.lit
    starts, ends, _ = ends_of(seen, metres)
    drawn.add("lit", pairs(starts[lit], ends[lit]))
    both = lit[:, :-1] & lit[:, 1:]
    drawn.fill("lit", triangles(starts[:, :-1][both], ends[:, :-1][both], ends[:, 1:][both]))
    return drawn
