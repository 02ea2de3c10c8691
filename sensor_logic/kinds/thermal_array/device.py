# SPDX-License-Identifier: GPL-3.0-or-later
"""What the device adds to the frames of an infrared array: a running mean, noise, drift and limits.

All draws are from the sensor's own generators, by the number of the update or by time. So a frame
is the same in a run, live, in a day and in batches of any size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ...model import Array, Updates
from .parameters import ThermalArrayParameters


def noise_by_place(parameters: ThermalArrayParameters) -> Array:
    """Return the factor (pixels,) by which the noise of each pixel exceeds that on the axis.

    It is 1 + a·r² + b·r⁶. r is the distance from the middle of the frame, in pixels, divided by
    that of a corner pixel. So 1 + a + b is the factor of a corner pixel.
    """
    across, up = (np.arange(n) - (n - 1) / 2 for n in parameters.pixels)
    squares = (across[None] ** 2 + up[:, None] ** 2).ravel()
    squares = squares / max(squares.max(), 1e-9)
    found: Array = 1.0 + parameters.noise_rise * squares + parameters.noise_corner * squares**3
    return found


class RunningMean:
    """The mean of the last readings, which starts as if the first one had lasted for long."""

    def __init__(self) -> None:
        self._last: Array | None = None

    def run(self, frames: Array, count: int) -> Array:
        """Return the mean (n, pixels) of each of the `frames` (n, pixels) and `count` − 1 before.

        It is exactly the same for batches of any size.
        """
        if count <= 1:
            self._last = None
            return frames
        last = self._last
        if last is None or last.shape != (count - 1, frames.shape[1]):
            last = np.repeat(frames[:1], count - 1, axis=0)
        known = np.concatenate([last, frames])
        self._last = known[len(frames) :]
        total = np.zeros_like(frames)
        for first in range(count):
            total += known[first : first + len(frames)]
        return total / count


@dataclass
class Device:
    """The errors of one device. It keeps draws that several updates need.

    Attributes
    ----------
    draws
        By the number of an update: the draws (pixels + 1,) of its noise, of all pixels and of the
        frame.
    knots
        By the number of a knot of the drift: its draws (pixels + 1,) in the same order.
    """

    draws: dict[int, Array] = field(default_factory=dict)
    knots: dict[tuple[int, int], Array] = field(default_factory=dict)

    def publish(self, parameters: ThermalArrayParameters, updates: Updates, frames: Array) -> Array:
        """Return the frames (n, pixels) in °C with the errors, limits and steps of the device."""
        pixels = frames.shape[1]
        device = updates.device_noise()
        # Also drawn where it is not used, so that the pattern does not depend on it.
        frames = frames + device.normal() * parameters.offset_sigma
        if parameters.fixed_pattern > 0.0 or parameters.drifts:
            pattern, seed = device.normal(size=pixels), int(device.integers(1 << 62))
            frames = frames + parameters.fixed_pattern * pattern
            if parameters.drifts:
                frames = frames + self._drift(parameters, updates.times, pixels, seed)
        if parameters.netd > 0.0 or parameters.frame_noise > 0.0:
            scales = np.append(parameters.netd * noise_by_place(parameters), parameters.frame_noise)
            noise = self._noise(parameters.mean_of, updates, pixels) * scales
            frames = frames + noise[:, :-1] + noise[:, -1:]
        if parameters.resolution > 0.0:
            frames = np.round(frames / parameters.resolution) * parameters.resolution
        return np.clip(frames, parameters.coldest, parameters.hottest)

    def _noise(self, count: int, updates: Updates, pixels: int) -> Array:
        """Return the noise (n, pixels + 1) of the updates, with a standard deviation of 1.

        With a running mean of `count` readings, successive updates share their draws.
        """
        known, found = self.draws, np.zeros((len(updates), pixels + 1))
        for row, number in zip(found, updates.numbers.tolist(), strict=True):
            needed = range(max(number - count + 1, 0), number + 1)
            for k in needed:
                if k not in known or len(known[k]) != len(row):
                    known[k] = updates.noise(k).normal(size=pixels + 1)
                row += known[k]
            row /= math.sqrt(len(needed))
            # The draws that the next update needs too.
            for k in [k for k in known if k < number - count + 2 or k > number]:
                del known[k]
        return found

    def _drift(
        self, parameters: ThermalArrayParameters, times: Array, pixels: int, seed: int
    ) -> Array:
        """Return the slow error (n, pixels) in K at each time.

        Each multiple of the drift time is a knot with draws of its own. Between two knots the error
        is the sum of their draws by the cosine and the sine, so that its standard deviation is the
        same at all times.
        """
        found = np.empty((len(times), pixels))
        for row, time in zip(found, (times / parameters.drift_time).tolist(), strict=True):
            knot = math.floor(time)
            angle = (time - knot) * math.pi / 2
            draws = math.cos(angle) * self._knot(seed, knot, pixels)
            draws += math.sin(angle) * self._knot(seed, knot + 1, pixels)
            row[:] = parameters.pixel_drift * draws[:-1] + parameters.frame_drift * draws[-1]
            for key in [key for key in self.knots if key not in ((seed, knot), (seed, knot + 1))]:
                del self.knots[key]
        return found

    def _knot(self, seed: int, knot: int, pixels: int) -> Array:
        known = self.knots.get((seed, knot))
        if known is None or len(known) != pixels + 1:
            known = np.random.default_rng([seed, knot % (1 << 32)]).normal(size=pixels + 1)
            self.knots[seed, knot] = known
        return known
