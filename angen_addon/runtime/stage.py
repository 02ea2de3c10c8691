# SPDX-License-Identifier: GPL-3.0-or-later
"""The steps of a run (`Agenda`), and the scene and the sensors at these steps (`Stage`).

The stage evaluates the scene at each step, and stores the poses that the sensors need. After a
batch of frames, the sensors sense all its frames together.
"""

from __future__ import annotations

import time
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.clock import Clock
from ...sensor_logic.kind import CROSSINGS, FORCES, RAYS, USES
from ...sensor_logic.model import Index
from ..scene.animation import all_animated, may_set
from ..scene.surfaces import SURFACES
from ..scene.timed import frames_to_step_from
from .moving_scene import MovingScene
from .pads import Pads
from .probes import Probes
from .sensor_runner import PendingUpdates, SensorRunner, SensorSteps
from .stillness import Stillness
from .time_base import clock_of, evaluated_depsgraph

# The steps of a run, and the sensors due at them.

# Quantities that can be queried after the scene has left a frame, from what is stored of the frame.
STORED = {RAYS, CROSSINGS, USES, *SURFACES}
# Parts of data paths of the properties that weights depend on, in addition to poses and shapes.
WEIGHT = ("angen_load", "gravity", "rigid_body", "scale_length")
# Most steps in a window, so that a long run needs no more memory than a short one.
WINDOW = 1 << 13


@dataclass(frozen=True)
class Window:
    """A part of a run, as the steps at which to evaluate the scene and to sense.

    Attributes
    ----------
    begin
        The first step of the part, whether or not the scene is evaluated at it.
    steps
        The steps (n,) at which the scene is evaluated, in order.
    sensed
        The steps at which sensors sense; at the others the scene is only evaluated.
    sensor_steps
        The steps at which each sensor senses.
    motion
        The steps (m,) of the whole frames at which the motion of objects is read, for pads.
    pads
        For each pad, the steps of the whole frames in which it has updates.
    read
        By step, the sensors whose parameters and pose must be read while the scene is at that step.
    """

    begin: int
    steps: Index
    sensed: Container[int]
    sensor_steps: dict[SensorRunner, SensorSteps]
    motion: Index
    pads: dict[SensorRunner, Index]
    read: dict[int, list[SensorRunner]]


