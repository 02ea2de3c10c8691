# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a sensor's parameters, whatever its kind, wherever a panel wants them."""

from __future__ import annotations

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
    """What the sensor reads at the playhead."""
    kind, settings = sensor.kind, sensor.settings
    row = layout.row()
    if kind.model is None:
        row.label(text="Not simulated", icon="X")
        return
    if not settings.enabled:
        row.label(text="Off", icon="X")
        return
    problem = state.CACHE.live.problems.get(sensor.name) if state.CACHE.live else None
    if problem:
        row.label(text="Invalid: see the parameters", icon="ERROR")
        return
    name = kind.events[0].name.capitalize()
    row.label(
        text=name if settings.active else f"Not {name.lower()}",
        icon="RADIOBUT_ON" if settings.active else "RADIOBUT_OFF",
    )
    row.label(text=f"{kind.value_label} {settings.value:.3f} {kind.value_unit}")


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
