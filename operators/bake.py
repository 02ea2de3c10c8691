# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the recording as keyframes."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..angen_addon import bake, state
from ..angen_addon.sensors import all_sensors, simulated


class ANGEN_OT_bake_keyframes(Operator):
    bl_idname = "angen.bake_keyframes"
    bl_label = "Bake to Keyframes"
    bl_description = "Key the recorded outputs of every sensor, replacing earlier keys of them"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if state.CACHE.recording(context.scene) is None:
            cls.poll_message_set("Simulate first")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        recording = state.CACHE.recording(scene)
        assert recording is not None
        count = bake.bake(simulated(all_sensors(context.view_layer)), recording)
        # The new keys are no edit that voids the recording they were made from.
        context.view_layer.update()
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        state.CACHE.keep_recording(scene, recording)
        self.report({"INFO"}, f"{count} sensors keyed")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_bake_keyframes,))
