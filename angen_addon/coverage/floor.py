# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where in a home somebody can move: the cells of its floors that have room, and which room
each is in."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ...sensor_logic.coverage.grid import NO_ROOM, Cells
from ...sensor_logic.coverage.motions import DIRECTIONS, HEADINGS, Motion
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Array
from ..plan import group_by_storey, sensor_in_plan
from ..progress import Doing, saying
from ..scene.home import EvaluatedHome
from ..scene.marks import COVERAGE_MARK
from ..scene.rays.geometry import faces_along
from ..scene.sensors import NotPlaced, Sensor, placed_matrix, room_of

# Cells on a floor, and what rays among the solids tell of them, in steps that can be given up.

Mask = NDArray[np.bool_]
# m above the floor: under the heads of doors and over what one could look across.
OVER_M = 1.9
# What rises less is the floor itself, a rug or a threshold; what lies deeper is another floor.
RUG_M, PIT_M = 0.1, 0.3
MOST_CELLS = 250_000
# Rays that are cast between two moments at which the work can be given up.
CASTS_AT_ONCE = 2000

T = TypeVar("T")
# Work in steps, which returns its result.
Steps = Generator[None, None, T]


@dataclass(frozen=True)
class Grid:
    """The cells (nx × ny) of a storey, row by row; `low` (2,) its corner in m."""

    low: Array
    shape: tuple[int, int]
    size: float
    floor: float

    def at(self, height: float) -> Array:
        """(n, 3): the middles of all cells at a height above the floor."""
        x = self.low[0] + (np.arange(self.shape[0]) + 0.5) * self.size
        y = self.low[1] + (np.arange(self.shape[1]) + 0.5) * self.size
        xs, ys = np.meshgrid(x, y, indexing="ij")
        level = np.full(xs.size, self.floor + height)
        return np.column_stack([xs.ravel(), ys.ravel(), level])


def met_along(
    home: EvaluatedHome, points: Array, direction: Array, length: float
) -> Steps[tuple[Array, NDArray[np.int64]]]:
    """How far it is free (n,) m from points (n, 3) along one direction, at most `length`, and the
    numbers (n,) of the solids that are met; a step is CASTS_AT_ONCE rays."""
    ranges, met = np.empty(len(points)), np.empty(len(points), np.int64)
    for first in range(0, len(points), CASTS_AT_ONCE):
        part = slice(first, first + CASTS_AT_ONCE)
        starts = points[part] / home.metres
        ways = np.broadcast_to(direction, starts.shape)
        reach = np.full(len(starts), length / home.metres)
        ranges[part], met[part] = home.caster.first_met(
            home.depsgraph, home.rows, starts, ways, reach
        )
        yield
    return np.minimum(ranges * home.metres, length), met


def free_ways(home: EvaluatedHome, points: Array, direction: Array, length: float) -> Steps[Array]:
    """(n,) m: how far it is free from points (n, 3) along one direction, at most `length`."""
    ranges, _ = yield from met_along(home, points, direction, length)
    return ranges


def floors(home: EvaluatedHome, grid: Grid, start: float) -> Steps[Array]:
    """(n,) m above the storey's floor of what is below each cell, seen from `start` above it;
    infinite where there is nothing."""
    deep = start + PIT_M
    ranges = yield from free_ways(home, grid.at(start), np.array([0.0, 0.0, -1.0]), deep)
    return np.where(ranges < deep - 1e-6, start - ranges, np.inf)


def passable(
    home: EvaluatedHome, grid: Grid, height: float, among: Mask | None = None
) -> Steps[tuple[Mask, Mask]]:
    """Whether nothing is between neighbours: (nx − 1, ny) along x, (nx, ny − 1) along y; only
    `among` these cells (nx, ny), if they are given."""
    points = grid.at(height).reshape(*grid.shape, 3)
    asked = np.ones(grid.shape, bool) if among is None else among
    ways = []
    for axis in (0, 1):
        there = np.eye(3)[axis]
        first, second = (slice(None, -1), slice(1, None))
        cut = (first,) if axis == 0 else (slice(None), first)
        pairs = asked[cut] & asked[(second,) if axis == 0 else (slice(None), second)]
        start = points[cut][pairs]
        free = yield from free_ways(home, start, there, grid.size)
        back = yield from free_ways(home, start + there * grid.size, -there, grid.size)
        clear = pairs.copy()
        clear[pairs] = np.minimum(free, back) >= grid.size * (1 - 1e-6)
        ways.append(clear)
    return ways[0], ways[1]


def flood(
    seeds: NDArray[np.int64], allowed: Mask, ways: tuple[Mask, Mask]
) -> Steps[NDArray[np.int64]]:
    """Labels (nx, ny) spread from `seeds` (0: none) step by step; where two meet at once the
    smaller one wins."""
    labels = np.where(allowed, seeds, 0)
    none = np.iinfo(np.int64).max
    while True:
        offered = np.where(labels > 0, labels, none)
        best = np.full(labels.shape, none)
        best[1:] = np.minimum(best[1:], np.where(ways[0], offered[:-1], none))
        best[:-1] = np.minimum(best[:-1], np.where(ways[0], offered[1:], none))
        best[:, 1:] = np.minimum(best[:, 1:], np.where(ways[1], offered[:, :-1], none))
        best[:, :-1] = np.minimum(best[:, :-1], np.where(ways[1], offered[:, 1:], none))
        new = (labels == 0) & allowed & (best < none)
        if not new.any():
            return labels
        labels = np.where(new, best, labels)
        yield


