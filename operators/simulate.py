# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulates the sensors over a range of frames, with progress; Esc keeps what is done."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Operator

from ..angen_addon.advice import lacking
from ..angen_addon.progress import Doing, Enough
from ..angen_addon.recording.stored_recording import settings_of, stored_run
from ..angen_addon.runtime import state
from ..angen_addon.runtime.simulation import Progress, simulate
from ..angen_addon.runtime.time_base import ends_before_time, frames_to_run, outside_scene
from ..angen_addon.scene.sensors import all_sensors, simulated
from ..sensor_logic.error import AngenError
from ..sensor_logic.recording.tracks import Recording
from .long_work import LongWork
from .polls import is_idle, needs

SCENES_OWN = -(2**31)


class ANGEN_OT_simulate(LongWork, Operator):
    bl_idname = "angen.simulate"
    bl_label = "Simulate Sensors"
    bl_description = "Record the readings of all sensors over the frames. Esc keeps what is done"
    bl_options = {"REGISTER"}
    esc = "keeps what is done"

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

    _scene_uid = 0
    _recording: Recording
    _settings: dict[str, str]

    @classmethod
    def poll(cls, context: Context) -> bool:
        return is_idle(cls, context) and needs(
            cls, simulated(all_sensors(context.view_layer)), "Add a sensor first: Shift+A, Sensor"
        )

    def _begin(self, context: Context) -> Generator[Any, None, None]:
        scene = context.scene
        first, last = frames_to_run(scene)
        first = first if self.frame_start == SCENES_OWN else self.frame_start
        last = last if self.frame_end == SCENES_OWN else self.frame_end
        if first > last:
            raise AngenError(f"The first frame, {first}, is after the last, {last}")
        if last < scene.frame_start:
            raise AngenError(ends_before_time(scene, first, last))
        if text := outside_scene(scene, first, last):
            self.report({"INFO"}, text)
        first = max(first, scene.frame_start)
        self._recording = Recording()
        self._scene_uid = scene.session_uid
        sensors = all_sensors(context.view_layer)
        run = simulate(scene, sensors, first, last, self._recording)
        self._settings = settings_of(scene, sensors)
        return self._through(run)

    def _through(self, run: Generator[Progress, None, None]) -> Generator[Any, None, None]:
        """Simulates; yields Doing, and last whether Esc ended it."""
        early = False
        try:
            for now in run:
                text = f"frame {now.frame:g}" + (f", {now.doing}" if now.doing else "")
                # A slow step is shown when it begins.
                yield Doing(now.share, text, slow=bool(now.doing))
        except Enough:
            early = True
        except AngenError as error:
            # What was done before is kept.
            self.report({"ERROR"}, str(error))
        finally:
            run.close()
        yield early

    def _finish(self, context: Context, early: bool = False) -> set[str] | None:
        self._store(context, early)
        return None if self._updates() or early else {"CANCELLED"}

    def _store(self, context: Context, early: bool) -> None:
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

    def cancel(self, context: Context) -> None:
        self._close(context)
        self._store(context, early=False)


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_simulate,))
