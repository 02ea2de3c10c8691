# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines and surfaces in the world, in Blender units, of what a sensor sees: one function a kind.

What each part means is named here; how it looks is decided in picture.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array, Pose
from ...sensor_logic.pyroelectric.detector import zones_of

Lines = NDArray[np.float32]
# m: lines on a surface stand this far before it, so that it does not hide them.
OFF_SURFACE = 0.01
# Ranges of neighbouring rays that differ by more than this share of the nearer, or by this many
# times the angle between them where that is more, are not on one surface.
JUMP, STEEPEST = 0.15, 4.0
# m, of marks on beams, and how far the lobe of an illuminance sensor is drawn.
LARGEST_MARK, LEAST_MARK, LOBE = 0.04, 0.004, 0.25
# m a newton, and the least and the longest arrow.
ARROW_PER_N, LEAST_ARROW, LONGEST_ARROW = 0.001, 0.06, 1.2
# Points this near to the way between their neighbours are left out, as on a flat wall: as a share
# of that way; and as far as ranges are exact, m.
STRAIGHT, EXACT = 2e-4, 2e-5
DASHES = 9
DASHES_AT = np.linspace(0.0, 1.0, 2 * DASHES)[:, None]
ROUND = 24


@dataclass
class Figure:
    """`lines`: by their meaning, (n, 2, 3); `fills`: triangles by theirs, (n, 3, 3)."""

    lines: dict[str, Lines] = field(default_factory=dict)
    fills: dict[str, Lines] = field(default_factory=dict)

    def add(self, meaning: str, *parts: Any) -> None:
        """More lines, each part (…, 2, 3)."""
        _append(self.lines, meaning, [np.asarray(part).reshape(-1, 2, 3) for part in parts])

    def fill(self, meaning: str, *parts: Any) -> None:
        """More triangles, each part (…, 3, 3)."""
        _append(self.fills, meaning, [np.asarray(part).reshape(-1, 3, 3) for part in parts])


def _append(into: dict[str, Lines], meaning: str, parts: list[Any]) -> None:
    known = [into[meaning]] if meaning in into else []
    into[meaning] = np.concatenate(known + parts).astype(np.float32)


def figure_of(seen: Any, metres: float) -> Figure:
    """The figure of one sensor (field.Seen), `metres` a Blender unit."""
    kind = seen.sensor.kind.identifier
    make = MAKERS.get(kind, _beams)
    return make(seen, metres)


def _ends(seen: Any, metres: float) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Where the rays start and end, (rows, n, 3), and which of them met something, (rows, n)."""
    rays, rows = seen.rays, seen.rays.rows
    met = seen.ranges < rays.reach
    off = np.minimum(OFF_SURFACE / metres, seen.ranges / 2) * met
    ends = rays.origins + rays.directions * (seen.ranges - off)[:, None]
    return rays.origins.reshape(rows, -1, 3), ends.reshape(rows, -1, 3), met.reshape(rows, -1)


def _motion(seen: Any, metres: float) -> Figure:
    """Each tilt as a sheet from the sensor to where its rays end; what is between them is dead. Or
    the zones of its lens."""
    if seen.parameters.model == "PYROELECTRIC":
        return _zones(seen, metres)
    figure = Figure()
    starts, ends, met = _ends(seen, metres)
    ranges = seen.ranges.reshape(met.shape)
    figure.add("edge", _pairs(starts[:, 0], ends[:, 0]), _pairs(starts[:, -1], ends[:, -1]))
    if ends.shape[1] < 2:
        figure.add("ray", _pairs(starts, ends))
        return figure
    contour = _pairs(ends[:, :-1], ends[:, 1:])
    both = met[:, :-1] & met[:, 1:]
    jump = _jumps(seen, ranges)
    dashed = np.arange(contour.shape[1]) % 2 == 0
    first, last = _straight(ends, both & ~jump, metres)
    figure.add("outline", _pairs(ends[:, :-1][first], ends[:, 1:][last]))
    figure.add("limit", contour[~both & ~jump & dashed])
    figure.add("edge", contour[jump])
    first, last = _straight(ends, np.ones_like(both), metres)
    figure.fill("sheet", _triangles(starts[:, :-1][first], ends[:, :-1][first], ends[:, 1:][last]))
    return figure


def _zones(seen: Any, metres: float) -> Figure:
    """Where each zone of a lens ends: filled those of the one element, empty those of the other."""
    figure = Figure()
    starts, ends, _ = _ends(seen, metres)
    for zone, start, end in zip(zones_of(seen.parameters), starts, ends, strict=True):
        corners = end[1:]
        figure.add("ray", (start[0], end[0]))
        figure.add("picture", _pairs(corners, np.roll(corners, -1, axis=0)))
        if zone.polarity > 0:
            figure.fill("picture", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return figure


def _straight(
    points: Array, drawn: NDArray[np.bool_], metres: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Of the steps (rows, n − 1) between points (rows, n, 3) that are drawn, those that begin and
    those that end a straight line."""
    way, middle = points[:, 2:] - points[:, :-2], points[:, 1:-1] - points[:, :-2]
    length = np.maximum(np.linalg.norm(way, axis=2), 1e-12)
    off = np.linalg.norm(np.cross(middle, way), axis=2) / length
    on = drawn[:, :-1] & drawn[:, 1:] & (off < np.maximum(STRAIGHT * length, EXACT / metres))
    on &= (middle * way).sum(axis=2) > 0.0
    first, last = drawn.copy(), drawn.copy()
    first[:, 1:] &= ~on
    last[:, :-1] &= ~on
    return first, last


