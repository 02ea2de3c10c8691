# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes of panels, and functions that draw texts, properties and progress."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy

from ...sensor_logic import progress
from ...sensor_logic.logs.wording import capital
from ..scene.lengths import SPEED, in_units, with_unit
from ..scene.sensors import unit_scale
from ..translations.interface import translated
from .help import WINDOW, draw_help

# Mean width of a letter of Blender's interface font, in pixels at scale 1.
WIDTH_OF_LETTER = 6.2
# Width of margins and icon, in letters.
MARGIN_LETTERS = 11
# Pixels: assumed width without a region.
USUAL_WIDTH = 320
LABEL_SHARE = 0.4
# Regions narrower than this (pixels at scale 1) have the names inside the fields, because a column
# of names would cut them.
NARROW = 230


class Helped:
    """Mix-in of panels with a button in the header, which opens a page of the documentation."""

    help_page = WINDOW
    layout: Any

    def draw_header_preset(self, _context: Any) -> None:
        draw_help(self.layout, self.help_page)


class Sidebar(Helped):
    """Mix-in of panels in the tab "Sensors" of the 3D view's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sensors"


class ClosedSidebar(Sidebar):
    bl_options = {"DEFAULT_CLOSED"}


class PhysicsTab(Helped):
    """Mix-in of panels below the panel Sensor, in the Physics tab of the Properties editor."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"
    bl_parent_id = "ANGEN_PT_physics"


def has_name_column() -> bool:
    """Return whether the region is wide enough for a column of names beside the fields."""
    region = bpy.context.region
    scale = bpy.context.preferences.system.ui_scale or 1.0
    # Without a window there is no width.
    return region is None or region.width <= 1 or region.width > NARROW * scale


def draw_progress(layout: Any, operator: str) -> bool:
    """Draw the progress of `operator` if it is running; return whether it is running."""
    working = progress.working
    if working is None or working.operator != operator:
        return False
    # In a row, beside other buttons, the texts would cut each other.
    layout = layout.column(align=True)
    layout.progress(text=f"{working.far}. Esc ends", factor=working.share)
    if working.doing:
        # The bar is too narrow for this text.
        layout.label(text=capital(working.doing))
    return True


def draw_lines(layout: Any, text: str, icon: str, click: tuple[str, int] | None = None) -> Any:
    """Draw a text in a box, broken into lines, and return the box, to which a button can be added.

    `click` is an operator's name and an index. If it is given, a click on a line calls that
    operator with the index.
    """
    region = bpy.context.region
    width = region.width if region else USUAL_WIDTH
    # Without a window there is no scale.
    scale = bpy.context.preferences.system.ui_scale or 1.0
    letters = max(20, int(width / (WIDTH_OF_LETTER * scale)) - MARGIN_LETTERS)
    box = layout.box().column(align=True)
    for line in textwrap.wrap(translated(text), letters, break_on_hyphens=False):
        if click is None:
            box.label(text=line, icon=icon, translate=False)
        else:
            row = box.row()
            row.alignment = "LEFT"
            button = row.operator(click[0], text=line, translate=False, icon=icon, emboss=False)
            button.index = click[1]
        icon = "BLANK1"
    return box


def draw_property(
    layout: Any, scene: Any, owner: Any, name: str, label: str, unit: str = ""
) -> None:
    """Draw a property with its unit, in the field if Blender supports the unit, else in the label.

    Lengths and speeds are stored in metres, and edited in the scene's unit.
    """
    text = with_unit(label, unit, scene)
    of_units = unit in ("m", SPEED) and unit_scale(scene) != 1.0
    layout.prop(owner, in_units(name) if of_units else name, text=text)


def draw_row(layout: Any, name: str, text: str, translate: bool = True) -> None:
    """Draw a name, aligned with the names of properties, and a text to its right."""
    row = layout.split(factor=LABEL_SHARE if has_name_column() else 0.5)
    left = row.row()
    left.alignment = "RIGHT"
    left.label(text=name, translate=translate)
    row.label(text=text, translate=translate)
