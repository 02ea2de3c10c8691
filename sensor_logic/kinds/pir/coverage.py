# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage of motion detectors: decide with the detector's own model whether it detects a motion.

A motion starts at an update of the detector. If the detector tilts its fan from update to update,
the motion starts at an update with the first tilt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...coverage.detect import DetectorView, hit_distances, parts_of
from ...coverage.motions import WALKER, Motion, Rays, Start, hits
from ...kind import RAYS, WARMTH
from ...logs.wording import ZERO_CELSIUS
from ...model import Array, Update
from ...physics import STEFAN_BOLTZMANN, radiosity
from .pyroelectric import (
    SAMPLE_EVERY,
    SIGHT,
    Response,
    filtered,
    rays_of,
    response_of,
    threshold_of,
)
from .range_scan import PirParameters, fan_directions


def view(parameters: PirParameters, update: Update, rate: float) -> DetectorView:
    """Return the view of a motion detector; the parameters are as for `Kind.view`."""
    if parameters.model == "PYROELECTRIC":
        return _warm_view(parameters, update, rate)
    fan = fan_directions(parameters)
    directions = fan.reshape(-1, 3) @ update.pose.axes.T
    reach = np.full(len(directions), parameters.range_max - parameters.range_min)
    origins = update.pose.origin + directions * parameters.range_min
    ranges = update.ask(RAYS, 0, origins, directions, reach)
    free = np.where(ranges >= reach, parameters.range_max, ranges + parameters.range_min)
    tilts = len(fan)
    period, offsets = 1.0 / rate, np.zeros(tilts)
    if parameters.sweep != "ALL":
        period, offsets = tilts / rate, np.arange(tilts) / rate
    return RangeView(
        update.pose.origin,
        directions.reshape(fan.shape),
        np.clip(free, parameters.range_min, parameters.range_max).reshape(fan.shape[:2]),
        parameters.range_min,
        parameters.range_max,
        parameters.threshold,
        period,
        offsets,
    )


def _warm_view(parameters: PirParameters, update: Update, rate: float) -> WarmView:
    local = rays_of(parameters)
    directions = local.directions @ update.pose.axes.T
    origins = update.pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), SIGHT)
    ranges = np.minimum(update.ask(RAYS, 0, origins, directions, reach), reach)
    seen = update.ask(WARMTH, 0, origins, directions, reach)
    ambient = STEFAN_BOLTZMANN * seen.ambient**4
    kelvin = WALKER.celsius + ZERO_CELSIUS
    return WarmView(
        update.pose.origin,
        directions,
        local.weights,
        ranges + parameters.range_min,
        radiosity(seen) - ambient,
        STEFAN_BOLTZMANN * WALKER.emissivity * (kelvin**4 - seen.ambient**4),
        parameters.range_min,
        response_of(parameters),
        threshold_of(parameters),
        1.0 / rate,
    )


