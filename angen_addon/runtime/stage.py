# SPDX-License-Identifier: GPL-3.0-or-later
"""What simulating, live sensing and explaining have in common: the scene is brought to a step, what
the sensors need of it there is kept, and those that are due sense, many steps at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.model import Index
from .agenda import Window
from .probes import Probes
from .sensor_runner import Dates, PendingUpdates, Read, SensorRunner
from .time_base import evaluated_depsgraph


@dataclass
class Kept:
    """The `steps` of which the probes keep frames, to be sensed, and what was read of sensors that
    change from one to the next."""

    steps: list[int] = field(default_factory=list)
    reads: dict[tuple[SensorRunner, int], Read | None] = field(default_factory=dict)

    def frames(self, dates: Dates) -> Index:
        """Which of the frames (n,) are those of the dates."""
        return np.searchsorted(np.array(self.steps), dates.steps)

    def reads_of(self, runner: SensorRunner, dates: Dates) -> list[Read | None] | None:
        """What was read of a sensor at its dates; None of one that stays as it is."""
        steps = dates.steps.tolist()
        if (runner, steps[0]) not in self.reads:
            return None
        return [self.reads[runner, step] for step in steps]


class Stage:
    """The sensors of a scene and the probes that look at it for them. `lit` are the updates of
    light sensors until their light was measured. `batches`: whether frames may be kept, to be
    sensed later, many at once."""

    def __init__(self, scene: Any, runners: Sequence[SensorRunner], batches: bool = False) -> None:
        self.scene = scene
        self.runners = list(runners)
        self.probes = Probes(scene)
        self.probes.serve(runner.sensor for runner in runners)
        self.lit: list[PendingUpdates] = []
        self._batches = batches
        self._pads: list[PendingUpdates] = []
        self._kept = Kept()

    @property
    def has_sensed_all(self) -> bool:
        """Whether nothing is kept that was not sensed yet."""
        return not self._kept.steps

    @property
    def last_step(self) -> int | None:
        """The last of the steps that are kept; None where there is none."""
        return self._kept.steps[-1] if self._kept.steps else None

    def go(self, step: int) -> Any:
        """Evaluates the scene at a step; returns the depsgraph."""
        frame, subframe = self.runners[0].clock.frame_and_subframe(step)
        self.scene.frame_set(frame, subframe=subframe)
        return evaluated_depsgraph()

    def visit(self, window: Window, step: int, fresh: bool) -> Iterator[PendingUpdates]:
        """Brings the scene to a step and takes down what is asked of it there; where it is not
        `fresh`, nothing is otherwise than at the step before. Yields what can be read by then; what
        light sensors ask is in `lit`. Raises SensorError."""
        depsgraph = self.go(step) if fresh else evaluated_depsgraph()
        if step not in window.looked:
            return
        self._take_down(window, step, depsgraph)
        yield from self._ready(step)
        yield from self.sense(window, depsgraph)

    def _take_down(self, window: Window, step: int, depsgraph: Any) -> None:
        clock = self.runners[0].clock
        whole = clock.frame_and_subframe(step)[0]
        pads = [runner.sensor for runner in window.pads.get(step, ())]
        self.probes.look(depsgraph, whole if step in window.motion else None, pads)
        self._kept.steps.append(step)
        for runner, number, due in window.read.get(step, ()):
            read = runner.read(depsgraph, self.probes.edits)
            kind = runner.sensor.kind
            if not (kind.motion or kind.light):
                self._kept.reads[runner, step] = read
                continue
            at = Dates.of(step, number, due)
            found = runner.pending(at, self._kept.frames(at), [read], depsgraph, self.probes)
            (self._pads if kind.motion else self.lit).extend(found)

    def _ready(self, step: int) -> list[PendingUpdates]:
        """The pads' updates whose next frame has come."""
        clock = self.runners[0].clock
        frame = clock.frame_and_subframe(step)[0]
        ready = [p for p in self._pads if clock.frame_and_subframe(p.steps[0])[0] < frame]
        self._pads = [p for p in self._pads if p not in ready]
        return ready

    def sense(self, window: Window, depsgraph: Any) -> Iterator[PendingUpdates]:
        """The updates at the steps that were kept, which are forgotten then. Each is to be asked
        for its readings before the next."""
        kept, self._kept = self._kept, Kept()
        if not kept.steps:
            return
        for runner, dates in window.dates:
            kind, due = runner.sensor.kind, dates.between(kept.steps[0], kept.steps[-1])
            if kind.motion or kind.light or not len(due.steps):
                continue
            reads = kept.reads_of(runner, due)
            if reads is None:
                reads = [runner.read(depsgraph, self.probes.edits)] * len(due.steps)
            yield from runner.pending(due, kept.frames(due), reads, depsgraph, self.probes)

    def measure(self, alone: bool) -> Iterator[str]:
        """Measures the light that is asked for; yields before each picture, in words what takes
        long. `alone`: nothing but frames will change until the end. Raises SensorError."""
        asked = [pending.request for pending in self.lit if pending.request is not None]
        if asked:
            # A picture of the light makes Blender evaluate the scene anew: it comes last.
            view_layer, depsgraph = bpy.context.view_layer, evaluated_depsgraph()
            yield from self.probes.measure(self.scene, view_layer, depsgraph, asked, alone)

    def take_lit(self) -> list[PendingUpdates]:
        """The updates of light sensors whose light was measured."""
        lit, self.lit = self.lit, []
        return lit

    def close(self) -> None:
        """Removes from the file what was kept there."""
        self.probes.close()
