# SPDX-License-Identifier: GPL-3.0-or-later
"""The steps of a run (`Agenda`), and the scene at them (`Stage`): it is evaluated, what sensors
need of each frame is stored, and the sensors that are due sense a batch of frames at once.
"""

from __future__ import annotations

import time
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.clock import Clock
from ...sensor_logic.error import AngenError
from ...sensor_logic.kind import CROSSINGS, FORCES, RAYS, REFLECTANCE, WARMTH
from ...sensor_logic.model import Index
from ..scene.animation import all_animated, may_set
from ..scene.surfaces import changes_by_itself, colours_change
from ..scene.timed import frames_to_step_from
from .probes import Probes
from .sensor_runner import Dates, PendingUpdates, Read, SensorRunner
from .skipping import MovingScene, Pads, Stillness
from .time_base import clock_of, evaluated_depsgraph

# Which steps of the clock a run looks at, and which sensors are due there.

# What is kept of frames in any scene, so that models can be answered later.
KEPT = {RAYS, WARMTH, REFLECTANCE, CROSSINGS}
# Parts of data paths whose values a weight depends on, beside places and shapes.
WEIGHT = ("angen_load", "gravity", "rigid_body", "scale_length")
# Steps that are planned at once, to bound memory.
WINDOW = 1 << 13


@dataclass(frozen=True)
class Window:
    """A stretch of a run that begins with the step `begin`: the `steps` (n,) to evaluate, in order;
    those that are `looked` at; the sensors' dates in it; the whole frames (m,) at which the motion
    is needed, as steps, and those of them at which each pad is due; and by step the sensors that
    must be read there."""

    begin: int
    steps: Index
    looked: Container[int]
    dates: dict[SensorRunner, Dates]
    motion: Index
    pads: dict[SensorRunner, Index]
    read: dict[int, list[SensorRunner]]


