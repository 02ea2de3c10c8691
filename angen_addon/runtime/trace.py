# SPDX-License-Identifier: GPL-3.0-or-later
"""The trace of a sensor: its model's queries, their answers and the hits of its rays.

Views draw the last hits. Explanations and the causes of a day's events use the last updates.
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
from ...sensor_logic.kind import RAYS, REFLECTANCE, WARMTH
from ...sensor_logic.model import FIRST, Answers, Array, Ask, Index, LightSample, Pose, Updates
from ..scene.light.probe import LightRequest
from ..scene.rays.caster import Rays
from ..scene.rays.sweep import SolidsAtStep, SweptRays
from ..scene.sensors import Sensor
from .probes import Probes

# The queries that cast rays.
CAST = {RAYS, WARMTH, REFLECTANCE}
# The least number of updates that are kept: a motion detector has fewer tilts.
KEPT = 256
# More than the ray bundles of any model.
BUNDLES = 1 << 20


class NotRecorded(LookupError):
    """A query that the run did not make; only the scene has the answer."""


@dataclass(frozen=True)
class Read:
    """Parameters and pose of a sensor at a step.

    Attributes
    ----------
    metres
        Metres in a Blender unit.
    parameters, pose
        The parameters of the sensor's kind, and the pose in metres.
    beside
        Answers that can be read at this step alone, by need: the weight (3,) of a pad in N with the
        partners that it measures alone; the poses of objects by the parameter that names them.
    change
        A number that grows whenever the parameters or the pose change.
    """

    metres: float
    parameters: Any
    pose: Pose
    at_step: dict[str, Any] | None
    change: int = 0

    def same(self, other: Read) -> bool:
        """Whether another step has the same values, and none that can be read at its step alone."""
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
    """What the answers to a model's queries depend on: the sensor, its steps and the probes.

    `frames` (n,) has the index of each step's frame among the stored frames. `light` is the light
    that was measured for the `request` of a light sensor.
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
        """Return the number of the model's ray bundle for the casters.

        It differs between variants of a sensor, which cast other rays.
        """
        return number + BUNDLES * self.sensor.variant


@dataclass(frozen=True)
class Swept:
    """The last sweep of a beam: its step, the beam and the solids."""

    step: int
    beam: SweptRays
    solids: SolidsAtStep


@dataclass(frozen=True)
class SensorRays:
    """Rays in world space, in Blender units: `origins` and unit `directions` (n, 3), `reach` (n,).

    `rows` is the number of equal rows, one for each tilt of a motion detector. With `apart` the
    rays are single rays, which span no fan.
    """

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    apart: bool = False


@dataclass(frozen=True, eq=False)
class RaysMet:
    """A bundle of rays in world space, in m, with its ranges.

    Origins and unit directions are (n, 3), `reach` and `ranges` (n,).
    """

    origins: Array
    directions: Array
    reach: Array
    ranges: Array

    def same(self, other: RaysMet) -> bool:
        """Whether another bundle has equal rays and ranges."""
        mine = self.origins, self.directions, self.reach, self.ranges
        its = other.origins, other.directions, other.reach, other.ranges
        return all(map(np.array_equal, mine, its))


class Hits(NamedTuple):
    """The hits of a bundle of rays: ranges (n,) in Blender units, and names of the hit objects.

    The name is empty where a ray hits nothing.
    """

    ranges: Array
    names: list[str]


