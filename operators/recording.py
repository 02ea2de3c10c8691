# SPDX-License-Identifier: GPL-3.0-or-later
"""Clear the recording. Other operators check here whether the recording matches the scene."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Event, Operator

from ..angen_addon.recording.results import RESULTS
from ..angen_addon.translations.interface import translated
from .polls import is_idle, needs

WAY_OUT = "Simulate again, or undo the change"


def why_not_fresh(scene: Any) -> str:
    """Return why no recording matches the scene, and what the user can do; empty if one does."""
    kept = RESULTS.kept(scene)
    if kept is None:
        return "Simulate first"
    return f"The recording is stale, {kept.stale}. {WAY_OUT}" if kept.stale else ""


def has_fresh_recording(operator: Any, context: Context) -> bool:
    """Poll: whether there is a recording, and Blender reported no edit of the scene since."""
    why_not = why_not_fresh(context.scene)
    return needs(operator, not why_not, why_not)


def is_still_fresh(operator: Any, context: Context) -> bool:
    """Return whether the recording matches the scene; if it does not, report an error.

    This compares the whole scene, because Blender does not report all edits.
    """
    scene = context.scene
    kept = RESULTS.kept(scene)
    assert kept is not None
    kept.verify(scene, context.evaluated_depsgraph_get())
    if kept.stale:
        operator.report({"ERROR"}, translated(why_not_fresh(scene)))
    return not kept.stale


# Modes whose undo steps restore the scene. Other modes restore only the edited data.
UNDONE_IN = {"OBJECT", "POSE"}


def can_undo(context: Context) -> bool:
    """Return whether Undo would restore a cleared recording in the current mode."""
    return context.mode in UNDONE_IN and bool(context.preferences.edit.use_global_undo)


class ANGEN_OT_clear_recording(Operator):
    bl_idname = "angen.clear_recording"
    bl_label = "Clear Recording"
    bl_description = (
        "Delete the recording, also from the file; sensors follow the playhead again. "
        "Undo brings it back"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return is_idle(cls, context) and needs(
            cls, RESULTS.kept(context.scene) is not None, "There is no recording"
        )

    def invoke(self, context: Context, event: Event) -> set[str]:
        if can_undo(context):
            return self.execute(context)
        # Undo cannot restore the recording: ask first.
        found: set[str] = context.window_manager.invoke_confirm(self, event)
        return found

    def execute(self, context: Context) -> set[str]:
        RESULTS.clear_recording(context.scene)
        self.report(
            {"INFO"},
            translated("Recording cleared: sensors follow the playhead. Undo brings it back"),
        )
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_clear_recording,))
