# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates a scene at the steps of a run, stores what its sensors need of each frame, and lets the
sensors that are due sense a batch of frames at once."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.error import AngenError
from ...sensor_logic.kind import REFLECTANCE, WARMTH
from ...sensor_logic.model import Index
from ..scene.reflectance import colours_change
from ..scene.warmth import changes_by_itself
from .agenda import Window
from .moving_scene import MovingScene
from .pads import Pads
from .probes import Probes
from .sensor_runner import PendingUpdates, Read, SensorRunner
from .time_base import clock_of, evaluated_depsgraph

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
            yield from self.probes.measure(
                self.scene, view_layer, depsgraph, [*asked.values()], alone
            )

    def take_lit(self) -> list[PendingUpdates]:
        """The updates of light sensors whose light was measured."""
        lit, self.lit = self.lit, []
        return lit

    def close(self) -> None:
        """Removes from the file what was kept there."""
        self.probes.close()