@dataclass(frozen=True)
class _RecordedQuery:
    """A recorded query with its answers.

    `which` (k,) lists the updates that the query is about; None means all. `bundle` is the number
    of the ray bundle, or the name of a parameter. `met` has the hits of rays.
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
    """Recorded updates at `steps` (n,) in order, and their queries."""

    steps: list[int]
    parameters: Any
    updates: Updates
    queries: list[_RecordedQuery] = field(default_factory=list)


class Trace:
    """The queries, answers and hits of one sensor.

    Attributes
    ----------
    bundles
        The last hits of each bundle of rays, by its number, cast with `parameters` and `pose`. A
        bundle that was not cast since these changed is missing.
    scan
        The ranges (n,) before the last ones, by the number of each bundle cast at the last update;
        None for a bundle cast for the first time.
    step
        The step of the last update.
    revision
        A number that grows whenever a bundle, the parameters or the pose change.
    swept
        The last sweep of the sensor's beam.
    keeps
        Whether the trace also keeps all queries and answers of the last updates, at least KEPT.
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
        """Forget the last hits, as the sensor starts anew."""
        self.revision += 1
        self.bundles: dict[int, RaysMet] = {}
        self.scan: dict[int, Array | None] = {}
        self.step: int | None = None
        self.parameters: Any = None
        self.pose: Any = None
        self.swept: Swept | None = None
        self._sensed: dict[int, Array] = {}

    def record(self, query: Query, updates: Updates) -> Updates:
        """Return the same updates, whose queries are recorded from now on."""
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
        """Answer a query, and record the answers and the hits."""
        answers: Answers = answer(*arguments, which=which)
        met = None
        if need in CAST and len(answers.rows):
            bundle, origins, directions, length = arguments
            read, known = query.read, (query.sensor.uid, query.bundle(bundle))
            last = query.steps[-1 if which is None else int(which[-1])]
            if need == RAYS:
                ranges = answers[-1]
            else:
                ranges = read.in_metres(getattr(query.probes, need).ranges(*known))
            self.set_pose(read.parameters, read.pose)
            self._note(last, bundle, RaysMet(origins, directions, length, ranges))
            if self.keeps:
                probes, count = query.probes, len(answers.rows)
                in_units = read.rays_in_units(origins, directions, length)
                met = probes.hits(query.depsgraph, *known, in_units, count)
                self._met, self._names = met[-1], probes.names
        if self.keeps:
            sensed.queries.append(_RecordedQuery(need, _bundle(arguments), which, answers, met))
        return answers

    def set_pose(self, parameters: Any, pose: Pose | None) -> None:
        """Set the parameters and the pose with which the next bundles are cast.

        Forget the present bundles if these have changed.
        """
        if not self._is_same_pose(parameters, pose):
            self.bundles = {}
            self.revision += 1
        self.parameters, self.pose = parameters, pose

    def _is_same_pose(self, parameters: Any, pose: Pose | None) -> bool:
        """Whether the parameters and the pose are the present ones."""
        known = self.pose
        if known is None or pose is None:
            return known is pose
        return bool(parameters == self.parameters) and pose.same(known)

    def _note(self, step: int, number: int, met: RaysMet) -> None:
        """Record a bundle that the sensor cast at a step."""
        if step != self.step:
            self.step, self.scan = step, {}
        if number not in self.scan:
            self.scan[number] = self._sensed.get(number)
        self._sensed[number] = met.ranges
        self.show(number, met)

    def show(self, number: int, met: RaysMet) -> None:
        """Set the hits of a bundle, outside of the sensor's updates."""
        known = self.bundles.get(number)
        if known is None or not known.same(met):
            self.bundles[number] = met
            self.revision += 1

    def copy_bundles(self, other: Trace) -> None:
        """Take the bundles of another trace of this sensor, in place of all bundles."""
        self.set_pose(other.parameters, other.pose)
        for number, met in other.bundles.items():
            self.show(number, met)
        for number in self.bundles.keys() - other.bundles.keys():
            del self.bundles[number]
            self.revision += 1

    def rays(self, metres: float) -> SensorRays:
        """Return the rays of all bundles, a row for each bundle."""
        met = self.bundles.values()
        if not met:
            return SensorRays(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
        return SensorRays(
            np.concatenate([one.origins / metres for one in met]),
            np.concatenate([one.directions for one in met]),
            np.concatenate([one.reach / metres for one in met]),
            len(met),
        )

    @property
    def hits(self) -> Hits:
        """The hits of the rays of the last query."""
        if self._met is None:
            return Hits(np.empty(0), [])
        return Hits(self._met.ranges.copy(), [self.name_of(n) for n in self._met.met.tolist()])

    def name_of(self, number: int) -> str:
        """Return the name of the solid `number`, as users know it; empty for no solid."""
        return self._names.get(number, "")

    def recall(self, step: int) -> tuple[Any, Updates]:
        """Return the parameters and the update at a step, with the recorded answers.

        Raise NotRecorded.
        """
        for sensed in reversed(self._updates):
            if sensed.steps[0] <= step <= sensed.steps[-1]:
                i = bisect_left(sensed.steps, step)
                updates, one = sensed.updates, slice(i, i + 1)
                scene = {need: partial(self._answer, sensed, i, need) for need in updates.scene}
                found = (
                    updates.numbers[one],
                    updates.times[one],
                    updates.due[one],
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
    """Return the number of the bundle, or the name of the parameter, that a query is about."""
    return arguments[0] if arguments and isinstance(arguments[0], (int, str)) else None
