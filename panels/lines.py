# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts in panels: broken into lines that fit, and names beside values."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy

# Of Blender's interface font, in pixels at a scale of 1; and what margins and the icon take.
WIDTH_OF_LETTER = 6.2
MARGIN_LETTERS = 11
# Pixels, where there is no region to measure.
USUAL_WIDTH = 320
LABEL_SHARE = 0.4


def draw_lines(layout: Any, text: str, icon: str) -> Any:
    """A box with a text broken into lines; returns the box, for what would mend it."""
    region = bpy.context.region
    width = region.width if region else USUAL_WIDTH
    # Without a window there is no scale.
    scale = bpy.context.preferences.system.ui_scale or 1.0
    letters = max(20, int(width / (WIDTH_OF_LETTER * scale)) - MARGIN_LETTERS)
    box = layout.box().column(align=True)
    for line in textwrap.wrap(text, letters, break_on_hyphens=False):
        box.label(text=line, icon=icon)
        icon = "BLANK1"
    return box


def draw_row(layout: Any, name: str, text: str) -> None:
    """A name to the left, as those of properties are, and its value."""
    row = layout.split(factor=LABEL_SHARE)
    left = row.row()
    left.alignment = "RIGHT"
    left.label(text=name)
    row.label(text=text)
