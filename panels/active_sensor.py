# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel of the active sensor, in the tab "Sensors" of the 3D view's sidebar."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel

from ..angen_addon.appearance.panel_parts import Sidebar
from ..angen_addon.view.active import active_sensor
from .instanced import draw_instanced
from .parameters import draw_sensor
from .presets import draw_choice


class ANGEN_PT_active_sensor(Sidebar, Panel):
    bl_label = "Active Sensor"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return active_sensor(context) is not None

    def draw_header(self, context: Context) -> None:
        sensor = active_sensor(context)
        if sensor is not None:
            self.layout.prop(sensor.settings, "enabled", text="")

    def draw(self, context: Context) -> None:
        sensor = active_sensor(context)
        if sensor is None:
            return
        # The icon shows the kind: both names would not fit.
        self.layout.label(text=sensor.name, icon=sensor.kind.icon, translate=False)
        if sensor.holders:
            draw_instanced(self.layout, sensor)
        else:
            draw_choice(self.layout, sensor)
        draw_sensor(self.layout, context, sensor)


register, unregister = bpy.utils.register_classes_factory((ANGEN_PT_active_sensor,))
