# SPDX-License-Identifier: GPL-3.0-or-later
"""Goes back to updates of a recording: the same frames, rays and noise as in the run; or takes what
they were from the run's own trace."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.kind import RAYS
from ...sensor_logic.model import Array, Pose
from ...sensor_logic.parameters import is_chosen, label_of, specs, value_text
from ...sensor_logic.recording.tracks import Recording, Track
from ...sensor_logic.wording import quoted
from ..runtime import handlers, state
from ..runtime.probes import Probes
from ..runtime.sensor_runner import PendingUpdates, SensorRunner
from ..runtime.time_base import evaluated_depsgraph
from ..runtime.trace import Hits, NotNoted, Trace
from ..scene.lengths import lengths_of
from ..scene.light.cycles import finished
from ..scene.sensors import Sensor, all_sensors, read_pose, unit_scale
from .facts import Explanation, Facts


class Replay:
    """One sensor at chosen updates of a recording. `runner` keeps its model's state between
    them; `lengths` is what to tell lengths in. `probes`: those of another replay, which know the
    home already."""

    def __init__(
        self, scene: Any, sensor: Sensor, recording: Recording, probes: Probes | None = None
    ) -> None:
        self._begin(scene, sensor, recording)
        self._trace.keeps = True
        self._probes = probes or Probes(scene)
        self._probes.serve([sensor])
        self._driven = all_sensors(bpy.context.view_layer) if state.are_driven() else []

    def _begin(
        self, scene: Any, sensor: Sensor, recording: Recording, trace: Trace | None = None
    ) -> None:
        track, clock = recording.track_of(sensor.uid), recording.clock
        if sensor.variant:
            # The others of the same sensor have that too.
            track = recording.tracks[sensor.name]
        assert track is not None and clock is not None
        self.scene = scene
        self.sensor = sensor
        self.track: Track = track
        self.runner = SensorRunner(sensor, clock)
        self.metres = unit_scale(scene)
        self.lengths = lengths_of(scene)
        self._recording = recording
        self._trace = trace or self.runner.trace

    @property
    def probes(self) -> Probes:
        """The probes of the scene at the last update that was taken. Raises NotNoted if there is no
        going back."""
        return self._probes

    @property
    def seen(self) -> Hits:
        """The hits of the rays that the sensor cast last."""
        return self._trace.hits

    def name_of(self, number: int) -> str:
        """The name that users know the solid `number` by."""
        return self._trace.name_of(number)

    def step(self, index: int) -> int:
        """The step of the clock at which update `index` of the track was made."""
        clock = self.runner.clock
        return round((self.track.frames[index] - clock.frame_start) * clock.substeps)

    def number(self, index: int) -> int:
        """Which update that was, counted from t = 0."""
        return self.runner.schedule.last_update(self.step(index))

    def index_of(self, number: int, index: int) -> int | None:
        """The index of update `number` in the track, if every update from there to `index` was
        recorded: across a gap a sensor forgets what was before."""
        back = self.number(index) - number
        if back > index or self.number(index - back) != number:
            return None
        return index - back

    def go(self, step: int) -> Any:
        """Evaluates the scene at a step; returns the depsgraph."""
        frame, subframe = self.runner.clock.frame_and_subframe(step)
        self._show_outputs_before(self.runner.clock.step_frame(step))
        self.scene.frame_set(frame, subframe=subframe)
        return evaluated_depsgraph()

    def take(self, index: int, frame: int | None = None) -> PendingUpdates | None:
        """Update `index` anew, not yet read; None where the sensor is off now. `frame`: as in
        `Probes.look`. Raises AngenError."""
        step = self.step(index)
        depsgraph = self.go(step)
        self.probes.look(depsgraph, frame, [] if frame is None else [self.sensor])
        return self.runner.take(self.number(index), step, depsgraph, self.probes)

    def measure_light(self, taken: PendingUpdates) -> None:
        """Render the light of an update that was just taken, as the run did. Raises AngenError."""
        assert taken.request is not None
        layer, depsgraph = bpy.context.view_layer, evaluated_depsgraph()
        alone = not handlers.others_follow_frames()
        what = self.scene, layer, depsgraph, [taken.request]
        taken.give_light(finished(self.probes.measure(*what, alone)))

    def take_moved(self, index: int) -> PendingUpdates | None:
        """As `take`, of a sensor that feels the motion through the frame: that follows from the
        frames beside it. Raises AngenError."""
        clock = self.runner.clock
        whole, subframe = clock.frame_and_subframe(self.step(index))[0], self.step(index)
        subframe %= clock.substeps
        for beside in (whole - 1, whole):
            if beside >= clock.frame_start and (beside < whole or subframe):
                depsgraph = self.go((beside - clock.frame_start) * clock.substeps)
                due = [self.sensor] if beside == whole else []
                self.probes.look(depsgraph, beside, due)
        taken = self.take(index, None if subframe else whole)
        if taken is not None:
            after = self.go((whole + 1 - clock.frame_start) * clock.substeps)
            self.probes.look(after, whole + 1, [])
        return taken

    def watch(self, first: int, last: int) -> None:
        """Lets the sensor look at the steps between two updates of the track, where it does so."""
        if not self.runner.watches:
            return
        for step in range(self.step(first) + 1, self.step(last)):
            depsgraph = self.go(step)
            self.probes.look(depsgraph, None)
            self.runner.watch(step, depsgraph, self.probes)

    def bounds(self, index: int, own: bool = False) -> dict[str, Array]:
        """Least and greatest corner (2, 3) in metres of what rays meet at an update, by name;
        `own`: the sensor's own too."""
        depsgraph = self.go(self.step(index))
        self.probes.look(depsgraph, None)
        solids = self.probes.caster.solids
        found: dict[str, Array] = {}
        for solid in solids.solids:
            box = np.stack([solids.lo[solid.row], solids.hi[solid.row]]) * self.metres
            if not np.isfinite(box).all() or (not own and self.sensor.uid in solid.owners):
                continue
            known = found.get(solid.name, box)
            found[solid.name] = np.stack(
                [np.minimum(known[0], box[0]), np.maximum(known[1], box[1])]
            )
        return found

    @property
    def pose(self) -> Pose:
        """The sensor's pose at the last update that was taken."""
        matrix = self.sensor.world_matrix(evaluated_depsgraph())
        return read_pose(self.sensor, matrix, self.metres)

    def explanation(
        self,
        index: int,
        headline: str,
        facts: Iterable[tuple[str, str]],
        doubt: str = "",
        cause: Any = None,
    ) -> Explanation:
        """The explanation of update `index`."""
        frame, time = self.track.frames[index], self.track.times[index]
        name = self.sensor.name
        return Explanation(name, index, frame, time, headline, tuple(facts), doubt, cause)

    def off(self, index: int) -> Explanation:
        """The explanation of an update at which the sensor, as it is now, senses nothing."""
        return self.explanation(index, "It is switched off at this frame", ())

    def _show_outputs_before(self, frame: float) -> None:
        """Drivers saw what the sensors had published before this frame."""
        for sensor in self._driven:
            track = self._recording.track_of(sensor.uid)
            if track is None:
                continue
            # What needs the motion is known a frame later.
            until = frame - 1.0 if sensor.kind.requires_forces else frame
            last = bisect_left(track.frames, until) - 1
            if last < 0:
                state.show(sensor, False, 0.0)
            else:
                state.show(sensor, bool(track.active[last]), track.value[last])


