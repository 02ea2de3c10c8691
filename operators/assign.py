# SPDX-License-Identifier: GPL-3.0-or-later
"""Make an existing object a sensor, or an ordinary object again."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Menu, Operator

from ..angen_addon.advice.sensing import without_surface
from ..angen_addon.scene.home.rooms import fill_room
from ..angen_addon.scene.instances import stands_for
from ..angen_addon.translations.interface import translated, translating
from ..sensor_logic.kind import FORCES
from ..sensor_logic.kinds import KINDS, NO_KIND
from ..sensor_logic.logs.wording import uncapitalized
from .add import KIND_ITEMS
from .polls import can_change_sensor, needs


class ANGEN_OT_sensor_assign(Operator):
    bl_idname = "angen.sensor_assign"
    bl_label = "Make Sensor"
    bl_description = "Make the active object a sensor"
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=KIND_ITEMS)

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls, context.object is not None, "Select the object that becomes a sensor"
        ) and needs(
            cls,
            context.object.is_editable,
            "The object is linked: make it local or a library override",
        )

    def execute(self, context: Context) -> set[str]:
        obj, kind = context.object, KINDS[self.kind]
        obj.angen_sensor.kind = self.kind
        fill_room(context.evaluated_depsgraph_get(), obj)
        problem = without_surface(obj) if kind.requires(FORCES) else None
        if problem:
            self.report({"WARNING"}, translated(f"'{obj.name}': {uncapitalized(problem.text)}"))
        else:
            self.report({"INFO"}, translated(f"'{obj.name}' is a sensor: {kind.label}"))
        return {"FINISHED"}


class ANGEN_OT_sensor_clear(Operator):
    bl_idname = "angen.sensor_clear"
    bl_label = "Clear Sensor"
    bl_description = "Make the active object an ordinary object again"
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(can_change_sensor)

    def execute(self, context: Context) -> set[str]:
        obj = stands_for(context.object)
        obj.angen_sensor.kind = NO_KIND
        self.report({"INFO"}, translated(f"'{obj.name}' is an ordinary object again"))
        return {"FINISHED"}


class ANGEN_MT_object_sensor(Menu):
    bl_idname = "ANGEN_MT_object_sensor"
    bl_label = "Sensor"

    def draw(self, context: Context) -> None:
        layout = self.layout
        for kind in KINDS.values():
            item = layout.operator(
                ANGEN_OT_sensor_assign.bl_idname, text=f"Make {kind.label}", icon=kind.icon
            )
            item.kind = kind.identifier
        layout.operator(ANGEN_OT_sensor_clear.bl_idname, icon="X")
        layout.separator()
        layout.operator("angen.copy_to_selected", icon="COPYDOWN")
        layout.operator("angen.door_fit", icon="SNAP_EDGE")


@translating
def draw_in_object_menu(self: Any, context: Context) -> None:
    self.layout.separator()
    self.layout.menu(ANGEN_MT_object_sensor.bl_idname, icon="OUTLINER_DATA_LIGHTPROBE")


_register, _unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_sensor_assign, ANGEN_OT_sensor_clear, ANGEN_MT_object_sensor)
)


def register() -> None:
    _register()
    bpy.types.VIEW3D_MT_object.append(draw_in_object_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(draw_in_object_menu)
    _unregister()
