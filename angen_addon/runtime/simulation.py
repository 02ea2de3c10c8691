# SPDX-License-Identifier: GPL-3.0-or-later
"""The one generator behind the operator, the command line and the tests.

It brings the scene to frame after frame, lets the sensors that are due sense those that are kept,
many at once, and records what they read. Who follows its progress may stop it or edit the scene.
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
from ...sensor_logic.error import AngenError, explained
from ...sensor_logic.model import Index
from ...sensor_logic.recording.tracks import Recording, Track
from ..scene.sensors import Sensor, all_sensors, check, check_names, report_steps, simulated
from . import handlers, skipping, state
from .sensor_runner import PendingUpdates, SensorRunner
from .skipping import MovingScene, moving_scene
from .stage import Agenda, Stage
from .time_base import clock_of, evaluated_depsgraph

# A picture of an update's few light paths takes as long as so many times the paths in a reference.
COST_OF_FEW = 2


@dataclass(frozen=True)
class Progress:
    """How far a run is: seconds of the scene done and in all, and the frame just sensed; what is
    being done there, if it takes long. Of the `steps` until there, at which sensors sensed, the
    scene was evaluated at `evaluated`: at the others it was as before. `moving`: why it had to be
    at all of them, in words. `reference`: the share of the run's work that is the light's
    reference, and `reference_done` what is traced of that."""

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
        """The share of the run that is done, 0 to 1."""
        frames = self.seconds_done / max(self.seconds_total, 1e-9)
        return self.reference * self.reference_done + (1.0 - self.reference) * frames


@dataclass(frozen=True)
class Exchange:
    """Before the whole frame `frame` of a run, `put` exchanges keys of the scene for others, with
    which it stands at the frame before as it did with those."""

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
    follow: Callable[[SensorRunner], object] | None = None,
    references: dict[Any, Any] | None = None,
) -> Generator[Progress, None, None]:
    """Simulates whole frames `frame_start` … `frame_end` into `recording`, yielding progress.

    `scene` is the scene of the present context; of `sensors`, those that can be sense. Other
    sensors whose outputs drivers read sense too, and are not recorded. A run that is longer than
    what the scene can hold the keys of has `exchanges`, after `frame_start`; `clock` tells its time
    where that is not the scene's; `follow` is called after each sensor's readings were recorded,
    with its runner, whose trace then keeps the last queries and answers. `references`: of the
    light, from an earlier run of the same scene; the run adds to them.
    The frame is put back at the end, also after an error or when the generator is closed early;
    what was recorded until then stays. Raises AngenError.
    """
    sensors = simulated(sensors)
    check_names(sensors)
    every = [*sensors, *unrecorded(sensors)]
    for sensor in every:
        check(sensor)
    clock = clock or clock_of(scene)
    first, last = clock.first_step(frame_start), clock.first_step(frame_end + 1) - 1
    runners = [SensorRunner(sensor, clock) for sensor in every]
    recording.frame_start, recording.frame_end = frame_start, frame_start - 1
    for sensor in sensors:
        kind, steps = sensor.kind.identifier, report_steps(sensor)
        recording.tracks[sensor.name] = Track(sensor.name, kind, sensor.uid, steps, clock)
    recording.clock = clock
    run = _Run(scene, runners, first, last, frame_end, recording, exchanges, follow)
    run.references = references
    return run.progress()


def unrecorded(sensors: Sequence[Sensor]) -> list[Sensor]:
    """The other sensors of the scene whose outputs drivers read: what `sensors` sense depends on
    them."""
    given = {sensor.uid for sensor in sensors}
    others = simulated(all_sensors(bpy.context.view_layer))
    return [s for s in state.read_by_drivers(others) if s.uid not in given]


class _Run:
    """The sensors of a scene from step `first` to `last`."""

    def __init__(
        self,
        scene: Any,
        runners: list[SensorRunner],
        first: int,
        last: int,
        frame_end: int,
        recording: Recording,
        exchanges: Sequence[Exchange],
        follow: Callable[[SensorRunner], object] | None,
    ) -> None:
        self._scene, self._runners = scene, runners
        self._first, self._last, self._frame_end = first, last, frame_end
        assert recording.clock is not None
        self._clock = recording.clock
        self._recording, self._follow = recording, follow
        for runner in runners:
            runner.trace.keeps = follow is not None
        self._exchanges = {self._clock.first_step(e.frame): e for e in exchanges}
        self._still = skipping.Stillness(skipping.NEVER)
        self._moving_scene: MovingScene | None = None
        self._kept: set[str] = set()
        self._steps = self._evaluated = 0
        self._moving = ""
        self.references: dict[Any, Any] | None = None
        self._reference, self._reference_done = self._share_of_reference(), 0.0

    def progress(self) -> Generator[Progress, None, None]:
        """Does it."""
        scene = self._scene
        frame_before, subframe_before = scene.frame_current, scene.frame_subframe
        handlers.ensure()
        state.CACHE.running = True
        # Other code may change the scene at a frame in ways that Blender tells nobody.
        alone = not handlers.others_follow_frames()
        removed = explained(
            "something that the run needs was removed during it", ReferenceError, raised=AngenError
        )
        try:
            with removed, _idle_outputs(self._runners) as driven:
                agenda = Agenda(scene, self._runners, self._clock, self._first, self._last)
                batches = alone and not driven and agenda.allows_batches
                self._kept = agenda.kept
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
                    self._leave_moving_scene()
            self._recording.frame_end = self._frame_end
        finally:
            _put_back(scene, frame_before, subframe_before)

    def _find_what_moves(self, frame: int, alone: bool, batches: bool) -> None:
        """When, from a frame on, and a passing scene of it."""
        needs = {need for runner in self._runners for need in runner.sensor.kind.needs}
        still = self._still = skipping.find(self._scene, needs, not alone)
        self._moving = still.why
        if batches:
            what = self._scene, self._runners, self._kept
            self._moving_scene = moving_scene(*what, still, frame)

    def _leave_moving_scene(self) -> None:
        moving, self._moving_scene = self._moving_scene, None
        if moving is not None:
            moving.close()

    def _exchange(self, exchange: Exchange, stage: Stage, alone: bool, batches: bool) -> None:
        self._leave_moving_scene()
        exchange.put()
        # What was edited must not be taken for what changes at a frame.
        evaluated_depsgraph()
        self._find_what_moves(exchange.frame, alone, batches)
        stage.begin_anew(self._moving_scene)

    def _resume(self, step: int, stage: Stage, alone: bool, batches: bool) -> None:
        """After others had their turn at a step."""
        if stage.resume():
            self._leave_moving_scene()
            self._find_what_moves(self._frame(step), alone, batches)
            stage.go(step)
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
                for steps, is_fresh in _alike(window.steps, fresh):
                    step = steps[-1]
                    self._steps += len(steps)
                    self._evaluated += is_fresh
                    if bpy.context.scene.session_uid != self._scene.session_uid:
                        raise AngenError("the run ended early: another scene is shown now")
                    for ready in stage.visit(window, steps, is_fresh):
                        self._record(ready, driven)
                    for doing in stage.measure(alone):
                        if not doing and not stage.is_due:
                            continue
                        # Whoever is told may undo: not while something is kept.
                        for ready in stage.sense(window, evaluated_depsgraph()):
                            self._record(ready, driven)
                        self._let_drivers_follow(driven)
                        self._note_reference(stage.probes.reference_done)
                        yield self._at(step, doing)
                    for lit in stage.take_lit():
                        self._note_reference(1.0)
                        self._record(lit, driven)
                    if stage.has_sensed_all:
                        # Whoever is told may change the scene: not while something is kept of it.
                        self._recording.frame_end = min(self._frame(step), self._frame_end)
                        self._let_drivers_follow(driven)
                        yield self._at(step)
                        self._resume(step, stage, alone, batches)
            finally:
                # Also where a sensor fails, or the user has seen enough: what was looked at counts.
                last = stage.last_step
                for ready in stage.sense(window, evaluated_depsgraph()):
                    self._record(ready, driven)
                if last is not None:
                    self._recording.frame_end = min(self._frame(last), self._frame_end)
            if last is not None:
                self._let_drivers_follow(driven)
                yield self._at(last)
                self._resume(last, stage, alone, batches)

    def _let_drivers_follow(self, driven: bool) -> None:
        """Evaluates what reads the outputs, before others have their turn: it is no edit, after
        which all of the scene would be looked at again."""
        if driven:
            state.CACHE.publishing = True
            try:
                evaluated_depsgraph()
            finally:
                state.CACHE.publishing = False

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
        """The share of the run's work that is the light's reference, estimated by light paths."""
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
        """Records what was read, and lets drivers see it from the next frame on."""
        sensor, readings, clock = pending.runner.sensor, pending.readings(), self._clock
        if not len(readings):
            return
        times, frames = clock.times_and_frames(np.array(pending.steps))
        times = times if readings.times is None else readings.times
        track = self._recording.tracks.get(sensor.name)
        if track is not None and track.uid == sensor.uid:
            track.extend(frames, times, readings)
            if self._follow is not None:
                self._follow(pending.runner)
        if driven:
            state.show(sensor, bool(readings.active[-1]), float(readings.value[-1]))


def _alike(steps: Index, fresh: NDArray[np.bool_]) -> Iterator[tuple[list[int], bool]]:
    """The steps, together with those that follow at which nothing changes, and whether anything may
    have at the first."""
    for part in np.split(np.arange(len(steps)), np.flatnonzero(fresh)):
        if len(part):
            yield steps[part].tolist(), bool(fresh[part[0]])


def _put_back(scene: Any, frame: int, subframe: float) -> None:
    """The scene as it stood; the frame handler must stay quiet until then."""
    try:
        scene.frame_set(frame, subframe=subframe)
    except ReferenceError:
        # Another file was opened: there is nothing to put back.
        pass
    finally:
        state.CACHE.running = False


@contextmanager
def _idle_outputs(runners: list[SensorRunner]) -> Iterator[bool]:
    """Where drivers read the sensors' outputs, these start idle, whatever the playhead showed,
    and are put back at the end. Yields whether drivers read them."""
    if not state.are_driven():
        yield False
        return
    sensors = [runner.sensor for runner in runners]
    before = [(sensor, sensor.settings.active, sensor.settings.value) for sensor in sensors]
    for sensor in sensors:
        state.show(sensor, False, 0.0)
    try:
        yield True
    finally:
        with suppress(ReferenceError):
            for sensor, active, value in before:
                state.show(sensor, active, value)
