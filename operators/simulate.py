# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulate the sensors over a range of frames, with progress; Esc keeps the simulated frames.

Frames that a recording already has are not simulated again, unless the scene has changed. If the
range only overlaps or adjoins the recording, the run covers both. It then begins at the first
frame, because hold times and noise start anew with each run. In a window the operator asks before
it replaces a recording that cannot be kept.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.props import BoolProperty, IntProperty
from bpy.types import Context, Event, Operator

from ..angen_addon.advice import lacking
from ..angen_addon.recording.references import REFERENCES
from ..angen_addon.recording.results import RESULTS
from ..angen_addon.recording.stored_recording import StoredRecording, settings_of, stored_run
from ..angen_addon.runtime.simulation import Progress, simulate
from ..angen_addon.runtime.time_base import ends_before_time, frames_to_run, outside_scene
from ..angen_addon.scene import outputs
from ..angen_addon.scene.sensors import Sensor, all_sensors, simulated
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kind import LIGHT
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.wording import capital
from ..sensor_logic.progress import Doing, Enough, Work
from ..sensor_logic.recording.tracks import Recording
from ..sensor_logic.recording.validity import not_valid, often_not_valid
from .long_work import LongWork
from .polls import cancelled, is_idle, needs
from .recording import can_undo

# Default of the frame properties: use the scene's frame.
FROM_SCENE = -(2**31)


@dataclass(frozen=True)
class RunPlan:
    """The frames and sensors to simulate.

    Attributes
    ----------
    first, last
        The first and the last frame.
    sensors
        The sensors to simulate.
    note
        A text for the operator's report.
    is_done
        Whether the recording already has these readings, so that nothing is simulated.
    question
        A text that says which recorded readings will be lost; empty if none will be.
    """

    first: int
    last: int
    sensors: Sequence[Sensor]
    note: str = ""
    is_done: bool = False
    question: str = ""


def plan_run(
    first: int, last: int, sensors: Sequence[Sensor], kept: StoredRecording | None
) -> RunPlan:
    """Return what to simulate for the `sensors` and the frames `first` to `last`.

    `kept` is the stored recording, or None.
    """
    if kept is None:
        return RunPlan(first, last, sensors)
    begin, end = kept.recording.frame_start, kept.recording.frame_end
    names, recorded = {sensor.name for sensor in sensors}, kept.recording.tracks.keys()
    is_around = first <= begin and end <= last
    new_frames, old_frames = f"frames {first} to {last}", f"frames {begin} to {end}"
    if kept.stale:
        is_lost, old_frames = end - begin > last - first, f"{old_frames}, and is stale"
    else:
        is_lost = not (is_around and recorded <= names)
        if is_lost and names <= recorded and begin <= first and last <= end:
            done = (
                f"Nothing has changed since {old_frames} were recorded: {new_frames} are "
                "not simulated again"
            )
            return RunPlan(
                first,
                last,
                sensors,
                f"{done}. To simulate them again, press Clear Recording first",
                is_done=True,
            )
        if is_lost and names == recorded and first <= end + 1 and begin <= last + 1:
            first, last = min(first, begin), max(last, end)
            note = f"To extend the recording, frames {first} to {last} are simulated"
            return RunPlan(first, last, sensors, note)
    if not is_lost:
        return RunPlan(first, last, sensors)
    new_text = f"{capital(new_frames)} replace it"
    if not recorded <= names:
        new_text = f"{capital(new_frames)}, without light sensors, replace it"
    question = f"{translated(f'The recording has {old_frames}')}.\n{translated(new_text)}"
    return RunPlan(first, last, sensors, question=question)


