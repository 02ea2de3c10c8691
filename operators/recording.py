# SPDX-License-Identifier: GPL-3.0-or-later
"""Forgets the recording, so that sensors follow the playhead again."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..angen_addon import state


class ANGEN_OT_clear_recording(Operator):
    bl_idname = "angen.clear_recording"
    bl_label = "Clear Recording"
    bl_description = "Forget what was recorded; sensors follow the playhead again"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if state.CACHE.recording(context.scene) is None:
            cls.poll_message_set("Nothing is recorded")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        state.CACHE.drop_recording(context.scene)
        self.report({"INFO"}, "Recording cleared: sensors follow the playhead")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_clear_recording,))
