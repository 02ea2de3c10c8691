# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the storeys of a home, and the rooms of the cells of a storey's floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.coverage.grid import NO_ROOM
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.model import Array
from ...sensor_logic.progress import Steps
from ..scene.home.evaluated_home import EvaluatedHome
from ..scene.home.floor import (
    CASTS_AT_ONCE,
    OVER_M,
    Grid,
    flood,
    floors,
    free_ways,
    passable,
)
from ..scene.home.rooms import Mask, Volume, room_at
from ..scene.sensors import Sensor
from .storeys import group_by_storey, sensor_in_plan


def storeys_of(
    home: EvaluatedHome, sensors: Sequence[Sensor], marked: Sequence[Volume]
) -> list[tuple[float, list[Sensor]]]:
    """Return pairs of a storey's floor height in m and its sensors, the lowest first.

    `marked` are the meshes that mark rooms. Raise `AngenError` if no room is known.
    """
    inside = [s for s in sensors if s.kind.in_room]
    seen = [p for p in (sensor_in_plan(home, sensor) for sensor in inside) if p is not None]
    by_name = {s.name: s for s in inside}
    found = [
        (level.floor, [by_name[p.name] for p in level.sensors])
        for level in group_by_storey(home, seen)
    ]
    for volume in marked:
        if not any(abs(volume.lo[2] - floor) < 1.0 for floor, _ in found):
            found.append((float(volume.lo[2]), []))
    if not found:
        raise AngenError(
            "no room is known: put a motion detector or a light sensor into each room, or mark it "
            "with a box that is Ignored by sensors and has its Room set (Physics tab, Sensor)"
        )
    return sorted(found, key=lambda storey: storey[0])


# Rooms. A flood fill over the cells starts at the sensors of a room and ends at walls, closed doors
# and cupboards higher than 1.9 m. A mesh can also mark a room (scene/rooms.py).

# Cells this near (m) to a sensor belong to its room, if no wall is between.
NEAR_M = 0.9


@dataclass(frozen=True)
class Labels:
    """The rooms of a grid's cells.

    Attributes
    ----------
    number
        The number (nx, ny) of each cell's room; 0 for none. Room 1 is the first of `names`.
    names
        The names of the rooms.
    guessed
        A mask (nx, ny) of cells in rooms without a wall to another room. The border between two
        such rooms follows only from the distances to their sensors.
    """

    number: NDArray[np.int64]
    names: list[str]
    guessed: Mask


def labels_of(
    home: EvaluatedHome, grid: Grid, members: Sequence[Sensor], marked: Sequence[Volume]
) -> Steps[Labels]:
    """Generator that returns the rooms of a storey's cells.

    `members` are the sensors of the storey, and `marked` the meshes that mark its rooms.
    """
    rooms = {s.uid: _room_of(home, s) for s in members}
    names = sorted({v.name for v in marked} | set(rooms.values()))
    floor_there = ((yield from floors(home, grid, OVER_M)) < np.inf).reshape(grid.shape)
    middle = grid.at(OVER_M / 2)
    fixed = np.zeros(len(middle), np.int64)
    for volume in marked:
        for first in range(0, len(middle), CASTS_AT_ONCE):
            part = np.arange(first, min(first + CASTS_AT_ONCE, len(middle)))
            inside = part[volume.holds(middle[part])]
            fixed[inside[fixed[inside] == 0]] = names.index(volume.name) + 1
            yield
    seeds = fixed.copy()
    points = grid.at(OVER_M)
    for sensor in sorted(members, key=lambda s: s.name):
        cells = yield from _cells_near(home, points, sensor)
        for cell in cells:
            if seeds[cell] == 0:
                seeds[cell] = names.index(rooms[sensor.uid]) + 1
    loose = floor_there & (fixed.reshape(grid.shape) == 0)
    allowed = np.where(fixed.reshape(grid.shape) > 0, floor_there, loose)
    start = np.where(fixed.reshape(grid.shape) > 0, 0, seeds.reshape(grid.shape))
    ways = yield from passable(home, grid, OVER_M)
    flooded = yield from flood(start, loose, ways)
    number = np.where(fixed.reshape(grid.shape) > 0, fixed.reshape(grid.shape), flooded)
    number = np.where(allowed, number, 0)
    return Labels(number, names, loose & np.isin(number, _open_rooms(flooded, loose, ways)))


def _room_of(home: EvaluatedHome, sensor: Sensor) -> str:
    """Return the room of a sensor: without one, that of its position, so that no room is split."""
    if sensor.room:
        return sensor.room
    place = sensor.world_matrix(home.depsgraph).translation
    return room_at(home.depsgraph, place, sensor.object) or NO_ROOM


def _open_rooms(
    number: NDArray[np.int64], loose: Mask, ways: tuple[Mask, Mask]
) -> NDArray[np.int64]:
    """Return the numbers of rooms that no wall separates from another room.

    `number` (nx, ny) is the room of each cell, and `loose` the mask of the cells to compare. `ways`
    are the masks of `passable`.
    """
    rooms = np.where(loose, number, 0)
    found = []
    for way, one, two in (
        (ways[0], rooms[:-1], rooms[1:]),
        (ways[1], rooms[:, :-1], rooms[:, 1:]),
    ):
        open_there = way & (one != two) & (one > 0) & (two > 0)
        found += [one[open_there], two[open_there]]
    return np.unique(np.concatenate(found))


def _cells_near(home: EvaluatedHome, points: Array, sensor: Sensor) -> Steps[list[int]]:
    """Generator that returns the numbers of nearby cells that horizontal rays from a sensor reach.

    The rays start below the sensor, a little in front of its wall.
    """
    matrix = sensor.world_matrix(home.depsgraph)
    at = np.array(matrix.translation) * home.metres
    looks = -np.array(matrix.col[2])[:2]
    size = float(np.linalg.norm(looks))
    here = at[:2] + (looks / size * 0.05 if size > 0.1 else 0.0)
    ways = points[:, :2] - here
    apart = np.linalg.norm(ways, axis=1)
    near = np.flatnonzero(apart <= NEAR_M)
    if not len(near):
        near = np.array([int(np.argmin(apart))])
    near = near[np.argsort(apart[near], kind="stable")]
    found = []
    for cell in near.tolist():
        start = np.array([[*here, points[cell, 2]]])
        length = max(float(apart[cell]), 1e-6)
        way = np.array([*(ways[cell] / length), 0.0])
        free = yield from free_ways(home, start, way, length)
        if free[0] >= length * (1 - 1e-6):
            found.append(cell)
    return found
