# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates the sensors over a range of frames, with progress; Esc keeps what is done."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Event, Operator

from ..angen_addon.advice import lacking
from ..angen_addon.commands.home import TimeLeft
from ..angen_addon.recording.stored_recording import settings_of, stored_run
from ..angen_addon.runtime import state
from ..angen_addon.runtime.simulation import Progress, simulate
from ..angen_addon.runtime.time_base import ends_before_time, frames_to_run, outside_scene
from ..angen_addon.scene.sensors import all_sensors, simulated
from ..sensor_logic.error import AngenError
from ..sensor_logic.recording.tracks import Recording
from .polls import is_idle, needs

SCENES_OWN = -(2**31)
# s: a slice is so long that Blender redraws a few times a second, and short enough for Esc.
LEAST, MOST = 0.25, 0.75
# A slice lasts this many times as long as Blender's last redraw, which so costs a tenth.
TIMES = 9.0


class Slices:
    """Chooses the length of slices by the time of Blender's redraws: each step of a run changes the
    scene, so that each redraw evaluates and draws everything."""

    def __init__(self) -> None:
        self._ended: float | None = None

    def begin(self) -> float:
        """Begins a slice; returns its end by `time.perf_counter`."""
        now = time.perf_counter()
        away = now - self._ended if self._ended is not None else 0.0
        return now + min(max(away * TIMES, LEAST), MOST)

    def end(self) -> None:
        """Ends a slice, once its work is done."""
        self._ended = time.perf_counter()


class ANGEN_OT_simulate(Operator):
    bl_idname = "angen.simulate"
    bl_label = "Simulate Sensors"
    bl_description = "Record the readings of all sensors over the frames. Esc keeps what is done"
    bl_options = {"REGISTER"}

    frame_start: IntProperty(
        name="Start",
        description="First frame (default: that of the preview range, or the scene's)",
        default=SCENES_OWN,
    )
    frame_end: IntProperty(
        name="End",
        description="Last frame (default: that of the preview range, or the scene's)",
        default=SCENES_OWN,
    )

    _run: Iterator[Progress]
    _scene_uid = 0
    _recording: Recording
    _settings: dict[str, str]
    _timer: Any = None
    _slices: Slices
    _left: TimeLeft

    @classmethod
    def poll(cls, context: Context) -> bool:
        return is_idle(cls, context) and needs(
            cls, simulated(all_sensors(context.view_layer)), "Add a sensor first: Shift+A, Sensor"
        )

    def _begin(self, context: Context) -> bool:
        scene = context.scene
        first, last = frames_to_run(scene)
        first = first if self.frame_start == SCENES_OWN else self.frame_start
        last = last if self.frame_end == SCENES_OWN else self.frame_end
        if first > last:
            self.report({"ERROR"}, f"The first frame, {first}, is after the last, {last}")
            return False
        if last < scene.frame_start:
            self.report({"ERROR"}, ends_before_time(scene, first, last))
            return False
        if text := outside_scene(scene, first, last):
            self.report({"INFO"}, text)
        first = max(first, scene.frame_start)
        self._recording = Recording()
        self._scene_uid = scene.session_uid
        try:
            sensors = all_sensors(context.view_layer)
            self._run = simulate(scene, sensors, first, last, self._recording)
            self._settings = settings_of(scene, sensors)
        except AngenError as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def _end(self, context: Context, early: bool = False) -> None:
        """Stores the recording, if there is any, and shows it at the playhead."""
        scene = context.scene
        # A script may have changed the scene meanwhile: the recording is not of that one.
        if not self._updates() or scene is None or scene.session_uid != self._scene_uid:
            return
        if (early or not self._has_a_frame()) and self._leaves_as_is(scene):
            return
        frame = scene.frame_current + scene.frame_subframe
        if self._recording.covers(frame):
            state.show_recorded(self._recording, all_sensors(context.view_layer), frame)
            # An update of drivers is no edit that makes the recording stale.
            context.view_layer.update()
        lacking.look(context.view_layer)
        depsgraph = context.evaluated_depsgraph_get()
        stored = stored_run(self._recording, scene, depsgraph)
        stored.note_begin(self._settings)
        state.CACHE.keep(scene, stored)
        first, last = self._recording.frame_start, self._recording.frame_end
        how = "Stopped, and recorded" if early else "Recorded"
        self.report({"INFO"}, f"{how} frames {first} to {last}: {self._updates()} updates")

    def _has_a_frame(self) -> bool:
        return self._recording.frame_end >= self._recording.frame_start

    def _leaves_as_is(self, scene: Any) -> bool:
        """Whether the earlier recording stays after Esc: no frame is done, or it is fresh and has
        all of the new frames."""
        first, last = self._recording.frame_start, self._recording.frame_end
        earlier = state.CACHE.recording(scene)
        holds = earlier is not None and earlier.covers(first) and earlier.covers(last)
        if self._has_a_frame() and not holds:
            return False
        stays = "nothing is recorded" if state.CACHE.kept(scene) is None else "what was stays"
        if holds and earlier is not None:
            stays = f"frames {earlier.frame_start} to {earlier.frame_end} stay recorded"
        done = "" if self._has_a_frame() else " before the first frame was done"
        self.report({"INFO"}, f"Stopped{done}: {stays}")
        return True

    def _updates(self) -> int:
        return sum(len(track) for track in self._recording.tracks.values())

    def execute(self, context: Context) -> set[str]:
        if not self._begin(context):
            return {"CANCELLED"}
        try:
            for _ in self._run:
                pass
        except AngenError as error:
            self.report({"ERROR"}, str(error))
        self._end(context)
        return {"FINISHED"} if self._updates() else {"CANCELLED"}

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.window is None:
            return self.execute(context)
        if not self._begin(context):
            return {"CANCELLED"}
        self._slices, self._left = Slices(), TimeLeft()
        manager = context.window_manager
        manager.progress_begin(0, 100)
        state.CACHE.progress = 0.0
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "ESC":
            self._stop(context, early=True)
            return {"FINISHED"}
        if event.type != "TIMER":
            # The scene is being stepped through: edits now would end up in the recording.
            return {"RUNNING_MODAL"}
        try:
            progress = self._advance()
        except BaseException as error:
            self._stop(context)
            if not isinstance(error, AngenError):
                raise
            self.report({"ERROR"}, str(error))
            return {"FINISHED"}
        if progress is None:
            self._stop(context)
            return {"FINISHED"}
        share = 100 * progress.seconds_done / max(progress.seconds_total, 1e-9)
        context.window_manager.progress_update(share)
        state.CACHE.progress = share / 100
        left = self._left.text()
        context.workspace.status_text_set(
            f"Simulating sensors: frame {progress.frame:g}, {share:.0f} %"
            f"{', ' if left else ''}{left}{', ' if progress.doing else ''}{progress.doing}"
            ". Esc keeps what is done"
        )
        return {"RUNNING_MODAL"}

    def _advance(self) -> Progress | None:
        """Simulates for a slice of time; returns None at the end. Raises AngenError."""
        until = self._slices.begin()
        for progress in self._run:
            self._left.note(progress)
            # A slow step is shown when it begins.
            if progress.doing or time.perf_counter() >= until:
                self._slices.end()
                return progress
        return None

    def _stop(self, context: Context, early: bool = False) -> None:
        self._run.close()  # type: ignore[attr-defined]
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        self._end(context, early)

    def cancel(self, context: Context) -> None:
        self._stop(context)


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_simulate,))
