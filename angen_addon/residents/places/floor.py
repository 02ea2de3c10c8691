# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where residents can walk: the floors below the marks, as free cells, and their rooms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.error import AngenError, InputError
from ....sensor_logic.model import Array
from ....sensor_logic.residents.places import BODY_M, Storey
from ....sensor_logic.residents.ways import Floor, parts
from ...coverage.cells import (
    MOST_CELLS,
    OVER_M,
    PIT_M,
    RUG_M,
    Grid,
    Mask,
    finished,
    flood,
    floors,
    free_ways,
    passable,
)
from ...coverage.floor import storeys_of
from ...coverage.rooms import labels_of, volumes
from ...plan.storeys import GRAIN_M, around, grouped
from ...scene.bearers import candidates
from ...scene.home import EvaluatedHome
from ...scene.rays.solids import Solid
from ...scene.sensors import all_sensors
from ..settings import is_resident, residents_in

# m: of a cell, where the home is not too large for it; of the largest.
SIZE_M, COARSEST_M = 0.05, 0.1
# m: a mark is at what is so near.
NEAR_M = 0.8
# m around the marks that residents may walk on.
AROUND_M = 2.0
# Heights (m) at which a body must not meet anything on its way from cell to cell.
FELT_M = (0.3, 1.0, 1.6)
# Rays go down around each mark at these distances (m) to find its floor.
RINGS_M, DEEP_M = (0.5, 1.0, 1.6, 2.2), 4.0
# m: a mark is at most so far above its floor.
ABOVE_M = 2.7
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class WalkedStorey:
    """A storey as residents walk on it: `home` without what they pass or are, and the number
    (nx, ny) of the cells that a body gets to from one another, 0 where it does not fit; `main` is
    the number that most marks are at. `doorways` (k, 2) are points along shut leaves, where nobody
    stays."""

    storey: Storey
    home: EvaluatedHome
    part: NDArray[np.int64]
    main: int
    doorways: Array = field(default_factory=lambda: np.empty((0, 2)))


def walked(home: EvaluatedHome, leaves: Sequence[Any]) -> EvaluatedHome:
    """The home as it is for who walks: without the leaves of doors and what hangs on them, and
    without residents and what they push."""
    frames = [r.angen_resident.walking_frame for r in residents_in(home.depsgraph.scene)]
    uids = {obj.session_uid for obj in (*leaves, *frames) if obj is not None}

    def stays(solid: Solid) -> bool:
        return not (uids & solid.owners or _lives(solid.original))

    return home.part(stays)


def _lives(obj: Any) -> bool:
    """Whether it is somebody's body, or what hangs on it."""
    owners = list(candidates(obj))
    rigged = any(owner.type == "ARMATURE" for owner in owners)
    return any(map(is_resident, owners)) or (
        rigged and any(owner.angen_load.mass > 0.0 for owner in owners)
    )


def grounds(
    home: EvaluatedHome,
    walk: EvaluatedHome,
    marks: Array,
    names: Sequence[str],
    things: NDArray[np.intp],
) -> list[WalkedStorey]:
    """The storeys below points (n, 3) m of the marks of these names, the lowest first; `things`
    (k,) are the rows of solids that are no floor. Raises AngenError."""
    rows = set(things.tolist())
    heights = _heights(walk.part(lambda solid: solid.row not in rows), marks)
    found = []
    for height in heights:
        below = [h for h in heights if h <= height]
        mine = [under(heights, z) == len(below) - 1 for z in marks[:, 2].tolist()]
        grid = _grid(height, marks[mine], list(compress(names, mine)))
        found.append(_ground(home, walk, grid, marks[mine]))
    return found


def under(heights: Sequence[float], z: float) -> int:
    below = [k for k, height in enumerate(heights) if height <= z + PIT_M]
    return below[-1] if below else 0


def _heights(home: EvaluatedHome, marks: Array) -> list[float]:
    """The heights (m) of the floors: what most rays around the marks meet. Raises AngenError."""
    starts = (marks[:, None] + around(RINGS_M) + [0.0, 0.0, 0.2]).reshape(-1, 3)
    ranges = finished(free_ways(home, starts, DOWN, DEEP_M))
    met = (starts[:, 2] - ranges)[ranges < DEEP_M - 1e-6]
    votes = Counter(np.round(met / GRAIN_M).astype(int).tolist())
    chosen: Counter[int] = Counter()
    for z in marks[:, 2].tolist():
        low, high = (z - ABOVE_M) / GRAIN_M, (z + RUG_M) / GRAIN_M
        of_mark = [grain for grain in votes if low <= grain <= high]
        if of_mark:
            chosen[max(of_mark, key=lambda grain: (votes[grain], -grain))] += 1
    if not chosen:
        raise InputError("no floor is below the marked places: give the home a floor")
    groups = grouped(sorted(chosen), lambda grain: grain * GRAIN_M)
    most = [max(group, key=lambda grain: (chosen[grain], -grain)) for group in groups]
    # The height itself, not the middle of its grain.
    return [float(np.median(met[np.abs(met - grain * GRAIN_M) <= GRAIN_M])) for grain in most]


