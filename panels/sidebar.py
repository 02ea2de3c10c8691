# SPDX-License-Identifier: GPL-3.0-or-later
"""Sidebar tab "Sensors" of the 3D view: simulate, read, and the active sensor."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel, Scene, UILayout

from ..angen_addon import state
from .lines import draw_lines
from .parameters import draw_sensor, sensor_of
from .presets import draw_presets


class _Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sensors"


class ANGEN_PT_simulation(_Sidebar, Panel):
    bl_label = "Simulation"

    def draw(self, context: Context) -> None:
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.operator_context = "INVOKE_DEFAULT"
        layout.operator("angen.simulate", icon="PLAY")
        draw_recording(layout, scene)
        row = layout.row(align=True)
        row.operator("angen.export_events", text="Events", icon="EXPORT")
        row.operator("angen.export_samples", text="Samples", icon="EXPORT")
        row.operator("angen.export_report", text="Report", icon="EXPORT")
        row = layout.row(align=True)
        row.operator("angen.bake_keyframes", icon="KEYFRAME_HLT")
        row.operator("angen.clear_recording", text="", icon="TRASH")
        column = layout.column()
        column.prop(scene, "angen_live")
        column.prop(scene, "angen_substeps")
        column.prop(scene, "angen_seed")
        column.prop(scene, "angen_luminous_efficacy")
        column.prop(scene, "angen_ray_caster")


def draw_recording(layout: UILayout, scene: Scene) -> None:
    """Whether there is a recording, and whether it still holds."""
    kept = state.CACHE.kept(scene)
    if state.CACHE.running:
        layout.label(text="Simulating: Esc keeps what is done", icon="TIME")
    elif kept is None:
        layout.label(text="Not recorded: live values", icon="INFO")
    elif kept.stale:
        text = f"Recording is stale, {kept.stale}. Values are live. Simulate again, or undo"
        draw_lines(layout, text, "ERROR")
    else:
        recording = kept.recording
        text = f"Recorded: frames {recording.frame_start} to {recording.frame_end}"
        layout.label(text=text, icon="CHECKMARK")
    if state.CACHE.notice:
        draw_lines(layout, state.CACHE.notice, "ERROR")


class ANGEN_PT_active_sensor(_Sidebar, Panel):
    bl_label = "Active Sensor"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return sensor_of(context.object) is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.object.angen_sensor, "enabled", text="")

    def draw_header_preset(self, context: Context) -> None:
        draw_presets(self.layout, context)

    def draw(self, context: Context) -> None:
        sensor = sensor_of(context.object)
        if sensor is None:
            return
        self.layout.label(text=f"{sensor.name}: {sensor.kind.label}", icon=sensor.kind.icon)
        draw_sensor(self.layout, context, sensor)


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_PT_simulation, ANGEN_PT_active_sensor)
)
