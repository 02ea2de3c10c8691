# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the cells of the floor where a body has room for a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...sensor_logic.coverage.grid import Cells
from ...sensor_logic.coverage.motions import DIRECTIONS, HEADINGS, Motion
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.model import Array
from ...sensor_logic.progress import Doing, Steps, Work, saying
from ..plan.rooms import Labels, labels_of, storeys_of
from ..scene.home.evaluated_home import EvaluatedHome
from ..scene.home.floor import (
    MOST_CELLS,
    OVER_M,
    PIT_M,
    RUG_M,
    Grid,
    flood,
    floors,
    free_ways,
    passable,
)
from ..scene.home.rooms import Volume, volumes
from ..scene.sensors import Sensor

# Rooms reach at most this far (m) from their sensors.
BEYOND_M = 10.0
# Obstacles around a body are searched with rays at several heights, at most this far apart (m).
EVERY_M = 0.4


def cells_of(
    home: EvaluatedHome,
    sensors: Sequence[Sensor],
    motion: Motion,
    size: float,
    rooms: Sequence[str] = (),
) -> Work[Cells]:
    """Generator that returns the cells of the floor where a body has room for a motion.

    Parameters
    ----------
    home
        The evaluated scene.
    sensors
        The sensors of the home. Their rooms tell which cells belong to which room.
    motion
        The body and its motion.
    size
        Side of a cell in m.
    rooms
        Names of the rooms; empty: all.

    Yields
    ------
    Doing
        The progress.

    Raises
    ------
    AngenError
        If there is no such room, or no free floor.
    """
    yield Doing(0.0, "looking for the floor")
    parts = []
    marked = volumes(home.depsgraph)
    for number, (floor, members) in enumerate(storeys_of(home, sensors, marked)):
        grid = _grid(home, floor, members, marked, size)
        doing = Doing(0.0, "looking for rooms")
        labels = yield from saying(doing, labels_of(home, grid, members, marked))
        doing = Doing(0.0, "looking for free floor")
        parts.append((yield from saying(doing, _storey_cells(home, grid, labels, motion, number))))
    every = _join(parts, size)
    known = every.rooms
    whole = every.of(rooms) if rooms else every
    for name in rooms:
        if name not in known:
            raise AngenError(
                f"no room '{name}' with free floor was found; the rooms are "
                f"{', '.join(known) or 'none'}. To add a room, set the field Room of a sensor in "
                "it, or of a mesh around it that is Ignored by sensors"
            )
    if not len(whole):
        raise AngenError(
            "no free floor was found below the sensors: give each room a floor and a sensor "
            "inside it, or set smaller cells"
        )
    return whole


def _grid(
    home: EvaluatedHome,
    floor: float,
    members: Sequence[Sensor],
    marked: Sequence[Volume],
    size: float,
) -> Grid:
    """Return the grid of a storey.

    It covers the meshes that mark rooms, and BEYOND_M around each sensor, but nothing outside the
    home.
    """
    near = [np.array(s.world_matrix(home.depsgraph).translation)[:2] * home.metres for s in members]
    low = np.array([p - BEYOND_M for p in near] + [v.lo[:2] for v in marked]).min(axis=0)
    high = np.array([p + BEYOND_M for p in near] + [v.hi[:2] for v in marked]).max(axis=0)
    is_near = np.isfinite(home.lo).all(axis=1) & np.isfinite(home.hi).all(axis=1)
    is_near &= (home.lo[:, 2] < floor + OVER_M) & (home.hi[:, 2] > floor - PIT_M)
    if is_near.any():
        low = np.maximum(low, home.lo[is_near, :2].min(axis=0))
        high = np.minimum(high, home.hi[is_near, :2].max(axis=0))
    first = np.floor(low / size)
    shape = np.maximum(np.ceil(high / size) - first, 1).astype(int)
    if shape.prod() > MOST_CELLS:
        raise AngenError(
            f"cells of {size:g} m would be {shape.prod()} cells, more than {MOST_CELLS}: set "
            "larger cells"
        )
    return Grid(first * size, (int(shape[0]), int(shape[1])), size, floor)


def _storey_cells(
    home: EvaluatedHome, grid: Grid, labels: Labels, motion: Motion, number: int
) -> Steps[Cells]:
    """Generator that returns the cells in a storey's rooms with room for the body's motion."""
    top = min(motion.top + 0.02, OVER_M)
    limit = max(motion.bottom, RUG_M)
    in_room = labels.number > 0
    high = yield from floors(home, grid, OVER_M)
    low = yield from floors(home, grid, top)
    open_sky = (high <= limit).reshape(grid.shape) & in_room
    under = (low <= limit).reshape(grid.shape) & in_room
    middle = (max(motion.bottom, RUG_M) + motion.top) / 2.0
    # A low body gets below tables, but no body gets into a solid.
    ways = yield from passable(home, grid, middle)
    reached = (yield from flood(open_sky.astype(np.int64), under | open_sky, ways)) > 0
    cells = np.flatnonzero((reached & under).ravel())
    names = np.array([*labels.names], object)[labels.number.ravel()[cells] - 1]
    at = grid.at(0.0)[cells]
    clearance = yield from _clearance(home, at, motion)
    lengths = motion.lengths(clearance)
    fits = (clearance.min(axis=1, initial=np.inf) >= motion.room) & (lengths > 0.0).any(axis=1)
    return Cells(
        grid.size,
        at[fits],
        tuple(str(name) for name in names[fits]),
        np.full(int(fits.sum()), number),
        lengths[fits],
    )


def _clearance(home: EvaluatedHome, at: Array, motion: Motion) -> Steps[Array]:
    """Generator that returns the free distance (n, 8) in m from points (n, 3) in 8 directions."""
    low, high = max(motion.bottom, RUG_M), motion.top
    heights = np.linspace(low, high, max(2, int(np.ceil((high - low) / EVERY_M)) + 1))
    reach = (motion.step if motion.walks else 0.0) + max(
        motion.radius, motion.length if not motion.walks else motion.length / 2.0
    )
    clearance = np.full((len(at), DIRECTIONS), reach + 1e-6)
    for column, heading in enumerate(HEADINGS.tolist()):
        way = np.array([np.cos(heading), np.sin(heading), 0.0])
        for height in heights.tolist():
            points = at + np.array([0.0, 0.0, height])
            free = yield from free_ways(home, points, way, reach + 1e-6)
            clearance[:, column] = np.minimum(clearance[:, column], free)
    return clearance


def _join(parts: Sequence[Cells], size: float) -> Cells:
    names: tuple[str, ...] = sum((part.room for part in parts), ())
    if not parts:
        return Cells(size, np.empty((0, 3)), (), np.empty(0, np.intp), np.empty((0, DIRECTIONS)))
    return Cells(
        size,
        np.concatenate([part.at for part in parts]),
        names,
        np.concatenate([part.storey for part in parts]),
        np.concatenate([part.lengths for part in parts]),
    )
