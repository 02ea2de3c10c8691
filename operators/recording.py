# SPDX-License-Identifier: GPL-3.0-or-later
"""Forgets the recording; and what operators ask of it before its results leave."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Event, Operator

from ..angen_addon.runtime import state

WAY_OUT = "Simulate again, or undo the change"


def why_not_fresh(scene: Any) -> str:
    """Why there is no recording of the scene as it is, with the way out; empty where there is."""
    kept = state.CACHE.kept(scene)
    if kept is None:
        return "Simulate first"
    return f"The recording is stale, {kept.stale}. {WAY_OUT}" if kept.stale else ""


def has_fresh_recording(operator: Any, context: Context) -> bool:
    """Whether there is a recording, of the scene as it is; sets the poll message."""
    why_not = why_not_fresh(context.scene)
    if why_not:
        operator.poll_message_set(why_not)
    return not why_not


def is_still_fresh(operator: Any, context: Context) -> bool:
    """The same after a look at everything: some changes Blender tells nobody of."""
    scene = context.scene
    kept = state.CACHE.kept(scene)
    assert kept is not None
    kept.verify(scene, context.evaluated_depsgraph_get())
    if kept.stale:
        operator.report({"ERROR"}, f"The recording is stale, {kept.stale}. {WAY_OUT}")
    return not kept.stale


# Modes in which undo goes back to what the scene was; in others, to what is edited there alone.
UNDONE_IN = {"OBJECT", "POSE"}


class ANGEN_OT_clear_recording(Operator):
    bl_idname = "angen.clear_recording"
    bl_label = "Clear Recording"
    bl_description = (
        "Forget what was recorded, in the file too; sensors follow the playhead again. "
        "Undo brings it back"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        if state.CACHE.running:
            cls.poll_message_set("A simulation is running")
            return False
        if state.CACHE.kept(context.scene) is None:
            cls.poll_message_set("Nothing is recorded")
            return False
        return True

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.mode in UNDONE_IN and context.preferences.edit.use_global_undo:
            return self.execute(context)
        # There is no way back.
        found: set[str] = context.window_manager.invoke_confirm(self, event)
        return found

    def execute(self, context: Context) -> set[str]:
        state.CACHE.clear_recording(context.scene)
        self.report({"INFO"}, "Recording cleared: sensors follow the playhead. Undo brings it back")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_clear_recording,))
