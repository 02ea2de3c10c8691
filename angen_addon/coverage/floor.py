# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the free floor of a home: the cells where a body can move, and the rooms of the cells.

Functions that return `Steps` are generators, so that long work can be ended between its steps.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.coverage.grid import NO_ROOM, Cells
from ...sensor_logic.coverage.motions import DIRECTIONS, HEADINGS, Motion
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Array
from ..authoring.rooms import Mask, Volume, room_at, volumes
from ..plan import group_by_storey, sensor_in_plan
from ..progress import Doing, saying
from ..scene.home import EvaluatedHome
from ..scene.sensors import Sensor

# m above the floor: below the heads of doors, and above furniture that is no partition.
OVER_M = 1.9
# m. A surface up to RUG_M above the floor is the floor, a rug or a threshold. A surface that is
# PIT_M below it is another floor.
RUG_M, PIT_M = 0.1, 0.3
MOST_CELLS = 250_000
# The number of rays that are cast in one step of the work.
CASTS_AT_ONCE = 2000

T = TypeVar("T")
# A generator that yields between steps of its work, so that it can be ended. It returns its result.
Steps = Generator[None, None, T]


@dataclass(frozen=True)
class Grid:
    """A rectangular grid of nx × ny square cells on the floor of a storey.

    Attributes
    ----------
    low
        The corner (2,) of the grid with the least x and y, in m.
    shape
        The number of cells along x and along y.
    size
        Side of a cell in m.
    floor
        Height of the floor in m.
    """

    low: Array
    shape: tuple[int, int]
    size: float
    floor: float

    def at(self, height: float) -> Array:
        """Return the centres (n, 3) of all cells, at a height (m) above the floor."""
        x = self.low[0] + (np.arange(self.shape[0]) + 0.5) * self.size
        y = self.low[1] + (np.arange(self.shape[1]) + 0.5) * self.size
        xs, ys = np.meshgrid(x, y, indexing="ij")
        level = np.full(xs.size, self.floor + height)
        return np.column_stack([xs.ravel(), ys.ravel(), level])


def cast_along(
    home: EvaluatedHome, points: Array, direction: Array, length: float
) -> Steps[tuple[Array, NDArray[np.int64]]]:
    """Cast parallel rays. This generator yields after every CASTS_AT_ONCE rays.

    Parameters
    ----------
    home
        The evaluated scene.
    points
        Starts (n, 3) of the rays, in m.
    direction
        Unit vector (3,).
    length
        Maximum range in m.

    Returns
    -------
    ranges : (n,) array
        In m.
    met : (n,) array
        Numbers of the solids that are hit.
    """
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
    """Generator that returns the distances (n,) in m from points (n, 3) to the first obstacle.

    The distances are measured along `direction`, and are at most `length`.
    """
    ranges, _ = yield from cast_along(home, points, direction, length)
    return ranges


def floors(home: EvaluatedHome, grid: Grid, start: float) -> Steps[Array]:
    """Generator that returns the height (n,) in m of the first surface below each cell.

    The search begins at the height `start`. All heights are above the storey's floor, and infinite
    if nothing is below.
    """
    deep = start + PIT_M
    ranges = yield from free_ways(home, grid.at(start), np.array([0.0, 0.0, -1.0]), deep)
    return np.where(ranges < deep - 1e-6, start - ranges, np.inf)


def passable(
    home: EvaluatedHome, grid: Grid, height: float, among: Mask | None = None
) -> Steps[tuple[Mask, Mask]]:
    """Generator that returns which pairs of neighbouring cells have no obstacle in between.

    The first mask (nx − 1, ny) is for neighbours along x, the second (nx, ny − 1) along y. Rays are
    cast between the cells' centres, at `height` above the floor. If a mask `among` (nx, ny) is
    given, all pairs with a cell outside of it count as blocked.
    """
    points = grid.at(height).reshape(*grid.shape, 3)
    included = np.ones(grid.shape, bool) if among is None else among
    ways = []
    for axis in (0, 1):
        axis_vector = np.eye(3)[axis]
        first, second = (slice(None, -1), slice(1, None))
        cut = (first,) if axis == 0 else (slice(None), first)
        pairs = included[cut] & included[(second,) if axis == 0 else (slice(None), second)]
        start = points[cut][pairs]
        free = yield from free_ways(home, start, axis_vector, grid.size)
        back = yield from free_ways(home, start + axis_vector * grid.size, -axis_vector, grid.size)
        clear = pairs.copy()
        clear[pairs] = np.minimum(free, back) >= grid.size * (1 - 1e-6)
        ways.append(clear)
    return ways[0], ways[1]


def flood(
    seeds: NDArray[np.int64], allowed: Mask, ways: tuple[Mask, Mask]
) -> Steps[NDArray[np.int64]]:
    """Generator that flood-fills labels from the cells `seeds`, and returns the labels (nx, ny).

    A label of 0 is none. Labels spread only to `allowed` cells, and only between neighbours for
    which `ways`, the masks of `passable`, are true. If two labels reach a cell in the same step,
    the cell gets the smaller one.
    """
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


# Rooms. A flood fill over the cells starts at the sensors of a room and ends at walls, closed doors
# and cupboards higher than 1.9 m. A mesh can also mark a room (authoring/rooms.py).

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
) -> Generator[Doing, None, Cells]:
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
