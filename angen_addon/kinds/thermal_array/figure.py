# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of infrared arrays: housings, pixels on what they see, and the frame in panels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from bpy.types import Context

from ....sensor_logic.geometry.pixels import pixel_corners
from ....sensor_logic.kinds.thermal_array.array import SIGHT, array_rays
from ....sensor_logic.logs.wording import measured
from ....sensor_logic.model import Array
from ....sensor_logic.palette import colours, limits
from ...advice.warmth import nothing_warm
from ...appearance.figures import Figure, around_edge, corners_of, pairs
from ...appearance.handles import Handle, Point
from ...appearance.housing import Housing, looking
from ...appearance.panel_parts import draw_lines, draw_row
from ...appearance.pixel_icons import icon_of
from ...appearance.reading_text import ReadingText
from ...runtime.trace import CastRays, SensorRays, Trace
from ...scene.sensors import Sensor

# K. The least difference between the darkest and the brightest colour, so that noise stays dim.
LEAST_SPAN = 5.0
# Rays from side to side in the floor plan.
ACROSS = 25
# m. Pixels that see nothing within this distance are drawn there.
FARTHEST = 12.0
# The opacity of the darkest colour, as a fraction of that of the brightest.
FAINT = 0.3
# m. The distance of the handles.
HANDLES = 0.5


def values_of(text: str) -> Array:
    """Return the temperatures (pixels,) in °C of the text of a frame."""
    return np.array(text.split(";"), np.float64) if text else np.empty(0)


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """Return a horizontal fan of rays for the floor plan, or one around the field of view.

    The latter is for an array that looks steeply up or down. `sight` is the trace with the sensor's
    parameters and pose. `metres` is the length of a Blender unit in m.
    """
    edge = around_edge(sight.pose)
    if edge is not None:
        slopes = (math.tan(angle / 2) for angle in sight.parameters.field_of_view)
        x, y = (side * slope for side, slope in zip(edge, slopes, strict=True))
        local = np.stack([x, y, -np.ones_like(x)], axis=1)
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        origins = np.broadcast_to(sight.pose.origin / metres, local.shape)
        return SensorRays(origins, local @ sight.pose.axes.T, np.full(len(local), SIGHT / metres))
    fan = replace(sight.parameters, columns=ACROSS, rows=1, rays=1)
    origins, directions, reach = array_rays(fan, sight.pose)
    return SensorRays(origins / metres, directions, reach / metres)


# By the hits of a bundle: the corners of its pixels. Without the cache, each redraw after a new
# frame takes 10 ms more for 32 × 24 pixels.
_corners: WeakKeyDictionary[CastRays, Array] = WeakKeyDictionary()


def _pixel_corners(seen: Any, cast: CastRays, metres: float) -> Array:
    """Return the corners (pixels, 4, 3) of the pixels on what they see, in Blender units."""
    known = _corners.get(cast)
    if known is None:
        parameters = seen.parameters
        edges = pixel_corners(seen.pose.axes, parameters.field_of_view, parameters.pixels)
        known = _corners[cast] = corners_of(
            cast, seen.pose.origin, edges, metres, FARTHEST, whole=True
        )
    return known


def pixels_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Draw the outlines of the pixels on what they see, and the edges of the field of view.

    `seen` is the `DrawnSensor`, and `number` the number of the ray bundle. `cast` has the rays with
    their ranges. `metres` is the length of a Blender unit in m.
    """
    drawn = Figure()
    columns, rows = seen.parameters.pixels
    corners = _pixel_corners(seen, cast, metres)
    drawn.add("edge", pairs(corners, np.roll(corners, -1, axis=1)))
    outer = ((0, 0), (columns - 1, 1), (columns * rows - 1, 2), (columns * (rows - 1), 3))
    for pixel, corner in outer:
        drawn.add("axis", (seen.pose.origin / metres, corners[pixel, corner]))
    return drawn


def frame_figure(seen: Any, fields: Mapping[str, Any], metres: float) -> Figure | None:
    """Fill the pixels with the colours of a reading's temperatures.

    Return None if the reading has no frame of this array. `seen` is the `DrawnSensor`, and `fields`
    the reading's values. `metres` is the length of a Blender unit in m.
    """
    values = values_of(fields["frame_c"] or "")
    columns, rows = seen.parameters.pixels
    if len(values) != columns * rows or seen.rays is None or not seen.rays.bundles:
        return None
    cast = next(iter(seen.rays.bundles.values()))
    corners = _pixel_corners(seen, cast, metres)
    drawn = Figure()
    drawn.fill("value", corners[:, [[0, 1, 2], [0, 2, 3]]])
    low, high = limits(values, LEAST_SPAN)
    opacity = FAINT + (1.0 - FAINT) * (values - low) / (high - low)
    each = np.column_stack([colours(values, low, high), opacity])
    drawn.colour("value", np.repeat(each, 2, axis=0))
    return drawn


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw the frame of the reading as a picture in the panel, with its temperatures.

    `seen` has the texts of the sensor's reading.
    """
    cold = nothing_warm(context.view_layer)
    if cold:
        draw_lines(layout, cold.text, "INFO")
    fields = seen.fields
    if fields is None:
        return
    column = layout.column(align=True)
    array = sensor.parameters
    values = values_of(fields.get("frame_c") or "")
    if len(values) == array.columns * array.rows:
        low, high = limits(values, LEAST_SPAN)
        each = colours(values, low, high).reshape(array.rows, array.columns, 3)
        icon = icon_of(f"{sensor.kind.identifier} {sensor.name}", fields["frame_c"], each)
        column.template_icon(icon_value=icon, scale=8.0)
        draw_row(column, "Colours", f"{low:.1f} to {high:.1f} °C".replace("-", "−"))
    draw_row(column, "Warm", f"{fields['warm_pixels']} of {array.columns * array.rows} pixels")
    draw_row(column, "Mean", measured(fields["mean_c"], "°C", 1))


def edge_handle(name: str, axis: int) -> Handle:
    """Return the handle of an angle of the field of view, on its right or upper edge."""

    def at(parameters: Any) -> Point:
        angle = getattr(parameters, name) / 2
        point = [0.0, 0.0, -HANDLES * math.cos(angle)]
        point[axis] = HANDLES * math.sin(angle)
        return tuple(point)

    return Handle(name, at)


# Housings: the package of the data sheet on a board of 25 × 18 mm.


def _on_board(housing: Housing, deep: float) -> Housing:
    return looking(housing.box((-0.0125, -0.009, deep), (0.0125, 0.009, deep + 0.0016)))


def _grid_eye() -> Housing:
    """Return Panasonic's Grid-EYE, 11.6 × 8.0 × 4.3 mm."""
    return _on_board(Housing().box((-0.0058, -0.004, 0.0), (0.0058, 0.004, 0.0043)), 0.0043)


def _can() -> Housing:
    """Return a can TO-39 with a flange of 9.3 mm; the height of 5 mm is an assumption."""
    outline = [(0.0041, 0.0), (0.0041, 0.0045), (0.00465, 0.0045), (0.00465, 0.005)]
    return _on_board(Housing().lathe(outline), 0.005)


CANS = ("MLX90640_BAA", "MLX90640_BAB", "MLX90641_BCA", "HTPA32")
HOUSINGS = {"": _grid_eye, **dict.fromkeys(CANS, _can)}
