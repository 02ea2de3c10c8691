# SPDX-License-Identifier: GPL-3.0-or-later
"""The trace of a sensor: its model's queries, their answers and the hits of its rays.

The viewport draws the last hits. *Explain*, and the search for the causes of a day's events, replay
the last updates from the recorded queries and answers.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...sensor_logic.clock import Clock
from ...sensor_logic.kind import RAYS
from ...sensor_logic.model import FIRST, Answers, Array, Ask, Index, LightSample, Pose, Updates
from ..scene.light.probe import LightRequest
from ..scene.rays.caster import Rays
from ..scene.rays.sweep import SolidsAtStep, SweptRays
from ..scene.sensors import Sensor
from ..scene.surfaces import SURFACES
from .probes import Probes

# The queries that cast rays.
CAST = {RAYS, *SURFACES}
# A trace keeps at least this many of the last updates. It is more than a motion detector has tilts.
KEPT = 256
# More than the ray bundles of any model.
BUNDLES = 1 << 20


class NotRecorded(LookupError):
    """A query has no recorded answer, because the run did not make it."""


@dataclass(frozen=True)
class Read:
    """Parameters and pose of a sensor at a step.

    Attributes
    ----------
    metres
        Metres in a Blender unit.
    parameters, pose
        The parameters of the sensor's kind, and the pose in metres.
    at_step
        Answers that can only be read while the scene is at the step, from `read_at_step`; else
        None.
    change
        A number that is greater than before if the parameters or the pose have changed.
    """

    metres: float
    parameters: Any
    pose: Pose
    at_step: dict[str, Any] | None
    change: int = 0

    def same(self, other: Read) -> bool:
        """Whether the values at another step are the same; never if either has `at_step`."""
        same = self.metres == other.metres and self.parameters == other.parameters
        return same and self.at_step is other.at_step is None and self.pose.same(other.pose)

    def rays_in_units(self, origins: Array, directions: Array, length: Array) -> Rays:
        """Return rays in Blender units, from origins (n, 3) and lengths (n,) in m."""
        return origins / self.metres, directions, length / self.metres

    def in_metres(self, lengths: Array) -> Array:
        """Return lengths in m, from lengths in Blender units."""
        return lengths if self.metres == 1.0 else lengths * self.metres


@dataclass
class Query:
    """What the answers to a model's queries depend on.

    Attributes
    ----------
    sensor, clock
        The sensor and the time base.
    read
        The parameters and the pose of the sensor.
    steps
        The steps of the updates that the model computes.
    frames
        The index (n,) of each step's frame among the stored frames.
    depsgraph, probes
        The evaluated scene, and the probes that read it.
    trace
        The trace that records the queries.
    request
        The request of a light sensor to the light probe; None for other kinds.
    light
        The light that was measured for the request; None until then.
    """

    sensor: Sensor
    clock: Clock
    read: Read
    steps: list[int]
    frames: Index
    depsgraph: Any
    probes: Probes
    trace: Trace
    request: LightRequest | None = None
    light: LightSample | None = None

    def bundle(self, number: int) -> int:
        """Return the number by which casters know the model's ray bundle `number`.

        Variants of one sensor cast different rays, so each variant has numbers of its own.
        """
        return number + BUNDLES * self.sensor.variant


@dataclass(frozen=True)
class Swept:
    """The last sweep of a beam: the step, and the beam and the solids at that step."""

    step: int
    beam: SweptRays
    solids: SolidsAtStep


@dataclass(frozen=True)
class SensorRays:
    """Rays in world space, in Blender units.

    Attributes
    ----------
    origins, directions
        The origins and the unit directions (n, 3).
    reach
        The length of each ray (n,).
    rows
        The number of rows, of equally many rays each. A motion detector has one for each tilt.
    apart
        Whether the rays are single rays; else the rays of a row span a fan.
    """

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    apart: bool = False


@dataclass(frozen=True, eq=False)
class RaysMet:
    """A bundle of rays in world space that was cast; lengths are in m.

    Attributes
    ----------
    origins, directions
        The origins and the unit directions (n, 3).
    reach
        The length of each ray (n,).
    ranges
        The distance at which each ray meets a surface (n,).
    """

    origins: Array
    directions: Array
    reach: Array
    ranges: Array

    def same(self, other: RaysMet) -> bool:
        """Whether another bundle has the same rays and the same ranges."""
        mine = self.origins, self.directions, self.reach, self.ranges
        its = other.origins, other.directions, other.reach, other.ranges
        return all(map(np.array_equal, mine, its))


class Hits(NamedTuple):
    """The hits of a bundle of n rays.

    Attributes
    ----------
    ranges
        The range of each ray (n,) in Blender units.
    names
        The name of the object that each ray hits, empty if it hits nothing.
    """

    ranges: Array
    names: list[str]


@dataclass(frozen=True)
class _RecordedQuery:
    """A recorded query with its answers.

    Attributes
    ----------
    need
        The queried quantity, such as RAYS.
    bundle
        The number of the ray bundle, or the name of a parameter that names an object.
    which
        The indices (k,) of the updates that the query is about; None means all updates.
    answers
        The answers, one for each of these updates.
    met
        The hits of the rays at each of these updates; None if the query casts no rays.
    """

    need: str
    bundle: Any
    which: Index | None
    answers: Answers
    met: Answers | None

    def place(self, update: int) -> int | None:
        """Return the index of an update's answer; None if the query was not about that update."""
        if self.which is None:
            return update
        at = int(np.searchsorted(self.which, update))
        return at if at < len(self.which) and self.which[at] == update else None


