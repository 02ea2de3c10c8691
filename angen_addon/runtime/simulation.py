# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulation of sensors over a range of frames, for the operator, the command line and tests.

The run evaluates successive frames, and stores them as a batch. The sensors then sense all frames
of the batch at once, and their readings are recorded. The run is a generator. At each yield, its
caller can stop it or edit the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.clock import Clock
from ...sensor_logic.logs.error import AngenError, explained
from ...sensor_logic.model import Index
from ...sensor_logic.recording.tracks import Recording, Track
from ..scene import outputs
from ..scene.sensors import Sensor, all_sensors, check, check_names, report_steps, simulated
from . import handlers, stillness
from .moving_scene import MovingScene, moving_scene
from .running import publishing, running
from .sensor_runner import PendingUpdates, SensorRunner
from .stage import Agenda, Stage
from .time_base import clock_of, evaluated_depsgraph

# A light path in the picture of one update takes as long as this many light paths of a light
# reference.
COST_OF_FEW = 2


@dataclass(frozen=True)
class Progress:
    """The progress of a run.

    Attributes
    ----------
    seconds_done, seconds_total
        The time simulated so far, and the time to simulate in the whole run, in seconds.
    frame
        The last frame that the sensors have sensed.
    doing
        A text on slow work at this frame, such as rendering; empty without such work.
    steps
        The number of steps so far.
    evaluated
        The number of steps so far at which the scene was evaluated. At the others nothing changed.
    moving
        A text on why the scene must be evaluated at every step; empty if steps can be skipped.
    reference
        The part of the run's work that goes into the light references, from 0 to 1. These are
        pictures with many light paths, by which noisy readings are corrected.
    reference_done
        The part of the light references that is computed so far, from 0 to 1.
    """

    seconds_done: float
    seconds_total: float
    frame: float
    doing: str = ""
    steps: int = 0
    evaluated: int = 0
    moving: str = ""
    reference: float = 0.0
    reference_done: float = 0.0

    @property
    def share(self) -> float:
        """The part of the run's work that is done, from 0 to 1."""
        frames = self.seconds_done / max(self.seconds_total, 1e-9)
        return self.reference * self.reference_done + (1.0 - self.reference) * frames


@dataclass(frozen=True)
class Exchange:
    """A replacement of keyframes during a run, for animation too long to be in the scene at once.

    Just before the run evaluates frame `frame`, it calls the function `put`, which replaces the
    keyframes. The old and the new keyframes must give the same scene at the frame before.
    """

    frame: int
    put: Callable[[], object]


def simulate(
    scene: Any,
    sensors: Sequence[Sensor],
    frame_start: int,
    frame_end: int,
    recording: Recording,
    exchanges: Sequence[Exchange] = (),
    clock: Clock | None = None,
    references: dict[Any, Any] | None = None,
) -> Generator[Progress, None, None]:
    """Simulate a range of frames, add the readings to a recording, and yield the progress.

    At the end, the scene returns to its former frame. This also happens after an error, or if the
    generator is closed early; the recording then has the readings up to that point. If drivers read
    the outputs of other sensors, these sensors are simulated too, but not recorded.

    Parameters
    ----------
    scene
        The scene to simulate; it must be the scene of the present context.
    sensors
        The sensors to record; those that are switched off are left out.
    frame_start, frame_end
        The first and the last frame.
    recording
        The recording to fill.
    exchanges
        Replacements of keyframes during the run, at frames after `frame_start`: see `Exchange`.
    clock
        The time base; by default the scene's.
    references
        Light references of an earlier run of the same scene, to which the run adds its own. They
        are pictures with many light paths, by which noisy readings are corrected.

    Raises
    ------
    AngenError
        If a sensor cannot be simulated.
    """
    sensors = simulated(sensors)
    check_names(sensors)
    simulated_sensors = [*sensors, *unrecorded(sensors)]
    for sensor in simulated_sensors:
        check(sensor)
    clock = clock or clock_of(scene)
    first, last = clock.first_step(frame_start), clock.first_step(frame_end + 1) - 1
    runners = [SensorRunner(sensor, clock) for sensor in simulated_sensors]
    for runner in runners:
        runner.recall(first)
    recording.frame_start, recording.frame_end = frame_start, frame_start - 1
    for sensor in sensors:
        kind, steps = sensor.kind.identifier, report_steps(sensor)
        warm_up = float(getattr(sensor.parameters, "warm_up_time", 0.0))
        recording.tracks[sensor.name] = Track(sensor.name, kind, sensor.uid, steps, clock, warm_up)
    recording.clock = clock
    run = _Run(scene, runners, first, last, frame_end, recording, exchanges)
    run.references = references
    return run.run()


