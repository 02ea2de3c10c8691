# SPDX-License-Identifier: GPL-3.0-or-later
"""The trace of a sensor: the rays that its model cast last, and how far they got.

The viewport draws them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...sensor_logic.arrays import are_equal
from ...sensor_logic.clock import Clock
from ...sensor_logic.forces.world import PadForces
from ...sensor_logic.kind import RAYS
from ...sensor_logic.model import Answers, Array, Ask, Index, LightSample, Pose, Updates
from ..scene.light.probe import LightRequest
from ..scene.rays.places import SolidPlaces
from ..scene.rays.sweep import SolidsAtStep, SweptRays
from ..scene.sensor_reader import Read
from ..scene.sensors import Sensor
from ..scene.surfaces import SURFACES
from .probes import Probes

# The queries that cast rays.
CAST = {RAYS, *SURFACES}
# More than the ray bundles of any model.
BUNDLES = 1 << 20


@dataclass
class Query:
    """The sensor, steps and scene of a query: a sensor model's question to the scene.

    Attributes
    ----------
    sensor, clock
        The sensor and the time base.
    read
        The parameters and the pose of the sensor.
    steps
        The steps of the updates that the model computes.
    frames
        The index (n,) of each step's frame among the captured frames.
    probes
        The probes that read the scene.
    trace
        The trace that records the queries.
    past
        For a sensor that integrates, the steps at which it has sensed so far, in order, with the
        places of all solids. The last of `steps` is among them.
    request
        The request of a light sensor to the light probe; None for other kinds.
    light
        The light that was measured for the request; None before the measurement.
    forces
        The contact forces on a pad, by whole frame.
    """

    sensor: Sensor
    clock: Clock
    read: Read
    steps: list[int]
    frames: Index
    probes: Probes
    trace: Trace
    past: Sequence[PlacedStep] = ()
    request: LightRequest | None = None
    light: LightSample | None = None
    forces: Mapping[int, PadForces] = field(default_factory=dict)

    def bundle(self, number: int) -> int:
        """Return the number of the model's ray bundle `number` that the ray caster uses.

        Variants of one sensor cast different rays, so each variant has its own numbers.
        """
        return number + BUNDLES * self.sensor.variant


class PlacedStep(NamedTuple):
    """A step, and the places of all solids (objects that rays can hit) at it."""

    step: int
    places: SolidPlaces


@dataclass(frozen=True)
class Swept:
    """The last sweep of a beam: its step, the beam, and the objects that rays could hit then."""

    step: int
    beam: SweptRays
    solids: SolidsAtStep


@dataclass(frozen=True)
class SensorRays:
    """n rays in world space, in Blender units.

    Attributes
    ----------
    origins, directions
        The origins and the unit directions (n, 3).
    reach
        The length of each ray (n,).
    rows
        The number of rows, each of the same number of rays. A motion detector has a row for each
        tilt.
    apart
        Whether the rays are single rays; if false, the rays of each row span a fan.
    """

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    apart: bool = False


@dataclass(frozen=True, eq=False)
class CastRays:
    """A bundle of n rays in world space and the ranges that a ray cast returned; lengths are in m.

    Attributes
    ----------
    origins, directions
        The origins and the unit directions (n, 3).
    reach
        The length of each ray (n,).
    ranges
        The distance from the origin of each ray to the nearest surface (n,).
    """

    origins: Array
    directions: Array
    reach: Array
    ranges: Array

    def same(self, other: CastRays) -> bool:
        """Return whether another bundle has the same rays and the same ranges."""
        mine = self.origins, self.directions, self.reach, self.ranges
        its = other.origins, other.directions, other.reach, other.ranges
        return are_equal(mine, its)


class Trace:
    """The last rays and hits of one sensor.

    Attributes
    ----------
    parameters, pose
        The parameters and the pose of the sensor when it cast the bundles.
    bundles
        The last rays and ranges of each ray bundle, by the number of the bundle. A change of the
        parameters or the pose removes all bundles.
    scan
        The ranges (n,) before the last cast, for each bundle of the last update, by its number. The
        value is None if a bundle was cast only once.
    step
        The step of the last update; None before the first one.
    revision
        A number that grows whenever a bundle, the parameters or the pose change.
    swept
        The last sweep of the sensor's beam; None before the first one.
    past
        For a sensor that integrates, the last steps at which it has sensed, in order.
    """

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor
        self.revision = 0
        # The names of solids by their numbers.
        self._names: Mapping[int, str] = {}
        self.forget()

    def forget(self) -> None:
        """Remove the last hits, because the sensor starts anew."""
        self.revision += 1
        self.bundles: dict[int, CastRays] = {}
        self.scan: dict[int, Array | None] = {}
        self.step: int | None = None
        self.parameters: Any = None
        self.pose: Any = None
        self.swept: Swept | None = None
        self.past: list[PlacedStep] = []
        self._sensed: dict[int, Array] = {}

    def record(self, query: Query, updates: Updates) -> Updates:
        """Return a copy of `updates` that records the rays and hits of the model's queries."""
        scene = {
            need: partial(self._ask, query, need, answer) if need in CAST else answer
            for need, answer in updates.scene.items()
        }
        return replace(updates, scene=scene)

    def _ask(
        self,
        query: Query,
        need: str,
        answer: Ask,
        *arguments: Any,
        indices: Index | None = None,
    ) -> Answers:
        """Answer the query `need` by the function `answer`, with the hits of its rays.

        Record the rays and ranges of the last update. `indices` (k,) are those of the updates
        that the query is about; None means all.
        """
        answers: Answers = answer(*arguments, indices=indices)
        if not len(answers.rows):
            return answers
        bundle, origins, directions, length, *_ = arguments
        read, known = query.read, (query.sensor.uid, query.bundle(bundle))
        last = query.steps[-1 if indices is None else int(indices[-1])]
        if need == RAYS:
            ranges = answers[-1]
        else:
            ranges = read.in_metres(query.probes.surfaces[need].ranges(*known))
        self.set_pose(read.parameters, read.pose)
        self._note(last, bundle, CastRays(origins, directions, length, ranges))
        in_units = read.rays_in_units(origins, directions, length)
        self._names = query.probes.names
        return replace(answers, hits=query.probes.hits(need, *known, in_units, len(answers.rows)))

    def set_pose(self, parameters: Any, pose: Pose | None) -> None:
        """Set the parameters and the pose with which the next bundles of rays are cast.

        Remove the present bundles if the parameters or the pose have changed.
        """
        if not self._is_same_pose(parameters, pose):
            self.bundles = {}
            self.revision += 1
        self.parameters, self.pose = parameters, pose

    def _is_same_pose(self, parameters: Any, pose: Pose | None) -> bool:
        known = self.pose
        if known is None or pose is None:
            return known is pose
        return bool(parameters == self.parameters) and pose.same(known)

    def _note(self, step: int, number: int, cast: CastRays) -> None:
        """Record that the sensor has cast the ray bundle `number` at a step."""
        if step != self.step:
            self.step, self.scan = step, {}
        if number not in self.scan:
            self.scan[number] = self._sensed.get(number)
        self._sensed[number] = cast.ranges
        self.show(number, cast)

    def show(self, number: int, cast: CastRays) -> None:
        """Set the rays and ranges of bundle `number`; call it for casts outside of updates."""
        known = self.bundles.get(number)
        if known is None or not known.same(cast):
            self.bundles[number] = cast
            self.revision += 1

    def copy_bundles(self, other: Trace) -> None:
        """Replace all bundles of rays by the bundles of another trace of the same sensor."""
        self.set_pose(other.parameters, other.pose)
        for number, cast in other.bundles.items():
            self.show(number, cast)
        for number in self.bundles.keys() - other.bundles.keys():
            del self.bundles[number]
            self.revision += 1

    def rays(self, metres: float) -> SensorRays:
        """Return the rays of all bundles in Blender units, as one row for each bundle.

        `metres` is the length of a Blender unit in m.
        """
        bundles = self.bundles.values()
        if not bundles:
            return SensorRays(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
        return SensorRays(
            np.concatenate([bundle.origins / metres for bundle in bundles]),
            np.concatenate([bundle.directions for bundle in bundles]),
            np.concatenate([bundle.reach / metres for bundle in bundles]),
            len(bundles),
        )

    def name_of(self, number: int) -> str:
        """Return the name of the object with this number; empty if no object has the number."""
        return self._names.get(number, "")
