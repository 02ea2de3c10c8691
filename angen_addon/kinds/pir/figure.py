# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of motion detectors in the viewport and the floor plan, housings and panel rows."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from bpy.types import Context
from numpy.typing import NDArray

from ....sensor_logic.kinds.pir.lenses import Zone, Zones
from ....sensor_logic.kinds.pir.pyroelectric import zones_of
from ....sensor_logic.model import Array
from ...advice import sensing as advice
from ...advice import warmth
from ...appearance.figures import CORNERS, Figure, corners_of, ends_of, pairs, straight, triangles
from ...appearance.housing import Housing, looking
from ...appearance.panel_parts import draw_lines
from ...appearance.reading_text import ReadingText
from ...runtime.trace import CastRays, SensorRays, Trace
from ...scene.sensors import Sensor

# Neighbouring rays count as hitting different surfaces if their ranges differ by more than JUMP
# times the nearer range. If STEEPEST times the angle between the rays is more, it replaces JUMP.
JUMP, STEEPEST = 0.15, 4.0
# At most this many tilts are drawn as surfaces, since surfaces are slow to draw.
SHEETS = 4


def rays_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Draw the tilts of a range scan, or the zones of a lens.

    Each tilt of a scan is drawn as a surface from the sensor to the hits of its rays. `seen` is the
    `DrawnSensor`, and `number` the number of the ray bundle. `cast` has the rays with their ranges.
    `metres` is the length of a Blender unit in m.
    """
    parameters = seen.parameters
    if parameters.model == "PYROELECTRIC":
        return _zones(seen, cast, metres)
    drawn, rows = Figure(), len(cast.reach) // parameters.rays
    starts, ends, hit = ends_of(cast, metres, rows)
    drawn.add("edge", pairs(starts[:, 0], ends[:, 0]), pairs(starts[:, -1], ends[:, -1]))
    if ends.shape[1] < 2:
        drawn.add("ray", pairs(starts, ends))
        return drawn
    contour = pairs(ends[:, :-1], ends[:, 1:])
    both = hit[:, :-1] & hit[:, 1:]
    jump = _jumps(cast, rows)
    dashed = np.arange(contour.shape[1]) % 2 == 0
    first, last = straight(ends, both & ~jump, metres)
    drawn.add("outline", pairs(ends[:, :-1][first], ends[:, 1:][last]))
    drawn.add("limit", contour[~both & ~jump & dashed])
    drawn.add("edge", contour[jump])
    tilts = np.linspace(0, parameters.tilt_count - 1, SHEETS).round().astype(int)
    sheets = np.flatnonzero(np.isin(number + np.arange(rows), tilts))
    starts, ends = starts[sheets], ends[sheets]
    first, last = straight(ends, np.ones_like(both[sheets]), metres)
    drawn.fill("sheet", triangles(starts[:, :-1][first], ends[:, :-1][first], ends[:, 1:][last]))
    return drawn


def _zones(seen: Any, cast: CastRays, metres: float) -> Figure:
    """Draw the far end of each zone of a lens, filled if the zone belongs to the positive element.

    A zone ends at its hit, or at the detection distance if this is nearer.
    """
    drawn, zones = Figure(), zones_of(seen.parameters)
    directions = zone_edges(zones) @ seen.pose.axes.T
    farthest = seen.parameters.range_max
    ends = corners_of(cast, seen.pose.origin, directions, metres, farthest)
    start = seen.pose.origin / metres
    drawn.add("ray", pairs(np.broadcast_to(start, ends[:, 0].shape), ends[:, 0]))
    corners = ends[:, 1:]
    drawn.add("picture", pairs(corners, np.roll(corners, -1, axis=1)))
    plus = corners[[zone.polarity > 0 for zone in zones]]
    drawn.fill("picture", plus[:, [0, 1, 2]], plus[:, [0, 2, 3]])
    return drawn


# Each change of the rays of a lens with 60 zones takes 2 ms longer without the cache.
@lru_cache(maxsize=16)
def zone_edges(zones: Zones) -> Array:
    """Return unit vectors along the axis and the four edges of each zone, shape (zones, 5, 3).

    The vectors are in the sensor's axes. The rays of a zone lie between its edges.
    """
    directions = np.empty((len(zones), 5, 3))
    for row, zone in zip(directions, zones, strict=True):
        up = np.cross(zone.right, zone.axis)
        x, y = zone.right * math.tan(zone.width / 2), up * math.tan(zone.height / 2)
        row[:] = [zone.axis, *(zone.axis + a * x + b * y for a, b in CORNERS)]
    found: Array = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    return found


def _jumps(cast: CastRays, rows: int) -> NDArray[np.bool_]:
    """Return whether neighbouring rays in a row end on different surfaces, shape (rows, n − 1).

    The angle between neighbours must be the same everywhere.
    """
    ranges = cast.ranges.reshape(rows, -1)
    apart = float(np.linalg.norm(cast.directions[1] - cast.directions[0]))
    near = np.minimum(ranges[:, :-1], ranges[:, 1:])
    found: NDArray[np.bool_] = np.abs(np.diff(ranges, axis=1)) > max(JUMP, STEEPEST * apart) * near
    return found


def scan_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure | None:
    """Draw the tilt that was scanned last; return None if the detector has only one tilt.

    `seen` is the `DrawnSensor`, and `number` the number of the ray bundle. `cast` has the rays with
    their ranges. `metres` is the length of a Blender unit in m.
    """
    parameters = seen.parameters
    one_of_many = len(cast.reach) == parameters.rays > 1 and parameters.tilt_count > 1
    if parameters.model == "PYROELECTRIC" or not one_of_many:
        return None
    drawn = Figure()
    starts, ends, _ = ends_of(cast, metres)
    jump = _jumps(cast, 1)
    first, last = straight(ends, ~jump, metres)
    drawn.add("now", pairs(ends[:, :-1][first], ends[:, 1:][last]))
    first, last = straight(ends, np.ones_like(jump), metres)
    drawn.fill("now", triangles(starts[:, :-1][first], ends[:, :-1][first], ends[:, 1:][last]))
    return drawn


def lit_figure(
    seen: Any, number: int, cast: CastRays, before: Array, metres: float
) -> Figure | None:
    """Draw the rays whose range changed by more than the threshold since the scan before.

    Return None if there was no movement. Noise does not count.

    Parameters
    ----------
    seen
        The `DrawnSensor`.
    number
        The number of the ray bundle: rays that the sensor casts together.
    cast
        The rays with their ranges.
    before
        The ranges (n,) of the scan before, in m.
    metres
        Length of a Blender unit in m.
    """
    parameters = seen.parameters
    if parameters.model == "PYROELECTRIC" or before.shape != cast.ranges.shape:
        return None
    lit = np.abs(cast.ranges - before) > parameters.threshold
    if not lit.any():
        return None
    drawn, rows = Figure(), len(lit) // parameters.rays
    starts, ends, _ = ends_of(cast, metres, rows)
    lit = lit.reshape(rows, -1)
    drawn.add("lit", pairs(starts[lit], ends[lit]))
    both = lit[:, :-1] & lit[:, 1:]
    drawn.fill("lit", triangles(starts[:, :-1][both], ends[:, :-1][both], ends[:, 1:][both]))
    return drawn


def _hc_sr501() -> Housing:
    """Return a board of 32 × 24 × 25 mm with a lens of 23 mm.

    The sizes are from innovatorsguru.com and purplebearsshopnearn.com. The depth of the lens is an
    assumption.
    """
    lens = [(0.0115 * math.sin(a), 0.0115 * (1 - math.cos(a)))
            for a in (math.pi / 2 * i / 4 for i in range(5))]  # fmt: skip
    housing = Housing().lathe([*lens, (0.0115, 0.0165)])
    return looking(housing.box((-0.016, -0.012, 0.0165), (0.016, 0.012, 0.025)))


def _pmod_pir() -> Housing:
    """Return a board of 1.2 × 0.8 inches, 0.55 inches high.

    The sizes are from the reference manual of Digilent's Pmod PIR.
    """
    housing = Housing().lathe([(0.0, 0.0), (0.0035, 0.001), (0.0047, 0.004), (0.0047, 0.0124)])
    return looking(housing.box((-0.01524, -0.01016, 0.0124), (0.01524, 0.01016, 0.01397)))


def _wall_detector() -> Housing:
    """Return a wall detector: a flat body of 68 × 110 mm with a bulging lens, 40 mm deep in all."""
    lens = [(0.026 * math.sin(a), 0.014 * (1 - math.cos(a)))
            for a in (math.pi / 2 * i / 4 for i in range(5))]  # fmt: skip
    return looking(Housing().lathe(lens).box((-0.034, -0.055, 0.014), (0.034, 0.055, 0.04)))


HOUSINGS = {
    "": _hc_sr501,
    "EKMC1601111": _pmod_pir,
    "EKMC1601111_SCAN": _pmod_pir,
    "HAA53_SCAN": _wall_detector,
    "EKMC1604111": _wall_detector,
    "EKMC1604111_SCAN": _wall_detector,
    "PET_IMMUNE": _wall_detector,
    "CURTAIN": _wall_detector,
    "SPACETI_WALL": _wall_detector,
}


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw in the panel why the detector may report nothing, with buttons that help.

    `seen` has the texts of the sensor's reading.
    """
    late = advice.warm_up(sensor, context.scene)
    if late:
        box = draw_lines(layout, late.text, "INFO")
        if not sensor.holders:
            button = box.operator("wm.context_set_float", text="Set to 0 s", icon="CHECKMARK")
            button.data_path, button.value = "object.angen_sensor.pir.warm_up_time", 0.0
    _draw_warmth(layout, context, sensor)