def unrecorded(sensors: Sequence[Sensor]) -> list[Sensor]:
    """Return the sensors of the scene whose outputs drivers read, and that are not in `sensors`.

    Through such a driver, the output of a sensor can change the scene and the readings of
    `sensors`.
    """
    given = {sensor.uid for sensor in sensors}
    others = simulated(all_sensors(bpy.context.view_layer))
    return [s for s in outputs.read_by_drivers(others) if s.uid not in given]


class _Run:
    """A run of the sensors of a scene from step `first` to `last`.

    In its methods, `alone` says that no other code has frame handlers, and `driven` that drivers
    read outputs. `batches` says that frames can be stored, and sensed later.
    """

    def __init__(
        self,
        scene: Any,
        runners: list[SensorRunner],
        first: int,
        last: int,
        frame_end: int,
        recording: Recording,
        exchanges: Sequence[Exchange],
    ) -> None:
        self._scene, self._runners = scene, runners
        self._first, self._last, self._frame_end = first, last, frame_end
        assert recording.clock is not None
        self._clock = recording.clock
        self._recording = recording
        self._exchanges = {self._clock.first_step(e.frame): e for e in exchanges}
        self._still = stillness.Stillness(stillness.NEVER)
        self._moving_scene: MovingScene | None = None
        self._stored: set[str] = set()
        self._steps = self._evaluated = 0
        self._moving = ""
        self.references: dict[Any, Any] | None = None
        self._reference, self._reference_done = self._share_of_reference(), 0.0

    def run(self) -> Generator[Progress, None, None]:
        scene = self._scene
        handlers.restore_handlers()
        # Other code may change the scene at a frame in ways that Blender does not report.
        alone = not handlers.has_other_frame_handlers()
        removed = explained(
            "the run ended early, because an object or scene that it needs was removed",
            ReferenceError,
            raised=AngenError,
        )
        with running(), _same_frame_after(scene):
            with removed, _idle_outputs(self._runners) as driven:
                agenda = Agenda(scene, self._runners, self._clock, self._first, self._last)
                batches = alone and not driven and agenda.allows_batches
                self._stored = agenda.stored
                try:
                    self._find_what_moves(self._frame(self._first), alone, batches)
                    stage = Stage(scene, self._runners, batches, self._moving_scene)
                    if self.references is not None and alone and not driven:
                        stage.probes.recall_light(self.references)
                    try:
                        yield from self._over_frames(stage, agenda, alone, driven, batches)
                    finally:
                        stage.close()
                finally:
                    self._close_moving_scene()
            self._recording.frame_end = self._frame_end

    def _find_what_moves(self, frame: int, alone: bool, batches: bool) -> None:
        """Find at which frames the scene can change, and make the scene of moving objects."""
        needs = {need for runner in self._runners for need in runner.sensor.kind.needs}
        still = self._still = stillness.find_stillness(self._scene, needs, not alone)
        self._moving = still.why
        if batches:
            what = self._scene, self._runners, self._stored
            self._moving_scene = moving_scene(*what, still, frame)

    def _close_moving_scene(self) -> None:
        moving, self._moving_scene = self._moving_scene, None
        if moving is not None:
            moving.close()

    def _exchange(self, exchange: Exchange, stage: Stage, alone: bool, batches: bool) -> None:
        self._close_moving_scene()
        exchange.put()
        # A pending edit must not count as a change by the frame.
        evaluated_depsgraph()
        self._find_what_moves(exchange.frame, alone, batches)
        stage.begin_anew(self._moving_scene)

    def _resume(self, step: int, stage: Stage, alone: bool, batches: bool) -> None:
        """Prepare the stage after a yield at a step, since the caller may have edited the scene."""
        if stage.resume():
            self._close_moving_scene()
            self._find_what_moves(self._frame(step), alone, batches)
            stage.evaluate(step)
            stage.begin_anew(self._moving_scene)

    def _over_frames(
        self, stage: Stage, agenda: Agenda, alone: bool, driven: bool, batches: bool
    ) -> Iterator[Progress]:
        for window in agenda.windows(self._exchanges):
            exchange = self._exchanges.get(window.begin)
            if exchange is not None:
                self._exchange(exchange, stage, alone, batches)
            fresh = agenda.fresh(window, self._still)
            try:
                for steps, is_fresh in _group_unchanged(window.steps, fresh):
                    step = steps[-1]
                    self._steps += len(steps)
                    self._evaluated += is_fresh
                    if bpy.context.scene.session_uid != self._scene.session_uid:
                        raise AngenError(
                            "the run ended early, because the window shows another scene"
                        )
                    for ready in stage.visit(window, steps, is_fresh):
                        self._record(ready, driven)
                    for doing in stage.measure(alone):
                        if not doing and not stage.is_due:
                            continue
                        # The caller may undo, so no captured frame may be left.
                        for ready in stage.sense(window, evaluated_depsgraph()):
                            self._record(ready, driven)
                        self._evaluate_drivers(driven)
                        self._note_reference(stage.probes.reference_done)
                        yield self._at(step, doing)
                    for measured in stage.take_light_updates():
                        self._note_reference(1.0)
                        self._record(measured, driven)
                    if stage.has_sensed_all:
                        # The caller may change the scene, so no captured frame may be left.
                        self._recording.frame_end = min(self._frame(step), self._frame_end)
                        self._evaluate_drivers(driven)
                        yield self._at(step)
                        self._resume(step, stage, alone, batches)
            finally:
                # Also after an error or a cancel: frames that are stored count.
                last = stage.last_step
                for ready in stage.sense(window, evaluated_depsgraph()):
                    self._record(ready, driven)
                if last is not None:
                    self._recording.frame_end = min(self._frame(last), self._frame_end)
            if last is not None:
                self._evaluate_drivers(driven)
                yield self._at(last)
                self._resume(last, stage, alone, batches)

    def _evaluate_drivers(self, driven: bool) -> None:
        """Evaluate the drivers that read outputs, if there are any (`driven`)."""
        # A later evaluation of them would count as an edit, after which all solids are listed anew.
        if driven:
            with publishing():
                evaluated_depsgraph()

    def _frame(self, step: int) -> int:
        return self._clock.frame_and_subframe(step)[0]

    def _at(self, step: int, doing: str = "") -> Progress:
        clock, first, last = self._clock, self._first, self._last
        done = clock.step_time(min(max(step - first, 0), last - first))
        seconds = clock.step_time(max(last - first, 1))
        steps = self._steps, self._evaluated, self._moving
        reference = self._reference, self._reference_done
        return Progress(done, seconds, clock.step_frame(step), doing, *steps, *reference)

    def _note_reference(self, done: float) -> None:
        self._reference_done = max(self._reference_done, done)

    def _share_of_reference(self) -> float:
        """Estimate which part of the run's light paths goes into the light references, 0 to 1."""
        traced = reference = 0
        for runner in self._runners:
            if runner.sensor.kind.requires_light and runner.sensor.parameters.engine == "CYCLES":
                samples = runner.sensor.parameters.samples
                updates = len(runner.schedule.between(self._first, self._last)[0])
                traced += COST_OF_FEW * samples * updates
                if updates and self._scene.angen_light_reference > samples:
                    reference += self._scene.angen_light_reference
        return reference / (reference + traced) if reference else 0.0

    def _record(self, pending: PendingUpdates, driven: bool) -> None:
        """Record the readings of updates; if drivers read outputs (`driven`), also write these."""
        sensor, readings, clock = pending.runner.sensor, pending.readings(), self._clock
        if not len(readings):
            return
        times, frames = clock.times_and_frames(np.array(pending.steps))
        times = times if readings.times is None else readings.times
        track = self._recording.tracks.get(sensor.name)
        if track is not None and track.uid == sensor.uid:
            track.extend(frames, times, readings, pending.parameters)
        # Drivers see the new outputs from the next frame on.
        if driven:
            outputs.show(sensor, bool(readings.active[-1]), float(readings.value[-1]))


