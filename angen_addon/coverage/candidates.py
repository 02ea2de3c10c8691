# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where detectors could hang in the rooms of a map: on walls at a height, and under
ceilings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.coverage.grid import Cells
from ...sensor_logic.model import Array, Pose
from ..plan.shapes import WALL_M, may_move
from ..scene.home import EvaluatedHome
from .cells import Steps, met_along

# m: how far walls are looked for from a cell; what is wider than this holds a sensor; its lens
# stands off the surface by so much.
FAR_M, WIDE_M, OFF_M = 8.0, 0.5, 0.03
# Two rays this far apart (m) tell how a wall runs.
ASIDE_M = 0.04
# A wall at more than this angle to the ray is found from elsewhere.
STEEPEST = math.radians(40.0)
# Looking straight off the wall, and half-way to both sides, as brackets allow.
TURNS = (0.0, math.radians(45.0), math.radians(-45.0))
# A detector under the ceiling looks down; its fan or zones may be turned.
ROLLS = tuple(math.radians(a) for a in (0.0, 90.0, 180.0, 270.0))
CEILING_FROM_M, CEILING_M = 1.5, 3.5
MOUNTINGS = ("WALL", "CEILING", "BOTH")
NOTHING_MET = -1


@dataclass(frozen=True)
class Candidate:
    """A pose in m for a detector in a room, `on` a wall or a ceiling."""

    pose: Pose
    room: str
    on: str

    @property
    def yaw(self) -> float:
        """Degrees from +X, counter-clockwise from above, of where it looks; down: of its +Y."""
        ahead = -self.pose.axes[:, 2] if self.on == "wall" else self.pose.axes[:, 1]
        return round(math.degrees(math.atan2(ahead[1], ahead[0])), 6) + 0.0


def candidates(
    home: EvaluatedHome, cells: Cells, mounting: str, height: float, spacing: float
) -> Steps[list[Candidate]]:
    """The poses for the rooms of `cells`; `height` m above the floor on walls, at least about
    `spacing` m apart."""
    found: list[Candidate] = []
    if mounting in ("WALL", "BOTH"):
        found += yield from _on_walls(home, cells, height, spacing)
    if mounting in ("CEILING", "BOTH"):
        found += yield from _under_ceilings(home, cells, spacing)
    return found


def _on_walls(
    home: EvaluatedHome, cells: Cells, height: float, spacing: float
) -> Steps[list[Candidate]]:
    spots: dict[tuple[Any, ...], tuple[float, Array, Array, str]] = {}
    for angle in np.arange(8) * math.pi / 4:
        way = np.array([math.cos(angle), math.sin(angle), 0.0])
        walls = yield from _walls_met(home, cells, height, way)
        for spot, normal, cell in walls:
            # One of each stretch of wall and direction, the one nearest to its middle.
            along = float(normal[0] * spot[1] - normal[1] * spot[0])
            off = float(normal[:2] @ spot[:2])
            room = cells.room[cell]
            bearing = round(math.degrees(math.atan2(normal[1], normal[0])) / 5.0)
            key = (room, int(cells.storey[cell]), bearing, round(off, 1), round(along / spacing))
            stray = abs(along / spacing - round(along / spacing))
            known = spots.get(key)
            if known is None or stray < known[0] - 1e-9:
                spots[key] = (stray, spot, normal, room)
    made = []
    for key in sorted(spots):
        _, spot, normal, room = spots[key]
        for turn in TURNS:
            made.append(Candidate(_level_pose(spot + normal * OFF_M, normal, turn), room, "wall"))
    return made


