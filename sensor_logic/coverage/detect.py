# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a detector detects a motion: the detector's own model, on rays that were cast once
through the empty room and are then intersected with the moving body in closed form.

A motion starts at an update; with the saw-tooth, at that of the first tilt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from .detectors import SAMPLE_EVERY, Response, filtered
from .motions import BodyHits, Motion, Rays, Start, hits

# Bodies times rays in one batch, to bound the memory.
AT_ONCE = 1_500_000


class DetectorView(Protocol):
    """One detector in the room, and its response to motions."""

    def strengths(self, motion: Motion, start: Start) -> Array:
        """The signal (m,) of each motion divided by the threshold: above 1 it is detected."""
        ...

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """(m,): false only for motions that are not detected; a much faster test."""
        ...


@dataclass(frozen=True)
class RangeView:
    """A range scan: unit `directions` (tilts, rays, 3) in the world; `free` (tilts, rays): its
    ranges in m without the body; `period`: s between two scans of one tilt; `offsets` (tilts,): the
    times of the first scans in s."""

    origin: Array
    directions: Array
    free: Array
    range_min: float
    range_max: float
    threshold: float
    period: float
    offsets: Array

    # Once a view; without it 0.1 ms a tilt of 1440 rays for each cell.
    @cached_property
    def _tilts(self) -> list[Rays]:
        each = zip(self.directions, self.free, strict=True)
        return [Rays(self.origin, ways, free) for ways, free in each]

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        found = np.zeros(len(start), bool)
        apart = np.linalg.norm(start.feet[:, :2] - self.origin[:2], axis=1)
        far = max(float(rays.far.max(initial=0.0)) for rays in self._tilts)
        left = np.flatnonzero(apart <= far + motion.longest)
        for rays in self._tilts:
            found[left] = rays.may_meet(motion, start.part(left))
            left = left[~found[left]]
        return found

    def strengths(self, motion: Motion, start: Start) -> Array:
        changes = np.zeros(len(start))
        near = np.flatnonzero(self.may_notice(motion, start))
        at_once = max(1, AT_ONCE // max(1, self.free.shape[1]))
        for first in range(0, len(near), at_once):
            rows = near[first : first + at_once]
            changes[rows] = self._changes(motion, start.part(rows))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = changes / self.threshold
        return np.where(changes > 0.0, ratio, 0.0)

    def _changes(self, motion: Motion, start: Start) -> Array:
        """(m,): the largest change in m of any range from one scan of a tilt to the next."""
        longest = float(start.length.max(initial=0.0)) / motion.speed
        largest = np.zeros(len(start))
        for tilt, offset in enumerate(self.offsets.tolist()):
            # At rest, then at each scan, until the body is at rest again.
            scans = max(0, math.ceil((longest - offset) / self.period - 1e-9)) + 1
            times = [0.0, *(offset + k * self.period for k in range(scans))]
            if times[1] == 0.0:
                times = times[1:]
            self._compare(tilt, motion, start, times, largest)
        return largest

    def _compare(
        self, tilt: int, motion: Motion, start: Start, times: list[float], largest: Array
    ) -> None:
        """Raises `largest` (m,) to the changes of one tilt's ranges from each time to the next.

        Only rays that hit a body are compared: all others read `free`.
        """
        free = self.free[tilt]
        rays = len(free)
        before, after = np.tile(free, len(start)), np.tile(free, len(start))
        known = np.empty(0, np.intp)
        for number, time in enumerate(times):
            met = hits(motion, start, time, self._tilts[tilt])
            at = _met_at(met, self.range_min)
            nearer = at < free[met.ray]
            found = met.body[nearer] * rays + met.ray[nearer]
            after[found] = at[nearer]
            if number:
                for which in (known, found):
                    _raise_to(largest, which // rays, np.abs(after[which] - before[which]))
            before[known] = free[known % rays]
            before, after, known = after, before, found


@dataclass(frozen=True)
class WarmView:
    """A pyroelectric detector: unit `directions` (n, 3) in the world, their signed `weights` (n,)
    in sr, and their ranges without the body, `free` (n,) in m; the radiosity `behind` (n,) there
    and that of the `body`, both in W/m² above that of the ambient; the `threshold` in W per m² of
    lenslet; `interval`: s between updates."""

    origin: Array
    directions: Array
    weights: Array
    free: Array
    behind: Array
    body: float
    range_min: float
    response: Response
    threshold: float
    interval: float

    # Once a view; without it 0.1 ms for each cell.
    @cached_property
    def _all(self) -> Rays:
        return Rays(self.origin, self.directions, self.free)

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        return self._all.may_meet(motion, start)

    def strengths(self, motion: Motion, start: Start) -> Array:
        signals = np.zeros(len(start))
        near = np.flatnonzero(self.may_notice(motion, start))
        at_once = max(1, AT_ONCE // max(1, len(self.free)))
        for first in range(0, len(near), at_once):
            rows = near[first : first + at_once]
            signals[rows] = self._signals(motion, start.part(rows))
        return signals / self.threshold

    def _signals(self, motion: Motion, start: Start) -> Array:
        """(m,): the largest size of the signal, from rest until it has decayed."""
        longest = float(start.length.max(initial=0.0)) / motion.speed
        moving = math.ceil(longest / self.interval - 1e-9) + 1
        settle = (self.response.thermal + 1.0 / self.response.high_cut) * 3.0
        still = max(1, math.ceil(settle / self.interval))
        powers = [self._power(motion, start, k * self.interval) for k in range(moving)]
        powers += [powers[-1]] * still
        # Like the detector's model: power changes linearly, with samples between the updates.
        parts = max(1, math.ceil(self.interval / SAMPLE_EVERY - 1e-9))
        steps = [powers[0]]
        for one, two in pairwise(powers):
            steps += [one + (two - one) * (k / parts) for k in range(1, parts + 1)]
        dt = round(self.interval / parts, 12)
        signals: Array = np.abs(filtered(self.response, np.stack(steps), dt)).max(axis=0)
        return signals

    def _power(self, motion: Motion, start: Start, time: float) -> Array:
        """(m,): the change of the power on the elements by the bodies, W per m² of lenslet."""
        met = hits(motion, start, time, self._all)
        seen = _met_at(met, self.range_min) < self.free[met.ray]
        ray = met.ray[seen]
        added = self.weights[ray] * (self.body - self.behind[ray]) / math.pi
        power = np.bincount(met.body[seen], added, len(start))
        return power.astype(np.float64)


def _raise_to(largest: Array, body: NDArray[np.intp], change: Array) -> None:
    """Raises `largest` (m,) to the changes (n,) of the bodies (n,), which must be in order."""
    if len(body):
        first = np.flatnonzero(np.diff(body, prepend=-1))
        most = np.maximum.reduceat(change, first)
        largest[body[first]] = np.maximum(largest[body[first]], most)


def _met_at(met: BodyHits, range_min: float) -> Array:
    """The distances (n,) in m of the hits from the origin; a ray, which begins at `range_min`, hits
    the far side of a body that it begins in."""
    at = np.where(met.enter >= range_min, met.enter, met.leave)
    return np.where(at >= range_min, at, np.inf)