class Agenda:
    """The steps of a run from `first` to `last`: those of the updates, those between that a sensor
    watches, the frames beside where one needs the motion, and no other, unless the scene holds what
    must be stepped through frame by frame from its start."""

    def __init__(
        self, scene: Any, runners: Sequence[SensorRunner], clock: Clock, first: int, last: int
    ) -> None:
        self._runners = runners
        self._first, self._last = first, last
        self._substeps = clock.substeps
        self._frame_start = clock.frame_start
        self._until: Index = np.zeros(0, np.intp)
        self._from: int | None = None
        # What is kept of frames; all else of the scene is looked for in it, at its frame.
        self.kept = KEPT | ({FORCES} if _weights_stay(scene) else set())
        starts = frames_to_step_from(scene)
        if starts:
            self._from = (min(starts) - clock.frame_start) * self._substeps

    @property
    def allows_batches(self) -> bool:
        """Whether frames may be kept: any may be gone back to, and no pad must be read at its
        own."""
        pads = any(runner.sensor.kind.requires_forces for runner in self._runners)
        return self._from is None and (not pads or FORCES in self.kept)

    def windows(self, cuts: Iterable[int] = ()) -> Iterator[Window]:
        """All of it, a stretch of time after the other; one begins at each of the steps `cuts`, and
        its first step is looked at anew."""
        substeps = self._substeps
        begin, end = self._first - self._first % substeps, self._last + 1
        if any(runner.sensor.kind.requires_forces for runner in self._runners):
            begin, end = begin - substeps, end + 2 * substeps
        if self._from is not None:
            begin = min(begin, self._from)
        size = WINDOW - WINDOW % substeps
        inside = [cut for cut in cuts if begin < cut < end]
        for start, stop in pairwise(sorted({*range(begin, end, size), *inside, end})):
            if start in inside:
                self._until = self._until[:0]
            yield self._window(start, stop)

    def fresh(self, window: Window, still: Stillness) -> NDArray[np.bool_]:
        """At which of the window's steps (n,) anything may be otherwise than at the step before."""
        last, self._until = self._until, window.steps[-1:]
        steps = np.concatenate([last, window.steps])
        if not len(steps):
            return np.zeros(0, bool)
        frames, parts = self._frame_start + steps // self._substeps, steps % self._substeps
        return still.fresh(frames, parts / self._substeps)[len(last) :]

    def _window(self, begin: int, end: int) -> Window:
        """The steps from `begin` to before `end`."""
        dates = [self._dates(runner, begin, end - 1) for runner in self._runners]
        parts = [own.steps for own in dates]
        motion: list[Index] = []
        pads: dict[SensorRunner, Index] = {}
        read: dict[int, list[SensorRunner]] = {}
        for runner, own in zip(self._runners, dates, strict=True):
            if runner.sensor.kind.requires_forces:
                frames = pads[runner] = self._frames_moved(runner, begin, end)
                motion += [frames - self._substeps, frames, frames + self._substeps]
            if not (runner.steady and set(runner.sensor.kind.needs) <= self.kept):
                for step in own.steps.tolist():
                    read.setdefault(step, []).append(runner)
        # Before time begins nobody looks at the motion.
        parts += [steps[steps >= 0] for steps in motion]
        looked: Container[int] = range(begin, end)
        if self._from is not None:
            through = np.arange(max(begin, self._from), min(end, self._last + 1), self._substeps)
            looked = frozenset(np.concatenate([through[:0], *parts]).tolist())
            parts.append(through)
        steps = np.unique(np.concatenate([np.zeros(0, np.int64), *parts]))
        steps = steps[(steps >= begin) & (steps < end)]
        moved = np.unique(np.concatenate([steps[:0], *motion]))
        every = dict(zip(self._runners, dates, strict=True))
        return Window(begin, steps, looked, every, moved, pads, read)

    def _frames_moved(self, runner: SensorRunner, begin: int, end: int) -> Index:
        """The whole frames, as steps, of the updates in a window and just outside of it."""
        first, last = max(begin - 2 * self._substeps, self._first), end + 2 * self._substeps
        steps = runner.schedule.between(first, min(last, self._last))[1]
        return np.unique(steps - steps % self._substeps)

    def _dates(self, runner: SensorRunner, first: int, last: int) -> Dates:
        """The updates from step `first` to `last`; and the steps between two, where the sensor
        watches."""
        schedule = runner.schedule
        first, last = max(first, self._first), min(last, self._last)
        numbers, steps = schedule.between(first, last)
        due = np.ones(len(steps), bool)
        if runner.watches:
            start = schedule.step(max(schedule.last_update(self._first - 1) + 1, 0))
            end = schedule.step(schedule.last_update(self._last))
            every = np.arange(max(first, start), min(last, end) + 1)
            due = np.isin(every, steps)
            spacing = schedule.steps_per_update
            numbers = every * spacing.denominator // spacing.numerator + ~due
            steps = every
        return Dates(steps, numbers, due)


def _weights_stay(scene: Any) -> bool:
    """Whether forces on pads change with places and shapes alone: the scene has no rigid bodies,
    and nothing animates a mass or gravity."""
    return scene.rigidbody_world is None and not any(
        may_set(owner, *WEIGHT) for owner in all_animated()
    )


# s: so often at least what is kept is sensed, so that a run tells how far it is.
TELL_EVERY = 0.25


