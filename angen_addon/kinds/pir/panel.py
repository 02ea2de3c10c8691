# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows in the panel of a motion detector below its parameters."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ....panels import warmth
from ....panels.lines import draw_lines
from ....panels.readings import ReadingText
from ...advice import sensing as advice
from ...scene.sensors import Sensor


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Shows why it may report nothing, with buttons that help."""
    late = advice.warm_up(sensor, context.scene)
    if late:
        box = draw_lines(layout, late.text, "INFO")
        if not sensor.holders:
            button = box.operator("wm.context_set_float", text="Set to 0 s", icon="CHECKMARK")
            button.data_path, button.value = "object.angen_sensor.pir.warm_up_time", 0.0
    warmth.draw_detector(layout, context, sensor, seen)