@dataclass(frozen=True)
class _RecordedUpdates:
    """Recorded updates of a sensor at ascending `steps`, with the queries that they made."""

    steps: list[int]
    parameters: Any
    updates: Updates
    queries: list[_RecordedQuery] = field(default_factory=list)


class Trace:
    """The queries, answers and hits of one sensor.

    Attributes
    ----------
    parameters, pose
        The parameters and the pose of the sensor with which the bundles were cast.
    bundles
        The last rays and ranges of each ray bundle, by the number of the bundle. When the
        parameters or the pose change, all bundles are removed until they are cast again.
    scan
        The ranges (n,) that each bundle had at its cast before the last one. The keys are the
        numbers of the bundles that the last update cast. The value is None for a bundle that was
        cast for the first time.
    step
        The step of the last update; None before the first one.
    revision
        A number that grows whenever a bundle, the parameters or the pose change.
    swept
        The last sweep of the sensor's beam; None before the first one.
    keeps
        Whether the trace also keeps the queries and answers of the last updates. Then it keeps at
        least KEPT updates.
    """

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor
        self.keeps = False
        self.revision = 0
        self._updates: deque[_RecordedUpdates] = deque()
        self._count = 0
        # The hits of the last query's rays, and the names of solids by their numbers.
        self._met: Any = None
        self._names: Mapping[int, str] = {}
        self.forget()

    def forget(self) -> None:
        """Forget the last hits, because the sensor starts anew."""
        self.revision += 1
        self.bundles: dict[int, RaysMet] = {}
        self.scan: dict[int, Array | None] = {}
        self.step: int | None = None
        self.parameters: Any = None
        self.pose: Any = None
        self.swept: Swept | None = None
        self._sensed: dict[int, Array] = {}

    def record(self, query: Query, updates: Updates) -> Updates:
        """Return updates that equal `updates`, but record each query that the model makes."""
        sensed = _RecordedUpdates(query.steps, query.read.parameters, updates)
        if self.keeps:
            self._updates.append(sensed)
            self._count += len(sensed.steps)
            while self._count - len(self._updates[0].steps) >= KEPT:
                self._count -= len(self._updates.popleft().steps)
        scene = {
            need: partial(self._ask, query, sensed, need, answer)
            for need, answer in updates.scene.items()
        }
        return replace(updates, scene=scene)

    def _ask(
        self,
        query: Query,
        sensed: _RecordedUpdates,
        need: str,
        answer: Ask,
        *arguments: Any,
        which: Index | None = None,
    ) -> Answers:
        """Answer a query with `answer`, record the answers and the hits, and return the answers.

        `sensed` are the updates that make the query, and `need` is the quantity.
        """
        answers: Answers = answer(*arguments, which=which)
        met = None
        if need in CAST and len(answers.rows):
            bundle, origins, directions, length = arguments
            read, known = query.read, (query.sensor.uid, query.bundle(bundle))
            last = query.steps[-1 if which is None else int(which[-1])]
            if need == RAYS:
                ranges = answers[-1]
            else:
                ranges = read.in_metres(query.probes.surfaces[need].ranges(*known))
            self.set_pose(read.parameters, read.pose)
            self._note(last, bundle, RaysMet(origins, directions, length, ranges))
            if self.keeps:
                probes, count = query.probes, len(answers.rows)
                in_units = read.rays_in_units(origins, directions, length)
                met = probes.hits(need, *known, in_units, count)
                self._met, self._names = met[-1], probes.names
        if self.keeps:
            sensed.queries.append(_RecordedQuery(need, _bundle(arguments), which, answers, met))
        return answers

    def set_pose(self, parameters: Any, pose: Pose | None) -> None:
        """Set the parameters and the pose with which the next bundles are cast.

        Remove the present bundles if the parameters or the pose have changed.
        """
        if not self._is_same_pose(parameters, pose):
            self.bundles = {}
            self.revision += 1
        self.parameters, self.pose = parameters, pose

    def _is_same_pose(self, parameters: Any, pose: Pose | None) -> bool:
        """Whether the parameters and the pose equal those of the present bundles."""
        known = self.pose
        if known is None or pose is None:
            return known is pose
        return bool(parameters == self.parameters) and pose.same(known)

    def _note(self, step: int, number: int, met: RaysMet) -> None:
        """Record that the sensor cast bundle `number` at a step."""
        if step != self.step:
            self.step, self.scan = step, {}
        if number not in self.scan:
            self.scan[number] = self._sensed.get(number)
        self._sensed[number] = met.ranges
        self.show(number, met)

    def show(self, number: int, met: RaysMet) -> None:
        """Set the rays and ranges of bundle `number`; call it for casts outside of updates."""
        known = self.bundles.get(number)
        if known is None or not known.same(met):
            self.bundles[number] = met
            self.revision += 1

    def copy_bundles(self, other: Trace) -> None:
        """Replace all bundles by those of another trace of the same sensor."""
        self.set_pose(other.parameters, other.pose)
        for number, met in other.bundles.items():
            self.show(number, met)
        for number in self.bundles.keys() - other.bundles.keys():
            del self.bundles[number]
            self.revision += 1

    def rays(self, metres: float) -> SensorRays:
        """Return the rays of all bundles in Blender units, as one row for each bundle.

        `metres` is the length of a Blender unit in m.
        """
        met = self.bundles.values()
        if not met:
            return SensorRays(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
        return SensorRays(
            np.concatenate([bundle.origins / metres for bundle in met]),
            np.concatenate([bundle.directions for bundle in met]),
            np.concatenate([bundle.reach / metres for bundle in met]),
            len(met),
        )

    @property
    def hits(self) -> Hits:
        """The hits of the rays that the last query cast."""
        if self._met is None:
            return Hits(np.empty(0), [])
        return Hits(self._met.ranges.copy(), [self.name_of(n) for n in self._met.met.tolist()])

    def name_of(self, number: int) -> str:
        """Return the object name of solid `number`; empty if no solid has this number."""
        return self._names.get(number, "")

    def recall(self, step: int) -> tuple[Any, Updates]:
        """Return the parameters of the sensor and its update at a step.

        Queries of the update get the recorded answers. Raise NotRecorded if the step is not kept.
        """
        for sensed in reversed(self._updates):
            if sensed.steps[0] <= step <= sensed.steps[-1]:
                i = bisect_left(sensed.steps, step)
                updates, single = sensed.updates, slice(i, i + 1)
                scene = {need: partial(self._answer, sensed, i, need) for need in updates.scene}
                found = (
                    updates.numbers[single],
                    updates.times[single],
                    updates.due[single],
                    updates.pose,
                    scene,
                )
                return sensed.parameters, Updates(*found, updates.noise, updates.device_noise)
        raise NotRecorded

    def _answer(
        self,
        sensed: _RecordedUpdates,
        update: int,
        need: str,
        *arguments: Any,
        which: Index | None = None,
    ) -> Answers:
        """Return the recorded answer to a query about one update. Raise NotRecorded."""
        bundle = _bundle(arguments)
        for known in sensed.queries:
            if (known.need, known.bundle) == (need, bundle):
                place = known.place(update)
                if place is not None:
                    if known.met is not None:
                        self._met = known.met[place]
                    return Answers([known.answers[place]], FIRST)
        raise NotRecorded


def _bundle(arguments: tuple[Any, ...]) -> Any:
    """Return what a query with these arguments is about; None if they do not say it.

    It is the number of a ray bundle, or the name of a parameter that names an object.
    """
    return arguments[0] if arguments and isinstance(arguments[0], (int, str)) else None