def _ground(home: EvaluatedHome, walk: EvaluatedHome, grid: Grid, marks: Array) -> WalkedStorey:
    over = finished(floors(walk, grid, OVER_M)).reshape(grid.shape)
    level = (over <= RUG_M) & (over >= -PIT_M)
    along = [finished(passable(walk, grid, felt, level)) for felt in FELT_M]
    ways = (
        np.all([pair[0] for pair in along], axis=0),
        np.all([pair[1] for pair in along], axis=0),
    )
    # Inside solids there is nothing in the way either: only what is reached is floor.
    seeds = np.where(level & _near(grid, marks), 1, 0)
    reached = finished(flood(seeds, level, ways)) > 0
    free = reached & ~_beside(ways, reached)
    part = parts(Floor(grid.low, grid.size, free), BODY_M)
    # What no body gets to is the inside of a wall.
    free &= finished(flood((part > 0).astype(np.int64), free, ways)) > 0
    floor = Floor(grid.low, grid.size, free)
    number, names, guessed = _rooms(home, grid, grid.floor)
    part = parts(floor, BODY_M)
    return WalkedStorey(
        Storey(grid.floor, floor, number, names, guessed), walk, part, _main(floor, part, marks)
    )


def _grid(height: float, marks: Array, names: Sequence[str]) -> Grid:
    """The cells around marks of these names. Raises InputError where they are too far apart."""
    low, high = marks[:, :2].min(axis=0) - AROUND_M, marks[:, :2].max(axis=0) + AROUND_M
    size = SIZE_M
    area = float(np.prod(high - low + 2 * size))
    if area / size**2 > MOST_CELLS:
        size = float(np.sqrt(area / MOST_CELLS)) * 1.01
    if size > COARSEST_M:
        off = np.linalg.norm(marks[:, :2] - np.median(marks[:, :2], axis=0), axis=1)
        raise InputError(
            f"'{names[int(np.argmax(off))]}' is marked {off.max():.0f} m from the other "
            "places: mark only what belongs to one home"
        )
    first = np.floor(low / size)
    # An even number, for rooms are found on cells twice as large.
    shape = ((np.ceil(high / size) - first + 1) // 2 * 2).astype(int)
    return Grid(first * size, (int(shape[0]), int(shape[1])), size, height)


def _near(grid: Grid, marks: Array) -> Mask:
    """(nx, ny): the cells at which a mark is, within AROUND_M."""
    points = grid.at(0.0)[:, :2]
    near = np.zeros(len(points), bool)
    for mark in marks[:, :2]:
        near |= ((points - mark) ** 2).sum(axis=1) <= AROUND_M**2
    return near.reshape(grid.shape)


def _beside(ways: tuple[Mask, Mask], reached: Mask) -> Mask:
    """The cells on both sides of what is too thin to stand on a cell of its own."""
    found = np.zeros_like(reached)
    thin = reached[:-1] & reached[1:] & ~ways[0]
    found[:-1] |= thin
    found[1:] |= thin
    thin = reached[:, :-1] & reached[:, 1:] & ~ways[1]
    found[:, :-1] |= thin
    found[:, 1:] |= thin
    return found


def _rooms(
    home: EvaluatedHome, grid: Grid, height: float
) -> tuple[NDArray[np.int64], tuple[str, ...], Mask]:
    """The room (nx, ny) of each cell, their names, as sensors and marks of rooms tell, and which
    cells (nx, ny) are guessed."""
    view_layer = home.depsgraph.view_layer
    marked = volumes(home)
    try:
        storeys = storeys_of(home, all_sensors(view_layer), marked)
    except AngenError:
        return np.zeros(grid.shape, np.int64), ("",), np.zeros(grid.shape, bool)
    members = [s for floor, group in storeys if abs(floor - height) < 1.0 for s in group]
    here = [volume for volume in marked if abs(volume.lo[2] - height) < 1.0]
    shape = grid.shape[0] // 2, grid.shape[1] // 2
    coarse = Grid(grid.low, shape, 2 * grid.size, height)
    found = finished(labels_of(home, coarse, members, here))
    guessed = found.guessed.repeat(2, 0).repeat(2, 1)
    return found.number.repeat(2, 0).repeat(2, 1), ("", *found.names), guessed


def _main(floor: Floor, part: NDArray[np.int64], marks: Array) -> int:
    """The number of the part of the floor that most of the marks are near."""
    votes: Counter[int] = Counter()
    for mark in marks:
        x, y = floor.cell(mark)
        reach = int(NEAR_M / floor.size)
        around = part[max(0, x - reach) : x + reach + 1, max(0, y - reach) : y + reach + 1]
        votes.update(set(np.unique(around).tolist()) - {0})
    sizes = np.bincount(part.ravel())
    return max(votes, key=lambda number: (votes[number], int(sizes[number])), default=0)
