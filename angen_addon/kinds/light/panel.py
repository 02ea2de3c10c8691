# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows in the panel of a light sensor below its parameters."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ....panels.lines import draw_lines
from ....panels.readings import ReadingText
from ....sensor_logic.wording import capital
from ...scene.sensors import Sensor


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Shows the note of the last live reading, such as on a view that is narrower than asked."""
    note = seen.fields.get("note", "") if seen.fields is not None else ""
    if note:
        draw_lines(layout, capital(note), "INFO")
