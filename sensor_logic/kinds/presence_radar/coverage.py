# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage of presence radars: decide with the radar's own model whether it detects a motion.

A body that walks, crawls or moves an arm is detected by the radial speed of its surface. A still
body is detected by its breathing, as if it had moved before. Both by the mean of the fading.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...coverage.detect import DetectorView, hit_distances, parts_of
from ...coverage.motions import Motion, Rays, Start, hits
from ...model import Array, Index, Update
from ...radio.echoes import ECHOES
from ...radio.substances import reflectance
from .parameters import RadarParameters
from .radar import (
    NEAREST,
    PERSON_BREATHING,
    PERSON_RATE,
    WINDOW,
    Beams,
    Calibration,
    amplitude,
    breathing_speed,
    calibration,
    cells_of,
    doppler_weight,
    gate_sums,
    radar_beams,
)
from .window import CELLS

# m. Losses along the rays are known at multiples of this distance. A wall nearer behind the front
# of a body would be inside the body.
STEP = 0.25
# The most losses that are kept, to bound the memory: with more rays, the steps are longer.
MOST_LOSSES = 4_000_000


def view(parameters: RadarParameters, update: Update, rate: float) -> DetectorView:
    """Return the view of a radar; its arguments are those of `Kind.view`."""
    beams = radar_beams(parameters, update.pose)
    rays = beams.origins, beams.directions
    how = parameters.frequency, parameters.integration_time
    whole = update.ask(ECHOES, 0, *rays, beams.length, *how)
    count, farthest = len(beams.length), float(whole.ranges.max())
    step = max(STEP, farthest / max(1, MOST_LOSSES // count))
    loss = [np.zeros(count)]
    # Until the rays have passed all that they pass. One bundle: the scene keeps the last answer of
    # each.
    while not np.array_equal(loss[-1], whole.loss) and (len(loss) - 1) * step < farthest:
        length = np.full(count, min(len(loss) * step, parameters.reach))
        loss.append(update.ask(ECHOES, 1, *rays, length, *how).loss)
    known, origin = calibration(parameters), update.pose.origin
    return RadarView(parameters, known, origin, beams, whole.ranges, np.stack(loss), step, rate)


@dataclass(frozen=True)
class RadarView:
    """A presence radar in a room.

    Attributes
    ----------
    parameters, known, beams
        The parameters of the radar, its calibration and its n rays.
    origin
        The position (3,) in m.
    free
        The ranges (n,) in m in the room without a body.
    loss
        The one-way loss (steps, n) in dB of each ray up to the multiples of `step`, as far as it
        grows.
    step
        The distance in m between these losses: STEP, or more with very many rays.
    rate
        The update rate in Hz.
    """

    parameters: RadarParameters
    known: Calibration
    origin: Array
    beams: Beams
    free: Array
    loss: Array
    step: float
    rate: float

    # Cached: without the cache, each cell takes 0.1 ms more.
    @cached_property
    def _rays(self) -> Rays:
        return Rays(self.origin, self.beams.directions, self.free)

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """Return whether any ray can hit the body during the motion, for m motions (m,)."""
        return self._rays.may_hit(motion, start)

    def strengths(self, motion: Motion, start: Start) -> Array:
        """Return the largest amplitude (m,) in a gate in each motion, by that of its threshold."""
        strengths = np.zeros(len(start))
        near = np.flatnonzero(self.may_notice(motion, start))
        for rows in parts_of(near, len(self.free)):
            part = start.part(rows)
            updates = max(1, math.ceil(motion.seconds(part) * self.rate - 1e-9))
            each = [self._strength(motion, part, k / self.rate) for k in range(1, updates + 1)]
            strengths[rows] = np.max(each, axis=0)
        return strengths

    def _strength(self, motion: Motion, start: Start, time: float) -> Array:
        """Return the largest ratio (m,) in a gate at the update at `time`."""
        parameters, known = self.parameters, self.known
        seen = hits(motion, start, time, self._rays)
        at = hit_distances(seen, parameters.range_min / parameters.range_scale)
        visible = (at < self.free[seen.ray]) & (at < parameters.reach)
        body, ray, at = seen.body[visible], seen.ray[visible], at[visible]
        step = np.minimum(np.ceil(at / self.step).astype(np.intp), len(self.loss) - 1)
        power = reflectance("BODY", parameters.frequency) * self.beams.weight[ray]
        power = power / np.maximum(at, NEAREST) ** 2 * 10.0 ** (-0.2 * self.loss[step, ray])
        channel, corner = (
            (0, parameters.moving_corner) if motion.speed else (1, parameters.still_corner)
        )
        if motion.speed:
            speed = self._radial_speed(motion, start, time, body, ray, at)
        else:
            speed = breathing_speed(PERSON_BREATHING, PERSON_RATE)
        size = cells_of(parameters)
        cell = body * size + np.rint(at * (CELLS / parameters.bin_length)).astype(np.intp)
        counts = np.bincount(cell, power * doppler_weight(speed, corner), len(start) * size)
        cells = counts.astype(np.float64)
        in_gates = gate_sums(cells.reshape(-1, size), WINDOW**2, parameters.gates)
        floors = known.floors[channel]
        found = np.where(
            in_gates > 0.0, np.hypot(known.gain[channel] * np.sqrt(in_gates), floors), 0.0
        )
        strongest: Array = (found / amplitude(parameters, known.thresholds[channel])).max(axis=1)
        return strongest

    def _radial_speed(
        self, motion: Motion, start: Start, time: float, body: Index, ray: Index, at: Array
    ) -> Array:
        """Return the mean radial speed (k,) of hit points in the integration time, in m/s.

        `body`, `ray` and `at` (k,) are those of the hits at `time`.
        """
        ways, interval = self.beams.directions[ray], self.parameters.integration_time
        radial: Array
        gone = [np.minimum(motion.speed * one, start.length) for one in (time - interval, time)]
        rate = ((gone[1] - gone[0]) / interval)[body]
        if motion.walks:
            heading = start.heading[body]
            radial = rate * (ways[:, 0] * np.cos(heading) + ways[:, 1] * np.sin(heading))
        else:
            arm = self.origin + ways * at[:, None] - start.feet[body]
            radial = rate * (ways[:, 1] * arm[:, 0] - ways[:, 0] * arm[:, 1])
        return radial
