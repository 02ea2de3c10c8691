# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeat updates of a recording, with the same frames, rays and noise as in the run.

During a run, its last updates are not repeated but read from the run's trace, which stores the rays
and hits of each update.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.model import Array, Pose
from ...sensor_logic.recording.tracks import Recording
from ..progress import finished
from ..runtime import handlers
from ..runtime.probes import Probes
from ..runtime.running import running
from ..runtime.sensor_runner import PendingUpdates, SensorRunner
from ..runtime.time_base import evaluated_depsgraph
from ..runtime.trace import Hits, NotRecorded, Trace
from ..scene import outputs
from ..scene.sensors import Sensor, all_sensors, read_pose
from .facts import Explanation
from .recorded import RecordedSensor


class Replay(RecordedSensor):
    """Repeats recorded updates of a sensor in the scene, to explain them.

    Attributes
    ----------
    runner
        Runs the sensor. It keeps the state of the sensor's model from one repeated update to the
        next.
    probes
        Answers the sensor's queries, such as ray casts. The constructor can take the probes of
        another replay, which have already read the scene.
    """

    def __init__(
        self, scene: Any, sensor: Sensor, recording: Recording, probes: Probes | None = None
    ) -> None:
        super().__init__(scene, sensor, recording)
        self.runner = SensorRunner(sensor, self.clock)
        self._recording = recording
        self._trace = self.runner.trace
        self._trace.keeps = True
        self._probes = probes or Probes(scene)
        self._probes.set_sensors([sensor])
        self._driven = all_sensors(bpy.context.view_layer) if outputs.are_driven() else []

    @property
    def probes(self) -> Probes:
        """The object that answers the sensor's queries, such as ray casts, at the last update.

        Raise `NotRecorded` if the frame cannot change because a run is in progress.
        """
        return self._probes

    @property
    def seen(self) -> Hits:
        """The hits of the rays that the sensor cast last."""
        return self._trace.hits

    def name_of(self, number: int) -> str:
        """Return the name, for users, of the solid (an object that rays hit) with this number."""
        return self._trace.name_of(number)

    def evaluate_step(self, step: int) -> Any:
        """Set the scene to a step of the clock, and return the evaluated depsgraph."""
        frame, subframe = self.runner.clock.frame_and_subframe(step)
        self._show_outputs_before(self.runner.clock.step_frame(step))
        self.scene.frame_set(frame, subframe=subframe)
        return evaluated_depsgraph()

    def take_update(self, index: int, frame: int | None = None) -> PendingUpdates | None:
        """Set the scene to update `index`, and return the inputs of the sensor's model there.

        Return None if the sensor is now switched off at that frame. `frame` is passed to
        `Probes.look`. Raise `AngenError` if the sensor cannot be read.
        """
        step = self.step_of(index)
        depsgraph = self.evaluate_step(step)
        self.probes.look(depsgraph, frame, [] if frame is None else [self.sensor])
        return self.runner.take(self.update_number(index), step, depsgraph, self.probes)

    def measure_light(self, taken: PendingUpdates) -> None:
        """Render the light for an update that `take_update` returned, as in the run.

        Raise `AngenError` if it cannot be rendered.
        """
        assert taken.request is not None
        layer, depsgraph = bpy.context.view_layer, evaluated_depsgraph()
        alone = not handlers.has_other_frame_handlers()
        what = self.scene, layer, depsgraph, [taken.request]
        taken.give_light(finished(self.probes.measure(*what, alone)))

    def take_with_motion(self, index: int) -> PendingUpdates | None:
        """Do what `take_update` does, for a sensor that also senses the motion of objects.

        The motion is computed from the frames before and after. Raise `AngenError` if the sensor
        cannot be read.
        """
        clock = self.runner.clock
        whole, subframe = clock.frame_and_subframe(self.step_of(index))[0], self.step_of(index)
        subframe %= clock.substeps
        for beside in (whole - 1, whole):
            if beside >= clock.frame_start and (beside < whole or subframe):
                depsgraph = self.evaluate_step((beside - clock.frame_start) * clock.substeps)
                due = [self.sensor] if beside == whole else []
                self.probes.look(depsgraph, beside, due)
        taken = self.take_update(index, None if subframe else whole)
        if taken is not None:
            after = self.evaluate_step((whole + 1 - clock.frame_start) * clock.substeps)
            self.probes.look(after, whole + 1, [])
        return taken

    def sense_between(self, first: int, last: int) -> None:
        """Run a swept sensor at each step between updates `first` and `last` of the track.

        A swept sensor computes what crosses its beam between two frames. Do nothing for other
        sensors.
        """
        if self.runner.watches:
            self._watch(range(self.step_of(first) + 1, self.step_of(last)))

    def sense_before(self, index: int) -> None:
        """Run a sensor that integrates at the steps in the integration time before update `index`.

        Leave out steps before a gap in the track.
        """
        last, first = self.step_of(index), index
        while (before := self.index_of(self.update_number(first) - 1, first)) is not None:
            first = before
            if not self.runner.is_integrated(self.step_of(first), last):
                break
        steps = range(self.step_of(first), last)
        self._watch(step for step in steps if self.runner.is_integrated(step, last))

    def _watch(self, steps: Iterable[int]) -> None:
        for step in steps:
            depsgraph = self.evaluate_step(step)
            self.probes.look(depsgraph, None)
            self.runner.watch(step, depsgraph, self.probes)

    def solid_bounds(self, index: int, include_sensor: bool = False) -> dict[str, Array]:
        """Return the bounds (2, 3) in m of the solids that rays can hit at update `index`.

        The keys are the names of the solids. If `include_sensor` is True, the sensor's own solids
        are included.
        """
        depsgraph = self.evaluate_step(self.step_of(index))
        self.probes.look(depsgraph, None)
        solids = self.probes.caster.solids
        found: dict[str, Array] = {}
        for solid in solids.solids:
            box = np.stack([solids.lo[solid.row], solids.hi[solid.row]]) * self.metres
            if not np.isfinite(box).all() or (
                not include_sensor and solid.is_passed_by(self.sensor.uid)
            ):
                continue
            known = found.get(solid.name, box)
            found[solid.name] = np.stack(
                [np.minimum(known[0], box[0]), np.maximum(known[1], box[1])]
            )
        return found

    @property
    def pose(self) -> Pose:
        """The sensor's pose at the last update that was repeated."""
        matrix = self.sensor.world_matrix(evaluated_depsgraph())
        return read_pose(self.sensor, matrix, self.metres)

    def explain_off(self, index: int) -> Explanation:
        """Return the explanation for an update at which the sensor is now switched off."""
        return self.explanation(index, "It is switched off at this frame", ())

    def _show_outputs_before(self, frame: float) -> None:
        """Set the outputs of all sensors to their values just before this frame, for drivers."""
        for sensor in self._driven:
            track = self._recording.track_of(sensor.uid)
            if track is None:
                continue
            # A force depends on the motion through a frame, so the run knew it one frame later.
            until = frame - 1.0 if sensor.kind.requires_forces else frame
            last = bisect_left(track.frames, until) - 1
            if last < 0:
                outputs.show(sensor, False, 0.0)
            else:
                outputs.show(sensor, bool(track.active[last]), track.value[last])


