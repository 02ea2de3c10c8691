# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel with the settings of what 3D views draw for sensors (sidebar and overlays popover)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel

from ..angen_addon.appearance.panel_parts import ClosedSidebar
from ..angen_addon.appearance.reading_text import (
    ACTIVE,
    BAKED,
    IDLE,
    NOT_SURE,
    OFF,
    OLD,
    UNKNOWN,
    WRONG,
)
from ..angen_addon.translations.interface import translating

# Icons of the table and the view, and what they mean.
SIGNS = (
    (ACTIVE, "Motion, open, pressed, lit"),
    (IDLE, "Still, closed, free, dark"),
    (WRONG, "Not valid"),
    (NOT_SURE, "Not yet sure, or warming up"),
    (OLD, "Old: the scene has changed since"),
    (BAKED, "Only baked keyframes"),
    (UNKNOWN, "No reading: scrub, play or simulate"),
    (OFF, "Off"),
)


class ANGEN_PT_overlay(ClosedSidebar, Panel):
    bl_label = "Show in View"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.angen_overlay, "show", text="")

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.angen_overlay
        layout.use_property_split = True
        layout.active = settings.show
        column = layout.column(heading="Show")
        column.prop(settings, "names")
        column.prop(settings, "values")
        column.prop(settings, "handles")
        column.prop(settings, "fields")
        row = layout.row()
        row.active = settings.fields
        row.prop(settings, "which", expand=True)
        column = layout.box().column(align=True)
        for icon, words in SIGNS:
            column.label(text=words, icon=icon)


@translating
def draw_in_popover(self: Any, context: Context) -> None:
    """Draw these settings below Blender's own in the popover Viewport Overlays."""
    settings = context.scene.angen_overlay
    column = self.layout.column()
    column.active = context.space_data.overlay.show_overlays
    column.label(text="Sensors")
    row = column.row(align=True)
    row.prop(settings, "show", text="Show")
    part = row.row(align=True)
    part.active = settings.show
    part.prop(settings, "fields")


_register, _unregister = bpy.utils.register_classes_factory((ANGEN_PT_overlay,))


def register() -> None:
    _register()
    bpy.types.VIEW3D_PT_overlay.append(draw_in_popover)


def unregister() -> None:
    bpy.types.VIEW3D_PT_overlay.remove(draw_in_popover)
    _unregister()
