# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of presence radars in the viewport and the floor plan, housings and panel rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from bpy.types import Context

from ....sensor_logic.kinds.presence_radar.gate_evidence import gate_energies
from ....sensor_logic.kinds.presence_radar.parameters import RadarParameters
from ....sensor_logic.kinds.presence_radar.radar import (
    calibration,
    edge_of,
    radar_beams,
)
from ....sensor_logic.logs.error import AngenError
from ....sensor_logic.logs.wording import Lengths, typed
from ....sensor_logic.model import Array, Index, Pose
from ...appearance.figures import Figure, around_edge, circle, ends_of, pairs, straight
from ...appearance.housing import Housing, looking
from ...appearance.reading_text import ACTIVE, IDLE, ReadingText
from ...runtime.trace import CastRays, SensorRays, Trace
from ...scene.lengths import lengths_of
from ...scene.sensors import Sensor, read_parameters

# The most gates that are drawn as arcs and as bars; more would be a solid surface.
ARCS, BARS = 40, 20
# Points of an arc for each gate.
POINTS = 49
# m. The size of the mark of a target, and the length of the arrow for 1 m/s.
MARK, ARROW = 0.12, 0.5
# rad. Half of the arc that shows the distance of a module without targets.
HALF_ARC = math.radians(12)
DRAWN = ("presence", "distance_m", "x_m", "y_m", "speed_mps")


