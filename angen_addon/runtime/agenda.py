# SPDX-License-Identifier: GPL-3.0-or-later
"""Which steps of the clock a run looks at, and which sensors are due there."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.clock import Clock
from ...sensor_logic.kind import CROSSINGS, FORCES, RAYS, REFLECTANCE, WARMTH
from ...sensor_logic.model import Index
from ..scene.animation import all_animated, may_set
from ..scene.timed import frames_to_step_from
from .sensor_runner import Dates, SensorRunner
from .stillness import Stillness

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
