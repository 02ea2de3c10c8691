# SPDX-License-Identifier: GPL-3.0-or-later
"""Propose poses for motion detectors, chosen among candidates on walls and below ceilings.

The work is a generator that yields its progress.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.coverage.detect import DetectorView
from ...sensor_logic.coverage.grid import Cells, ChosenPlaces, CoverageMap, choose
from ...sensor_logic.coverage.motions import Motion
from ...sensor_logic.kind import Kind
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.model import Array, Pose
from ...sensor_logic.progress import Doing, Enough, Steps, Work, saying
from ..plan.storeys import WALL_M, may_move
from ..scene.home.evaluated_home import EvaluatedHome
from ..scene.home.floor import cast_along
from ..scene.sensors import Sensor
from .floor_cells import cells_of
from .maps import Views, check_cell, detectors, upper_bound_map, whole_map

# m. Walls are searched up to FAR_M from a cell. A solid of at least WIDE_M can hold a detector. The
# lens of a detector is OFF_M from the surface.
FAR_M, WIDE_M, OFF_M = 8.0, 0.5, 0.03
# Two rays this far apart (m) give the direction of a wall.
ASIDE_M = 0.04
# A wall is used only if the angle between its normal and the ray is at most this: rays in other
# directions find the others.
STEEPEST = math.radians(40.0)
# A detector looks straight away from the wall, or half-way to a side, as brackets allow.
TURNS = (0.0, math.radians(45.0), math.radians(-45.0))
# A detector below a ceiling looks down. These are its angles about the vertical.
ROLLS = tuple(math.radians(a) for a in (0.0, 90.0, 180.0, 270.0))
# m above the floor: the start of rays to the ceiling, and the greatest height of a ceiling.
CEILING_FROM_M, CEILING_M = 1.5, 3.5
MOUNTINGS = ("WALL", "CEILING", "BOTH")
NOTHING_HIT = -1


@dataclass(frozen=True)
class Candidate:
    """A possible pose (m) of a detector, and the room; `on` is "wall" or "ceiling"."""

    pose: Pose
    room: str
    on: str

    @property
    def yaw(self) -> float:
        """The direction in which the detector looks, in degrees from +X, counter-clockwise.

        For a detector that looks down, it is the direction of the detector's +Y axis.
        """
        ahead = -self.pose.axes[:, 2] if self.on == "wall" else self.pose.axes[:, 1]
        return round(math.degrees(math.atan2(ahead[1], ahead[0])), 6) + 0.0


def candidates(
    home: EvaluatedHome, cells: Cells, mounting: str, height: float, spacing: float
) -> Steps[list[Candidate]]:
    """Generator that returns candidate poses for the rooms of `cells`, about `spacing` m apart.

    `mounting` is WALL, CEILING or BOTH. On walls the poses are `height` m above the floor.
    """
    found: list[Candidate] = []
    if mounting in ("WALL", "BOTH"):
        found += yield from _on_walls(home, cells, height, spacing)
    if mounting in ("CEILING", "BOTH"):
        found += yield from _under_ceilings(home, cells, spacing)
    return found


def _on_walls(
    home: EvaluatedHome, cells: Cells, height: float, spacing: float
) -> Steps[list[Candidate]]:
    """Generator that returns candidates on walls, `height` m above the floor."""
    spots: dict[tuple[Any, ...], tuple[float, Array, Array, str]] = {}
    for angle in np.arange(8) * math.pi / 4:
        way = np.array([math.cos(angle), math.sin(angle), 0.0])
        walls = yield from _wall_spots(home, cells, height, way)
        for spot, normal, cell in walls:
            # For each stretch of wall and each direction, keep the spot nearest to its middle.
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


def _wall_spots(
    home: EvaluatedHome, cells: Cells, height: float, direction: Array
) -> Steps[list[tuple[Array, Array, int]]]:
    """Generator that returns points on walls, each with the wall's normal and a cell's number.

    They are the hits of rays along `direction` that start `height` m above each cell.
    """
    side = np.array([-direction[1], direction[0], 0.0]) * ASIDE_M
    start = cells.at + np.array([0.0, 0.0, height])
    first, rows = yield from _cast_from(home, start, direction)
    second, beside = yield from _cast_from(home, start + side, direction)
    found = []
    wall = _mounting_test(home, height + cells.at[:, 2], cells.at[:, 2] + WALL_M)
    ok = (first < FAR_M) & (second < FAR_M) & (rows == beside)
    ok &= np.abs(first - second) <= ASIDE_M * math.tan(STEEPEST)
    for i in np.flatnonzero(ok).tolist():
        row = rows[i]
        if row < 0 or not wall(row, i):
            continue
        tangent = side + direction * (second[i] - first[i])
        normal = np.array([-tangent[1], tangent[0], 0.0]) / np.linalg.norm(tangent)
        if normal @ direction > 0.0:
            normal = -normal
        found.append((start[i] + direction * first[i], normal, i))
    return found


def _mounting_test(home: EvaluatedHome, heights: Array, tops: Array) -> Any:
    """Return a function that takes a solid's row and a cell's number, and returns a bool.

    It is True if the solid can hold a detector above the cell. `heights` are the heights of the
    detector for each cell. The solid must reach up to `tops`.
    """
    lo, hi, solids = home.lo, home.hi, home.caster.solids.solids
    still: dict[int, bool] = {}

    def is_wall(row: int, cell: int) -> bool:
        if row not in still:
            wide = float((hi[row] - lo[row])[:2].max()) >= WIDE_M
            still[row] = wide and not may_move(solids[row].owner)
        high = hi[row, 2] >= tops[cell] - 1e-6 and hi[row, 2] >= heights[cell] + 0.05
        return still[row] and bool(high) and bool(lo[row, 2] <= heights[cell] - 0.05)

    return is_wall


def _cast_from(
    home: EvaluatedHome, starts: Array, direction: Array
) -> Steps[tuple[Array, NDArray[np.int64]]]:
    """Generator that casts rays along `direction` from the points `starts` (n, 3).

    Return the ranges (n,) in m and the rows (n,) of the solids that are hit, −1 for none.
    """
    ranges, numbers = yield from cast_along(home, starts, direction, FAR_M)
    by_number = {solid.number: solid.row for solid in home.caster.solids.solids}
    rows = np.array([by_number.get(n, NOTHING_HIT) for n in numbers.tolist()], np.int64)
    return ranges, rows


def _level_pose(at: Array, normal: Array, turn: float) -> Pose:
    """Return the pose of a detector at a point of a wall that looks horizontally.

    Its direction is the wall's normal, rotated by `turn` (rad).
    """
    c, s = math.cos(turn), math.sin(turn)
    look = np.array([normal[0] * c - normal[1] * s, normal[0] * s + normal[1] * c, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return Pose(at, np.column_stack([np.cross(up, -look), up, -look]))


def _under_ceilings(home: EvaluatedHome, cells: Cells, spacing: float) -> Steps[list[Candidate]]:
    chosen = _spread_cells(cells, spacing)
    at = cells.at[chosen] + np.array([0.0, 0.0, CEILING_FROM_M])
    up = np.array([0.0, 0.0, 1.0])
    ranges, rows = yield from _cast_from(home, at, up)
    solids = home.caster.solids.solids
    made = []
    for i, cell in enumerate(chosen):
        row = int(rows[i])
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


def _spread_cells(cells: Cells, spacing: float) -> Sequence[int]:
    """Return the numbers of cells that are about `spacing` m apart.

    Each is the cell nearest to the middle of a square with this side.
    """
    found: dict[tuple[Any, ...], tuple[float, int]] = {}
    for i, at in enumerate(cells.at):
        square = np.floor(at[:2] / spacing)
        stray = float(np.abs(at[:2] / spacing - square - 0.5).max())
        key = (int(cells.storey[i]), cells.room[i], *square.tolist())
        if key not in found or stray < found[key][0] - 1e-9:
            found[key] = (stray, i)
    return [found[key][1] for key in sorted(found)]


MOST_CANDIDATES = 5000
# The part of the time that the upper bounds of all candidates take in the sample home, from 0 to 1:
# for one detector, and for several.
FIRST_SHARE, FIRST_OF_SEVERAL = 0.8, 0.6
# The exact coverage of a candidate is on average its upper bound times this.
SHRINKS = 0.8
# Besides the chosen candidates, this many are computed exactly before the next choice.
NEXT_BEST = 4


@dataclass(frozen=True)
class Wish:
    """How many detectors to propose, of which kind, and where.

    Attributes
    ----------
    count
        Number of detectors.
    kind, parameters, rate
        Their kind and parameters, and their update rate in Hz.
    rooms
        Names of the rooms; empty: all.
    mounting
        WALL, CEILING or BOTH.
    height
        Height on walls above the floor, in m.
    spacing
        Distance between candidates, in m.
    seed
        The seed of the random choice among equally good candidates.
    beside
        Whether to count only the floor that the home's existing detectors do not cover.
    """

    count: int
    kind: Kind
    parameters: Any
    rate: float
    rooms: tuple[str, ...] = ()
    mounting: str = "WALL"
    height: float = 2.3
    spacing: float = 0.5
    seed: int = 0
    beside: bool = False


@dataclass(frozen=True)
class Proposal:
    """The proposed detectors.

    Attributes
    ----------
    chosen
        The chosen candidates, first the one that adds the most covered floor.
    names
        The names of the proposed detectors.
    choice
        The number of cells that the chosen candidates cover, and an upper bound for any choice.
    map
        The coverage map of the chosen candidates.
    tried
        The number of candidates.
    before
        The number of cells that the home's existing detectors cover already.
    """

    chosen: tuple[Candidate, ...]
    names: tuple[str, ...]
    choice: ChosenPlaces
    map: CoverageMap
    tried: int
    before: int

    def summary(self) -> str:
        """Return the result in a sentence or two, for a report."""
        all_cells, choice = len(self.map.cells), self.choice
        covered = (choice.covered + self.before) / all_cells
        bound = min(1.0, (choice.bound + self.before) / all_cells)
        return (
            f"{len(self.chosen)} of {self.tried} candidates cover {100 * covered:.1f} % of the "
            f"floor. No choice of the same number covers more than {100 * bound:.1f} %, so this "
            f"choice is at least {math.floor(1000 * choice.assured + 1e-9) / 10:g} % of the best"
        )


def propose(
    depsgraph: Any, sensors: Sequence[Sensor], wish: Wish, motion: Motion, size: float
) -> Work[Proposal]:
    """Search for the poses with which new detectors together cover the most floor.

    Parameters
    ----------
    depsgraph
        The evaluated depsgraph.
    sensors
        All sensors of the home. Their rooms tell which cells belong to which room.
    wish
        The detectors to propose.
    motion
        The motion that they should notice.
    size
        Side of a cell in m.

    Yields
    ------
    Doing or None
        The progress.

    Raises
    ------
    AngenError
        If there is no possible pose, or a setting is wrong.
    Enough
        If the caller threw it in before the exact coverage of any candidate was computed.
    """
    check_cell(size)
    _check(wish)
    home = EvaluatedHome(depsgraph)
    cells = yield from cells_of(home, sensors, motion, size, wish.rooms)
    looking = candidates(home, cells, wish.mounting, wish.height, wish.spacing)
    found = yield from saying(Doing(0.05, "looking for walls and ceilings"), looking)
    if not found:
        raise AngenError(
            f"no wall or ceiling was found for a detector {wish.height:g} m above the floor: set "
            "another height or mounting"
        )
    if len(found) > MOST_CANDIDATES:
        raise AngenError(
            f"{len(found)} candidates are more than {MOST_CANDIDATES}: set fewer rooms or a "
            "larger spacing"
        )
    weights = np.ones(len(cells))
    if wish.beside:
        present = Views(home)
        for sensor in detectors(sensors):
            covered = whole_map({sensor.name: present.of(sensor)}, cells, motion)
            weights[covered.count > 0] = 0.0
            yield Doing(0.05, "looking for floor that is covered already")
    search = _Search(home, cells, motion, wish, found, weights)
    choice = yield from search.run()
    chosen = tuple(found[i] for i in choice.chosen)
    names = tuple(f"Proposed {wish.kind.short_label} {i + 1}" for i in range(len(chosen)))
    views = {name: search.view(candidate) for name, candidate in zip(names, chosen, strict=True)}
    covered = whole_map(views, cells, motion)
    before = int((weights == 0.0).sum())
    return Proposal(chosen, names, choice, covered, len(found), before)


class _Search:
    """Searches for the candidates that together cover the most floor.

    An upper bound of a candidate's coverage is far quicker to compute than the exact coverage. So
    only candidates with high upper bounds are computed exactly.
    """

    def __init__(
        self,
        home: EvaluatedHome,
        cells: Cells,
        motion: Motion,
        wish: Wish,
        found: Sequence[Candidate],
        weights: Array,
    ) -> None:
        self._views, self._cells, self._motion, self._wish = Views(home), cells, motion, wish
        self._found, self._weights = found, weights
        # (candidates, cells): the covered cells, or their upper bound where it is not `exact`.
        self._sets = np.zeros((len(found), len(cells)), bool)
        self._exact = np.zeros(len(found), bool)
        self._first = FIRST_SHARE if wish.count == 1 else FIRST_OF_SEVERAL
        self._share = 0.0

    def view(self, candidate: Candidate) -> DetectorView:
        """Return the `DetectorView` of a detector with a candidate's pose."""
        wish = self._wish
        return self._views.at(wish.kind, wish.parameters, candidate.pose, wish.rate)

    def run(self) -> Work[ChosenPlaces]:
        """Run the search; yield the progress, and return the best choice."""
        for i, candidate in enumerate(self._found):
            view = self.view(candidate)
            self._sets[i] = upper_bound_map({"": view}, self._cells, self._motion).covered[0]
            self._share = 0.05 + self._first * (i + 1) / len(self._found)
            yield Doing(self._share, f"candidate {i + 1} of {len(self._found)}")
        while True:
            choice = self._choose(np.arange(len(self._found)))
            if self._exact[list(choice.chosen)].all():
                return choice
            try:
                yield from self._look_closely(choice)
            except Enough:
                if not self._exact.any():
                    raise
                best = self._choose(np.flatnonzero(self._exact))
                return replace(best, bound=max(choice.bound, best.covered))

    def _choose(self, rows: NDArray[np.intp]) -> ChosenPlaces:
        """Return the best choice among the candidates with the indices `rows`."""
        wish = self._wish
        choice = choose(self._sets[rows], wish.count, self._weights, wish.seed)
        return replace(choice, chosen=tuple(int(rows[i]) for i in choice.chosen))

    def _look_closely(self, choice: ChosenPlaces) -> Iterator[Doing]:
        """Compute the exact coverage of the chosen and the next best candidates, with progress."""
        worth = np.where(self._exact, -1.0, self._sets @ self._weights)
        next_best = np.argsort(-worth, kind="stable")[:NEXT_BEST].tolist()
        for i in dict.fromkeys([*choice.chosen, *next_best]):
            if self._exact[i]:
                continue
            view = self.view(self._found[i])
            self._sets[i] = whole_map({"": view}, self._cells, self._motion).covered[0]
            self._exact[i] = True
            known = np.flatnonzero(self._exact)
            best = float((self._sets[known] @ self._weights).max())
            looked = len(known) / (len(known) + self._count_remaining(choice))
            self._share = max(self._share, 0.05 + self._first + (0.95 - self._first) * looked)
            yield Doing(
                self._share,
                f"{len(known)} candidates computed exactly; the best choice so far covers "
                f"{self._percent(best)}, no choice more than {self._percent(choice.bound)}",
                found=True,
            )

    def _count_remaining(self, choice: ChosenPlaces) -> int:
        """Estimate for how many more candidates the exact coverage must be computed.

        These may add more floor than the weakest chosen candidate. The exact gain of the weakest is
        estimated as SHRINKS times its upper bound.
        """
        *others, weakest = choice.chosen
        free = np.where(self._sets[others].any(axis=0), 0.0, self._weights)
        gains = self._sets @ free
        return int(((gains > gains[weakest] * SHRINKS) & ~self._exact).sum())

    def _percent(self, worth: float) -> str:
        """Return the covered floor in percent, if new detectors cover `worth` more cells."""
        before = float((self._weights == 0.0).sum())
        return f"{100 * min(1.0, (worth + before) / len(self._cells)):.0f} %"


def _check(wish: Wish) -> None:
    if wish.count < 1:
        raise AngenError(f"the number of detectors is {wish.count}: it must be at least 1")
    if not 0.1 <= wish.spacing <= 5.0:
        raise AngenError(f"the spacing is {wish.spacing:g} m: it must be from 0.1 m to 5 m")
    problems = wish.parameters.problems()
    if problems:
        raise AngenError(f"the parameters of the detector to place are wrong: {problems[0]}")
