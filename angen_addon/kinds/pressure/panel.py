# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows in the panel of a pressure pad below its parameters: its whole reading, and warnings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bpy.types import Context

from ....panels.lines import draw_lines, draw_row
from ....panels.readings import ReadingText
from ....sensor_logic.kinds.pressure import KIND
from ....sensor_logic.log.partner_names import split
from ....sensor_logic.model import NOT_YET
from ....sensor_logic.quantities import NOTHING, Lengths
from ...advice import sensing as advice
from ...scene.sensors import Sensor
from ...scene.units import lengths_of
from .words import centre_text

SECTIONS = (
    (
        "Force and Partners",
        (
            "threshold",
            "report_step",
            "partner_object",
            "partner_collection",
            "subtract_own_weight",
            "noise_sigma",
        ),
    ),
    (
        "Resistor",
        (
            "resistor",
            "resistance_at_1n",
            "exponent",
            "force_min",
            "force_max",
            "unloaded_resistance",
            "area",
            "hysteresis",
            "drift",
            "part_spread",
            "repeatability",
        ),
    ),
    ("Electronics", ("load_resistor", "supply_voltage", "adc_bits")),
)


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Shows the reading, and warnings with buttons that help."""
    pad, scene = sensor.object, context.scene
    problem = advice.without_surface(pad)
    if problem:
        draw_lines(layout, problem.text, "ERROR")
        return
    if seen.fields is not None:
        _draw_reading(layout, seen.fields, lengths_of(scene))
    outdated = None if seen.recorded else advice.outdated_cache(scene)
    if outdated:
        draw_lines(layout, outdated.text, "ERROR")
    elif seen.problem:
        not_yet = seen.problem == NOT_YET
        draw_lines(layout, _not_yet(seen) if not_yet else _not_valid(seen), seen.icon)
    sinks = advice.sinks(pad, scene)
    if sinks:
        box = draw_lines(layout, sinks.text, "ERROR")
        box.row().prop(pad.rigid_body, "type", expand=True)
    for found in (
        advice.weightless(pad, scene, context.view_layer),
        advice.hidden_partner(sensor, context.view_layer),
    ):
        if found:
            draw_lines(layout, found.text, "ERROR")
    short = advice.short_cache(scene)
    if short:
        box = draw_lines(layout, short.text, "ERROR")
        box.prop(scene.rigidbody_world.point_cache, "frame_end", text="Cache End")


def _not_yet(seen: ReadingText) -> str:
    text = f"Not yet sure: {seen.problem}. The force is that of bodies at rest"
    return text if seen.recorded else f"{text}; play on, or simulate, for a sure one"


def _not_valid(seen: ReadingText) -> str:
    text = f"Not valid: {seen.problem}"
    if seen.fields is None:
        return text
    text += ". This is the last known reading"
    return text if seen.recorded else f"{text}; play on, or simulate, for a sure one"


def _draw_reading(layout: Any, fields: Mapping[str, Any], lengths: Lengths) -> None:
    """Shows all but the force, which stands in the sensor's state above."""
    column = layout.column(align=True)
    of = KIND.fields
    # Below its threshold a pad is free, and may carry a cushion.
    label = "Pressed By" if fields["pressed"] else "On It"
    draw_row(column, label, ", ".join(split(fields["partners"])) or NOTHING)
    draw_row(column, "Centre", centre_text(fields["cop_x_m"], fields["cop_y_m"], lengths))
    draw_row(column, "Resistor", of["resistance_ohm"].text(fields["resistance_ohm"]))
    voltage = of["voltage_v"].text(fields["voltage_v"])
    draw_row(column, "Output", f"{voltage}, ADC {fields['adc']}")
