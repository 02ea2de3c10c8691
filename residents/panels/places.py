# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels on the places of residents (Physics tab and sidebar).

One panel is on the active object as a place, the other on all places.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel

from ...angen_addon.appearance.panel_parts import (
    ClosedSidebar,
    PhysicsTab,
    draw_lines,
    draw_progress,
    draw_property,
    has_name_column,
)
from ...angen_addon.scene.instances import is_sensor
from ..acting.places import CUPBOARD, DOOR, DRAWER, LAMP, MOVED
from ..blender.marks import FACING, NONE, WITH_DISTANCE, describe_leaf, marked
from ..operators import places

MOST = 6


def draw_place(layout: Any, context: Context) -> None:
    """Draw the settings of the active object as a place."""
    obj = context.object
    mark = obj.angen_place
    column = layout.column()
    column.use_property_split = has_name_column()
    column.prop(mark, "use")
    if mark.use == NONE:
        return
    column.prop(mark, "room")
    if mark.use in FACING:
        column.prop(mark, "facing")
    if mark.use in WITH_DISTANCE:
        draw_property(column, context.scene, mark, "away", "Distance", "m")
    if mark.use == LAMP:
        column.prop(mark, "switch")
    if mark.use in MOVED:
        _draw_moved(layout, column, context)
    layout.operator("angen.place_guess", icon="FILE_REFRESH")


def _draw_moved(layout: Any, column: Any, context: Context) -> None:
    """Draw the settings of a leaf or drawer, and a line on how it opens."""
    mark = context.object.angen_place
    text, slides = describe_leaf(context.object) if mark.use != DRAWER else ("", True)
    if mark.use in (DOOR, CUPBOARD):
        column.prop(mark, "motion")
    if slides:
        draw_property(column, context.scene, mark, "slide", "Slides By", "m")
    else:
        column.prop(mark, "angle")
    if mark.use != DRAWER:
        column.prop(mark, "other_side", text="Other End" if slides else "Other Side")
        draw_lines(layout, text, "INFO")
    if mark.use == DOOR:
        column.prop(mark, "entrance")


class ANGEN_PT_physics_place(PhysicsTab, Panel):
    bl_label = "Resident's Place"
    help_page = "residents"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw(self, context: Context) -> None:
        draw_place(self.layout, context)


class ANGEN_PT_places(ClosedSidebar, Panel):
    bl_label = "Residents' Places"
    help_page = "residents"

    def draw(self, context: Context) -> None:
        layout = self.layout
        obj = context.object
        if obj is not None and not is_sensor(obj):
            layout.label(text=obj.name, icon="OBJECT_DATA", translate=False)
            draw_place(layout, context)
        layout.operator_menu_enum("angen.place_point", "use", text="Add Place at 3D Cursor")
        row = layout.row(align=True)
        if not draw_progress(row, "angen.places_check"):
            row.operator("angen.places_check", icon="VIEWZOOM")
        row = row.row(align=True)
        row.active = context.scene.angen_overlay.show
        row.prop(context.scene, "angen_show_places", text="", icon="HIDE_OFF", toggle=True)
        count = len(marked(context.view_layer))
        if places.checked is None:
            layout.label(text=f"{count} marked, not checked", icon="INFO")
            return
        count_text, found = places.checked
        draw_lines(layout, count_text, "ERROR" if found else "CHECKMARK")
        for text in found[:MOST]:
            draw_lines(layout, text, "ERROR")
        if len(found) > MOST:
            layout.label(text=f"and {len(found) - MOST} more", icon="BLANK1")
        draw_lines(layout, "After changes, press Check Places again", "INFO")


register, unregister = bpy.utils.register_classes_factory((ANGEN_PT_physics_place, ANGEN_PT_places))
