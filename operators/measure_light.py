# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the light at the current frame without a simulation; Esc cancels."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..angen_addon.runtime.live import live_of
from ..angen_addon.runtime.playhead import fresh_recording
from ..angen_addon.scene.sensors import Sensor, all_sensors, simulated
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.active import active_sensor
from ..sensor_logic.logs.wording import listed
from ..sensor_logic.progress import Work
from .long_work import LongWork
from .polls import can_read_scene, needs


def light_sensors(context: Context) -> list[Sensor]:
    """Return the light sensors that are selected, and the active one."""
    active = active_sensor(context)
    handle = active.handle if active is not None else None
    found = simulated(all_sensors(context.view_layer))
    return [s for s in found if s.kind.requires_light and (s.selected or s.handle == handle)]


class ANGEN_OT_measure_light(LongWork, Operator):
    bl_idname = "angen.measure_light"
    bl_label = "Measure Now"
    bl_description = (
        "Measure the light at this frame with the active and the selected light sensors. "
        "Esc cancels"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        active, scene = active_sensor(context), context.scene
        is_light = active is not None and active.kind.requires_light
        return (
            can_read_scene(cls, context)
            and needs(cls, is_light, "Select a light sensor")
            and needs(cls, scene.angen_live, "Live is off: switch it on to see values")
            and needs(cls, fresh_recording(scene) is None, "The light of this frame is recorded")
        )

    def _begin(self, context: Context) -> Work[int]:
        self._names = [sensor.name for sensor in light_sensors(context)]
        live = live_of(context.scene)
        return live.measure_now(context.scene, context.view_layer, light_sensors(context))

    def _finish(self, context: Context, result: int) -> None:
        frame = context.scene.frame_current
        self.report(
            {"INFO"}, translated(f"Light measured at frame {frame}: {listed(self._names, 3)}")[:200]
        )


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_measure_light,))