class Recalled(Replay):
    """A replay during a run, which reads stored rays and hits instead of changing the frame.

    A query that the run has not made raises `NotRecorded`.
    """

    def __init__(self, scene: Any, recording: Recording, trace: Trace) -> None:
        RecordedSensor.__init__(self, scene, trace.sensor, recording)
        self.runner = SensorRunner(trace.sensor, self.clock)
        self._trace = trace

    @property
    def probes(self) -> Probes:
        raise NotRecorded

    def evaluate_step(self, step: int) -> Any:
        raise NotRecorded

    def take_update(self, index: int, frame: int | None = None) -> PendingUpdates | None:
        step = self.step_of(index)
        parameters, updates = self._trace.recall(step)
        return PendingUpdates(self.runner, [step], parameters, updates)

    def measure_light(self, taken: PendingUpdates) -> None:
        """Do nothing, because the run has already rendered the light."""

    def take_with_motion(self, index: int) -> PendingUpdates | None:
        return self.take_update(index)

    def sense_before(self, index: int) -> None:
        """Do nothing, because the trace has the speeds."""

    def sense_between(self, first: int, last: int) -> None:
        if self.runner.watches:
            for step in range(self.step_of(first) + 1, self.step_of(last)):
                parameters, updates = self._trace.recall(step)
                self.runner.model.sense(parameters, updates)


@contextmanager
def replaying(scene: Any, sensor: Sensor, recording: Recording) -> Iterator[Replay]:
    """Context manager: on entry, give a `Replay` of a sensor; on exit, restore frame and outputs.

    In between, the frame may change. Do not use it in a frame handler, nor during a run.
    """
    frame, subframe = scene.frame_current, scene.frame_subframe
    view_layer = bpy.context.view_layer
    before = [(s, s.settings.active, s.settings.value) for s in all_sensors(view_layer)]
    handlers.restore_handlers()
    with running():
        replay = None
        try:
            replay = Replay(scene, sensor, recording)
            yield replay
        finally:
            if replay is not None:
                replay.probes.close()
            with suppress(ReferenceError):
                for other, active, value in before:
                    outputs.show(other, active, value)
                scene.frame_set(frame, subframe=subframe)
                # Evaluate now: later, the restored frame and outputs would count as an edit.
                view_layer.update()