# Which room each cell of a floor is in.
#
# A room is what a flood over the cells reaches from the sensors in it without passing a wall, a
# closed door or a cupboard higher than 1.9 m; or what is inside a mesh that marks it: *Ignored by
# sensors*, with its room noted or shown as wire or bounds.

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


# Rooms reach at most this far (m) from the sensors that tell of them.
BEYOND_M = 10.0
# Heights (m) of a body are this far apart at most, where its surroundings are felt for obstacles.
EVERY_M = 0.4


def cells_of(
    home: EvaluatedHome,
    sensors: Sequence[Sensor],
    motion: Motion,
    size: float,
    rooms: Sequence[str] = (),
) -> Generator[Doing, None, Cells]:
    """The cells where the body can move; only those of `rooms`, if any are named. Yields what is
    being done. Raises AngenError."""
    yield Doing(0.0, "looking for the floor")
    parts = []
    marked = volumes(home)
    for number, (floor, members) in enumerate(storeys_of(home, sensors, marked)):
        grid = _grid(home, floor, members, marked, size)
        doing = Doing(0.0, "looking for rooms")
        labels = yield from saying(doing, labels_of(home, grid, members, marked))
        doing = Doing(0.0, "looking where there is room to move")
        parts.append((yield from saying(doing, _storey_cells(home, grid, labels, motion, number))))
    every = _joined(parts, size)
    known = every.rooms
    whole = every.of(rooms) if rooms else every
    for name in rooms:
        if name not in known:
            raise AngenError(
                f"no room '{name}' with free floor was found; there are "
                f"{', '.join(known) or 'none'}. A room is named by the field Room of a sensor in "
                "it, or of a mesh that marks it and is Ignored by sensors"
            )
    if not len(whole):
        raise AngenError(
            "no free floor was found under the sensors: rooms need a floor, and sensors that hang "
            "inside them; or take smaller cells"
        )
    return whole


def storeys_of(
    home: EvaluatedHome, sensors: Sequence[Sensor], marked: Sequence[Volume]
) -> list[tuple[float, list[Sensor]]]:
    """Heights of floors in m with the sensors over each."""
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
            "no room is known: put a motion detector or a light sensor into it, or mark it with a "
            "box that is Ignored by sensors and has its Room noted (Physics tab, Sensor)"
        )
    return sorted(found, key=lambda storey: storey[0])


def _grid(
    home: EvaluatedHome,
    floor: float,
    members: Sequence[Sensor],
    marked: Sequence[Volume],
    size: float,
) -> Grid:
    """A grid as large as the home there, but only so far from sensors and marks as they can
    matter."""
    near = [np.array(s.world_matrix(home.depsgraph).translation)[:2] * home.metres for s in members]
    low = np.array([p - BEYOND_M for p in near] + [v.lo[:2] for v in marked]).min(axis=0)
    high = np.array([p + BEYOND_M for p in near] + [v.hi[:2] for v in marked]).max(axis=0)
    there = np.isfinite(home.lo).all(axis=1) & np.isfinite(home.hi).all(axis=1)
    there &= (home.lo[:, 2] < floor + OVER_M) & (home.hi[:, 2] > floor - PIT_M)
    if there.any():
        low = np.maximum(low, home.lo[there, :2].min(axis=0))
        high = np.minimum(high, home.hi[there, :2].max(axis=0))
    first = np.floor(low / size)
    shape = np.maximum(np.ceil(high / size) - first, 1).astype(int)
    if shape.prod() > MOST_CELLS:
        raise AngenError(
            f"cells of {size:g} m make {shape.prod()} of them, more than {MOST_CELLS}: "
            "take larger ones"
        )
    return Grid(first * size, (int(shape[0]), int(shape[1])), size, floor)


def _storey_cells(
    home: EvaluatedHome, grid: Grid, labels: Labels, motion: Motion, number: int
) -> Steps[Cells]:
    """The cells of the rooms where the body can be."""
    top = min(motion.top + 0.02, OVER_M)
    limit = max(motion.bottom, RUG_M)
    in_room = labels.number > 0
    high = yield from floors(home, grid, OVER_M)
    low = yield from floors(home, grid, top)
    open_sky = (high <= limit).reshape(grid.shape) & in_room
    under = (low <= limit).reshape(grid.shape) & in_room
    middle = (max(motion.bottom, RUG_M) + motion.top) / 2.0
    # Under tables a low body gets, into a solid none.
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
    """(n, 8) m: how far it is free around cells, over the height of the body."""
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


def _joined(parts: Sequence[Cells], size: float) -> Cells:
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
