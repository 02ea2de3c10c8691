# SPDX-License-Identifier: GPL-3.0-or-later
"""What a light sensor shows besides its parameters: what there is to say of how it was measured."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ....panels.lines import draw_lines
from ....panels.readings import Shown
from ....sensor_logic.wording import capital
from ...scene.sensors import Sensor


def draw(layout: Any, context: Context, sensor: Sensor, seen: Shown) -> None:
    """The note of the last live reading, if there is one: closed forms do not model everything."""
    note = seen.fields.get("note", "") if seen.fields is not None else ""
    if note:
        draw_lines(layout, capital(note), "INFO")
