# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel Live to MQTT: sends the readings at the playhead to a broker (sidebar)."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel

from ..angen_addon.appearance.panel_parts import ClosedSidebar, draw_lines
from ..angen_addon.output.mqtt.online import may_go_online
from ..operators import live_mqtt

OFFLINE = "Blender's online access is off. Switch it on: Preferences, System, Allow Online Access"


class ANGEN_PT_live_mqtt(ClosedSidebar, Panel):
    bl_label = "Live to MQTT"
    help_page = "home_assistant"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return live_mqtt.settings_of(context) is not None

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, live_mqtt.settings_of(context)
        layout.use_property_split, layout.use_property_decorate = True, False
        busy = live_mqtt.is_busy()
        column = layout.column()
        column.enabled = not busy
        column.prop(settings, "broker")
        column.prop(context.scene, "angen_topic")
        for name in ("user", "password", "tls"):
            column.prop(settings, name)
        if settings.tls:
            column.prop(settings, "authority")
        if not may_go_online():
            box = draw_lines(layout, OFFLINE, "ERROR")
            box.operator("screen.userpref_show", text="Preferences").section = "SYSTEM"
        if not busy:
            row = layout.row(align=True)
            row.operator("angen.mqtt_start", text="Start", icon="PLAY")
            row.operator("angen.mqtt_remove", text="Remove", icon="TRASH")
            text, icon = live_mqtt.outcome
            if text:
                draw_lines(layout, text, icon)
            return
        layout.operator("angen.mqtt_stop", text="Stop", icon="PAUSE")
        sender = live_mqtt.sender
        assert sender is not None
        draw_lines(layout, sender.state, "LINKED")
        scene = live_mqtt.sent_scene()
        if scene not in (None, context.scene):
            draw_lines(layout, f"The readings are those of scene '{scene.name}'", "INFO")


register, unregister = bpy.utils.register_classes_factory((ANGEN_PT_live_mqtt,))
