# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on where the reading of the active sensor comes from, and the value of baked keys."""

from __future__ import annotations

from typing import Any

from .lines import draw_lines
from .readings import ReadingText


def draw(layout: Any, seen: ReadingText) -> None:
    """Draws these rows under the reading of a sensor that is switched on."""
    if seen.origin:
        row = layout.row()
        row.active = False
        row.label(text=seen.origin, icon="BLANK1")
    if seen.old:
        draw_lines(layout, seen.old, "TIME")
    if seen.keys:
        text = f"Baked keys say '{seen.keys}': drivers read them. Unbake removes them"
        box = draw_lines(layout, text, "KEYFRAME_HLT")
        box.operator("angen.unbake_keyframes", icon="KEYFRAME").selected = True
