# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain the active sensor's last event before the playhead, or its reading at the playhead."""

from __future__ import annotations

from dataclasses import replace

import bpy
from bpy.props import BoolProperty
from bpy.types import Context, Operator

from ..angen_addon.explain.explain import MEMORY, explain
from ..angen_addon.recording.results import RESULTS
from ..angen_addon.runtime.time_base import clock_of
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.active import active_sensor
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.recording.events import log_indices
from ..sensor_logic.recording.tracks import Track
from .event_jump import has_recorded_track, recorded_track
from .polls import cancelled


def event_at(track: Track, frame: float) -> int | None:
    """Return the index of the last event of a track at or before `frame`; None if there is none."""
    found = [i for i in log_indices(track).tolist() if track.frames[i] <= frame + 1e-4]
    return found[-1] if found else None


class ANGEN_OT_explain(Operator):
    bl_idname = "angen.explain"
    bl_label = "Explain"
    bl_description = (
        "Find which object made the active sensor report its last event at or before the playhead, "
        "and by how much"
    )
    bl_options = {"REGISTER"}

    now: BoolProperty(
        name="Now",
        description="Explain the reading at the playhead instead of the last event, or what would "
        "have to change for an event",
    )

    poll = classmethod(has_recorded_track)

    def execute(self, context: Context) -> set[str]:
        scene, found, sensor = context.scene, recorded_track(context), active_sensor(context)
        assert found is not None and sensor is not None
        recording, track = found
        if recording.clock != clock_of(scene):
            return cancelled(self, "The scene's frame rate or start has changed: simulate again")
        frame = scene.frame_current + scene.frame_subframe
        index = track.at(frame + 1e-4) if self.now else event_at(track, frame)
        if index is None:
            first = track.frames[0]
            self.report(
                {"INFO"}, translated(f"No event yet: the recording starts at frame {first:g}")
            )
            return {"CANCELLED"}
        try:
            explanation = explain(scene, sensor, recording, index)
        except AngenError as error:
            return cancelled(self, error)
        kept = RESULTS.kept(scene)
        if kept is not None and kept.stale and not explanation.doubt:
            doubt = f"the recording is stale ({kept.stale}): simulate again"
            explanation = replace(explanation, doubt=doubt)
        MEMORY.keep(recording, sensor.uid, explanation)
        self.report({"WARNING" if explanation.doubt else "INFO"}, translated(explanation.headline))
        return {"FINISHED"}


def unregister() -> None:
    MEMORY.clear()
    bpy.utils.unregister_class(ANGEN_OT_explain)


def register() -> None:
    bpy.utils.register_class(ANGEN_OT_explain)