def _group_unchanged(steps: Index, fresh: NDArray[np.bool_]) -> Iterator[tuple[list[int], bool]]:
    """Yield groups of successive steps between which the scene does not change.

    `fresh` (n,) says at which of the `steps` (n,) the scene may differ from the step before. Yield
    each group with the value of `fresh` at its first step.
    """
    for part in np.split(np.arange(len(steps)), np.flatnonzero(fresh)):
        if len(part):
            yield steps[part].tolist(), bool(fresh[part[0]])


@contextmanager
def _same_frame_after(scene: Any) -> Iterator[None]:
    """Context manager: on exit, set the scene to the frame at which it is on entry."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        # If another file was opened, the scene is gone.
        with suppress(ReferenceError):
            scene.frame_set(frame, subframe=subframe)


@contextmanager
def _idle_outputs(runners: list[SensorRunner]) -> Iterator[bool]:
    """Context manager: switch all outputs off on entry, and restore them on exit.

    If no driver reads outputs, do nothing. Yield whether any driver does.
    """
    if not outputs.are_driven():
        yield False
        return
    sensors = [runner.sensor for runner in runners]
    before = [(sensor, sensor.settings.active, sensor.settings.value) for sensor in sensors]
    for sensor in sensors:
        outputs.show(sensor, False, 0.0)
    try:
        yield True
    finally:
        with suppress(ReferenceError):
            for sensor, active, value in before:
                outputs.show(sensor, active, value)
