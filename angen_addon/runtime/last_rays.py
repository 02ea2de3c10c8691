# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rays of a sensor met when it sensed last: for views, which cast none of their own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...sensor_logic.model import Array, Pose


@dataclass(frozen=True, eq=False)
class RaysMet:
    """A bundle of rays in the world, in m: origins (n, 3), unit directions (n, 3), how far they
    reach (n,) and how far they get (n,). The same object as long as these stay the same."""

    origins: Array
    directions: Array
    reach: Array
    ranges: Array

    def same(self, other: RaysMet) -> bool:
        mine = self.origins, self.directions, self.reach, self.ranges
        its = other.origins, other.directions, other.reach, other.ranges
        return all(a is b or np.array_equal(a, b) for a, b in zip(mine, its, strict=True))


class LastRays:
    """The bundles of one sensor, by their number, with the `parameters` and the `pose` that they
    were cast with; a bundle that was not cast since these changed is not known. `scan`: those cast
    at the last update, each with the ranges (n,) that it found at its update before, None of the
    first. `revision` grows where a bundle or what it was cast with changes."""

    def __init__(self) -> None:
        self.revision = 0
        self.forget()

    def forget(self) -> None:
        """Nothing is known: the sensor starts anew."""
        self.revision += 1
        self.bundles: dict[int, RaysMet] = {}
        self.scan: dict[int, Array | None] = {}
        self.step: int | None = None
        self.parameters: Any = None
        self.pose: Pose | None = None
        self._sensed: dict[int, Array] = {}

    def aim(self, parameters: Any, pose: Pose | None) -> None:
        """From now on bundles are cast with these; None: none are."""
        if not self._is_aimed(parameters, pose):
            self.bundles = {}
            self.revision += 1
        self.parameters, self.pose = parameters, pose

    def _is_aimed(self, parameters: Any, pose: Pose | None) -> bool:
        known = self.pose
        if parameters is self.parameters and pose is known:
            return True
        if known is None or pose is None or parameters != self.parameters:
            return False
        same = np.array_equal(pose.origin, known.origin) and np.array_equal(pose.axes, known.axes)
        return bool(same)

    def note(self, step: int, number: int, met: RaysMet) -> None:
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

    def take_over(self, other: LastRays) -> None:
        """Shows what a full scan found."""
        self.aim(other.parameters, other.pose)
        for number, met in other.bundles.items():
            self.show(number, met)
        for number in self.bundles.keys() - other.bundles.keys():
            del self.bundles[number]
            self.revision += 1
