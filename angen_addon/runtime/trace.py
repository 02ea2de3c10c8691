# SPDX-License-Identifier: GPL-3.0-or-later
"""What made a reading: the queries of a sensor's updates, their answers and the hits of its rays.
Views draw the last hits; explanations and the causes of a day's events read the last updates."""

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

# The queries that cast rays, which meet something.
CAST = {RAYS, WARMTH, REFLECTANCE}
# The number of updates that are kept at least: a motion detector goes through fewer tilts.
KEPT = 256
# A model has fewer bundles of rays than this.
BUNDLES = 1 << 20


class NotNoted(LookupError):
    """The run did not make this query: only the scene itself has the answer."""


@dataclass(frozen=True)
class Read:
    """What was read of a sensor at a step: metres in a Blender unit, parameters, pose, and
    `beside`, by need, what can be read at that step alone: a pad's weight (3,) in N with the
    partners that it measures alone; the poses of objects by the parameter that names them. `change`
    is the same number as at the step before where the sensor stays as it is."""

    metres: float
    parameters: Any
    pose: Pose
    beside: dict[str, Any] | None
    change: int = 0

    def same(self, other: Read) -> bool:
        """Whether another has the same values, all of which are known to stay."""
        same = self.metres == other.metres and self.parameters == other.parameters
        return same and self.beside is other.beside is None and self.pose.same(other.pose)

    def rays_in_units(self, origins: Array, directions: Array, length: Array) -> Rays:
        """Rays with origins (n, 3) and lengths (n,) in m, in Blender units."""
        return origins / self.metres, directions, length / self.metres

    def in_metres(self, lengths: Array) -> Array:
        """Lengths in Blender units, in m."""
        return lengths if self.metres == 1.0 else lengths * self.metres


@dataclass
class Question:
    """Which sensor's model asks, as it was `read`, and about which `steps`: their `frames` (n,)
    among those that the probes keep. `trace`: that of the sensor. `light` is what was measured for
    the `request` of a light sensor."""

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
        """The number by which the casters know the model's bundle `number`: with other settings a
        sensor casts other rays."""
        return number + BUNDLES * self.sensor.variant


@dataclass(frozen=True)
class Swept:
    """Where a beam was swept to last: the step, the beam, and the solids."""

    step: int
    beam: SweptRays
    solids: SolidsAtStep


@dataclass(frozen=True)
class SensorRays:
    """Rays in the world, in Blender units: `origins` (n, 3), unit `directions` (n, 3), `reach`
    (n,). `rows`: how many equal rows they stand in, for a motion detector its tilts; `apart`: each
    stands for itself, they span no fan."""

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    apart: bool = False


@dataclass(frozen=True, eq=False)
class RaysMet:
    """A bundle of rays in the world, in m: origins (n, 3), unit directions (n, 3), how far they
    reach (n,) and how far they get (n,)."""

    origins: Array
    directions: Array
    reach: Array
    ranges: Array

    def same(self, other: RaysMet) -> bool:
        mine = self.origins, self.directions, self.reach, self.ranges
        its = other.origins, other.directions, other.reach, other.ranges
        return all(map(np.array_equal, mine, its))


class Hits(NamedTuple):
    """What a bundle of rays met: ranges (n,) in Blender units, and the name of the object that
    each met, empty where it met nothing."""

    ranges: Array
    names: list[str]


@dataclass(frozen=True)
class _Asked:
    """A query about those of the updates that `which` (k,) lists, all where it is None; rays by
    their bundle. The answers, and what rays `met`."""

    need: str
    bundle: Any
    which: Index | None
    answers: Answers
    met: Answers | None

    def place(self, update: int) -> int | None:
        """The index of an update's answer; None where the query was not about that update."""
        if self.which is None:
            return update
        at = int(np.searchsorted(self.which, update))
        return at if at < len(self.which) and self.which[at] == update else None


@dataclass(frozen=True)
class _Sensed:
    """Updates at `steps` (n,) in order, and their queries."""

    steps: list[int]
    parameters: Any
    updates: Updates
    asked: list[_Asked] = field(default_factory=list)


