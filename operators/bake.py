# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the recording to keyframes, and remove baked keyframes."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty
from bpy.types import Context, Operator

from ..angen_addon.recording import bake
from ..angen_addon.recording.results import RESULTS
from ..angen_addon.scene.instances import stands_for
from ..angen_addon.scene.sensors import all_sensors, simulated
from ..angen_addon.translations.interface import translated
from ..sensor_logic.logs.wording import plural
from .polls import cancelled, needs
from .recording import has_fresh_recording, is_still_fresh


class ANGEN_OT_bake_keyframes(Operator):
    bl_idname = "angen.bake_keyframes"
    bl_label = "Bake to Keyframes"
    bl_description = (
        "Write the recorded outputs of every sensor as keyframes, replacing earlier ones"
    )
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(has_fresh_recording)

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        if not is_still_fresh(self, context):
            return {"CANCELLED"}
        recording = RESULTS.recording(scene)
        assert recording is not None
        baked = bake.bake(simulated(all_sensors(context.view_layer)), recording, scene)
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        for note in baked.notes:
            self.report({"WARNING"}, translated(note))
        if not baked.count:
            return cancelled(self, "No sensor could get keyframes")
        self.report({"INFO"}, translated(f"Baked the outputs of {plural(baked.count, 'sensor')}"))
        return {"FINISHED"}


class ANGEN_OT_unbake_keyframes(Operator):
    bl_idname = "angen.unbake_keyframes"
    bl_label = "Unbake"
    bl_description = (
        "Remove the keyframes of the sensors' outputs, so that drivers read recorded or live values"
    )
    bl_options = {"REGISTER", "UNDO"}

    selected: BoolProperty(
        name="Selected", description="Unbake only the selected and active sensors"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls,
            any(map(bake.is_baked, all_sensors(context.view_layer))),
            "No sensor has baked keyframes",
        )

    def execute(self, context: Context) -> set[str]:
        scene, active = context.scene, stands_for(context.view_layer.objects.active)
        sensors = [
            sensor
            for sensor in all_sensors(context.view_layer)
            if not self.selected or sensor.object == active or sensor.object.select_get()
        ]
        unbaked = bake.unbake(sensors)
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        for note in unbaked.notes:
            self.report({"WARNING"}, translated(note))
        if not unbaked.count:
            return cancelled(self, "No selected sensor has baked keyframes that can be removed")
        many = plural(unbaked.count, "sensor")
        self.report(
            {"INFO"},
            translated(f"Removed the keyframes of {many}: drivers read recorded or live values"),
        )
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_bake_keyframes, ANGEN_OT_unbake_keyframes)
)
