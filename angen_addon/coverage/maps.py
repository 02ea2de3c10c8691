# SPDX-License-Identifier: GPL-3.0-or-later
"""The coverage map of the detectors of a scene as it is now: one generator behind the operator, the
command line and the tests."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...sensor_logic.coverage.detect import DetectorView
from ...sensor_logic.coverage.grid import Cells, CoverageMap
from ...sensor_logic.coverage.motions import DIRECTIONS, Motion
from ...sensor_logic.error import AngenError
from ..scene.home import EvaluatedHome
from ..scene.sensors import Sensor, check_names
from .floor import cells_of
from .views import detectors, view_of

SMALLEST_CELL, LARGEST_CELL = 0.05, 2.0
# Motions looked at between two reports of progress.
AT_ONCE = 4000


@dataclass(frozen=True)
class MapProgress:
    """How far a map is: its share, and what is being done."""

    share: float
    text: str


class Enough(Exception):
    """Thrown into a generator of stages to end it: it returns its best result so far, or raises
    this without one."""


# The floor is this share of the work.
FLOOR_SHARE = 0.3


def cover(
    depsgraph: Any,
    sensors: Sequence[Sensor],
    chosen: Sequence[Sensor],
    motion: Motion,
    size: float,
    rooms: Sequence[str] = (),
) -> Generator[MapProgress | CoverageMap, None, None]:
    """The map of the `chosen` detectors; all `sensors` tell of rooms. Yields stages, and last the
    map. Raises AngenError."""
    check_cell(size)
    chosen = detectors(chosen)
    check_names(list(chosen))
    home = EvaluatedHome(depsgraph)
    cells = None
    for told in cells_of(home, sensors, motion, size, rooms):
        if isinstance(told, str):
            yield MapProgress(0.0, told)
        else:
            cells = told
    assert cells is not None
    views = {}
    for sensor in chosen:
        views[sensor.name] = view_of(home, sensor)
        yield MapProgress(FLOOR_SHARE, sensor.name)
    yield from strengths(views, cells, motion)


def strengths(
    views: Mapping[str, DetectorView], cells: Cells, motion: Motion
) -> Iterator[MapProgress | CoverageMap]:
    """What each view makes of the motions in the cells; stages, and last the map."""
    start, cell, direction = cells.starts()
    found = np.zeros((len(views), len(cells), DIRECTIONS), np.float32)
    for row, (name, view) in enumerate(views.items()):
        for first in range(0, len(start), AT_ONCE):
            rows = slice(first, first + AT_ONCE)
            found[row, cell[rows], direction[rows]] = view.strengths(motion, start.part(rows))
            share = (row + min(1.0, (first + AT_ONCE) / len(start))) / len(views)
            yield MapProgress(FLOOR_SHARE + (1.0 - FLOOR_SHARE) * share, name)
    yield CoverageMap(motion, cells, tuple(views), found)


def at_once(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> CoverageMap:
    """The same map without stages."""
    *_, last = strengths(views, cells, motion)
    assert isinstance(last, CoverageMap)
    return last


def at_most(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> CoverageMap:
    """A map of what the views may notice: nothing that they do is missing."""
    start, cell, direction = cells.starts()
    found = np.zeros((len(views), len(cells), DIRECTIONS), np.float32)
    for row, view in enumerate(views.values()):
        found[row, cell, direction] = np.where(view.may_notice(motion, start), np.inf, 0.0)
    return CoverageMap(motion, cells, tuple(views), found)


def check_cell(size: float) -> None:
    """Raises AngenError where cells of this size (m) make no sense."""
    if not SMALLEST_CELL <= size <= LARGEST_CELL:
        raise AngenError(
            f"a cell of {size:g} m: it must be from {SMALLEST_CELL:g} m to {LARGEST_CELL:g} m"
        )
