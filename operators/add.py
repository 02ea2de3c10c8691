# SPDX-License-Identifier: GPL-3.0-or-later
"""Shift+A, Sensor: a new sensor at the 3D cursor."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, Menu, Operator

from ..angen_addon.sensors import unit_scale
from ..sensor_logic.kinds import KINDS
from .marker import marker_mesh
from .preset import apply, find_preset

KIND_ITEMS = [(k.identifier, k.label, k.tip, k.icon, k.number) for k in KINDS.values()]


class ANGEN_OT_sensor_add(Operator):
    bl_idname = "angen.sensor_add"
    bl_label = "Add Sensor"
    bl_description = (
        "Add a sensor at the 3D cursor. It looks along its −Z axis with +Y up, as cameras do; "
        "a pressure sensor is a pad that lies there and feels what presses on its +Z side"
    )
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=KIND_ITEMS)
    preset: StringProperty(
        name="Preset", description="Identifier of a preset of the kind; empty: the defaults"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode to add a sensor")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        kind = KINDS[self.kind]
        try:
            preset = find_preset(kind, self.preset) if self.preset else None
        except KeyError as error:
            self.report({"ERROR"}, error.args[0])
            return {"CANCELLED"}
        mesh = marker_mesh(self.kind, unit_scale(context.scene))
        sensor = bpy.data.objects.new(kind.label.partition(" (")[0], mesh)
        sensor.matrix_world = context.scene.cursor.matrix
        sensor.angen_sensor.kind = self.kind
        if preset is not None:
            apply(sensor, preset)
        context.collection.objects.link(sensor)
        for selected in context.selected_objects:
            selected.select_set(False)
        sensor.select_set(True)
        context.view_layer.objects.active = sensor
        self.report({"INFO"}, f"Added '{sensor.name}' at the 3D cursor")
        return {"FINISHED"}


class ANGEN_MT_sensor_add(Menu):
    bl_idname = "ANGEN_MT_sensor_add"
    bl_label = "Sensor"

    def draw(self, context: Context) -> None:
        for kind in KINDS.values():
            add = self.layout.operator(
                ANGEN_OT_sensor_add.bl_idname, text=kind.label, icon=kind.icon
            )
            add.kind = kind.identifier


def draw_in_add_menu(self: Any, context: Context) -> None:
    self.layout.menu(ANGEN_MT_sensor_add.bl_idname, icon="OUTLINER_DATA_LIGHTPROBE")


_register, _unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_sensor_add, ANGEN_MT_sensor_add)
)


def register() -> None:
    _register()
    bpy.types.VIEW3D_MT_add.append(draw_in_add_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_add.remove(draw_in_add_menu)
    _unregister()
