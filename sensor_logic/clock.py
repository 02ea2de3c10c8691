# SPDX-License-Identifier: GPL-3.0-or-later
"""The times at which a sensor samples.

The arithmetic is exact (fractions), so playback, baking and runs without a window agree.

Time t is 0 at the start frame of the scene. A sensor with rate r publishes at t = k/r, for k = 0,
1, 2, … It samples at the first step at or after k/r. A step is a frame, or one of the `substeps` of
a frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

# Enough for 1/3 Hz, 29.97 fps and the like.
LARGEST_DENOMINATOR = 1000


def exact(value: float) -> Fraction:
    """Return the number that a user typed, given the single-precision value that Blender stores.

    Blender stores 0.9 as 0.899999976…, which would put the third sample at 0.9 Hz and 24 fps one
    frame late. The result is the simplest fraction that is equal in single precision. If there is
    no simple one, it is the value rounded to seven significant digits, as many as single precision
    holds.
    """
    simple = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
    if np.float32(float(simple)) == np.float32(value):
        return simple
    return Fraction(f"{value:.7g}")


@dataclass(frozen=True)
class Clock:
    """The time base of a scene.

    Steps are counted from the frame `frame_start`. A frame has `substeps` steps.
    """

    frame_start: int
    fps: float
    fps_base: float = 1.0
    substeps: int = 1

    # Both are cached: without the cache, each conversion of a step takes 6 µs more.
    @cached_property
    def steps_per_second(self) -> Fraction:
        """The number of steps in a second."""
        return exact(self.fps) / exact(self.fps_base) * self.substeps

    @cached_property
    def _steps_over_seconds(self) -> tuple[int, int]:
        return self.steps_per_second.as_integer_ratio()

    def step_time(self, step: int) -> float:
        """Return the time of `step` in seconds since the start frame."""
        steps, seconds = self._steps_over_seconds
        return step * seconds / steps

    def times_and_frames(
        self, steps: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the times (n,) in s from the start frame, and the frames (n,), of steps (n,)."""
        count, seconds = self._steps_over_seconds
        return steps * seconds / count, self.frame_start + steps / self.substeps

    def steps_within(self, seconds: float) -> int:
        """Return the number of whole steps in a time; 1 for a time shorter than a step."""
        return max(1, math.floor(exact(seconds) * self.steps_per_second))

    def step_frame(self, step: int) -> float:
        """Return the frame of `step`, with a fraction for a step between two frames."""
        return self.frame_start + step / self.substeps

    def frame_and_subframe(self, step: int) -> tuple[int, float]:
        """Return the arguments of `Scene.frame_set` for `step`."""
        whole, part = divmod(step, self.substeps)
        return self.frame_start + whole, part / self.substeps

    def first_step(self, frame: int) -> int:
        """Return the first step of a frame.

        It is 0 for frames before the start frame, because time begins at the start frame.
        """
        return max(0, (frame - self.frame_start) * self.substeps)


@dataclass(frozen=True)
class Schedule:
    """The steps at which a sensor of `rate` (Hz) samples; its updates are numbered from 0.

    A rate above the number of steps per second gives one sample a step, because nothing changes
    between two steps.
    """

    clock: Clock
    rate: float

    # Cached: without the cache, each update takes 5 µs more.
    @cached_property
    def steps_per_update(self) -> Fraction:
        """The number of steps from one update to the next, at least 1."""
        return max(self.clock.steps_per_second / exact(self.rate), Fraction(1))

    def step(self, number: int) -> int:
        """Return the step at which update `number` samples."""
        spacing = self.steps_per_update
        return -(-number * spacing.numerator // spacing.denominator)

    def last_update(self, step: int) -> int:
        """Return the number of the last update at or before `step`; −1 before the first update."""
        spacing = self.steps_per_update
        return step * spacing.denominator // spacing.numerator if step >= 0 else -1

    def updates(self, first: int, last: int) -> Iterator[tuple[int, int]]:
        """Yield the number and the step of every update with first ≤ step ≤ last."""
        numbers, steps = self.between(first, last)
        yield from zip(numbers.tolist(), steps.tolist(), strict=True)

    def between(self, first: int, last: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the numbers (n,) and steps (n,) of the updates with first ≤ step ≤ last."""
        begin = max(0, self.last_update(first - 1) + 1)
        numbers = np.arange(begin, max(begin, self.last_update(last) + 1), dtype=np.int64)
        spacing = self.steps_per_update
        return numbers, -(-numbers * spacing.numerator // spacing.denominator)
