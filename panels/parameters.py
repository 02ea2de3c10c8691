# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a sensor's parameters, whatever its kind, wherever a panel wants them."""

from __future__ import annotations

import math
from typing import Any

from ..angen_addon import state
from ..angen_addon.sensors import Sensor, SensorError, check
from ..sensor_logic.kinds import KINDS, NO_KIND, not_simulated
from ..sensor_logic.parameters import specs, used


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
        _lines(layout, str(error).partition(": ")[2], "ERROR")


def draw_output(layout: Any, sensor: Sensor) -> None:
    """What the sensor reads at the playhead: state and value, or why there is none."""
    kind, settings = sensor.kind, sensor.settings
    if kind.model is None:
        layout.label(text="Not simulated", icon="X")
    elif not settings.enabled:
        layout.label(text="Off", icon="X")
    elif state.CACHE.live and sensor.name in state.CACHE.live.problems:
        layout.label(text="Invalid", icon="ERROR")
    else:
        row = layout.split(factor=0.6, align=True)
        row.label(
            text=kind.active_label if settings.active else kind.idle_label,
            icon="RADIOBUT_ON" if settings.active else "RADIOBUT_OFF",
        )
        value = row.row()
        value.alignment = "RIGHT"
        value.label(text=_quantity(settings.value, kind.value_unit))


def _quantity(value: float, unit: str) -> str:
    if unit == "rad":
        return f"{math.degrees(value):.0f}°"
    return f"{value:.3f} {unit}"


def _lines(layout: Any, text: str, icon: str) -> None:
    """A text broken into lines short enough for a narrow panel."""
    box = layout.box().column(align=True)
    line = ""
    for word in text.split():
        if line and len(line) + len(word) > 42:
            box.label(text=line, icon=icon)
            line, icon = "", "BLANK1"
        line = f"{line} {word}".strip()
    box.label(text=line, icon=icon)