class Agenda:
    """The steps of a run from `first` to `last` at which the scene is evaluated.

    These are all steps with an update of a sensor. A swept optical switch adds all steps between
    its updates, and a radar those in the integration time before each update. A pad adds the frames
    before and after each of its updates. A scene with physics adds every frame from the start of
    its physics.
    """

    def __init__(
        self, scene: Any, runners: Sequence[SensorRunner], clock: Clock, first: int, last: int
    ) -> None:
        self._runners = runners
        self._first, self._last = first, last
        self._substeps = clock.substeps
        self._frame_start = clock.frame_start
        self._last_step: Index = np.zeros(0, np.intp)
        self._stepped_from: int | None = None
        # Quantities that can be queried later, from captured frames. All others must be queried
        # while the scene is at the frame.
        self.stored = STORED | ({FORCES} if _weights_stay(scene) else set())
        starts = frames_to_step_from(scene)
        if starts:
            self._stepped_from = (min(starts) - clock.frame_start) * self._substeps

    @property
    def allows_batches(self) -> bool:
        """Whether a run can store frames, and let the sensors sense them later.

        It cannot if physics need every frame in turn. Nor can it if forces on a pad can only be
        computed while the scene is at the frame.
        """
        has_pads = any(runner.sensor.kind.requires_forces for runner in self._runners)
        return self._stepped_from is None and (not has_pads or FORCES in self.stored)

    def windows(self, cuts: Iterable[int] = ()) -> Iterator[Window]:
        """Yield all parts of the run in order.

        A new part begins at each step in `cuts`. The scene is then evaluated at its first step,
        even if nothing has changed.
        """
        substeps = self._substeps
        begin, end = self._first - self._first % substeps, self._last + 1
        if any(runner.sensor.kind.requires_forces for runner in self._runners):
            begin, end = begin - substeps, end + 2 * substeps
        if self._stepped_from is not None:
            begin = min(begin, self._stepped_from)
        size = WINDOW - WINDOW % substeps
        inside = [cut for cut in cuts if begin < cut < end]
        for start, stop in pairwise(sorted({*range(begin, end, size), *inside, end})):
            if start in inside:
                self._last_step = self._last_step[:0]
            yield self._window(start, stop)

    def fresh(self, window: Window, still: Stillness) -> NDArray[np.bool_]:
        """Return whether the scene at each step of a window can differ from the step before, (n,).

        `still` has the times at which the scene can change. Call this method for each window in
        order.
        """
        last, self._last_step = self._last_step, window.steps[-1:]
        steps = np.concatenate([last, window.steps])
        if not len(steps):
            return np.zeros(0, bool)
        frames, parts = self._frame_start + steps // self._substeps, steps % self._substeps
        return still.fresh(frames, parts / self._substeps)[len(last) :]

    def _window(self, begin: int, end: int) -> Window:
        """Return the part of the run from step `begin` up to the step before `end`."""
        sensor_steps = [self._sensor_steps(runner, begin, end - 1) for runner in self._runners]
        parts = [steps_of.steps for steps_of in sensor_steps]
        motion: list[Index] = []
        pads: dict[SensorRunner, Index] = {}
        read: dict[int, list[SensorRunner]] = {}
        for runner, steps_of in zip(self._runners, sensor_steps, strict=True):
            if runner.sensor.kind.requires_forces:
                frames = pads[runner] = self._frames_moved(runner, begin, end)
                motion += [frames - self._substeps, frames, frames + self._substeps]
            if not (runner.reader.steady and set(runner.sensor.kind.needs) <= self.stored):
                for step in steps_of.steps.tolist():
                    read.setdefault(step, []).append(runner)
        # No sensor senses before step 0.
        parts += [steps[steps >= 0] for steps in motion]
        sensed: Container[int] = range(begin, end)
        if self._stepped_from is not None:
            stepped = np.arange(
                max(begin, self._stepped_from), min(end, self._last + 1), self._substeps
            )
            sensed = frozenset(np.concatenate([stepped[:0], *parts]).tolist())
            parts.append(stepped)
        steps = np.unique(np.concatenate([np.zeros(0, np.int64), *parts]))
        steps = steps[(steps >= begin) & (steps < end)]
        moved = np.unique(np.concatenate([steps[:0], *motion]))
        by_runner = dict(zip(self._runners, sensor_steps, strict=True))
        return Window(begin, steps, sensed, by_runner, moved, pads, read)

    def _frames_moved(self, runner: SensorRunner, begin: int, end: int) -> Index:
        """Return the steps of a pad's whole frames with updates, in the window or near it."""
        first, last = max(begin - 2 * self._substeps, self._first), end + 2 * self._substeps
        steps = runner.schedule.between(first, min(last, self._last))[1]
        return np.unique(steps - steps % self._substeps)

    def _sensor_steps(self, runner: SensorRunner, first: int, last: int) -> SensorSteps:
        schedule = runner.schedule
        first, last = max(first, self._first), min(last, self._last)
        numbers, steps = schedule.between(first, last)
        due = np.ones(len(steps), bool)
        if runner.senses_between:
            start = schedule.step(max(schedule.last_update(self._first - 1) + 1, 0))
            end = schedule.step(schedule.last_update(self._last))
            watched = np.arange(max(first, start), min(last, end) + 1)
            due = np.isin(watched, steps)
            # A swept switch watches all of them.
            kept = due | runner.is_watched(watched)
            watched, due = watched[kept], due[kept]
            spacing = schedule.steps_per_update
            numbers = watched * spacing.denominator // spacing.numerator + ~due
            steps = watched
        return SensorSteps(steps, numbers, due)


def _weights_stay(scene: Any) -> bool:
    """Return whether forces on pads depend only on the poses and shapes of objects.

    This holds if the scene has no rigid bodies, and neither a mass nor the gravity is animated.
    """
    return scene.rigidbody_world is None and not any(
        may_set(owner, *WEIGHT) for owner in all_animated()
    )