class Trace:
    """The queries, answers and hits of one sensor.

    Of its rays it has the last hits: `bundles`, by their number, cast with the `parameters` and the
    `pose`; a bundle that was not cast since these changed is missing. `scan`: the bundles cast at
    the last update, at `step`, each with the ranges (n,) that it found at its update before, None
    of the first. `revision` grows where a bundle or what it was cast with changes. `swept`: where
    its beam was swept to last. If it `keeps` them, it also has all queries and answers of at least
    the last KEPT updates.
    """

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor
        self.keeps = False
        self.revision = 0
        self._updates: deque[_Sensed] = deque()
        self._count = 0
        # What the rays of the last query met, and the names of solids by their numbers.
        self._met: Any = None
        self._names: Mapping[int, str] = {}
        self.forget()

    def forget(self) -> None:
        """Forgets the last hits: the sensor starts anew."""
        self.revision += 1
        self.bundles: dict[int, RaysMet] = {}
        self.scan: dict[int, Array | None] = {}
        self.step: int | None = None
        self.parameters: Any = None
        self.pose: Any = None
        self.swept: Swept | None = None
        self._sensed: dict[int, Array] = {}

    def listen(self, question: Question, updates: Updates) -> Updates:
        """Return the same updates, whose queries are recorded from now on."""
        sensed = _Sensed(question.steps, question.read.parameters, updates)
        if self.keeps:
            self._updates.append(sensed)
            self._count += len(sensed.steps)
            while self._count - len(self._updates[0].steps) >= KEPT:
                self._count -= len(self._updates.popleft().steps)
        asks = updates.scene.items()
        scene = {need: partial(self._ask, question, sensed, need, ask) for need, ask in asks}
        return replace(updates, scene=scene)

    def _ask(
        self,
        question: Question,
        sensed: _Sensed,
        need: str,
        ask: Ask,
        *asked: Any,
        which: Index | None = None,
    ) -> Answers:
        answers: Answers = ask(*asked, which=which)
        met = None
        if need in CAST and len(answers.rows):
            bundle, origins, directions, length = asked
            read, known = question.read, (question.sensor.uid, question.bundle(bundle))
            last = question.steps[-1 if which is None else int(which[-1])]
            if need == RAYS:
                ranges = answers[-1]
            else:
                ranges = read.in_metres(getattr(question.probes, need).ranges(*known))
            self.aim(read.parameters, read.pose)
            self._note(last, bundle, RaysMet(origins, directions, length, ranges))
            if self.keeps:
                probes, count = question.probes, len(answers.rows)
                in_units = read.rays_in_units(origins, directions, length)
                met = probes.met(question.depsgraph, *known, in_units, count)
                self._met, self._names = met[-1], probes.names
        if self.keeps:
            sensed.asked.append(_Asked(need, _bundle(asked), which, answers, met))
        return answers

    def aim(self, parameters: Any, pose: Pose | None) -> None:
        """From now on bundles are cast with these; None: none are."""
        if not self._is_aimed(parameters, pose):
            self.bundles = {}
            self.revision += 1
        self.parameters, self.pose = parameters, pose

    def _is_aimed(self, parameters: Any, pose: Pose | None) -> bool:
        known = self.pose
        if known is None or pose is None:
            return known is pose
        return bool(parameters == self.parameters) and pose.same(known)

    def _note(self, step: int, number: int, met: RaysMet) -> None:
        """A bundle that the sensor cast at a step."""
        if step != self.step:
            self.step, self.scan = step, {}
        if number not in self.scan:
            self.scan[number] = self._sensed.get(number)
        self._sensed[number] = met.ranges
        self.show(number, met)

    def show(self, number: int, met: RaysMet) -> None:
        """What a bundle meets, apart from the sensor's updates."""
        known = self.bundles.get(number)
        if known is None or not known.same(met):
            self.bundles[number] = met
            self.revision += 1

    def take_over(self, other: Trace) -> None:
        """Show the bundles of another trace of this sensor, and no others."""
        self.aim(other.parameters, other.pose)
        for number, met in other.bundles.items():
            self.show(number, met)
        for number in self.bundles.keys() - other.bundles.keys():
            del self.bundles[number]
            self.revision += 1

    def rays(self, metres: float) -> SensorRays:
        """All rays of the bundles, a row for each bundle."""
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
        """The name that users know the solid `number` by; empty of none."""
        return self._names.get(number, "")

    def recall(self, step: int) -> tuple[Any, Updates]:
        """Parameters and the update at a step, with the answers that its queries had then. Raises
        NotNoted."""
        for sensed in reversed(self._updates):
            if sensed.steps[0] <= step <= sensed.steps[-1]:
                i = bisect_left(sensed.steps, step)
                own, one = sensed.updates, slice(i, i + 1)
                scene = {need: partial(self._answer, sensed, i, need) for need in own.scene}
                found = own.numbers[one], own.times[one], own.due[one], own.pose, scene
                return sensed.parameters, Updates(*found, own.noise, own.device_noise)
        raise NotNoted

    def _answer(
        self, sensed: _Sensed, update: int, need: str, *asked: Any, which: Index | None = None
    ) -> Answers:
        bundle = _bundle(asked)
        for known in sensed.asked:
            if (known.need, known.bundle) == (need, bundle):
                place = known.place(update)
                if place is not None:
                    if known.met is not None:
                        self._met = known.met[place]
                    return Answers([known.answers[place]], FIRST)
        raise NotNoted


def _bundle(asked: tuple[Any, ...]) -> Any:
    """What tells queries of one need apart: the bundle's number, or whose pose it is."""
    return asked[0] if asked and isinstance(asked[0], (int, str)) else None
