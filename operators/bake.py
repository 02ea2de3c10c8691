# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the recording as keyframes."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..angen_addon import bake, state
from ..angen_addon.sensors import all_sensors, simulated
from .recording import has_fresh_recording, is_still_fresh


class ANGEN_OT_bake_keyframes(Operator):
    bl_idname = "angen.bake_keyframes"
    bl_label = "Bake to Keyframes"
    bl_description = "Key the recorded outputs of every sensor, replacing earlier keys of them"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_fresh_recording(cls, context)

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        if not is_still_fresh(self, context):
            return {"CANCELLED"}
        recording = state.CACHE.recording(scene)
        assert recording is not None
        baked = bake.bake(simulated(all_sensors(context.view_layer)), recording)
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        for note in baked.notes:
            self.report({"WARNING"}, note)
        if not baked.count:
            self.report({"ERROR"}, "No sensor could be keyed")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{baked.count} sensors keyed")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_bake_keyframes,))
