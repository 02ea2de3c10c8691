# SPDX-License-Identifier: GPL-3.0-or-later
"""Where sensor models meet the scene: a runner for each sensor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.clock import Clock, Schedule
from ...sensor_logic.kind import CROSSINGS, RAYS
from ...sensor_logic.model import Index, Pose, Reading, Readings, Update, Updates
from ...sensor_logic.noise import generator
from ..scene.animation import is_animated, stays
from ..scene.instances import Uid
from ..scene.light.four_walls import view_rays
from ..scene.light.probe import LightRequest
from ..scene.rays.caster import RayCaster
from ..scene.sensors import Sensor, check_evaluated, decimal, read_parameters, read_pose, unit_scale
from .answers import ANSWERS, beside_of, light_request
from .probes import Probes
from .trace import CAST, Question, RaysMet, Read, Trace


@dataclass(frozen=True)
class Dates:
    """The `steps` (n,) at which one sensor looks at the scene, each with the update's number, or
    where none is `due` that of the next."""

    steps: Index
    numbers: Index
    due: NDArray[np.bool_]

    @classmethod
    def of(cls, step: int, number: int, due: bool = True) -> Dates:
        """A single one."""
        return cls(np.array([step]), np.array([number]), np.array([due]))

    def part(self, which: slice) -> Dates:
        return Dates(self.steps[which], self.numbers[which], self.due[which])

    def between(self, first: int, last: int) -> Dates:
        """Those from step `first` to `last`."""
        return self.part(slice(*np.searchsorted(self.steps, (first, last + 1))))


@dataclass(frozen=True)
class PendingUpdates:
    """Updates of a sensor with all that is known of the scene at their `steps`. Their readings are
    to be asked for once: at once; of a kind that needs the motion, after the next frame; of a light
    sensor, after its `request` was measured."""

    runner: SensorRunner
    steps: list[int]
    parameters: Any
    updates: Updates
    request: LightRequest | None = None

    def readings(self) -> Readings:
        """Of the updates that are due."""
        made: Readings = self.runner.model.sense(self.parameters, self.updates)
        return made

    def reading(self) -> Reading:
        """Of the last of them."""
        return self.readings()[-1]

    @property
    def update(self) -> Update:
        """The first of them."""
        return self.updates[0]


class SensorRunner:
    """A sensor with its schedule and the state of its model."""

    def __init__(self, sensor: Sensor, clock: Clock) -> None:
        self.sensor = sensor
        self.clock = clock
        self.uid: Uid = sensor.uid
        self.schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        self.watches = self._watches()
        self.trace = Trace(sensor)
        self._edits = 0
        self._steady: bool | None = None
        self.reset()

    @property
    def casts(self) -> bool:
        """Whether its reading waits for no light and no motion, as of what casts rays."""
        return not (self.sensor.kind.requires_light or self.sensor.kind.requires_forces)

    @property
    def steady(self) -> bool:
        """Whether the sensor stays as it is until the next edit."""
        if self._steady is None:
            paths = (f"angen_sensor.{self.sensor.kind.attribute}.", "angen_sensor.enabled")
            parts = self.sensor.object, *self.sensor.holders
            self._steady = all(stays(part, *paths, "hide_viewport") for part in parts)
        return self._steady

    def _watches(self) -> bool:
        """Whether it looks at the steps between its updates too, at some frame at least."""
        kind, group = self.sensor.kind, self.sensor.parameters
        choices = kind.needs.get(CROSSINGS)
        return choices is not None and all(
            getattr(group, name) == value
            or is_animated(self.sensor.object, f"angen_sensor.{kind.attribute}.{name}")
            for name, value in choices
        )

    def reset(self) -> None:
        """Forgets earlier updates, as after a jump of the playhead."""
        self.model = self.sensor.kind.model()
        self._pose: tuple[Any, float, Pose] | None = None
        self._read: Read | None = None
        self.trace.forget()

    def read(self, depsgraph: Any, edits: int) -> Read | None:
        """The parameters and the pose after so many `edits` of the scene; None while the sensor is
        switched off. Raises AngenError."""
        known, metres = self._read, unit_scale(depsgraph.scene)
        if self._edits != edits:
            self._edits, self._steady = edits, None
        elif known is not None and known.metres == metres and known.beside is None and self.steady:
            return known
        self._read = None
        evaluated = self.sensor.object.evaluated_get(depsgraph)
        settings = self.sensor.settings_in(evaluated)
        if not settings.enabled:
            return None
        check_evaluated(self.sensor, depsgraph)
        parameters = read_parameters(self.sensor, settings)
        pose = self._pose_now(self.sensor.world_matrix(depsgraph), metres)
        beside = beside_of(self.sensor, evaluated, depsgraph, metres)
        if known is None or not known.same(metres, parameters, pose, beside):
            known = Read(metres, parameters, pose, beside)
        self._read = known
        return known

    def _pose_now(self, matrix: Any, metres: float) -> Pose:
        """The pose, the same object as long as the sensor stands still."""
        known = self._pose
        if known is None or known[0] != matrix or known[1] != metres:
            known = (matrix.copy(), metres, read_pose(self.sensor, matrix, metres))
            self._pose = known
        return known[2]

    def take(
        self, number: int, step: int, depsgraph: Any, probes: Probes, due: bool = True
    ) -> PendingUpdates | None:
        """Update `number` at the scene's present state; None while the sensor is switched off.
        Raises AngenError."""
        read, frame = self.read(depsgraph, probes.edits), np.array([probes.frame])
        return next(
            self.pending(Dates.of(step, number, due), frame, [read], depsgraph, probes), None
        )

    def watch(self, step: int, depsgraph: Any, probes: Probes) -> None:
        """Looks at a step between two updates. Raises AngenError."""
        number = self.schedule.last_update(step) + 1
        pending = self.take(number, step, depsgraph, probes, due=False)
        if pending is not None:
            pending.readings()

    def pending(
        self,
        dates: Dates,
        frames: Index,
        reads: Sequence[Read | None],
        depsgraph: Any,
        probes: Probes,
    ) -> Iterator[PendingUpdates]:
        """What the sensor asks of the scene at its dates (n,), which follow each other without a
        gap: as one as long as it stays as it was read then. `reads` are (n,), or one for all;
        `frames` (n,) tells which of those that the probes keep the dates are. Each is to be asked
        for its readings before the next is made."""
        begins = [i for i in range(len(reads)) if i == 0 or reads[i] is not reads[i - 1]]
        ends = [*begins[1:], len(dates.steps)]
        for begin, end in zip(begins, ends, strict=True):
            read, part = reads[begin], slice(begin, end)
            if read is None:
                self.reset()
            else:
                yield self._pending(read, dates.part(part), frames[part], depsgraph, probes)

    def _pending(
        self, read: Read, dates: Dates, frames: Index, depsgraph: Any, probes: Probes
    ) -> PendingUpdates:
        when = self.clock, read, dates.steps.tolist(), frames
        question = Question(self.sensor, *when, depsgraph, probes, self.trace)
        needs = self.sensor.kind.needs
        scene, name = depsgraph.scene, self.sensor.stands_for or self.sensor.name
        updates = Updates(
            dates.numbers,
            self.clock.times_and_frames(dates.steps)[0],
            dates.due,
            read.pose,
            {need: partial(ANSWERS[need], question) for need in needs},
            partial(generator, scene.angen_seed, name),
            partial(generator, scene.angen_seed, f"{name}, part", 0),
        )
        request = None
        if self.sensor.kind.requires_light:
            request = light_request(
                self.sensor, read.parameters, read.pose, read.metres, self.steady
            )
        due = dates.steps[dates.due].tolist()
        updates = self.trace.listen(question, updates)
        return PendingUpdates(self, due, read.parameters, updates, request)


def all_rays(
    sensor: Sensor, clock: Clock, depsgraph: Any, probes: Probes | None = None
) -> Trace | None:
    """All rays that a sensor's model ever casts at the depsgraph's frame, update after update until
    they repeat; of a light sensor the axes and corners of its views. None while it is switched off.
    Its own readings go on as if nobody had looked.

    Without `probes` nothing is cast: only those rays are listed, by the model's RAYS, as if nothing
    was there. Raises AngenError.
    """
    apart, needs = SensorRunner(sensor, clock), CAST
    casts_views = probes is not None and sensor.kind.requires_light
    if probes is None:
        # These have never looked at the scene.
        probes, needs = Probes(depsgraph.scene, RayCaster()), {RAYS}
    read, trace = apart.read(depsgraph, probes.edits), apart.trace
    if read is None:
        return None
    trace.aim(read.parameters, read.pose)
    if casts_views:
        _cast_views(read, trace, probes)
    elif apart.casts and any(sensor.kind.requires(need, read.parameters) for need in needs):
        number, known = 0, -1
        while len(trace.bundles) > known:
            known = len(trace.bundles)
            dates, frame = Dates.of(apart.schedule.step(number), number), np.array([probes.frame])
            apart._pending(read, dates, frame, depsgraph, probes).readings()
            number += 1
    return trace


def _cast_views(read: Read, trace: Trace, probes: Probes) -> None:
    """Cast the axis and the corners of each view of a light sensor."""
    sensor, metres = trace.sensor, read.metres
    request = light_request(sensor, read.parameters, read.pose, metres, False)
    if request.method == "FOUR_WALL":
        for wall, rays in enumerate(zip(*view_rays(request), strict=True)):
            ranges = probes.caster.cast(sensor.uid, wall, *rays)
            origins, directions, reach = rays
            met = RaysMet(origins * metres, directions, reach * metres, ranges * metres)
            trace.show(wall, met)