def rays_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Draw the level and the upright outline of what the radar reaches, and its gates as arcs.

    Gates are drawn in the level plane up to what stops the waves. `seen` is the `DrawnSensor`, and
    `number` the number of the ray bundle. `cast` has the rays with their ranges. `metres` is the
    length of a Blender unit in m.
    """
    parameters: RadarParameters = seen.parameters
    drawn = Figure()
    across, up = parameters.rays_across, parameters.rays_up
    if len(cast.reach) != across * up:
        return drawn
    level = np.arange(across) + across * (up // 2)
    for rays in (level, upright_rays(parameters)):
        part = CastRays(
            cast.origins[rays], cast.directions[rays], cast.reach[rays], cast.ranges[rays]
        )
        starts, ends, hit = ends_of(part, metres)
        drawn.add("edge", pairs(starts[:, 0], ends[:, 0]), pairs(starts[:, -1], ends[:, -1]))
        both = hit[:, :-1] & hit[:, 1:]
        for meaning, which in (("outline", both), ("limit", ~both)):
            first, last = straight(ends, which, metres)
            drawn.add(meaning, pairs(ends[:, :-1][first], ends[:, 1:][last]))
    drawn.add(
        "gate", *_arcs(parameters, seen.pose, cast.directions[level], cast.ranges[level], metres)
    )
    return drawn


# Each change of the rays takes 0.5 ms longer without the cache.
@lru_cache(maxsize=16)
def upright_rays(parameters: RadarParameters) -> Index:
    """Return the numbers (rays_up,) of the rays nearest to the upright plane, from below."""
    beams = radar_beams(parameters, Pose(np.zeros(3), np.eye(3)))
    azimuth = np.abs(beams.azimuth.reshape(parameters.rays_up, parameters.rays_across))
    found: Index = np.arange(parameters.rays_up) * parameters.rays_across + azimuth.argmin(axis=1)
    return found


def _arcs(
    parameters: RadarParameters, pose: Pose, directions: Array, ranges: Array, metres: float
) -> list[Array]:
    """Return the middle of each gate as lines in the level plane, up to what stops the waves.

    `directions` (n, 3) and `ranges` (n,) in m are those of a level row of rays, from left to right.
    """
    edge = edge_of(parameters.horizontal_fov)
    azimuth = np.linspace(-edge, edge, POINTS)
    # A point is in sight if the rays on both sides of it get farther.
    rays = np.arctan2(*(directions @ pose.axes[:, [0, 2]] * (1.0, -1.0)).T)
    after = np.clip(np.searchsorted(rays, azimuth), 1, len(rays) - 1) if len(rays) > 1 else 0
    free = np.minimum(ranges[after], ranges[np.maximum(after - 1, 0)])
    local = np.stack([np.sin(azimuth), np.zeros(POINTS), -np.cos(azimuth)], axis=1)
    ways, origin = local @ pose.axes.T, pose.origin
    arcs = []
    every = max(1, math.ceil(parameters.gates / ARCS))
    for gate in range(every, parameters.gates, every):
        radius = min(gate * parameters.bin_length, parameters.reach)
        points = (origin + ways * radius) / metres
        clear = (free[:-1] >= radius - 1e-9) & (free[1:] >= radius - 1e-9)
        arcs.append(pairs(points[:-1][clear], points[1:][clear]))
    return arcs


def targets_figure(seen: Any, fields: Mapping[str, Any], metres: float) -> Figure | None:
    """Draw a ring at each target, with an arrow as long as its speed; None without presence.

    Targets are drawn at the height of the radar, which does not measure heights. Without a target,
    as of a module that reports none, draw an arc at the distance. `seen` is the `DrawnSensor`,
    `fields` has the published fields, and `metres` is the length of a Blender unit in m.
    """
    if not fields["presence"]:
        return None
    drawn, pose = Figure(), seen.pose
    right, up, back = pose.axes.T
    if not fields["x_m"]:
        angles = np.linspace(-HALF_ARC, HALF_ARC, POINTS // 4)
        ways = np.outer(np.sin(angles), right) - np.outer(np.cos(angles), back)
        points = (pose.origin + ways * fields["distance_m"]) / metres
        drawn.add("force", pairs(points[:-1], points[1:]))
        return drawn
    texts = (str(fields[name]).split(";") for name in ("x_m", "y_m", "speed_mps"))
    for x, y, speed in zip(*texts, strict=True):
        place = pose.origin + right * float(x) - back * float(y)
        ring = circle(place / metres, right, -back, MARK / metres)
        drawn.add("force", pairs(ring, np.roll(ring, -1, axis=0)))
        drawn.add("force", (place / metres, (place + up * MARK) / metres))
        way = place - pose.origin
        away = way / max(float(np.linalg.norm(way)), 1e-9)
        if abs(float(speed)) * ARROW > MARK / 4:
            _add_arrow(drawn, place, away * float(speed) * ARROW, metres)
    return drawn


def _add_arrow(drawn: Figure, place: Array, way: Array, metres: float) -> None:
    """Add an arrow from `place` along `way`, in m, with a tip across the way that faces up."""
    length = float(np.linalg.norm(way))
    along = way / length
    side = np.cross(along, (0.0, 0.0, 1.0))
    if np.linalg.norm(side) < 1e-6:
        side = np.cross(along, (1.0, 0.0, 0.0))
    side = side / np.linalg.norm(side)
    tip = place + way
    neck, half = tip - along * min(length / 2, MARK), min(length / 4, MARK / 2)
    drawn.add("force", (place / metres, neck / metres))
    drawn.fill("force", np.stack([tip, neck + side * half, neck - side * half]) / metres)


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """Return a level fan of rays for the floor plan, or one around the field of view.

    The latter is for a radar that looks steeply up or down. `sight` is the trace with the sensor's
    parameters and pose. `metres` is the length of a Blender unit in m.
    """
    edge = around_edge(sight.pose)
    if edge is None:
        beams = radar_beams(replace(sight.parameters, rays_across=25, rays_up=1), sight.pose)
        return SensorRays(beams.origins / metres, beams.directions, beams.length / metres)
    azimuth = edge[0] * sight.parameters.horizontal_fov / 2
    elevation = edge[1] * sight.parameters.vertical_fov / 2
    across, ahead = np.sin(azimuth), np.cos(azimuth)
    level = np.cos(elevation)
    local = np.stack([across * level, np.sin(elevation), -ahead * level], axis=1)
    origins = np.broadcast_to(sight.pose.origin / metres, local.shape)
    reach = np.full(len(local), sight.parameters.range_max / metres)
    return SensorRays(origins, local @ sight.pose.axes.T, reach)


# The sections of parameters in the panel.
SECTIONS = (
    (
        "Detection",
        (
            "moving_thresholds",
            "still_thresholds",
            "movement_starts",
            "hold_time",
            "max_targets",
            "report_step",
        ),
    ),
    (
        "Energies",
        (
            "moving_range",
            "moving_energy",
            "still_range",
            "still_energy",
            "scale",
            "still_time",
            "moving_floors",
            "still_floors",
        ),
    ),
    (
        "Waves",
        (
            "frequency",
            "horizontal_fov",
            "vertical_fov",
            "range_min",
            "range_max",
            "gate_length",
            "range_scale",
            "angle_resolution",
            "integration_time",
            "tail_share",
            "tail_length",
            "rays_across",
            "rays_up",
        ),
    ),
    ("Noise", ("fading", "floor_noise", "energy_noise", "range_noise", "angle_noise")),
)


def gate_span(parameters: RadarParameters, gate: int, lengths: Lengths) -> str:
    """Return where the half of a gate around its middle is, such as "1.125–1.875 m".

    `gate` is its number from 0.
    """
    first, last = (round(max(gate + end, 0.0) * parameters.gate_length, 3) for end in (-0.5, 0.5))
    return f"{typed(first / lengths.metres, '')}–{lengths.typed(last)}"


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw a bar for each gate in the panel: the larger of its two energies.

    A sign before it says whether the gate detects anything, by the rounded energies of the log.
    `seen` has the texts of the sensor's reading.
    """
    text = (seen.fields or {}).get("gates")
    if not text or seen.problem:
        return
    lengths = lengths_of(context.scene)
    try:
        parameters: RadarParameters = read_parameters(sensor, sensor.settings, lengths)
    except AngenError:
        # The panel shows the problem.
        return
    found = gate_energies(text)
    needed = calibration(parameters).thresholds
    column = layout.column(align=True)
    column.label(text="Energy of each gate, 0 to 100")
    for number, energies in enumerate(found[:BARS]):
        detects = number < parameters.gates and any(np.array(energies) > needed[:, number])
        moving, still = energies
        words = f"{gate_span(parameters, number, lengths)}: moving {moving:.0f}, still {still:.0f}"
        row = column.row(align=True)
        row.label(text="", icon=ACTIVE if detects else IDLE)
        row.progress(text=words, factor=max(energies) / 100.0)
    if len(found) > BARS:
        column.label(text=f"and {len(found) - BARS} more gates")


# Housings. The sizes of the LD2410 and LD2450 are from their manuals; thicknesses are usual ones.


def _board(across: float, up: float) -> Housing:
    """Return a board of size `across` by `up` (m) behind its antenna, with a chip on its back."""
    x, y = across / 2, up / 2
    board = Housing().box((-x, -y, 0.0), (x, y, 0.0012))
    side = min(x, y) * 0.6
    return looking(board.box((-side, -side, 0.0012), (side, side, 0.0022)))


HOUSINGS = {
    "": lambda: _board(0.035, 0.007),
    "LD2410C_FINE": lambda: _board(0.022, 0.016),
    "LD2450": lambda: _board(0.044, 0.015),
    "MR60BHA1": lambda: _board(0.035, 0.03),
}
