# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts in panels: broken into lines that fit, and names beside values."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy

from ..angen_addon.scene.lengths import in_units
from ..angen_addon.scene.sensors import unit_scale
from ..angen_addon.scene.units import with_unit

# Of Blender's interface font, in pixels at a scale of 1; and what margins and the icon take.
WIDTH_OF_LETTER = 6.2
MARGIN_LETTERS = 11
# Pixels, where there is no region to measure.
USUAL_WIDTH = 320
LABEL_SHARE = 0.4
# Where a region is narrower than this many pixels at a scale of 1, names of fields would be cut in
# a column of their own: they stand in the fields.
NARROW = 230


def has_name_column() -> bool:
    """Whether the present region has room for a column of names beside the fields."""
    region = bpy.context.region
    scale = bpy.context.preferences.system.ui_scale or 1.0
    # Without a window there is no width.
    return region is None or region.width <= 1 or region.width > NARROW * scale


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


def draw_property(
    layout: Any, scene: Any, owner: Any, name: str, label: str, unit: str = ""
) -> None:
    """A property with its unit: in the field where Blender can show it there, else in the label.
    Lengths, which are stored in metres, are shown and read in the scene's own unit."""
    text = with_unit(label, unit, scene)
    of_units = unit == "m" and unit_scale(scene) != 1.0
    layout.prop(owner, in_units(name) if of_units else name, text=text)


def draw_row(layout: Any, name: str, text: str) -> None:
    """A name to the left, as those of properties are, and its value."""
    row = layout.split(factor=LABEL_SHARE if has_name_column() else 0.5)
    left = row.row()
    left.alignment = "RIGHT"
    left.label(text=name)
    row.label(text=text)
