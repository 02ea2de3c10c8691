# SPDX-License-Identifier: GPL-3.0-or-later
"""Runners of sensors: each makes the updates of one sensor.

An update is one time at which a sensor senses and publishes. A runner takes the parameters and
poses of its sensor from a batch of captured frames. It then calls the sensor's model, which queries
the scene. The functions in `ANSWERS` answer these queries by the probes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.clock import Clock, Schedule
from ...sensor_logic.forces.world import PadForces
from ...sensor_logic.geometry.sweep import RayCrossings
from ...sensor_logic.kind import CROSSINGS, FORCES, LIGHT, POSES, RAYS, USES
from ...sensor_logic.logs.error import AngenError, explained
from ...sensor_logic.model import (
    Answers,
    Array,
    Index,
    LightSample,
    ObjectUse,
    PadContact,
    Pose,
    Reading,
    Readings,
    Updates,
)
from ...sensor_logic.noise import generator
from ...sensor_logic.parameters import specs
from ...sensor_logic.radio.echoes import ECHOES
from ..scene.animation import is_animated
from ..scene.instances import Uid
from ..scene.light.probe import LightRequest
from ..scene.light.views import view_rays
from ..scene.rays.caster import RayCaster
from ..scene.rays.sweep import TOLERANCE, SweptRays
from ..scene.sensor_reader import Read, SensorReader
from ..scene.sensors import NotPlaced, Sensor, decimal, read_parameters
from ..scene.surfaces import SURFACES
from ..scene.uses import check_watched, keyed_uses, may_change, watched_object
from .probes import Probes
from .trace import CAST, CastRays, PlacedStep, Query, Swept, Trace

# The index of the only frame of a batch.
PRESENT = np.zeros(1, np.intp)

# Answers to models' queries. In all of them, `indices` (k,) are those of the updates that a
# query is about; None means all. A new property of surfaces needs a probe in `scene/surfaces/`, any
# other quantity a function here and an entry in `ANSWERS`.


def answer_ranges(query: Query, bundle: int, *rays: Array, indices: Index | None = None) -> Answers:
    """Return the range in m of each ray of a bundle, at each update that a query is about.

    A bundle is a set of rays that the model casts together; `bundle` is its number. `rays` are the
    origins and directions (n, 3), and the lengths (n,) in m. `indices` (k,) are those of the
    updates; None means all.
    """
    frames = query.frames if indices is None else query.frames[indices]
    cast, in_units = query.probes.caster.cast_at, query.read.rays_in_units(*rays)
    found = cast(query.sensor.uid, query.bundle(bundle), in_units, frames)
    return Answers([query.read.in_metres(ranges) for ranges in found.table], found.rows)


def answer_surfaces(
    need: str,
    query: Query,
    bundle: int,
    origins: Array,
    directions: Array,
    length: Array,
    *details: Any,
    indices: Index | None = None,
) -> Answers:
    """Return a property of the surfaces that rays hit, such as their temperature.

    `need` is the name of the query, and decides which property. The other parameters are as for
    `answer_ranges`.

    `details` are arguments of the query besides the rays.
    """
    frames = query.frames if indices is None else query.frames[indices]
    known = query.sensor.uid, query.bundle(bundle)
    in_units = query.read.rays_in_units(origins, directions, length)
    return query.probes.surfaces[need].see(*known, in_units, frames, *details)


def answer_echoes(
    query: Query,
    bundle: int,
    origins: Array,
    directions: Array,
    length: Array,
    frequency: float,
    integration_time: float,
    indices: Index | None = None,
) -> Answers:
    """Return the `Echoes` that a radar gets along its rays.

    The speeds in the echoes are those during the `integration_time` (s) before each update. The
    radar's `frequency` is in GHz. The other parameters are as for `answer_ranges`.
    """
    clock, steps = query.clock, np.array(query.steps, np.intp)
    known = np.array([one.step for one in query.past], np.intp)
    within = clock.steps_within(integration_time)
    pasts = []
    for step in (steps if indices is None else steps[indices]).tolist():
        first, end = np.searchsorted(known, (step - within, step + 1)).tolist()
        # At least the step before, where the playhead has skipped frames.
        past = query.past[max(min(first, end - 2), 0) : end]
        pasts.append([(clock.step_time(one.step), one.places) for one in past])
    rays = origins, directions, length
    details = frequency, integration_time, pasts
    return answer_surfaces(ECHOES, query, bundle, *rays, *details, indices=indices)


def answer_poses(query: Query, name: str, indices: Index | None = None) -> Answers:
    """Return the pose of the object in the parameter `name`; None if the parameter is empty.

    `indices` is as for `answer_ranges`.
    """
    assert query.read.at_step is not None
    count = len(query.steps) if indices is None else len(indices)
    return Answers([query.read.at_step[POSES][name]], np.zeros(count, np.intp))


def answer_uses(query: Query, indices: Index | None = None) -> Answers:
    """Return whether the object that the sensor watches is in use, at each update of a query.

    `indices` is as for `answer_ranges`.
    """
    frames = query.frames if indices is None else query.frames[indices]
    sensor, captured = query.sensor, query.probes.frames
    with explained(f"'{sensor.name}'", NotPlaced, raised=AngenError):
        check_watched(sensor, captured.depsgraph)
    watched, used = watched_object(sensor), captured.used.get(sensor.name)
    if watched is None:
        return Answers([None], np.zeros(len(frames), np.intp))
    table = [ObjectUse(watched.name, False), ObjectUse(watched.name, True)]
    if used is None:
        return Answers(table, np.full(len(frames), int(watched.angen_use.in_use)))
    return Answers(table, used[frames].astype(np.intp))


def answer_crossings(
    query: Query, origins: Array, directions: Array, length: Array, indices: Index | None = None
) -> Answers:
    """Return how objects crossed the rays since the step before.

    An answer is None if the sensor did not sense at the step before. `indices` is as for
    `answer_ranges`.
    """
    chosen = np.arange(len(query.steps)) if indices is None else indices
    rays = origins, directions, length
    found = [_sweep(query, query.steps[i], int(query.frames[i]), rays) for i in chosen.tolist()]
    return Answers(found, np.arange(len(found)))


def _sweep(
    query: Query, step: int, frame: int, rays: tuple[Array, Array, Array]
) -> RayCrossings | None:
    before, metres = query.trace.swept, query.read.metres
    beam = SweptRays(matrix_of(query.read.pose, metres), *query.read.rays_in_units(*rays))
    if before is not None and before.beam.same(beam):
        # The earlier beam has computed its bounds.
        beam = before.beam
    sweeper = query.probes.sweeper
    now = sweeper.solids_at(frame)
    query.trace.swept = Swept(step, beam, now)
    if before is None or before.step != step - 1:
        return None
    found = sweeper.sweep(
        query.sensor.uid, before.solids, now, before.beam, beam, TOLERANCE / metres
    )
    near, far = map(query.read.in_metres, (found.near, found.far))
    return replace(found, near=near, far=far)


def answer_contact(query: Query, indices: Index | None = None) -> Answers:
    """Return the forces on a pad at all updates of a query."""
    assert query.read.at_step is not None
    weight, chosen = query.read.at_step[FORCES]
    table: list[PadContact] = []
    rows = []
    for step in query.steps:
        whole = query.clock.frame_and_subframe(step)[0]
        forces = query.forces[whole]
        if not table or table[-1].forces is not forces:
            table.append(PadContact(forces, weight, chosen))
        rows.append(len(table) - 1)
    return Answers(table, np.array(rows, np.intp))


def answer_light(query: Query, indices: Index | None = None) -> Answers:
    """Return the measured light, as one answer for all updates of a query."""
    assert query.light is not None
    return Answers([query.light], np.zeros(len(query.steps), np.intp))


ANSWERS: dict[str, Callable[..., Answers]] = {
    RAYS: answer_ranges,
    CROSSINGS: answer_crossings,
    FORCES: answer_contact,
    LIGHT: answer_light,
    POSES: answer_poses,
    USES: answer_uses,
    **{need: partial(answer_surfaces, need) for need in SURFACES},
    ECHOES: answer_echoes,
}


def matrix_of(pose: Pose, metres: float) -> Array:
    """Return the matrix (4, 4) of a pose, without scale, in Blender units."""
    matrix = np.eye(4)
    matrix[:3, :3] = pose.axes
    matrix[:3, 3] = pose.origin / metres
    return matrix


def light_request(
    sensor: Sensor, parameters: Any, pose: Pose, metres: float, steady: bool
) -> LightRequest:
    """Return the request to measure a light sensor's light, with lengths in Blender units.

    `steady` says whether the sensor keeps its parameters and pose until the next edit.
    """
    return LightRequest(
        sensor.name,
        matrix_of(pose, metres),
        parameters.method,
        parameters.engine,
        parameters.samples,
        parameters.clip_start / metres,
        parameters.clip_end / metres,
        parameters.field_of_view,
        parameters.exposure,
        steady,
    )


@dataclass(frozen=True)
class SensorSteps:
    """The steps at which one sensor senses.

    Attributes
    ----------
    steps
        The steps (n,), ascending.
    numbers
        The number of the update at each step (n,). A step between two updates has the number of the
        later one.
    due
        Whether the sensor publishes at each step (n,). A swept optical switch also senses at the
        steps between its updates, and a radar at those within its integration time.
    """

    steps: Index
    numbers: Index
    due: NDArray[np.bool_]

    @classmethod
    def of(cls, step: int, number: int, due: bool = True) -> SensorSteps:
        """Return a single step with the number of its update.

        `due` says whether the sensor publishes at this step.
        """
        return cls(np.array([step]), np.array([number]), np.array([due]))

    def part(self, which: slice | NDArray[np.bool_]) -> SensorSteps:
        """Return the steps that the slice or mask `which` selects."""
        return SensorSteps(self.steps[which], self.numbers[which], self.due[which])

    def between(self, first: int, last: int) -> SensorSteps:
        """Return the steps from `first` to `last`, both included."""
        return self.part(slice(*np.searchsorted(self.steps, (first, last + 1))))


@dataclass(frozen=True)
class PendingUpdates:
    """Updates of a sensor whose readings are not computed yet.

    Call either `readings` or `reading`, and only once. For a pad, first pass its forces to
    `give_forces`. For a light sensor, first measure the light of its `request` and pass it to
    `give_light`.

    Attributes
    ----------
    runner
        The runner of the sensor.
    steps
        The steps of the updates at which the sensor publishes.
    parameters
        The parameters of the sensor's kind at these steps.
    updates
        The input of the model.
    query
        The sensor, steps and scene to which the model's queries refer.
    """

    runner: SensorRunner
    steps: list[int]
    parameters: Any
    updates: Updates
    query: Query | None = None

    @property
    def request(self) -> LightRequest | None:
        """The request to the light probe; None if the sensor is not a light sensor."""
        return self.query.request if self.query is not None else None

    def give_light(self, found: Mapping[str, LightSample]) -> None:
        """Set the light of this sensor; `found` has the measured light of all sensors, by name."""
        assert self.query is not None
        self.query.light = found[self.runner.sensor.name]

    def give_forces(self, forces: Mapping[int, PadForces]) -> None:
        """Set the forces on this pad at each whole frame with an update, by frame."""
        assert self.query is not None
        self.query.forces = forces

    def readings(self) -> Readings:
        """Compute and return the readings, one for each of the `steps`."""
        made: Readings = self.runner.model.sense(self.parameters, self.updates)
        return made

    def reading(self) -> Reading:
        """Compute the readings, and return the last one."""
        return self.readings()[-1]


class SensorRunner:
    """A sensor with its schedule and the state of its model; it makes the sensor's updates."""

    def __init__(self, sensor: Sensor, clock: Clock) -> None:
        self.sensor = sensor
        self.clock = clock
        self.uid: Uid = sensor.uid
        self.schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        self.watches = self._watches()
        self._steps_before = self._integrated_steps()
        self.reader = SensorReader(sensor)
        self.trace = Trace(sensor)
        self.reset()

    @property
    def casts(self) -> bool:
        """Whether readings can be computed at once, because they need neither light nor forces."""
        return not (self.sensor.kind.requires_light or self.sensor.kind.requires_forces)

    def _watches(self) -> bool:
        """Return whether the sensor senses between its updates, as a swept optical switch does.

        So does a sensor of something that is used: a short use counts too.
        """
        kind, group = self.sensor.kind, self.sensor.parameters
        if kind.requires(USES):
            return may_change(self.sensor)
        choices = kind.needs.get(CROSSINGS)
        return choices is not None and all(
            getattr(group, name) == value
            or is_animated(self.sensor.object, f"angen_sensor.{kind.attribute}.{name}")
            for name, value in choices
        )

    def _integrated_steps(self) -> int:
        """Return the number of steps before each update over which the sensor integrates."""
        kind, name = self.sensor.kind, self.sensor.kind.integrates
        if not name:
            return 0
        seconds = getattr(self.sensor.parameters, name)
        if is_animated(self.sensor.object, f"angen_sensor.{kind.attribute}.{name}"):
            seconds = specs(kind.parameters)[name].maximum
        return self.clock.steps_within(seconds)

    @property
    def senses_between(self) -> bool:
        """Whether the sensor may also sense at steps between its updates."""
        return self.watches or self._steps_before > 0

    def is_watched(self, steps: Any) -> Any:
        """Return whether the sensor also senses at steps (n,) if it publishes at none of them."""
        spacing = self.schedule.steps_per_update
        number = steps * spacing.denominator // spacing.numerator + 1
        ahead = -(-number * spacing.numerator // spacing.denominator) - steps
        return self.watches | (ahead <= self._steps_before)

    def reset(self) -> None:
        """Forget earlier updates; call this method after a jump of the playhead, for example."""
        self.model = self.sensor.kind.model()
        self.reader.forget()
        self.trace.forget()

    def recall(self, step: int) -> None:
        """Let the model know the uses of what it watches before `step`, as keys tell them.

        Call this method after a jump of the playhead, or where a run begins. It does nothing for
        other kinds of sensors.
        """
        if not self.sensor.kind.requires(USES):
            return
        frame_start = self.clock.frame_start
        last = self.clock.frame_and_subframe(step)[0] - 1
        if last < frame_start or not (known := keyed_uses(self.sensor, frame_start, last)):
            return
        steps = np.array([self.clock.first_step(frame) for frame, _ in known])
        rows = np.arange(len(known))
        updates = Updates(
            rows,
            self.clock.times_and_frames(steps)[0],
            np.zeros(len(known), bool),
            Pose(np.zeros(3), np.eye(3)),
            {USES: lambda indices=None: Answers([use for _, use in known], rows)},
            partial(generator, 0, ""),
            partial(generator, 0, "", 0),
        )
        with suppress(AngenError):
            self.model.sense(read_parameters(self.sensor, self.sensor.settings), updates)

    def pending(self, due: SensorSteps, probes: Probes) -> Iterator[PendingUpdates]:
        """Yield the updates at the steps `due` (one or more), which are in the probes' batch.

        Steps with the same parameters and pose form a group. Compute the readings of each group
        before you take the next one. Nothing is yielded for steps at which the sensor is switched
        off. Raise AngenError if the sensor cannot be read.
        """
        captured = probes.frames
        frames = captured.at(due.steps)
        yield from self.updates(due, frames, captured.reads_of(self.reader, frames), probes)

    def updates(
        self, steps: SensorSteps, frames: Index, reads: Sequence[Read | None], probes: Probes
    ) -> Iterator[PendingUpdates]:
        """Yield the updates at successive steps from what was read of the sensor, as `pending`.

        Parameters
        ----------
        steps
            The steps (n,) of the updates.
        frames
            The index (n,) of each step's frame in the batch.
        reads
            Parameters and pose at each step (n,), or a single entry for all steps. An entry is None
            while the sensor is switched off.
        """
        changes = [None if read is None else read.change for read in reads]
        begins = [i for i in range(len(reads)) if i == 0 or changes[i] != changes[i - 1]]
        ends = [*begins[1:], len(steps.steps)]
        for begin, end in zip(begins, ends, strict=True):
            read, part = reads[begin], slice(begin, end)
            if read is None:
                self.reset()
                continue
            now, at = steps.part(part), frames[part]
            past: list[PlacedStep] = []
            if self.sensor.kind.integrates:
                past = self._add_places(now, at, read, probes)
                now, at = now.part(now.due), at[now.due]
            if len(now.steps):
                yield self._pending(read, now, at, probes, past)

    def _add_places(
        self, steps: SensorSteps, frames: Index, read: Read, probes: Probes
    ) -> list[PlacedStep]:
        """Note the places of all solids at steps (n,), and return all steps noted so far.

        `frames` (n,) has the index of each step's frame. Steps before the integration time of the
        next update are kept no longer.
        """
        first, last = int(steps.steps[0]), int(steps.steps[-1])
        past = [one for one in self.trace.past if one.step < first]
        places = map(probes.places.at, frames.tolist())
        past += map(PlacedStep, steps.steps.tolist(), places)
        seconds = getattr(read.parameters, self.sensor.kind.integrates)
        oldest = last - self.clock.steps_within(seconds)
        self.trace.past = [one for one in past if one.step >= oldest]
        return past

    def _pending(
        self,
        read: Read,
        steps: SensorSteps,
        frames: Index,
        probes: Probes,
        past: Sequence[PlacedStep] = (),
    ) -> PendingUpdates:
        when = self.clock, read, steps.steps.tolist(), frames
        query = Query(self.sensor, *when, probes, self.trace, past)
        if self.sensor.kind.requires_light:
            query.request = light_request(
                self.sensor, read.parameters, read.pose, read.metres, self.reader.steady
            )
        needs = self.sensor.kind.needs
        name = self.sensor.stands_for or self.sensor.name
        updates = Updates(
            steps.numbers,
            self.clock.times_and_frames(steps.steps)[0],
            steps.due,
            read.pose,
            {need: partial(ANSWERS[need], query) for need in needs},
            partial(generator, read.seed, name),
            partial(generator, read.seed, f"{name}, part", 0),
            self.trace.name_of,
        )
        due = steps.steps[steps.due].tolist()
        updates = self.trace.record(query, updates)
        return PendingUpdates(self, due, read.parameters, updates, query)


def single_update(
    runner: SensorRunner, number: int, step: int, probes: Probes
) -> PendingUpdates | None:
    """Return update `number` of a sensor at `step`; None while the sensor is switched off.

    The probes must have read the scene at this step alone: see `Probes.look`. Raise AngenError if
    the sensor cannot be read.
    """
    return next(runner.pending(SensorSteps.of(step, number), probes), None)


def all_rays(
    sensor: Sensor, clock: Clock, depsgraph: Any, probes: Probes | None = None
) -> Trace | None:
    """Return a `Trace` with all rays that a sensor casts over its updates, at the present frame.

    A new runner makes updates until the rays repeat, so the sensor's own readings do not change.
    For a light sensor, the rays are the axes and the corners of its views. Return None while the
    sensor is switched off. Raise AngenError if the sensor cannot be read.

    Without `probes`, return only the rays of sensors that measure ranges, with hits as in an empty
    scene.
    """
    runner, needs = SensorRunner(sensor, clock), CAST
    casts_views = probes is not None and sensor.kind.requires_light
    if probes is None:
        # New probes, whose scene is empty.
        probes, needs = Probes(depsgraph.scene, RayCaster()), {RAYS}
        probes.show_captured(depsgraph)
    read, trace = runner.reader.read(depsgraph, probes.capture.edits), runner.trace
    if read is None:
        return None
    trace.set_pose(read.parameters, read.pose)
    if casts_views:
        _cast_views(read, trace, probes)
    elif runner.casts and any(sensor.kind.requires(need, read.parameters) for need in needs):
        number, known = 0, -1
        while len(trace.bundles) > known:
            known = len(trace.bundles)
            steps = SensorSteps.of(runner.schedule.step(number), number)
            runner._pending(read, steps, PRESENT, probes).readings()
            number += 1
    return trace


def _cast_views(read: Read, trace: Trace, probes: Probes) -> None:
    """Cast the axis and the corners of each view of a light sensor, and add them to its `Trace`."""
    sensor, metres = trace.sensor, read.metres
    request = light_request(sensor, read.parameters, read.pose, metres, False)
    if request.method == "FOUR_WALL":
        for wall, rays in enumerate(zip(*view_rays(request), strict=True)):
            ranges = probes.caster.cast(sensor.uid, wall, *rays)
            origins, directions, reach = rays
            cast = CastRays(origins * metres, directions, reach * metres, ranges * metres)
            trace.show(wall, cast)