class ANGEN_OT_simulate(LongWork, Operator):
    bl_idname = "angen.simulate"
    bl_label = "Simulate"
    # REGISTER is left out: Blender would rerun the operator without progress.
    bl_options = {"UNDO"}
    esc = "Esc keeps what is done"

    frame_start: IntProperty(
        name="Start",
        description="First frame (default: that of the preview range, or the scene's)",
        default=FROM_SCENE,
    )
    frame_end: IntProperty(
        name="End",
        description="Last frame (default: that of the preview range, or the scene's)",
        default=FROM_SCENE,
    )
    without_light: BoolProperty(
        name="Without Light",
        description="Leave out light sensors, which take most of the time",
        options={"SKIP_SAVE"},
    )
    replace: BoolProperty(
        name="Replace",
        description="Replace a longer recording without a question",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    _is_confirming = False
    _planned: RunPlan
    _scene_uid = 0
    _recording: Recording
    _settings: dict[str, str]
    _references: dict[Any, Any]

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        return translated(
            "Record the readings of all sensors except light sensors over the frames. Esc keeps "
            "the frames that are done"
            if properties.without_light
            else "Record the readings of all sensors over the frames. Esc keeps the frames that "
            "are done"
        )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return is_idle(cls, context) and needs(
            cls, simulated(all_sensors(context.view_layer)), "Add a sensor first: Shift+A, Sensor"
        )

    def invoke(self, context: Context, event: Event) -> set[str]:
        try:
            plan = self._planned = self._plan(context)
        except AngenError as error:
            return cancelled(self, error)
        if plan.is_done:
            self.report({"INFO"}, translated(plan.note))
            # Nothing has changed: push no undo step.
            return {"CANCELLED"}
        if context.window is None or not plan.question or self.replace:
            return LongWork.invoke(self, context, event)
        self._is_confirming = True
        manager = context.window_manager
        texts = [plan.question]
        if can_undo(context):
            texts.append(translated("Undo brings it back"))
        found: set[str] = manager.invoke_confirm(
            self,
            event,
            title=translated("Replace the Recording?"),
            message=". ".join(texts),
            confirm_text=translated("Replace"),
            icon="WARNING",
        )
        return found

    def execute(self, context: Context) -> set[str]:
        if self._is_confirming:
            # The user has confirmed: invoke a new run, which shows progress.
            keys = "frame_start", "frame_end", "without_light"
            given = {key: getattr(self, key) for key in keys}
            bpy.ops.angen.simulate("INVOKE_DEFAULT", replace=True, **given)
            return {"CANCELLED"}
        try:
            self._planned = self._plan(context)
        except AngenError as error:
            return cancelled(self, error)
        if self._planned.is_done:
            self.report({"INFO"}, translated(self._planned.note))
            return {"FINISHED"}
        return LongWork.execute(self, context)

    def _plan(self, context: Context) -> RunPlan:
        """Return the plan for the operator's frames. Raise `AngenError` if they are invalid."""
        scene = context.scene
        first, last = frames_to_run(scene)
        first = first if self.frame_start == FROM_SCENE else self.frame_start
        last = last if self.frame_end == FROM_SCENE else self.frame_end
        if first > last:
            raise AngenError(f"The first frame, {first}, is after the last, {last}")
        if last < scene.frame_start:
            raise AngenError(ends_before_time(scene, first, last))
        if text := outside_scene(scene, first, last):
            self.report({"INFO"}, translated(text))
        sensors = simulated(all_sensors(context.view_layer))
        if self.without_light:
            sensors = [s for s in sensors if not s.kind.requires(LIGHT)]
            if not sensors:
                raise AngenError("There are only light sensors: press Simulate instead")
        kept = RESULTS.kept(scene)
        if kept is not None:
            kept.verify(scene, context.evaluated_depsgraph_get())
        return plan_run(max(first, scene.frame_start), last, sensors, kept)

    def _begin(self, context: Context) -> Work[bool]:
        scene, plan = context.scene, self._planned
        if plan.note:
            self.report({"INFO"}, translated(plan.note))
        self._recording = Recording()
        self._scene_uid = scene.session_uid
        self._references = {}
        if any(sensor.kind.requires(LIGHT) for sensor in plan.sensors):
            depsgraph = context.evaluated_depsgraph_get()
            self._references = REFERENCES.of(scene, depsgraph)
        what = scene, plan.sensors, plan.first, plan.last, self._recording
        run = simulate(*what, references=self._references)
        self._settings = settings_of(scene, all_sensors(context.view_layer), plan.sensors)
        return self._steps(run)

    def _steps(self, run: Generator[Progress, None, None]) -> Work[bool]:
        """Simulate, and return whether Esc ended the run."""
        early = False
        try:
            for now in run:
                text = f"frame {now.frame:g}"
                if now.doing:
                    text = f"frame {now.frame:g}, {now.doing}"
                # Show a slow step when it begins.
                yield Doing(now.share, text, slow=bool(now.doing))
        except Enough:
            # Esc may come after the last frame.
            early = self._recording.frame_end < self._planned.last
        except AngenError as error:
            # The frames that were simulated are kept.
            self.report({"ERROR"}, translated(str(error)))
        finally:
            run.close()
        return early

    def _finish(self, context: Context, early: bool = False) -> set[str] | None:
        return None if self._store(context, early) else {"CANCELLED"}

    def _store(self, context: Context, early: bool) -> bool:
        """Store the recording and show its readings; return whether the recording was stored.

        `early` says whether Esc ended the run.
        """
        scene = context.scene
        # A script may have switched to another scene, to which the recording does not belong.
        if scene is None or scene.session_uid != self._scene_uid:
            return False
        if (early or not self._has_a_frame()) and self._keeps_earlier(scene):
            return False
        if not self._updates():
            self.report(
                {"INFO"}, translated(f"No sensor was on in these frames: {self._stays(scene)}")
            )
            return False
        frame = scene.frame_current + scene.frame_subframe
        if self._recording.covers(frame):
            outputs.show_recorded(self._recording, all_sensors(context.view_layer), frame)
            # Update drivers now: a later update would make the recording stale.
            context.view_layer.update()
        lacking.look(context.view_layer)
        depsgraph = context.evaluated_depsgraph_get()
        stored = stored_run(self._recording, scene, depsgraph)
        stored.note_begin(self._settings)
        if not stored.stale:
            REFERENCES.keep(scene, depsgraph, stored.fingerprint, self._references)
        former = RESULTS.kept(scene)
        RESULTS.keep(scene, stored)
        first, last = self._recording.frame_start, self._recording.frame_end
        text = f"Recorded frames {first} to {last}: {self._updates()} updates"
        if self.without_light:
            text = f"{text}. Light sensors are not recorded"
        if early:
            text = f"Stopped. {text}"
        if former is not None:
            begin, end = former.recording.frame_start, former.recording.frame_end
            if can_undo(context) and (begin < first or last < end):
                text += f". Undo brings back frames {begin} to {end}"
        self.report({"INFO"}, translated(text))
        for text in often_not_valid(not_valid(self._recording.tracks.values())):
            self.report({"WARNING"}, translated(text))
        return True

    def _has_a_frame(self) -> bool:
        return self._recording.frame_end >= self._recording.frame_start

    def _keeps_earlier(self, scene: Any) -> bool:
        """Return whether to keep the earlier recording, instead of a run that Esc ended.

        Keep it if no frame was simulated. Also keep it if it matches the scene and has all readings
        of the run.
        """
        first, last = self._recording.frame_start, self._recording.frame_end
        earlier = RESULTS.recording(scene)
        holds = (
            earlier is not None
            and earlier.covers(first)
            and earlier.covers(last)
            and self._recording.tracks.keys() <= earlier.tracks.keys()
        )
        if self._has_a_frame() and not holds:
            return False
        stays = self._stays(scene)
        if holds and earlier is not None:
            stays = f"frames {earlier.frame_start} to {earlier.frame_end} stay recorded"
        text = f"Stopped: {stays}"
        if not self._has_a_frame():
            text = f"Stopped before the first frame was done: {stays}"
        self.report({"INFO"}, translated(text))
        return True

    def _stays(self, scene: Any) -> str:
        """Return what is recorded if the run is not."""
        is_recorded = RESULTS.kept(scene) is not None
        return "the earlier recording stays" if is_recorded else "nothing is recorded"

    def _updates(self) -> int:
        """Return the number of updates in the new recording."""
        return sum(len(track) for track in self._recording.tracks.values())

    def cancel(self, context: Context) -> None:
        """Store the simulated frames. Blender calls this when it ends the operator itself.

        Blender also calls it when the user cancels the question, before anything is simulated.
        """
        is_running = self._timer is not None
        self._close(context)
        if is_running:
            self._store(context, early=False)


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_simulate,))