@dataclass
class FrameBatch:
    """Frames that the probes store until the sensors sense them. Frame i is the scene from
    `steps[i]` until the next of the steps, the newest until the step `last`. `reads`: parameters
    and pose, by runner and frame, of sensors that change from frame to frame. `since`: the start of
    the batch by `time.monotonic`, s."""

    steps: list[int] = field(default_factory=list)
    last: int = -1
    reads: dict[tuple[SensorRunner, int], Read | None] = field(default_factory=dict)
    since: float = field(default_factory=time.monotonic)

    def frames(self, steps: Index) -> Index:
        """The frames (n,) at these steps (n,)."""
        return np.searchsorted(np.array(self.steps), steps, side="right") - 1

    def part(self, steps: Index) -> Index:
        """Those of the ascending steps (n,) that are in the batch."""
        return steps[slice(*np.searchsorted(steps, (self.steps[0], self.last + 1)))]

    def reads_of(self, runner: SensorRunner, frames: Index) -> list[Read | None] | None:
        """Parameters and poses of a sensor at frames (n,); None for one that does not change."""
        if (runner, int(frames[0])) not in self.reads:
            return None
        return [self.reads[runner, frame] for frame in frames.tolist()]


class Stage:
    """Sensors of a scene and the probes that read the scene for them. `lit`: updates of light
    sensors whose light is not measured yet. `batches`: whether frames may be stored and sensed
    later, many at once."""

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
        # What was edited before must not be taken for what changes at a frame.
        evaluated_depsgraph()
        self.probes = Probes(scene)
        self.probes.serve(runner.sensor for runner in runners)
        self.lit: list[PendingUpdates] = []
        sensors = [runner.sensor for runner in runners]
        warm = any(sensor.kind.requires(WARMTH, sensor.parameters) for sensor in sensors)
        coloured = any(sensor.kind.requires(REFLECTANCE, sensor.parameters) for sensor in sensors)
        changes = (warm and changes_by_itself(scene)) or (coloured and colours_change())
        self._batches = batches and not changes
        self._moving = moving if self._batches else None
        self._pads = Pads(self.runners, self._clock, self.probes)
        self._batch = FrameBatch()

    @property
    def has_sensed_all(self) -> bool:
        """Whether nothing is kept that was not sensed yet."""
        return not self._batch.steps

    @property
    def is_due(self) -> bool:
        """Whether it is time to sense what is kept, and to tell how far the run is."""
        return not self._batches or time.monotonic() - self._batch.since > TELL_EVERY

    @property
    def last_step(self) -> int | None:
        """The last of the steps that are kept; None where there is none."""
        return self._batch.last if self._batch.steps else None

    def resume(self) -> bool:
        """Others had their turn, and may have edited the scene. Returns whether what moves has to
        be found anew, for `begin_anew`: it may be something else now."""
        # What was edited must not be taken for what changes at a frame.
        evaluated_depsgraph()
        self.probes.note_edits()
        return self._moving is not None and self.probes.must_list

    def begin_anew(self, moving: MovingScene | None) -> None:
        """The scene was edited while nothing was kept: other things move now."""
        self.probes.note_edits()
        self._moving = moving if self._batches else None

    def go(self, step: int) -> Any:
        """Evaluates the scene at a step; returns the depsgraph."""
        frame, subframe = self._clock.frame_and_subframe(step)
        self.scene.frame_set(frame, subframe=subframe)
        return evaluated_depsgraph()

    def visit(self, window: Window, steps: list[int], fresh: bool) -> Iterator[PendingUpdates]:
        """Brings the scene to the first of some steps, at the others of which it is the same, and
        takes down what is asked of it there; where it is not `fresh`, it is as at the step before.
        Yields what can be read by then; what light sensors ask is in `lit`. Raises AngenError."""
        looked = [step for step in steps if step in window.looked]
        depsgraph, watched, is_whole = self._evaluate(window, steps[0], looked, fresh)
        if not looked:
            return
        if not self._batches:
            self.probes.look(depsgraph, None)
        elif not self.probes.keep(watched):
            if not self.has_sensed_all:
                # Things came or went: what was before is sensed while it is still there.
                yield from self.sense(window, self.go(self._batch.last))
                is_whole = False
            # What comes is not among what stood at an earlier frame.
            depsgraph = depsgraph if is_whole else self.go(steps[0])
            self.probes.keep_first(depsgraph, watched)
        before = self._batch.last
        self._batch.steps.append(looked[0])
        self._batch.last = looked[-1]
        try:
            self._take_down(window, looked, depsgraph)
        except AngenError:
            # Those before can be sensed nevertheless.
            self._batch.steps.pop()
            self._batch.last = before
            raise
        if self.is_due or self.probes.full:
            yield from self.sense(window, depsgraph)

    def _evaluate(
        self, window: Window, step: int, looked: list[int], fresh: bool
    ) -> tuple[Any, Any, bool]:
        """Brings the scene to a step, or if nothing more is asked there only what moves: the
        scene's depsgraph, that whose frames are kept, and whether the scene is at the step."""
        is_read = any(at in window.read for at in looked)
        self.probes.expect_light(is_read)
        if self._moving is None:
            depsgraph = self.go(step) if fresh else evaluated_depsgraph()
            return depsgraph, depsgraph, True
        whole = is_read or not self.probes.follows
        depsgraph = self.go(step) if whole else evaluated_depsgraph()
        # The scene itself has told of what light depends on.
        self.probes.expect_light(False)
        return depsgraph, self._moving.go(*self._clock.frame_and_subframe(step)), whole

    def _take_down(self, window: Window, looked: list[int], depsgraph: Any) -> None:
        """What must be read at the steps themselves, at all of which the scene is the same."""
        frame = len(self._batch.steps) - 1
        for runner in {r: None for step in looked for r in window.read.get(step, ())}:
            read = runner.read(depsgraph, self.probes.edits)
            self._batch.reads[runner, frame] = read
            if runner.sensor.kind.requires_light:
                dates = window.dates[runner].between(looked[0], looked[-1])
                frames = self._batch.frames(dates.steps)
                self.lit.extend(runner.pending(dates, frames, [read], depsgraph, self.probes))

    def sense(self, window: Window, depsgraph: Any) -> Iterator[PendingUpdates]:
        """Yields the updates at the steps of the batch and begins the next batch. The caller asks
        each for its readings before it takes the next."""
        batch, self._batch = self._batch, FrameBatch()
        if not batch.steps:
            return
        self.probes.develop(depsgraph)
        for runner, dates in window.dates.items():
            kind, due = runner.sensor.kind, dates.between(batch.steps[0], batch.last)
            if kind.requires_light or not len(due.steps):
                continue
            frames = batch.frames(due.steps)
            reads = batch.reads_of(runner, frames)
            if reads is None:
                reads = [runner.read(depsgraph, self.probes.edits)]
            if kind.requires_forces:
                self._pads.wait(runner, due, reads)
            else:
                yield from runner.pending(due, frames, reads, depsgraph, self.probes)
        moved = batch.part(window.motion)
        pads = {runner: batch.part(steps) for runner, steps in window.pads.items()}
        if len(moved):
            yield from self._pads.sense(moved, batch.frames(moved), pads, depsgraph)

    def measure(self, alone: bool) -> Iterator[str]:
        """Measures the light that is asked for; yields before each picture, in words what takes
        long. Whoever lets others have their turn there senses first what is kept. `alone`: nothing
        but frames will change until the end. Raises AngenError."""
        # Of one that is due at several steps at which the scene is the same, the same is asked.
        asked = {p.request.name: p.request for p in self.lit if p.request is not None}
        if asked:
            # A picture of the light makes Blender evaluate the scene anew: it comes last.
            view_layer, depsgraph = bpy.context.view_layer, evaluated_depsgraph()
            what = self.scene, view_layer, depsgraph, [*asked.values()]
            found = yield from self.probes.measure(*what, alone)
            for pending in self.lit:
                pending.give_light(found)

    def take_lit(self) -> list[PendingUpdates]:
        """The updates of light sensors whose light was measured."""
        lit, self.lit = self.lit, []
        return lit

    def close(self) -> None:
        """Removes from the file what was kept there."""
        self.probes.close()
