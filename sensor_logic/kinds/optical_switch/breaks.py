# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a beam's light passes between two looks at it, by what swept through it."""

from __future__ import annotations

import numpy as np

from ...geometry.sweep import Passes
from ...geometry.triangle_tree import Index
from ...model import Array

# Share of the time between two looks. A gap in a break that is shorter is rounding; at 24
# frames a second it is 0.4 µs, of which no part takes note.
NO_GAP = 1e-5


def light_between(passes: Passes, ranges: Array, threshold: float, rays: int) -> Array:
    """The light (n,), a share of the full, at the times one after the other between which it
    stays the same. A ray is stopped by what it meets nearer than `threshold`, m.

    `ranges` (p, 2): what each pass is away from the sensor at its begin and its end, m.
    """
    ray, begin, end = _stopped(passes, ranges, threshold)
    if not len(ray):
        return np.zeros(0)
    begin, end = _merged(ray, begin, end)
    times = np.concatenate([begin, end])
    order = np.argsort(times, kind="stable")
    stopped = np.cumsum(np.repeat([1, -1], len(begin))[order])
    # What lasts no time is none; what is before the first break and after the last is full light.
    lasts = np.diff(times[order]) > 0.0
    light = 1.0 - stopped[:-1][lasts] / rays
    before = [1.0] if times[order[0]] > NO_GAP else []
    after = [1.0] if times[order[-1]] < 1.0 - NO_GAP else []
    return np.concatenate([before, light, after])


def _stopped(passes: Passes, ranges: Array, threshold: float) -> tuple[Index, Array, Array]:
    """The passes (p,) as far as they are nearer than the threshold: ray, begin and end."""
    one, two = ranges[:, 0], ranges[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip((threshold - one) / (two - one), 0.0, 1.0)
    crosses = passes.begin + share * (passes.end - passes.begin)
    begin = np.where(one < threshold, passes.begin, crosses)
    end = np.where(two < threshold, passes.end, crosses)
    stops = (one < threshold) | (two < threshold)
    return passes.ray[stops], begin[stops], end[stops]


def _merged(ray: Index, begin: Array, end: Array) -> tuple[Array, Array]:
    """Times (n,) of each ray that overlap, or come next to each other, as one."""
    # Each ray has its own stretch of one axis of time.
    starts, stops = begin + 2.0 * ray, end + 2.0 * ray
    order = np.argsort(starts, kind="stable")
    starts, furthest = starts[order], np.maximum.accumulate(stops[order])
    new = np.flatnonzero(np.append(True, starts[1:] > furthest[:-1] + NO_GAP))
    last = np.append(new[1:], len(starts)) - 1
    shift = 2.0 * ray[order][new]
    return starts[new] - shift, furthest[last] - shift