def _walls_met(
    home: EvaluatedHome, cells: Cells, height: float, way: Array
) -> Steps[list[tuple[Array, Array, int]]]:
    """Places on walls, where these face, and the cells they are seen from, looking along `way`."""
    side = np.array([-way[1], way[0], 0.0]) * ASIDE_M
    start = cells.at + np.array([0.0, 0.0, height])
    first, met = yield from _met(home, start, way)
    second, beside = yield from _met(home, start + side, way)
    found = []
    wall = _holds(home, height + cells.at[:, 2], cells.at[:, 2] + WALL_M)
    ok = (first < FAR_M) & (second < FAR_M) & (met == beside)
    ok &= np.abs(first - second) <= ASIDE_M * math.tan(STEEPEST)
    # A wall is not met from outside its room: nothing else is between, for rays are straight.
    for i in np.flatnonzero(ok).tolist():
        row = met[i]
        if row < 0 or not wall(row, i):
            continue
        tangent = side + way * (second[i] - first[i])
        normal = np.array([-tangent[1], tangent[0], 0.0]) / np.linalg.norm(tangent)
        if normal @ way > 0.0:
            normal = -normal
        found.append((start[i] + way * first[i], normal, i))
    return found


def _holds(home: EvaluatedHome, heights: Array, tops: Array) -> Any:
    """Tells whether the solid of a row, met from a cell, is something to hang a sensor on."""
    lo, hi, solids = home.lo, home.hi, home.caster.solids.solids
    still: dict[int, bool] = {}

    def is_wall(row: int, cell: int) -> bool:
        if row not in still:
            wide = float((hi[row] - lo[row])[:2].max()) >= WIDE_M
            still[row] = wide and not may_move(solids[row].owner)
        high = hi[row, 2] >= tops[cell] - 1e-6 and hi[row, 2] >= heights[cell] + 0.05
        return still[row] and bool(high) and bool(lo[row, 2] <= heights[cell] - 0.05)

    return is_wall


def _met(home: EvaluatedHome, start: Array, way: Array) -> Steps[tuple[Array, NDArray[np.int64]]]:
    """Ranges (n,) in m, and the rows (n,) of the solids met, −1 for none."""
    ranges, numbers = yield from met_along(home, start, way, FAR_M)
    by_number = {solid.number: solid.row for solid in home.caster.solids.solids}
    met = np.array([by_number.get(n, NOTHING_MET) for n in numbers.tolist()], np.int64)
    return ranges, met


def _level_pose(at: Array, normal: Array, turn: float) -> Pose:
    c, s = math.cos(turn), math.sin(turn)
    look = np.array([normal[0] * c - normal[1] * s, normal[0] * s + normal[1] * c, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return Pose(at, np.column_stack([np.cross(up, -look), up, -look]))


def _under_ceilings(home: EvaluatedHome, cells: Cells, spacing: float) -> Steps[list[Candidate]]:
    chosen = _spread(cells, spacing)
    at = cells.at[chosen] + np.array([0.0, 0.0, CEILING_FROM_M])
    up = np.array([0.0, 0.0, 1.0])
    ranges, met = yield from _met(home, at, up)
    solids = home.caster.solids.solids
    made = []
    for i, cell in enumerate(chosen):
        row = int(met[i])
        if row < 0 or ranges[i] + CEILING_FROM_M > CEILING_M:
            continue
        wide = float((home.hi[row] - home.lo[row])[:2].min()) >= WIDE_M
        if not wide or may_move(solids[row].owner):
            continue
        place = at[i] + up * (ranges[i] - OFF_M)
        for roll in ROLLS:
            top = np.array([math.cos(roll), math.sin(roll), 0.0])
            axes = np.column_stack([np.cross(top, up), top, up])
            made.append(Candidate(Pose(place, axes), cells.room[cell], "ceiling"))
    return made


def _spread(cells: Cells, spacing: float) -> Sequence[int]:
    """Cells about `spacing` m apart: of each square the one nearest to its middle."""
    found: dict[tuple[Any, ...], tuple[float, int]] = {}
    for i, at in enumerate(cells.at):
        square = np.floor(at[:2] / spacing)
        stray = float(np.abs(at[:2] / spacing - square - 0.5).max())
        key = (int(cells.storey[i]), cells.room[i], *square.tolist())
        if key not in found or stray < found[key][0] - 1e-9:
            found[key] = (stray, i)
    return [found[key][1] for key in sorted(found)]
