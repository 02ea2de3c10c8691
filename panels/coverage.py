# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of coverage maps, and of proposed places for motion detectors (sidebar)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel, UILayout

from ..angen_addon.appearance.panel_parts import (
    ClosedSidebar,
    draw_lines,
    draw_progress,
    draw_property,
    draw_row,
)
from ..angen_addon.coverage import shown
from ..angen_addon.scene.lengths import lengths_of
from ..operators.propose import active_detector
from ..sensor_logic.coverage.grid import NO_ROOM
from ..sensor_logic.coverage.motions import MOTIONS
from ..sensor_logic.logs.wording import plural

ROOMS_SHOWN, NAMES_SHOWN = 12, 3


class ANGEN_PT_coverage(ClosedSidebar, Panel):
    bl_label = "Coverage"
    help_page = "coverage"

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.angen_coverage
        layout.use_property_split = True
        column = layout.column()
        column.prop(settings, "motion")
        draw_property(column, context.scene, settings, "height", "Height", "m")
        if settings.height == 0.0:
            usual = lengths_of(context.scene).typed(round(MOTIONS[settings.motion].height, 3))
            draw_row(column, "", f"0: usual, {usual}")
        draw_property(column, context.scene, settings, "cell", "Cell", "m")
        column.prop(settings, "rooms", placeholder="all")
        column.prop(settings, "selected")
        layout.operator_context = "INVOKE_DEFAULT"
        row = layout.row(align=True)
        if not draw_progress(row, "angen.coverage"):
            row.operator("angen.coverage", icon="MESH_GRID")
        row.operator("angen.export_coverage", text="", icon="EXPORT")
        row.operator("angen.coverage_clear", text="", icon="TRASH")
        found = shown.summary(context.scene)
        if found is not None:
            stale = shown.why_stale(context.scene)
            if stale:
                draw_lines(layout, f"The map is stale, {stale}. Map Coverage again", "ERROR")
            _draw_rooms(layout, found, context.scene, not stale)


class ANGEN_PT_coverage_place(ClosedSidebar, Panel):
    bl_label = "Propose Places"
    help_page = "coverage"
    bl_parent_id = "ANGEN_PT_coverage"

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.angen_coverage
        layout.use_property_split = True
        column = layout.column()
        column.prop(settings, "count")
        column.prop(settings, "mounting")
        height = column.column()
        height.active = settings.mounting != "CEILING"
        draw_property(height, context.scene, settings, "mounting_height", "On Walls At", "m")
        column.prop(settings, "beside")
        like = active_detector(context)
        text = f"Parameters of {like.name}" if like else "Parameters: the defaults"
        layout.label(text=text, icon="INFO")
        layout.operator_context = "INVOKE_DEFAULT"
        if not draw_progress(layout, "angen.place_propose"):
            layout.operator("angen.place_propose", icon="PIVOT_CURSOR")
        if shown.proposed(context.scene) or shown.is_of_proposal(context.scene):
            row = layout.row(align=True)
            row.operator("angen.place_accept", icon="CHECKMARK")
            row.operator("angen.place_discard", icon="X")


def _draw_rooms(layout: UILayout, figures: dict, scene: Any, is_fresh: bool) -> None:
    """Draw the coverage of each room as a table, greyed out if the map is out of date."""
    box = layout.box().column(align=True)
    frame = figures.get("frame", scene.frame_current)
    count = plural(figures["sensors"], "detector")
    text = f"{figures['motion']}, {count}"
    if frame != scene.frame_current:
        text = f"{figures['motion']}, {count}, frame {frame}"
    box.label(text=text)
    for name in figures.get("names", [])[:NAMES_SHOWN]:
        box.label(text=name, translate=False)
    if figures["sensors"] > NAMES_SHOWN:
        box.label(text=f"and {figures['sensors'] - NAMES_SHOWN} more")
    if shown.is_of_proposal(scene):
        box.label(text="Only proposed places count", icon="INFO")
    box.active = is_fresh
    rooms = figures["rooms"]
    if len(rooms) > ROOMS_SHOWN:
        rooms = [*rooms[: ROOMS_SHOWN - 1], rooms[-1]]
    # Other names are the user's.
    ours = "Room", NO_ROOM, rooms[-1][0]
    lines = [("Room", "Covered", "Dead m²")]
    lines += [(name, f"{100 * share:.0f} %", f"{dead:.1f}") for name, _, share, dead in rooms]
    for name, covered, dead in lines:
        row = box.split(factor=0.45)
        row.label(text=name, translate=name in ours)
        part = row.split(factor=0.5)
        part.label(text=covered)
        part.label(text=dead)
    _draw_legend(layout)


def _draw_legend(layout: UILayout) -> None:
    """Draw the colours of the map with their meaning."""
    column = layout.column(align=True)
    column.use_property_split = False
    column.use_property_decorate = False
    for material, label in shown.legend():
        row = column.split(factor=0.15)
        row.prop(material, "diffuse_color", text="")
        row.label(text=label)


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_PT_coverage, ANGEN_PT_coverage_place)
)
