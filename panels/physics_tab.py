# SPDX-License-Identifier: GPL-3.0-or-later
"""Physics tab of the Properties editor: the active object as a sensor."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel

from ..angen_addon.scene.sensors import room_of
from .parameters import draw_sensor, sensor_of
from .presets import draw_presets


class ANGEN_PT_physics(Panel):
    bl_label = "Sensor"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        if sensor_of(context.object):
            self.layout.prop(context.object.angen_sensor, "enabled", text="")

    def draw_header_preset(self, context: Context) -> None:
        draw_presets(self.layout, context)

    def draw(self, context: Context) -> None:
        layout = self.layout
        column = layout.column()
        column.use_property_split = True
        column.prop(context.object.angen_sensor, "kind")
        sensor = sensor_of(context.object)
        if sensor is None:
            layout.prop(context.object, "angen_ignored")
            if context.object.angen_ignored:
                column.prop(
                    context.object.angen_sensor, "room", placeholder=room_of(context.object)
                )
        else:
            draw_sensor(layout, context, sensor)


register, unregister = bpy.utils.register_classes_factory((ANGEN_PT_physics,))
