# SPDX-License-Identifier: GPL-3.0-or-later
"""Pads in a run: their forces are worked out at frames at which the scene moves, and hold at all
others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...sensor_logic.clock import Clock
from ...sensor_logic.contact.world import PadForces
from ...sensor_logic.model import Index
from .probes import Probes
from .sensor_runner import Dates, PendingUpdates, Read, SensorRunner

# What tells the scene at one frame from that at others.
State = tuple[int, ...]


@dataclass
class _Pad:
    """What is known of a pad, by whole frames as steps: the `states` of the scene at the last steps
    at which the motion was needed, what tells the forces at those at which it is due, and at which
    of these they are to be worked out (`asked`); the `forces` that are known; and the updates that
    wait for the frame after theirs."""

    runner: SensorRunner
    states: dict[int, State] = field(default_factory=dict)
    due: dict[int, State] = field(default_factory=dict)
    asked: dict[int, State] = field(default_factory=dict)
    forces: dict[State, PadForces] = field(default_factory=dict)
    waiting: list[tuple[Dates, list[Read | None]]] = field(default_factory=list)

    @property
    def size(self) -> int:
        """Steps in a frame."""
        return self.runner.clock.substeps

    def note_due(self, steps: Iterable[int]) -> None:
        """Takes down frames at which the forces will be asked for."""
        for step in steps:
            near = [self.states.get(step + self.size * i) for i in (-1, 0, 1)]
            still = near[0] is not None and near[0] == near[1] == near[2]
            state = self.due[step] = (near[1] if still else None) or (step,)
            if state not in self.forces and state not in self.asked.values():
                self.asked[step] = state

    def ready(self) -> Iterator[tuple[Dates, list[Read | None]]]:
        """The updates whose forces are known."""
        waiting, self.waiting = self.waiting, []
        for dates, reads in waiting:
            known = [self.state_at(step) in self.forces for step in dates.steps.tolist()]
            count = known.index(False) if False in known else len(known)
            if count:
                yield dates.part(slice(count)), reads[:count]
            if count < len(known):
                rest = reads[count:] if len(reads) > 1 else reads
                self.waiting.append((dates.part(slice(count, None)), rest))

    def state_at(self, step: int) -> State | None:
        return self.due.get(step - step % self.size)

    def known(self, dates: Dates) -> dict[int, PadForces]:
        """The forces at updates that are ready, by the frame."""
        clock, steps = self.runner.clock, dates.steps.tolist()
        found = {step: self.forces[self.due[step - step % self.size]] for step in steps}
        return {clock.frame_and_subframe(step)[0]: forces for step, forces in found.items()}

    def forget(self) -> None:
        """What is not needed for updates to come, but what held last."""
        self.states = {step: self.states[step] for step in sorted(self.states)[-2:]}
        first = min((dates.steps[0] for dates, _ in self.waiting), default=max(self.due, default=0))
        self.due = {step: state for step, state in self.due.items() if step >= first - self.size}
        last = [*self.forces][-1:]
        kept = {*self.due.values(), *last}
        self.forces = {state: self.forces[state] for state in self.forces if state in kept}


class Pads:
    """The pads among the sensors of a run, whose probes tell the forces."""

    def __init__(self, runners: Sequence[SensorRunner], clock: Clock, probes: Probes) -> None:
        self._pads = {r: _Pad(r) for r in runners if r.sensor.kind.requires_forces}
        self._probes = probes
        self._clock = clock

    def wait(self, runner: SensorRunner, dates: Dates, reads: list[Read | None]) -> None:
        """Updates to be sensed, with what was read of the pad at each."""
        self._pads[runner].waiting.append((dates, reads))

    def sense(
        self, steps: Index, frames: Index, due: dict[SensorRunner, Index], depsgraph: Any
    ) -> Iterator[PendingUpdates]:
        """The updates whose next frame has come. Of the `steps` (n,) at which the motion is needed,
        whole frames, `frames` (n,) tells which of those that the probes keep they are; at which of
        them pads are `due`."""
        needed = set(steps[-2:].tolist())
        syncs = self._probes.caster.solids.syncs
        states = {s: (syncs, f) for s, f in zip(steps.tolist(), frames.tolist(), strict=True)}
        for runner, pad in self._pads.items():
            pad.states |= states
            pad.note_due(due[runner].tolist())
            needed.update(step + pad.size * i for step in pad.asked for i in (-1, 0, 1))
        for step, frame in zip(steps.tolist(), frames.tolist(), strict=True):
            if step in needed:
                self._look(step, frame, depsgraph)
        self._probes.show(-1)
        for runner, pad in self._pads.items():
            for dates, reads in pad.ready():
                self._probes.known_forces = pad.known(dates)
                yield from runner.pending(dates, dates.steps * 0, reads, depsgraph, self._probes)
                self._probes.known_forces = {}
            pad.forget()

    def _look(self, step: int, frame: int, depsgraph: Any) -> None:
        """Looks at the motion at a step, and works out the forces at the frame before."""
        due = [pad.runner.sensor for pad in self._pads.values() if step in pad.asked]
        whole = self._clock.frame_and_subframe(step)[0]
        self._probes.show(frame)
        self._probes.look_at_motion(depsgraph, whole, due)
        for pad in self._pads.values():
            state = pad.asked.pop(step - self._clock.substeps, None)
            if state is not None:
                pad.forces[state] = self._probes.forces(pad.runner.uid, whole - 1)