class Recalled(Replay):
    """One sensor at the last updates of a run that is still going on, as the run itself met them:
    the scene stays where it is. What the run did not ask raises NotNoted."""

    def __init__(self, scene: Any, recording: Recording, trace: Trace) -> None:
        self._begin(scene, trace.sensor, recording, trace)

    @property
    def probes(self) -> Probes:
        raise NotNoted

    def go(self, step: int) -> Any:
        raise NotNoted

    def take(self, index: int, frame: int | None = None) -> PendingUpdates | None:
        step = self.step(index)
        parameters, updates = self._trace.recall(step)
        return PendingUpdates(self.runner, [step], parameters, updates)

    def measure_light(self, taken: PendingUpdates) -> None:
        """Its light is in the trace."""

    def take_moved(self, index: int) -> PendingUpdates | None:
        return self.take(index)

    def watch(self, first: int, last: int) -> None:
        if self.runner.watches:
            for step in range(self.step(first) + 1, self.step(last)):
                parameters, updates = self._trace.recall(step)
                self.runner.model.sense(parameters, updates)


@contextmanager
def replaying(scene: Any, sensor: Sensor, recording: Recording) -> Iterator[Replay]:
    """A replay of a sensor with a track in the recording. The frame and the outputs are put back,
    also after an error. Not in a frame handler, nor while a run is on."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    view_layer = bpy.context.view_layer
    before = [(s, s.settings.active, s.settings.value) for s in all_sensors(view_layer)]
    handlers.ensure()
    state.CACHE.running = True
    replay = None
    try:
        replay = Replay(scene, sensor, recording)
        yield replay
    finally:
        try:
            if replay is not None:
                replay.probes.close()
            with suppress(ReferenceError):
                for other, active, value in before:
                    state.show(other, active, value)
                scene.frame_set(frame, subframe=subframe)
                # What is put back must not be taken for an edit.
                view_layer.update()
        finally:
            state.CACHE.running = False


# The explanation of a kind that tells no more of itself.


def explain_plainly(replay: Replay, index: int) -> Explanation:
    """Update `index` of a sensor of a kind that tells no more of itself. Raises AngenError."""
    pending, kind = replay.take(index), replay.sensor.kind
    if pending is None:
        return replay.off(index)
    track, lengths = replay.track, replay.lengths
    facts: Facts = []
    for field in kind.samples:
        value = track.columns[field.name][index]
        text = field.text(value, lengths) if field.type is float else str(value)
        facts.append((field.name, ("yes" if value else "no") if field.type is bool else text))
    if list(kind.needs) == [RAYS]:
        pending.reading()
        facts.append(("Nearest", _nearest(replay)))
    for name, spec in specs(kind.parameters).items():
        if is_chosen(pending.parameters, spec.used_when):
            unit = kind.unit_of(spec, pending.parameters)
            text = value_text(getattr(pending.parameters, name), spec, unit, lengths)
            facts.append((label_of(spec, pending.parameters), text))
    word = kind.active_label if track.active[index] else kind.idle_label
    reading = track.reading_at(index).text(track.value[index], lengths)
    return replay.explanation(index, f"{word}: {reading}", facts)


def _nearest(replay: Replay) -> str:
    """The object that the sensor's rays met first."""
    ranges, names = replay.seen
    met = [(length, name) for length, name in zip(ranges.tolist(), names, strict=True) if name]
    if not met:
        return "nothing"
    length, name = min(met)
    return f"{quoted(name)}, {replay.lengths.text(length * replay.metres)} away"
