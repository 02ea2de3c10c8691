# SPDX-License-Identifier: GPL-3.0-or-later
"""The plans that a coverage map is drawn on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...sensor_logic.coverage.grid import CoverageMap
from ...sensor_logic.coverage.picture import svg
from ...sensor_logic.report.facts import PlanStorey, SensorInPlan
from ..plan.fields import placed
from ..plan.shapes import shapes_at
from ..plan.storeys import levels
from ..scene.home import EvaluatedHome
from ..scene.sensors import Sensor

# Where a plan is cut, above its floor (m), and how much is shown around the cells and detectors.
CUT_M, AROUND_M, LEAST_M = 1.1, 0.7, 2.0


def picture(
    depsgraph: Any,
    sensors: Sequence[Sensor],
    coverage: CoverageMap,
    title: str,
    proposed: Sequence[SensorInPlan] = (),
) -> str:
    """The SVG of a map with its detectors, and those that are proposed."""
    home = EvaluatedHome(depsgraph)
    chosen = [s for s in sensors if s.name in coverage.sensors]
    seen = [p for p in (placed(home, sensor) for sensor in chosen) if p is not None]
    marks = [replace(p, fans=(), beams=()) for level in levels(home, seen) for p in level.sensors]
    cells = coverage.cells
    storeys = []
    for number in range(int(cells.storey.max()) + 1):
        at = cells.at[cells.storey == number]
        if not len(at):
            at = cells.at
        floor = float(at[0, 2])
        heights = {p.name: _height(home, chosen, p.name) - floor for p in marks}
        over = [
            replace(p, height=heights[p.name]) for p in marks if -0.5 <= heights[p.name] < 2.9
        ] + [p for p in proposed if abs(p.height - floor) < 4.0]
        corners = np.concatenate([at[:, :2], *(p.at[None] for p in over)])
        low, high = corners.min(axis=0) - AROUND_M, corners.max(axis=0) + AROUND_M
        missing = np.maximum(LEAST_M - (high - low), 0.0) / 2
        view = np.stack([low - missing, high + missing])
        shapes = shapes_at(home, floor, floor + CUT_M, (view[0], view[1]))
        # Floors would hide the cells.
        shown = tuple(shape for shape in shapes if shape.role != "floor")
        storeys.append(PlanStorey(floor, floor + CUT_M, view, shown, tuple(over)))
    return svg(coverage, storeys, title)


def _height(home: EvaluatedHome, sensors: Sequence[Sensor], name: str) -> float:
    sensor = next(s for s in sensors if s.name == name)
    return float(sensor.world_matrix(home.depsgraph).translation.z) * home.metres
