# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows and explanation of sensors in collection instances (sidebar)."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ..angen_addon.appearance.panel_parts import draw_lines
from ..angen_addon.scene.sensors import Sensor
from ..angen_addon.view.active import active_sensor
from ..angen_addon.view.readings import reading_text
from ..operators.instance_override import why_not

MOST_ROWS = 16


def draw_rows(layout: Any, context: Context, sensors: list[Sensor]) -> None:
    """Draw a row for each sensor; a click on a row selects the sensor."""
    active = active_sensor(context)
    where = "collection instances"
    if active is not None and active.holders:
        # There may be many homes: list only the active sensor's.
        sensors = [s for s in sensors if s.handle == active.handle]
        where = f"'{active.handle.name}'"
    column = layout.box().column(align=True)
    column.label(text=f"In {where}: {len(sensors)}", icon="OUTLINER_OB_GROUP_INSTANCE")
    for sensor in sensors[:MOST_ROWS]:
        seen = reading_text(sensor, context.scene)
        row = column.row(align=True)
        row.active = sensor.settings.enabled
        chosen = active is not None and active.uid == sensor.uid
        item = row.operator(
            "angen.sensor_show",
            text=sensor.name,
            icon=seen.icon,
            emboss=chosen,
            depress=chosen,
            translate=False,
        )
        item.name, item.library = sensor.name, sensor.library
        value = row.row()
        value.alignment = "RIGHT"
        value.label(text=seen.short, translate=False)
    if len(sensors) > MOST_ROWS:
        column.label(text=f"and {len(sensors) - MOST_ROWS} more: search above")


def draw_instanced(layout: Any, sensor: Sensor) -> None:
    """Draw an explanation of what is not possible with a sensor in a collection instance.

    Also draw the button that replaces the instance by library overrides, if that is possible.
    """
    text = (
        f"This sensor is in the instance '{sensor.handle.name}'. Its settings are the same in all "
        "instances of the collection. Its outputs have no keyframes, and drivers cannot read them"
    )
    box = draw_lines(layout, text, "OUTLINER_OB_GROUP_INSTANCE")
    if not why_not(sensor):
        box.operator("angen.instance_override", icon="LIBRARY_DATA_OVERRIDE")
