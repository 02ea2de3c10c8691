# SPDX-License-Identifier: GPL-3.0-or-later
"""Which floor each sensor stands over: what most rays straight down around it meet."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ...sensor_logic.model import Array
from ...sensor_logic.report.facts import SensorInPlan
from ..scene.home import EvaluatedHome
from ..scene.instances import Uid

# Rays go down around the sensor, at these distances from it (m).
RINGS_M, DIRECTIONS, REACH_M = (0.35, 0.8, 1.4), 8, 12.0
# They start this much above it, for it may lie on the floor; under a ceiling or a rug, at half of
# what is free.
START_M = 0.3
# Floors this far apart (m) are storeys; below it steps of one.
STOREY_M = 1.8
# Heights this close (m) are the same floor.
GRAIN_M = 0.02
BUNDLE_UP, BUNDLE_DOWN = -1, -2

T = TypeVar("T")


@dataclass(frozen=True)
class SensorStorey:
    """A storey: height of its floor in m, and its sensors, by name."""

    floor: float
    sensors: tuple[SensorInPlan, ...]


def levels(home: EvaluatedHome, sensors: Sequence[tuple[Uid, SensorInPlan]]) -> list[SensorStorey]:
    """The storeys, the lowest first, of sensors that come with their session uids; their `height`,
    which is that in the world, becomes that above the floor."""
    found: list[tuple[float, SensorInPlan]] = []
    floors = [_floor_below(home, uid, sensor) for uid, sensor in sensors]
    known = [floor for floor in floors if floor is not None]
    for (_, sensor), floor in zip(sensors, floors, strict=True):
        if floor is None:
            # Nothing is below it: the next floor down that others have, else where it hangs.
            below = [f for f in known if f <= sensor.height]
            floor = max(below, default=sensor.height)
        found.append((floor, sensor))
    found.sort(key=lambda pair: (pair[0], pair[1].name))
    return [_level(group) for group in grouped(found, lambda pair: pair[0])]


def grouped(found: Iterable[T], height: Callable[[T], float]) -> list[list[T]]:
    """Groups what is sorted by its height (m) into storeys."""
    groups: list[list[T]] = []
    for one in found:
        if not groups or height(one) - height(groups[-1][0]) >= STOREY_M:
            groups.append([])
        groups[-1].append(one)
    return groups


def around(rings: Sequence[float]) -> Array:
    """The offsets (n, 3) of rays down: one in the middle, and DIRECTIONS at each distance."""
    turns = [2 * math.pi * k / DIRECTIONS for k in range(DIRECTIONS)]
    ring = [(r * math.cos(t), r * math.sin(t), 0.0) for r in rings for t in turns]
    return np.array([(0.0, 0.0, 0.0), *ring])


def _level(group: list[tuple[float, SensorInPlan]]) -> SensorStorey:
    counted = Counter(round(floor / GRAIN_M) for floor, _ in group)
    # The upper one of two: what lies in a floor has its underside below.
    most = max(counted, key=lambda grain: (counted[grain], grain))
    floor = min(floor for floor, _ in group if round(floor / GRAIN_M) == most)
    members = [replace(sensor, height=sensor.height - floor) for _, sensor in group]
    return SensorStorey(floor, tuple(sorted(members, key=lambda sensor: sensor.name)))


def _floor_below(home: EvaluatedHome, uid: Uid, sensor: SensorInPlan) -> float | None:
    """Height in m of what most rays down meet; the lower of two that as many do."""
    here = np.array([[*sensor.at, sensor.height]])
    up = np.array([[0.0, 0.0, 1.0]])
    free = float(home.cast(uid, BUNDLE_UP, here, up, np.array([2 * START_M]))[0])
    top = sensor.height + free / 2
    origins = np.array([*sensor.at, top]) + around(RINGS_M)
    down = np.broadcast_to(np.array([0.0, 0.0, -1.0]), origins.shape)
    ranges = home.cast(uid, BUNDLE_DOWN, origins, down, np.full(len(origins), REACH_M))
    heights = [top - r for r in ranges.tolist() if r < REACH_M]
    if not heights:
        return None
    counted = Counter(round(height / GRAIN_M) for height in heights)
    most = min(counted, key=lambda grain: (-counted[grain], grain))
    return min(height for height in heights if round(height / GRAIN_M) == most)
