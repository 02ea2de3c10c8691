# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the active object as a resident (Physics tab and sidebar)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel

from ...angen_addon.appearance.panel_parts import (
    PhysicsTab,
    Sidebar,
    draw_lines,
    draw_property,
    draw_row,
    has_name_column,
)
from ...angen_addon.scene.lengths import SPEED
from ..blender.person import LABELS, body_of
from ..blender.settings import is_resident
from ..body.skeleton import Sort


def resident_of(obj: Any) -> Any:
    """Return the armature of the resident that an object belongs to, or None."""
    return next((one for one in (obj, obj.parent) if is_resident(one)), None) if obj else None


class _Resident:
    bl_label = "Resident"
    help_page = "residents"
    layout: Any

    @classmethod
    def poll(cls, context: Context) -> bool:
        return resident_of(context.object) is not None

    def draw(self, context: Context) -> None:
        layout = self.layout
        rig = resident_of(context.object)
        settings, scene = rig.angen_resident, context.scene
        column = layout.column()
        column.use_property_split = has_name_column()
        draw_row(column, "Type", LABELS[Sort(settings.sort)])
        draw_property(column, scene, settings, "speed", "Speed", SPEED)
        draw_property(column, scene, settings, "stature", "Stature", "m")
        if body_of(rig) is None:
            draw_lines(
                layout,
                "The body was deleted, and sensors do not notice it: undo, or add a new resident",
                "ERROR",
            )
            return
        draw_property(column, scene, settings, "mass", "Mass", "kg")
        warmth = body_of(rig).angen_warmth
        is_cat = settings.sort == Sort.CAT.value
        draw_property(column, scene, warmth, "temperature", "Skin", "°C")
        column.prop(warmth, "insulation", text="Fur (clo)" if is_cat else "Clothes (clo)")
        if not is_cat:
            column.prop(settings, "walking_frame")
            if settings.walking_frame is None and rig is context.object:
                layout.operator("angen.walking_frame_add", icon="ADD")
        draw_lines(layout, f'In a routine: resident = "{rig.name}"', "INFO")


class ANGEN_PT_physics_resident(_Resident, PhysicsTab, Panel):
    pass


class ANGEN_PT_sidebar_resident(_Resident, Sidebar, Panel):
    pass


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_PT_physics_resident, ANGEN_PT_sidebar_resident)
)
