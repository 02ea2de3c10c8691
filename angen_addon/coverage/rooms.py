# SPDX-License-Identifier: GPL-3.0-or-later
"""Which room each cell of a floor is in.

A room is what a flood over the cells reaches from the sensors in it without passing a wall, a
closed door or a cupboard higher than 1.9 m; or what is inside a mesh that marks it: *Ignored by
sensors*, with its room noted or shown as wire or bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ...sensor_logic.coverage.grid import NO_ROOM
from ...sensor_logic.model import Array
from ..scene.home import EvaluatedHome
from ..scene.marks import COVERAGE_MARK
from ..scene.placed import NotPlaced, placed_matrix
from ..scene.rays.geometry import faces_along
from ..scene.rooms import room_of
from ..scene.sensors import Sensor
from .cells import CASTS_AT_ONCE, OVER_M, Grid, Mask, Steps, flood, floors, free_ways, passable

# Cells this near (m) to a sensor are of its room, if no wall is between.
NEAR_M = 0.9
# No ray this way runs along an edge of what is built square.
ASKEW = np.array([0.1234, 0.2345, 0.9642]) / np.linalg.norm([0.1234, 0.2345, 0.9642])


class Volume:
    """An object whose mesh marks the inside of a room."""

    def __init__(self, home: EvaluatedHome, obj: Any) -> None:
        self.name = room_of(obj) or obj.name
        matrix, metres = placed_matrix(obj, home.depsgraph), home.metres
        points = [matrix @ v.co * metres for v in obj.data.vertices]
        self.lo = np.min(np.array(points), axis=0)
        self.hi = np.max(np.array(points), axis=0)
        self._tree = BVHTree.FromPolygons(points, [tuple(p.vertices) for p in obj.data.polygons])

    def holds(self, points: Array) -> Mask:
        """(n,): by whether a ray leaves it an odd number of times."""
        inside = ((points >= self.lo) & (points <= self.hi)).all(axis=1)
        for i in np.flatnonzero(inside).tolist():
            inside[i] = faces_along(self._tree, points[i], ASKEW, 1e-4) % 2 == 1
        return inside


def volumes(home: EvaluatedHome) -> list[Volume]:
    """The meshes that mark rooms, by name; the doctor names those without a place."""
    marks = [
        obj
        for obj in home.depsgraph.view_layer.objects
        if obj.type == "MESH"
        and obj.angen_ignored
        and COVERAGE_MARK not in obj
        and len(obj.data.polygons) > 3
        and (room_of(obj) or obj.display_type in {"WIRE", "BOUNDS"})
    ]
    found = []
    for obj in sorted(marks, key=lambda obj: obj.name):
        with suppress(NotPlaced):
            found.append(Volume(home, obj))
    return found


@dataclass(frozen=True)
class Labels:
    """The number of the room (nx, ny) of each cell, 0 for none, into `names`. `guessed` (nx, ny):
    the cells of rooms that no wall parts from another, so that only sensors tell where they end."""

    number: NDArray[np.int64]
    names: list[str]
    guessed: Mask


def labels_of(
    home: EvaluatedHome, grid: Grid, members: Sequence[Sensor], marked: Sequence[Volume]
) -> Steps[Labels]:
    names = sorted({v.name for v in marked} | {s.room or NO_ROOM for s in members})
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
        cells = yield from _cells_at(home, points, sensor)
        for cell in cells:
            if seeds[cell] == 0:
                seeds[cell] = names.index(sensor.room or NO_ROOM) + 1
    loose = floor_there & (fixed.reshape(grid.shape) == 0)
    allowed = np.where(fixed.reshape(grid.shape) > 0, floor_there, loose)
    start = np.where(fixed.reshape(grid.shape) > 0, 0, seeds.reshape(grid.shape))
    ways = yield from passable(home, grid, OVER_M)
    flooded = yield from flood(start, loose, ways)
    number = np.where(fixed.reshape(grid.shape) > 0, fixed.reshape(grid.shape), flooded)
    number = np.where(allowed, number, 0)
    return Labels(number, names, loose & np.isin(number, _without_wall(flooded, loose, ways)))


def _without_wall(
    number: NDArray[np.int64], loose: Mask, ways: tuple[Mask, Mask]
) -> NDArray[np.int64]:
    """The numbers of rooms that one gets to from another without passing a wall."""
    rooms = np.where(loose, number, 0)
    found = []
    for way, one, two in (
        (ways[0], rooms[:-1], rooms[1:]),
        (ways[1], rooms[:, :-1], rooms[:, 1:]),
    ):
        open_there = way & (one != two) & (one > 0) & (two > 0)
        found += [one[open_there], two[open_there]]
    return np.unique(np.concatenate(found))


def _cells_at(home: EvaluatedHome, points: Array, sensor: Sensor) -> Steps[list[int]]:
    """The cells that are seen from under a sensor, in front of what it hangs on."""
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
