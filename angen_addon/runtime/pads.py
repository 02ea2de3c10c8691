# SPDX-License-Identifier: GPL-3.0-or-later
"""The pads of a run: forces are computed at frames at which something moves.

At all other frames, the forces before stay valid.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...sensor_logic.clock import Clock
from ...sensor_logic.forces.world import PadForces
from ...sensor_logic.model import Index
from ..scene.sensor_reader import Read
from .probes import Probes
from .sensor_runner import PendingUpdates, SensorRunner, SensorSteps

# Identifies a state of what a pad can feel; frames between which nothing of it moves have the same.
State = tuple[Any, ...]


@dataclass
class _Pad:
    """A pad in a run. Frames between which nothing moves that it feels have the same `State`.

    Attributes
    ----------
    states
        The state by step, for the last steps at which the motion was read.
    due
        The state that decides the forces, by the step of each whole frame with updates.
    needed
        The state of the scene, by each step at which forces are not computed yet.
    forces
        The computed forces by the state of the scene.
    waiting
        The updates whose forces are not computed yet: their steps, and the parameters and poses.
    """

    runner: SensorRunner
    states: dict[int, State] = field(default_factory=dict)
    due: dict[int, State] = field(default_factory=dict)
    needed: dict[int, State] = field(default_factory=dict)
    forces: dict[State, PadForces] = field(default_factory=dict)
    waiting: list[tuple[SensorSteps, list[Read | None]]] = field(default_factory=list)

    @property
    def size(self) -> int:
        return self.runner.clock.substeps

    def note_due(self, steps: Iterable[int]) -> None:
        """Register the steps of whole frames at which forces will be queried.

        If nothing moves from the frame before to the frame after, the step gets their state.
        Otherwise the step gets a new state.
        """
        for step in steps:
            near = [self.states.get(step + self.size * i) for i in (-1, 0, 1)]
            still = near[0] is not None and near[0] == near[1] == near[2]
            state = self.due[step] = (near[1] if still else None) or (step,)
            if state not in self.forces and state not in self.needed.values():
                self.needed[step] = state

    def ready(self) -> Iterator[tuple[SensorSteps, list[Read | None]]]:
        """Yield the steps, and the parameters and poses, of updates whose forces are computed."""
        waiting, self.waiting = self.waiting, []
        for sensor_steps, reads in waiting:
            known = [self.state_at(step) in self.forces for step in sensor_steps.steps.tolist()]
            count = known.index(False) if False in known else len(known)
            if count:
                yield sensor_steps.part(slice(count)), reads[:count]
            if count < len(known):
                rest = reads[count:] if len(reads) > 1 else reads
                self.waiting.append((sensor_steps.part(slice(count, None)), rest))

    def state_at(self, step: int) -> State | None:
        """Return the state that decides the forces at a step; None if the pad has no update."""
        return self.due.get(step - step % self.size)

    def known(self, sensor_steps: SensorSteps) -> dict[int, PadForces]:
        """Return the computed forces at the steps of updates, by the whole frame of each step."""
        clock, steps = self.runner.clock, sensor_steps.steps.tolist()
        found = {step: self.forces[self.due[step - step % self.size]] for step in steps}
        return {clock.frame_and_subframe(step)[0]: forces for step, forces in found.items()}

    def forget(self) -> None:
        """Remove the states and forces that no later update needs, except the last forces."""
        self.states = {step: self.states[step] for step in sorted(self.states)[-2:]}
        first = min(
            (sensor_steps.steps[0] for sensor_steps, _ in self.waiting),
            default=max(self.due, default=0),
        )
        self.due = {step: state for step, state in self.due.items() if step >= first - self.size}
        last = [*self.forces][-1:]
        needed = {*self.due.values(), *last}
        self.forces = {state: self.forces[state] for state in self.forces if state in needed}


class Pads:
    """All pads of a run, with their updates that wait until the probes have computed forces."""

    def __init__(
        self,
        scene: Any,
        runners: Sequence[SensorRunner],
        clock: Clock,
        probes: Probes,
        weights_stay: bool,
    ) -> None:
        """Prepare the pads among `runners`.

        `weights_stay` says whether forces on pads depend only on the poses and shapes of objects.
        """
        self._pads = {r: _Pad(r) for r in runners if r.sensor.kind.requires_forces}
        self._scene, self._weights_stay = scene, weights_stay
        self._probes = probes
        self._clock = clock

    def wait(
        self, runner: SensorRunner, sensor_steps: SensorSteps, reads: list[Read | None]
    ) -> None:
        """Add updates of a pad, which wait for its forces.

        `reads` has the parameters and pose at each step, or a single entry for all steps.
        """
        self._pads[runner].waiting.append((sensor_steps, reads))

    def sense(self, steps: Index, due: dict[SensorRunner, Index]) -> Iterator[PendingUpdates]:
        """Yield the updates of pads whose forces are known, since the next frame was evaluated.

        Parameters
        ----------
        steps
            The steps (n,) of whole frames, in the probes' batch, at which the motion is to be read.
        due
            For each pad, the steps of the whole frames with updates.
        """
        needed, frames = set(steps[-2:].tolist()), self._probes.frames.at(steps)
        for runner, pad in self._pads.items():
            pad.states |= zip(steps.tolist(), self._states(pad, frames), strict=True)
            pad.note_due(due[runner].tolist())
            needed.update(step + pad.size * i for step in pad.needed for i in (-1, 0, 1))
        for step, frame in zip(steps.tolist(), frames.tolist(), strict=True):
            if step in needed:
                self._look(step, frame)
        self._probes.show(-1)
        for runner, pad in self._pads.items():
            for sensor_steps, reads in pad.ready():
                forces, frames = pad.known(sensor_steps), 0 * sensor_steps.steps
                for update in runner.updates(sensor_steps, frames, reads, self._probes):
                    update.give_forces(forces)
                    yield update
            pad.forget()

    def _states(self, pad: _Pad, frames: Index) -> list[State]:
        """Return the state (n,) of what a pad can feel at frames (n,) of the batch, by index."""
        solids = self._probes.caster.solids
        near = self._weights_stay and self._probes.states_near(pad.runner.uid, self._scene)
        if not near:
            return [(solids.syncs, frame) for frame in frames.tolist()]
        listed = solids.listing, solids.edits, len(self._probes.frames.rows)
        return [(*listed, near[frame]) for frame in frames.tolist()]

    def _look(self, step: int, index: int) -> None:
        """Read how objects move at a step, and compute the needed forces at the frame before.

        `index` is that of the step's frame in the batch.
        """
        due = [pad.runner.sensor for pad in self._pads.values() if step in pad.needed]
        whole = self._clock.frame_and_subframe(step)[0]
        self._probes.look_at_motion(whole, due, index)
        for pad in self._pads.values():
            state = pad.needed.pop(step - self._clock.substeps, None)
            if state is not None:
                pad.forces[state] = self._probes.forces(pad.runner.uid, whole - 1)