def _draw_warmth(layout: Any, context: Context, sensor: Sensor) -> None:
    """Draw warnings of what a pyroelectric detector cannot sense in this scene."""
    if not warmth.sensing_warmth([sensor]):
        return
    cold, slow = warmth.nothing_warm(context.view_layer), warmth.too_slow(sensor)
    if cold:
        draw_lines(layout, cold.text, "INFO")
    if slow:
        _draw_rate(draw_lines(layout, slow.text, "INFO"), context.scene, sensor.kind.signal_rate)
    layout.operator("angen.lens_table", icon="TEXT")


def _draw_rate(layout: Any, scene: Any, enough: float) -> None:
    """Draw a button that sets the active sensor's update rate to at least `enough` (Hz)."""
    frames = scene.render.fps / scene.render.fps_base
    # The lowest rate that is high enough and divides the frame rate.
    rate = max(frames / max(1.0, frames // enough), enough)
    fit = layout.operator("wm.context_set_float", text=f"Set to {rate:g} Hz", icon="CHECKMARK")
    fit.data_path, fit.value = "object.angen_sensor.update_rate", rate


# Number of rays from side to side of a zone in the floor plan.
RAYS_A_ZONE = 5


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """Return the rays for the floor plan.

    For a range scan, these are its rays. For a lens, they are a horizontal fan for each zone, as
    wide as the zone and as long as the detection distance. `sight` is the `Trace` with the sensor's
    rays, parameters and pose. `metres` is the length of a Blender unit in m.
    """
    parameters, pose = sight.parameters, sight.pose
    if parameters.model != "PYROELECTRIC":
        return replace(sight.rays(metres), rows=parameters.tilt_count)
    zones = zones_of(parameters)
    directions = np.array([_across(zone) for zone in zones]).reshape(-1, 3)
    directions = directions @ pose.axes.T
    origins = np.broadcast_to(pose.origin / metres, directions.shape)
    reach = np.full(len(directions), parameters.range_max / metres)
    return SensorRays(origins, directions, reach, len(zones))


def _across(zone: Zone) -> list[tuple[float, float, float]]:
    """Return RAYS_A_ZONE unit vectors in the sensor's axes, across the width of a zone."""
    level, rise = math.cos(zone.elevation), math.sin(zone.elevation)
    sides = np.linspace(-zone.width / 2, zone.width / 2, RAYS_A_ZONE) + zone.azimuth
    return [(-math.sin(a) * level, rise, -math.cos(a) * level) for a in sides.tolist()]