def _jumps(seen: Any, ranges: Array) -> NDArray[np.bool_]:
    """(rows, n − 1): whether neighbouring rays with these ranges (rows, n) end on different things;
    rays stand equally far apart."""
    apart = float(np.linalg.norm(seen.rays.directions[1] - seen.rays.directions[0]))
    near = np.minimum(ranges[:, :-1], ranges[:, 1:])
    found: NDArray[np.bool_] = np.abs(np.diff(ranges, axis=1)) > max(JUMP, STEEPEST * apart) * near
    return found


def sweep_figure(seen: Any, metres: float) -> Figure:
    """The tilt that a detector scans now, and its rays that saw something move."""
    sweep = seen.sweep
    if sweep.tilts not in seen.scans:
        seen.scans[sweep.tilts] = _scanned(seen, metres)
    scanned: Figure = seen.scans[sweep.tilts]
    lit = sweep.lit
    if lit is None or lit.shape != (seen.rays.rows, len(seen.ranges) // seen.rays.rows):
        return scanned
    starts, ends, _ = _ends(seen, metres)
    figure = Figure(dict(scanned.lines), dict(scanned.fills))
    figure.add("lit", _pairs(starts[lit], ends[lit]))
    both = lit[:, :-1] & lit[:, 1:]
    figure.fill("lit", _triangles(starts[:, :-1][both], ends[:, :-1][both], ends[:, 1:][both]))
    return figure


def _scanned(seen: Any, metres: float) -> Figure:
    """The tilt that is scanned now, where there are others."""
    figure = Figure()
    starts, ends, met = _ends(seen, metres)
    tilts = list(seen.sweep.tilts)
    if len(tilts) < len(ends) and ends.shape[1] > 1:
        ranges = seen.ranges.reshape(met.shape)
        starts_now, ends_now, jump = starts[tilts], ends[tilts], _jumps(seen, ranges)[tilts]
        first, last = _straight(ends_now, ~jump, metres)
        figure.add("now", _pairs(ends_now[:, :-1][first], ends_now[:, 1:][last]))
        first, last = _straight(ends_now, np.ones_like(jump), metres)
        figure.fill(
            "now",
            _triangles(starts_now[:, :-1][first], ends_now[:, :-1][first], ends_now[:, 1:][last]),
        )
    return figure


def _switch(seen: Any, metres: float) -> Figure:
    """The beam to where it breaks, a cross there and what is dark behind; a bar where it must reach
    for the switch to be open."""
    figure = _beams(seen, metres)
    _, ends, met = _ends(seen, metres)
    rays, parameters, pose = seen.rays, seen.parameters, seen.pose
    size = min(max(parameters.range_max / 10, LEAST_MARK), LARGEST_MARK) / metres
    across, up = pose.axes[:, 0] * size, pose.axes[:, 1] * size
    for place in ends[met]:
        figure.add("break", (place - across - up, place + across + up))
        figure.add("break", (place - across + up, place + across - up))
    far = rays.origins + rays.directions * rays.reach[:, None]
    for place, end in zip(ends[met], far[met.reshape(-1)], strict=True):
        figure.add("dark", _dashes(place, end))
    gate = (pose.origin - pose.axes[:, 2] * parameters.threshold) / metres
    figure.add("gate", (gate - across / 2, gate + across / 2), (gate - up / 2, gate + up / 2))
    return figure


def _beams(seen: Any, metres: float) -> Figure:
    figure = Figure()
    starts, ends, _ = _ends(seen, metres)
    figure.add("beam", _pairs(starts, ends))
    return figure


def _light(seen: Any, metres: float) -> Figure:
    """Four views, each an axis and its picture where it ends; or, of a face, how much light counts
    from where: the cosine."""
    if not len(seen.rays.reach):
        return _lobe(seen.pose, metres)
    figure = Figure()
    starts, ends, _ = _ends(seen, metres)
    middle = seen.pose.origin / metres
    for start, end in zip(starts, ends, strict=True):
        figure.add("dark", _dashes(middle, start[0]))
        figure.add("axis", (start[0], end[0]))
        corners, feet = end[1:], start[1:]
        figure.add("edge", _pairs(feet, corners))
        figure.add("picture", _pairs(corners, np.roll(corners, -1, axis=0)))
        figure.fill("picture", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return figure


def _lobe(pose: Pose, metres: float) -> Figure:
    figure = Figure()
    angles = np.linspace(-math.pi / 2, math.pi / 2, ROUND + 1)
    for side in (0, 1):
        ways = np.outer(np.sin(angles), pose.axes[:, side]) - np.outer(
            np.cos(angles), pose.axes[:, 2]
        )
        curve = (pose.origin + ways * np.cos(angles)[:, None] * LOBE) / metres
        figure.add("axis", _pairs(curve[:-1], curve[1:]))
    circle = _circle(pose.origin / metres, pose.axes[:, 0], pose.axes[:, 1], LOBE / 4 / metres)
    figure.add("edge", _pairs(circle, np.roll(circle, -1, axis=0)))
    return figure


def _pad(seen: Any, metres: float) -> Figure:
    """The outline of the pad; the force is the reading's: see `force_figure`."""
    figure = Figure()
    if seen.outline is not None:
        corners = seen.outline
        figure.add("pad", _pairs(corners, np.roll(corners, -1, axis=0)))
        figure.fill("pad", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return figure


def force_figure(pose: Pose, metres: float, force: float, centre: tuple[float, float]) -> Figure:
    """An arrow that presses on a pad at its centre of pressure (m, along the pad's axes), as long
    as the force (N); and a dot there."""
    figure = Figure()
    x, y, z = pose.axes.T
    place = (pose.origin + x * centre[0] + y * centre[1] + z * OFF_SURFACE) / metres
    length = min(max(force * ARROW_PER_N, LEAST_ARROW), LONGEST_ARROW) / metres
    width = min(length / 3, 0.04 / metres)
    tail, neck = place + z * length, place + z * width * 1.6
    figure.add("force", (tail, neck))
    for side in (x, y):
        figure.fill("force", (place, neck - side * width * 0.6, neck + side * width * 0.6))
    dot = _circle(place, x, y, 0.02 / metres)
    figure.fill("force", _triangles(np.broadcast_to(place, dot.shape), dot, np.roll(dot, 1, 0)))
    ring = _circle(place, x, y, 0.035 / metres)
    figure.add("force", _pairs(ring, np.roll(ring, -1, axis=0)))
    return figure


def surface_outline(evaluated: Any, place: Any) -> Array:
    """Corners (4, 3) in the world of the upper side of an object's bounds, at a place."""
    corners = np.array(evaluated.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    upper = [(lo[0], lo[1]), (hi[0], lo[1]), (hi[0], hi[1]), (lo[0], hi[1])]
    local = np.array([(a, b, hi[2], 1.0) for a, b in upper])
    matrix = np.array(place, np.float64)
    return (local @ matrix.T)[:, :3]


def _pairs(one: Any, two: Any) -> Array:
    return np.stack([one, two], axis=-2)


def _triangles(one: Any, two: Any, three: Any) -> Array:
    return np.stack([one, two, three], axis=-2)


def _dashes(one: Array, two: Array) -> Array:
    """(DASHES, 2, 3): the way from one point to another in dashes."""
    return (one + (two - one) * DASHES_AT).reshape(DASHES, 2, 3)


def _circle(middle: Array, x: Array, y: Array, radius: float) -> Array:
    angles = np.arange(ROUND) * 2 * math.pi / ROUND
    return middle + radius * (np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y))


MAKERS = {"PIR": _motion, "OPTICAL_SWITCH": _switch, "PRESSURE": _pad, "LIGHT": _light}
