# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the plan of a home from its scene: storeys, walls and furniture, what each sensor sees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ...sensor_logic.model import Array
from ...sensor_logic.report.facts import PlanShape, PlanStorey, SensorInPlan
from ..runtime import state
from ..runtime.time_base import evaluated_depsgraph
from ..scene.home import EvaluatedHome
from ..scene.sensors import Sensor
from .fields import placed
from .shapes import shapes_at
from .storeys import SensorStorey, levels

# Where a plan is cut, above its floor (m): above sills and tables, below the heads of openings.
CUT_M = 1.1
# The plan shows what is cut up to this far from where sensors are and see, and this much around.
BEYOND_M, MARGIN_M, LEAST_M = 4.0, 0.3, 2.0


def storeys(scene: Any, sensors: Sequence[Sensor], frame: int) -> tuple[PlanStorey, ...]:
    """The storeys that have sensors, the lowest first, as they are at a whole frame; not to be
    called in a frame handler. Raises AngenError."""
    with at_frame(scene, frame):
        depsgraph = evaluated_depsgraph()
        home = EvaluatedHome(depsgraph)
        seen = [s for s in (placed(home, sensor) for sensor in sensors) if s is not None]
        return tuple(_storey(home, level) for level in levels(home, seen))


@contextmanager
def at_frame(scene: Any, frame: int) -> Iterator[None]:
    """The scene at a whole frame; put back at the end, and no handler of ours shows values."""
    before = scene.frame_current, scene.frame_subframe
    if before == (frame, 0.0):
        yield
        return
    state.CACHE.running = True
    try:
        scene.frame_set(frame)
        yield
    finally:
        scene.frame_set(before[0], subframe=before[1])
        state.CACHE.running = False


def _storey(home: EvaluatedHome, level: SensorStorey) -> PlanStorey:
    own = np.concatenate([_extent(sensor) for sensor in level.sensors])
    low, high = own.min(axis=0), own.max(axis=0)
    cut = level.floor + CUT_M
    shapes = shapes_at(home, level.floor, cut, (low - BEYOND_M, high + BEYOND_M))
    view = _view(low, high, shapes)
    return PlanStorey(level.floor, cut, view, shapes, level.sensors)


def _extent(sensor: SensorInPlan) -> Array:
    """Corners (n, 2) of where a sensor is and what it sees."""
    return np.concatenate([sensor.at[None], *sensor.fans, *sensor.beams])


def _view(low: Array, high: Array, shapes: Sequence[PlanShape]) -> Array:
    """The part of the world to show (2, 2): the sensors and the walls around them."""
    within = low - BEYOND_M, high + BEYOND_M
    for shape in shapes:
        if shape.role in {"wall", "solid"}:
            points = np.concatenate([line.points for line in shape.lines])
            near = points[((points >= within[0]) & (points <= within[1])).all(axis=1)]
            if len(near):
                low, high = np.minimum(low, near.min(axis=0)), np.maximum(high, near.max(axis=0))
    missing = np.maximum(LEAST_M - (high - low), 0.0) / 2
    return np.stack([low - missing - MARGIN_M, high + missing + MARGIN_M])