@dataclass(frozen=True)
class RangeView:
    """A detector that scans ranges.

    Attributes
    ----------
    origin
        The position (3,) in m.
    directions
        Unit directions (tilts, rays, 3) in the world.
    free
        The ranges (tilts, rays) in m in the room without a body.
    period
        The time in s between two scans of the same tilt.
    offsets
        The time (tilts,) in s of the first scan of each tilt.
    """

    origin: Array
    directions: Array
    free: Array
    range_min: float
    range_max: float
    threshold: float
    period: float
    offsets: Array

    # Cached: without the cache, each cell takes 0.1 ms more for a tilt of 1440 rays.
    @cached_property
    def _tilts(self) -> list[Rays]:
        each = zip(self.directions, self.free, strict=True)
        return [Rays(self.origin, ways, free) for ways, free in each]

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """Return whether any ray can hit the body during the motion, for m motions (m,)."""
        found = np.zeros(len(start), bool)
        if not motion.speed:
            return found
        apart = np.linalg.norm(start.feet[:, :2] - self.origin[:2], axis=1)
        far = max(float(rays.far.max(initial=0.0)) for rays in self._tilts)
        left = np.flatnonzero(apart <= far + motion.longest)
        for rays in self._tilts:
            found[left] = rays.may_hit(motion, start.part(left))
            left = left[~found[left]]
        return found

    def strengths(self, motion: Motion, start: Start) -> Array:
        """Return the largest change (m,) of a range in each motion, divided by the threshold."""
        changes = np.zeros(len(start))
        near = np.flatnonzero(self.may_notice(motion, start))
        for rows in parts_of(near, self.free.shape[1]):
            changes[rows] = self._changes(motion, start.part(rows))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = changes / self.threshold
        return np.where(changes > 0.0, ratio, 0.0)

    def _changes(self, motion: Motion, start: Start) -> Array:
        """Return the largest change (m,) in m of a range between successive scans of a tilt."""
        longest = motion.seconds(start)
        largest = np.zeros(len(start))
        for tilt, offset in enumerate(self.offsets.tolist()):
            # Before the motion, then at each scan until the body is at rest again.
            scans = max(0, math.ceil((longest - offset) / self.period - 1e-9)) + 1
            times = [0.0, *(offset + k * self.period for k in range(scans))]
            if times[1] == 0.0:
                times = times[1:]
            self._compare(tilt, motion, start, times, largest)
        return largest

    def _compare(
        self, tilt: int, motion: Motion, start: Start, times: list[float], largest: Array
    ) -> None:
        """Set `largest` (m,), in place, to the largest change of a range, if that is larger.

        The ranges of one tilt are compared between successive `times`. A ray that hits no body has
        the range `free` and is not compared.
        """
        free = self.free[tilt]
        rays = len(free)
        before, after = np.tile(free, len(start)), np.tile(free, len(start))
        known = np.empty(0, np.intp)
        for number, time in enumerate(times):
            body_hits = hits(motion, start, time, self._tilts[tilt])
            at = hit_distances(body_hits, self.range_min)
            nearer = at < free[body_hits.ray]
            found = body_hits.body[nearer] * rays + body_hits.ray[nearer]
            after[found] = at[nearer]
            if number:
                for which in (known, found):
                    _raise_to(largest, which // rays, np.abs(after[which] - before[which]))
            before[known] = free[known % rays]
            before, after, known = after, before, found


@dataclass(frozen=True)
class WarmView:
    """A pyroelectric detector.

    Attributes
    ----------
    origin
        The position (3,) in m.
    directions
        Unit directions (n, 3) of the rays in the world.
    weights
        The solid angle (n,) of each ray in sr, with the sign of its element's polarity.
    free
        The ranges (n,) in m in the room without a body.
    behind
        The radiosity (n,) of the surfaces that the rays hit without a body, minus the radiosity of
        a surface at ambient temperature, in W/m².
    body
        The same for the body.
    threshold
        The least signal that is detected, in W per m² of lenslet.
    interval
        The time in s between updates.
    """

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

    # Cached: without the cache, each cell takes 0.1 ms more.
    @cached_property
    def _all(self) -> Rays:
        return Rays(self.origin, self.directions, self.free)

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """Return whether any ray can hit the body during the motion, for m motions (m,)."""
        return self._all.may_hit(motion, start) & bool(motion.speed)

    def strengths(self, motion: Motion, start: Start) -> Array:
        """Return the largest size (m,) of the signal in each motion, divided by the threshold."""
        signals = np.zeros(len(start))
        near = np.flatnonzero(self.may_notice(motion, start))
        for rows in parts_of(near, len(self.free)):
            signals[rows] = self._signals(motion, start.part(rows))
        return signals / self.threshold

    def _signals(self, motion: Motion, start: Start) -> Array:
        """Return the largest size (m,) of the signal for m motions.

        The signal is computed from the begin of the motion until it has decayed.
        """
        longest = motion.seconds(start)
        moving = math.ceil(longest / self.interval - 1e-9) + 1
        settle = (self.response.thermal + 1.0 / self.response.high_cut) * 3.0
        still = max(1, math.ceil(settle / self.interval))
        powers = [self._power(motion, start, k * self.interval) for k in range(moving)]
        powers += [powers[-1]] * still
        # As in the detector's model, the power changes linearly between updates.
        parts = max(1, math.ceil(self.interval / SAMPLE_EVERY - 1e-9))
        steps = [powers[0]]
        for one, two in pairwise(powers):
            steps += [one + (two - one) * (k / parts) for k in range(1, parts + 1)]
        dt = round(self.interval / parts, 12)
        signals: Array = np.abs(filtered(self.response, np.stack(steps), dt)).max(axis=0)
        return signals

    def _power(self, motion: Motion, start: Start, time: float) -> Array:
        """Return the change (m,) of the power on the elements that each body causes at `time`.

        The unit is W per m² of lenslet.
        """
        body_hits = hits(motion, start, time, self._all)
        seen = hit_distances(body_hits, self.range_min) < self.free[body_hits.ray]
        ray = body_hits.ray[seen]
        added = self.weights[ray] * (self.body - self.behind[ray]) / math.pi
        power = np.bincount(body_hits.body[seen], added, len(start))
        return power.astype(np.float64)


def _raise_to(largest: Array, body: NDArray[np.intp], change: Array) -> None:
    """Set `largest` (m,), in place, to the largest change of each body, if that is larger.

    `change` (n,) has the changes, and `body` (n,) the number of the body of each, in ascending
    order.
    """
    if len(body):
        first = np.flatnonzero(np.diff(body, prepend=-1))
        most = np.maximum.reduceat(change, first)
        largest[body[first]] = np.maximum(largest[body[first]], most)
