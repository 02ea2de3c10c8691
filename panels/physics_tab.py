# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel of the active object as a sensor, in the Physics tab of the Properties editor."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel

from ..angen_addon.appearance.help import draw_help
from ..angen_addon.appearance.panel_parts import Helped
from ..angen_addon.scene.instances import has_housing, stands_for
from ..angen_addon.scene.sensors import room_of
from .parameters import draw_sensor, sensor_of
from .presets import draw_presets


class ANGEN_PT_physics(Helped, Panel):
    bl_label = "Sensor"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None

    def draw_header(self, context: Context) -> None:
        sensor = sensor_of(stands_for(context.object))
        if sensor is not None:
            self.layout.prop(sensor.settings, "enabled", text="")

    def draw_header_preset(self, context: Context) -> None:
        draw_presets(self.layout, context)
        draw_help(self.layout, self.help_page)

    def draw(self, context: Context) -> None:
        layout, obj = self.layout, stands_for(context.object)
        if obj != context.object:
            layout.label(text=obj.name, icon="OBJECT_DATA", translate=False)
        column = layout.column()
        column.use_property_split = True
        column.prop(obj.angen_sensor, "kind")
        sensor = sensor_of(obj)
        if sensor is None:
            layout.prop(obj, "angen_ignored")
            if obj.angen_ignored:
                column.prop(obj.angen_sensor, "room", placeholder=room_of(obj))
        else:
            draw_sensor(layout, context, sensor)
            if has_housing(obj):
                layout.prop(sensor.settings, "housing_solid")


register, unregister = bpy.utils.register_classes_factory((ANGEN_PT_physics,))
