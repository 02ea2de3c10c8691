# SPDX-License-Identifier: GPL-3.0-or-later
"""Search the home for mistakes that cause wrong readings."""

from __future__ import annotations

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Operator

from ..angen_addon.authoring.presets import select_only
from ..angen_addon.doctor import Finding, count, findings
from ..angen_addon.scene import memory
from ..angen_addon.translations.interface import translated
from .polls import can_read_scene, cancelled, is_idle

# The findings of the last Examine Home; None before it.
found: tuple[Finding, ...] | None = None


@memory.forgets_at_load
def forget() -> None:
    """Forget the findings, which are about the open file."""
    global found
    found = None


class ANGEN_OT_doctor(Operator):
    bl_idname = "angen.doctor"
    bl_label = "Examine Home"
    bl_description = (
        "Look for what gives sensors wrong readings: scale, missing faces, doors without hinges, "
        "lamps, sensors inside walls, missing files. Each finding has a remedy"
    )
    bl_options = {"REGISTER"}

    poll = classmethod(is_idle)

    def execute(self, context: Context) -> set[str]:
        global found
        found = tuple(findings())
        self.report({"WARNING" if found else "INFO"}, translated(count(list(found)).capitalize()))
        return {"FINISHED"}


class ANGEN_OT_doctor_select(Operator):
    bl_idname = "angen.doctor_select"
    bl_label = "Select Objects"
    bl_description = "Select the objects that this finding is about"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(options={"HIDDEN"})

    poll = classmethod(can_read_scene)

    def execute(self, context: Context) -> set[str]:
        names = found[self.index].objects if found and 0 <= self.index < len(found) else ()
        shown = context.view_layer.objects
        objects = [shown[name] for name in names if name in shown]
        if not objects:
            return cancelled(self, "The objects are not in this view layer: Examine Home again")
        select_only(context, *objects)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_doctor, ANGEN_OT_doctor_select))