# s: after this time at most, the captured frames are sensed and the run yields its progress.
PROGRESS_INTERVAL = 0.25


class Stage:
    """The sensors of a scene, and the probes that read the scene for them.

    Parameters
    ----------
    scene
        The user's scene.
    runners
        The runners of the sensors.
    batches
        Whether frames are stored, so that the sensors sense many frames together.
    moving
        A scene with only the moving objects, to evaluate in place of `scene` where possible.

    Attributes
    ----------
    probes
        The probes that read the scene.
    light_updates
        The updates of light sensors whose light is not measured yet.
    """

    def __init__(
        self,
        scene: Any,
        runners: Sequence[SensorRunner],
        batches: bool = False,
        moving: MovingScene | None = None,
    ) -> None:
        self.scene = scene
        self.runners = list(runners)
        self._clock = runners[0].clock if runners else clock_of(scene)
        # A pending edit must not count as a change by the frame.
        evaluated_depsgraph()
        self.probes = Probes(scene)
        self.probes.set_sensors(runner.sensor for runner in runners)
        self._capture = self.probes.capture
        self.light_updates: list[PendingUpdates] = []
        sensors = [runner.sensor for runner in runners]
        changes = any(
            probe.changes_by_itself(scene)
            for need, probe in SURFACES.items()
            if any(sensor.kind.requires(need, sensor.parameters) for sensor in sensors)
        )
        self._batches = batches and not changes
        self._moving = moving if self._batches else None
        self._pads = Pads(scene, self.runners, self._clock, self.probes, _weights_stay(scene))
        # When the batch began, by `time.monotonic`.
        self._since = time.monotonic()

    @property
    def has_sensed_all(self) -> bool:
        """Whether the sensors have sensed all captured frames."""
        return not self._capture.steps

    @property
    def is_due(self) -> bool:
        """Whether the captured frames should be sensed now, and the progress yielded."""
        return not self._batches or time.monotonic() - self._since > PROGRESS_INTERVAL

    @property
    def last_step(self) -> int | None:
        """The last step of the newest captured frame; None if no frame is stored."""
        return self._capture.last if self._capture.steps else None

    def resume(self) -> bool:
        """Prepare for the next step after a yield, since the caller may have edited the scene.

        Return True if the temporary scene of moving objects may lack objects, because an edit has
        made others move. Then make a new such scene, and call `begin_anew` with it.
        """
        # A pending edit must not count as a change by the frame.
        evaluated_depsgraph()
        self._capture.note_edits()
        return self._moving is not None and self._capture.solids.must_list

    def begin_anew(self, moving: MovingScene | None) -> None:
        """Use another scene of moving objects from now on; with None, use only the user's scene.

        Call this method after an edit that makes other objects move, and only while no frame is
        stored.
        """
        self._capture.note_edits()
        self._capture.watch_uses(runner.sensor for runner in self.runners)
        self._moving = moving if self._batches else None

    def evaluate(self, step: int) -> Any:
        """Evaluate the scene at a step, and return the depsgraph."""
        frame, subframe = self._clock.frame_and_subframe(step)
        self.scene.frame_set(frame, subframe=subframe)
        return evaluated_depsgraph()

    def visit(self, window: Window, steps: list[int], fresh: bool) -> Iterator[PendingUpdates]:
        """Evaluate the scene at steps between which nothing changes, and store it as one frame.

        Yield the updates whose readings can be computed now. Updates of light sensors are added to
        `light_updates` instead. `fresh` says whether the scene can differ from the scene at the
        step before `steps`. Raise AngenError if a sensor cannot be read.
        """
        sensed = [step for step in steps if step in window.sensed]
        depsgraph, watched, is_whole = self._evaluate(window, steps[0], sensed, fresh)
        if not sensed:
            return
        if not self._capture.add(watched):
            if not self.has_sensed_all:
                # Objects came or went: sense the captured frames while their solids are listed.
                yield from self.sense(window, self.evaluate(self._capture.last))
                is_whole = False
            # New objects are not in the scene at the earlier frame.
            depsgraph = depsgraph if is_whole else self.evaluate(steps[0])
            if self._capture.add_first(depsgraph, watched) and self._batches:
                self.probes.prepare_pads(depsgraph)
        self._read_sensors(window, sensed, depsgraph, watched)
        if self.is_due or self._capture.full:
            yield from self.sense(window, depsgraph)

    def _evaluate(
        self, window: Window, step: int, sensed: list[int], fresh: bool
    ) -> tuple[Any, Any, bool]:
        """Evaluate the scene at a step, or only the moving objects if no sensor must be read.

        `sensed` are the steps at which sensors sense. `fresh` says whether the scene can have
        changed. Return the depsgraph of the scene, the depsgraph from which the frame is stored,
        and whether the scene itself is at the step.
        """
        is_read = any(at in window.read for at in sensed)
        self.probes.expect_light(is_read)
        if self._moving is None:
            depsgraph = self.evaluate(step) if fresh else evaluated_depsgraph()
            return depsgraph, depsgraph, True
        whole = is_read or self._capture.solids.must_list
        depsgraph = self.evaluate(step) if whole else evaluated_depsgraph()
        # Light depends on the user's scene, not on the scene of moving objects.
        self.probes.expect_light(False)
        return depsgraph, self._moving.evaluate(*self._clock.frame_and_subframe(step)), whole

    def _read_sensors(
        self, window: Window, sensed: list[int], depsgraph: Any, watched: Any
    ) -> None:
        """Read the parameters and poses that can change, and add updates to `light_updates`."""
        # Nothing changes between the steps in `sensed`, so one reading serves all of them.
        runners = list(dict.fromkeys(r for step in sensed for r in window.read.get(step, ())))
        reads = self._capture.read_sensors(sensed, depsgraph, watched, [r.reader for r in runners])
        for runner, read in zip(runners, reads, strict=True):
            if runner.sensor.kind.requires_light:
                due = window.sensor_steps[runner].between(sensed[0], sensed[-1])
                self.light_updates += runner.updates(due, 0 * due.steps, [read], self.probes)

    def sense(self, window: Window, depsgraph: Any) -> Iterator[PendingUpdates]:
        """Yield the updates at all steps of the captured frames, and begin the next batch.

        Compute the readings of each item before you take the next one. Updates of pads are yielded
        only once the next frame was evaluated, perhaps with the next batch.
        """
        self._since = time.monotonic()
        if self.has_sensed_all:
            return
        self.probes.show_captured(depsgraph)
        frames = self.probes.frames
        for runner, sensor_steps in window.sensor_steps.items():
            kind, due = runner.sensor.kind, sensor_steps.between(frames.steps[0], frames.last)
            if kind.requires_light or not len(due.steps):
                continue
            if kind.requires_forces:
                self._pads.wait(runner, due, frames.reads_of(runner.reader, frames.at(due.steps)))
            else:
                yield from runner.pending(due, self.probes)
        moved = frames.part(window.motion)
        if len(moved):
            pads = {runner: frames.part(steps) for runner, steps in window.pads.items()}
            yield from self._pads.sense(moved, pads)

    def measure(self, alone: bool) -> Iterator[str]:
        """Measure the light of all `light_updates`, and yield a text before each slow picture.

        At such a yield, call `sense` before you yield to another caller. `alone` says whether only
        the frame changes until the end of the run. Raise AngenError if the light cannot be
        rendered.
        """
        # A sensor that is due at several steps without changes has one request.
        requests = {p.request.name: p.request for p in self.light_updates if p.request is not None}
        if requests:
            # To render light, Blender evaluates the scene anew: this comes last.
            view_layer, depsgraph = bpy.context.view_layer, evaluated_depsgraph()
            what = self.scene, view_layer, depsgraph, [*requests.values()]
            found = yield from self.probes.measure(*what, alone)
            for pending in self.light_updates:
                pending.give_light(found)

    def take_light_updates(self) -> list[PendingUpdates]:
        """Return all `light_updates`, whose light is measured by now, and empty that list."""
        found, self.light_updates = self.light_updates, []
        return found

    def close(self) -> None:
        """Remove the temporary data of the probes from the file."""
        self.probes.close()
