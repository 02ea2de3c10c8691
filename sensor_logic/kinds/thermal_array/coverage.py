# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage of infrared arrays: how far a body's warm pixels exceed the threshold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...coverage.detect import DetectorView, hit_distances, parts_of
from ...coverage.motions import WALKER, Motion, Rays, Start, hits
from ...kind import RAYS, WARMTH
from ...logs.wording import ZERO_CELSIUS
from ...model import Array, Update
from ...physics import STEFAN_BOLTZMANN, radiosity
from .array import Background, Settling, array_rays, celsius
from .parameters import ThermalArrayParameters

# The motion is sampled at least this often, in Hz, however low the update rate is.
LEAST_RATE = 1.0
# While the body rests, pixels settle for this many time constants, in at most this many steps.
REST = 7.0
REST_STEPS = 200


def view(parameters: ThermalArrayParameters, update: Update, rate: float) -> DetectorView:
    """Return the view of an infrared array; its arguments are those of `Kind.view`."""
    origins, directions, reach = array_rays(parameters, update.pose)
    ranges = np.minimum(update.ask(RAYS, 0, origins, directions, reach), reach)
    seen = update.ask(WARMTH, 0, origins, directions, reach)
    kelvin = WALKER.celsius + ZERO_CELSIUS
    emitted = WALKER.emissivity * (kelvin**4 - seen.ambient**4) + seen.ambient**4
    return ThermalView(
        update.pose.origin,
        directions,
        ranges,
        radiosity(seen),
        STEFAN_BOLTZMANN * emitted,
        parameters,
        1.0 / max(rate, LEAST_RATE),
    )


@dataclass(frozen=True)
class ThermalView:
    """An infrared array in a room.

    Attributes
    ----------
    origin
        The position (3,) in m.
    directions
        Unit directions (n, 3) of the rays in the world, pixel by pixel.
    free
        The ranges (n,) in m in the room without a body.
    behind
        The radiosity (n,) of the surfaces that the rays hit without a body, in W/m².
    body
        The same for the body.
    parameters
        The parameters of the array.
    interval
        The time in s between updates.
    """

    origin: Array
    directions: Array
    free: Array
    behind: Array
    body: float
    parameters: ThermalArrayParameters
    interval: float

    # Cached: without the cache, each cell takes 0.1 ms more.
    @cached_property
    def _all(self) -> Rays:
        return Rays(self.origin, self.directions, self.free)

    @cached_property
    def _empty(self) -> Array:
        """The mean radiosity (pixels,) in W/m² without a body."""
        found: Array = self.behind.reshape(-1, self.parameters.rays).mean(axis=1)
        return found

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """Return whether any ray can hit the body during the motion, for m motions (m,)."""
        return self._all.may_hit(motion, start)

    def strengths(self, motion: Motion, start: Start) -> Array:
        """Return the excess temperature (m,) in each motion, divided by the threshold.

        It is that of the pixel which makes the output go on: of as many pixels as must be warm, the
        least warm one.
        """
        found = np.zeros(len(start))
        near = np.flatnonzero(self.may_notice(motion, start))
        pixels = self.parameters.columns * self.parameters.rows
        for rows in parts_of(near, len(self.free) + 8 * pixels):
            found[rows] = self._excess(motion, start.part(rows))
        return found / self.parameters.threshold

    def _excess(self, motion: Motion, start: Start) -> Array:
        """Return the largest excess temperature (m,) in K until the body has come to rest.

        A learnt background learns meanwhile, from the pixels that are not warm.
        """
        moving = math.ceil(motion.seconds(start) / self.interval - 1e-9) + 1
        settling, background = Settling(), Background()
        largest = np.zeros(len(start))
        tau, before = self.parameters.settling_time, np.tile(self._empty, (len(start), 1))
        settling.run(before.reshape(1, -1), np.zeros(1), tau)
        learns = self.parameters.background == "LEARNT"
        if learns:
            background.run(self.parameters, celsius(before.reshape(1, -1)), np.zeros(1))
        # With a fixed background, pixels that have settled exceed it most.
        resting = min(math.ceil(REST * tau / self.interval), REST_STEPS) if learns else 0
        for number in range(moving + resting):
            step = self.interval
            if number < moving:
                now = self._radiosities(motion, start, number * self.interval)
            else:
                step = max(step, REST * tau / REST_STEPS)
            steps = np.full(1, step)
            frames = celsius(settling.run(now.reshape(1, -1), steps, tau))
            if learns:
                learnt, _ = background.run(self.parameters, frames, steps)
                excess = (frames - learnt).reshape(now.shape)
            else:
                excess = _over_median(frames.reshape(now.shape))
            np.maximum(largest, self._least_warm(excess), out=largest)
        if learns:
            return largest
        return np.maximum(largest, self._least_warm(_over_median(celsius(now))))

    def _radiosities(self, motion: Motion, start: Start, time: float) -> Array:
        """Return the mean radiosity (m, pixels) of each pixel with each body at `time`, in W/m²."""
        found = hits(motion, start, time, self._all)
        seen = hit_distances(found, 0.0) < self.free[found.ray]
        body, ray = found.body[seen], found.ray[seen]
        pixels, rays = len(self._empty), self.parameters.rays
        added = (self.body - self.behind[ray]) / rays
        where = body * pixels + ray // rays
        sums = np.bincount(where, added, len(start) * pixels).reshape(len(start), pixels)
        return self._empty + sums

    def _least_warm(self, excess: Array) -> Array:
        """Return the excess (m,) in K of the last of the pixels that must be warm.

        `excess` (m, pixels) is the excess of all pixels in K.
        """
        last = excess.shape[1] - self.parameters.min_pixels
        found: Array = np.partition(excess, last, axis=1)[:, last]
        return found


def _over_median(frames: Array) -> Array:
    """Return the excess (m, pixels) of the pixels of each frame (m, pixels) over its median."""
    found: Array = frames - np.median(frames, axis=1)[:, None]
    return found
