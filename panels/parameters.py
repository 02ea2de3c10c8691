# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a sensor's parameters, whatever its kind, wherever a panel wants them."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import bpy

from ..angen_addon import state
from ..angen_addon.sensors import Sensor, SensorError, check
from ..sensor_logic.kinds import KINDS, NO_KIND, not_simulated
from ..sensor_logic.parameters import specs, used

# Of Blender's interface font, in pixels at a scale of 1; and what margins and the icon take.
WIDTH_OF_LETTER = 7.5
MARGIN_LETTERS = 10


def sensor_of(obj: Any) -> Sensor | None:
    """The object as a sensor, if it is one."""
    if obj is None or obj.angen_sensor.kind == NO_KIND:
        return None
    return Sensor(obj.name, KINDS[obj.angen_sensor.kind], obj)


def draw_parameters(layout: Any, sensor: Sensor) -> None:
    """All parameters that the chosen model looks at, and what is wrong with them."""
    layout.use_property_split = True
    layout.use_property_decorate = True
    settings = sensor.settings
    group = getattr(settings, sensor.kind.attribute)
    if sensor.kind.model is None:
        _lines(layout, not_simulated(sensor.kind), "INFO")
    layout.prop(settings, "update_rate")
    for name, spec in specs(sensor.kind.parameters).items():
        if used(group, name, spec) and len(spec.choices) != 1:
            layout.prop(group, name)
    try:
        check(sensor)
    except SensorError as error:
        problem = str(error).removeprefix(f"'{sensor.name}': ")
        for name, spec in specs(sensor.kind.parameters).items():
            problem = problem.replace(name, spec.label)
        _lines(layout, problem, "ERROR")


def reading_of(sensor: Sensor) -> tuple[str, str]:
    """What the sensor reads at the playhead, in words, or why nothing; and an icon for it."""
    kind, settings = sensor.kind, sensor.settings
    if kind.model is None:
        return "Not simulated", "X"
    if not settings.enabled:
        return "Off", "X"
    if state.CACHE.live and sensor.name in state.CACHE.live.problems:
        return "Invalid", "ERROR"
    word = kind.active_label if settings.active else kind.idle_label
    icon = "RADIOBUT_ON" if settings.active else "RADIOBUT_OFF"
    return f"{word}, {_quantity(settings.value, kind.value_unit)}", icon


def _quantity(value: float, unit: str) -> str:
    if unit == "rad":
        return f"{math.degrees(value):.0f}°"
    return f"{value:.3f} {unit}"


def _lines(layout: Any, text: str, icon: str) -> None:
    """A text broken into lines that fit the panel."""
    context = bpy.context
    scale = context.preferences.system.ui_scale
    width = max(20, int(context.region.width / (WIDTH_OF_LETTER * scale)) - MARGIN_LETTERS)
    box = layout.box().column(align=True)
    for line in textwrap.wrap(text, width):
        box.label(text=line, icon=icon)
        icon = "BLANK1"
