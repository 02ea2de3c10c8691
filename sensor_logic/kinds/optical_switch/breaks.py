# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a beam between two steps, by the solids that crossed it."""

from __future__ import annotations

import numpy as np

from ...geometry.sweep import RayCrossings
from ...geometry.triangle_tree import Index
from ...model import Array

# Share of the time between two steps: a shorter gap in a break is a rounding error. At 24 frames a
# second it is 0.4 µs, too short for any switch.
NO_GAP = 1e-5


def light_between(crossings: RayCrossings, ranges: Array, threshold: float, rays: int) -> Array:
    """The shares of the full light (n,) in the successive intervals in which it is constant. A
    solid nearer than `threshold` (m) stops a ray.

    `ranges` (p, 2): the distance in m of each crossing from the sensor at its begin and its end.
    """
    ray, begin, end = _stopped(crossings, ranges, threshold)
    if not len(ray):
        return np.zeros(0)
    begin, end = _merged(ray, begin, end)
    times = np.concatenate([begin, end])
    order = np.argsort(times, kind="stable")
    stopped = np.cumsum(np.repeat([1, -1], len(begin))[order])
    # Empty intervals are dropped; before the first break and after the last the light is full.
    lasts = np.diff(times[order]) > 0.0
    light = 1.0 - stopped[:-1][lasts] / rays
    before = [1.0] if times[order[0]] > NO_GAP else []
    after = [1.0] if times[order[-1]] < 1.0 - NO_GAP else []
    return np.concatenate([before, light, after])


def _stopped(
    crossings: RayCrossings, ranges: Array, threshold: float
) -> tuple[Index, Array, Array]:
    """Ray, begin and end of the crossings' parts that are nearer than the threshold."""
    one, two = ranges[:, 0], ranges[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip((threshold - one) / (two - one), 0.0, 1.0)
    at_threshold = crossings.begin + share * (crossings.end - crossings.begin)
    begin = np.where(one < threshold, crossings.begin, at_threshold)
    end = np.where(two < threshold, crossings.end, at_threshold)
    stops = (one < threshold) | (two < threshold)
    return crossings.ray[stops], begin[stops], end[stops]


def _merged(ray: Index, begin: Array, end: Array) -> tuple[Array, Array]:
    """Begins and ends (n,) after merging the intervals of each ray that overlap or adjoin."""
    # Each ray gets its own section of one time axis.
    starts, stops = begin + 2.0 * ray, end + 2.0 * ray
    order = np.argsort(starts, kind="stable")
    starts, furthest = starts[order], np.maximum.accumulate(stops[order])
    new = np.flatnonzero(np.append(True, starts[1:] > furthest[:-1] + NO_GAP))
    last = np.append(new[1:], len(starts)) - 1
    shift = 2.0 * ray[order][new]
    return starts[new] - shift, furthest[last] - shift
