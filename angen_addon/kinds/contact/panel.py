# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows in the panel of a door contact below its parameters."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ....panels.lines import draw_lines
from ....panels.readings import ReadingText
from ...scene.sensors import Sensor

NO_MAGNET = "It has no magnet, so it is always open. Choose the object that is its magnet"


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Warns of a missing magnet."""
    if sensor.parameters.magnet is None:
        draw_lines(layout, NO_MAGNET, "ERROR")
