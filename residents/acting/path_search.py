# SPDX-License-Identifier: GPL-3.0-or-later
"""Find paths over a floor that are wide enough for a body.

The floor is a grid of free cells. A path is the cheapest one over neighbouring cells (A*), and
cells near obstacles cost more. Corners that a walker would cut are then removed, and the others
rounded.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array

# Preferred distance from obstacles beyond the walker's half width, m, and the largest cost factor
# of cells nearer than that.
EASY_M, EASY = 0.15, 3.0
# Distance before a corner at which a walker begins to turn, m.
ROUNDING = 0.45
_ROOT2 = math.sqrt(2.0)
_NEIGHBOURS = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)]


class NoPath(ValueError):
    """Raised if no path is wide enough for a body.

    `nearest` (2,) is the reachable point that is nearest to the goal, m.
    """

    def __init__(self, text: str, nearest: Array) -> None:
        super().__init__(text)
        self.nearest = nearest


@dataclass(frozen=True, eq=False)
class Floor:
    """A floor as a grid of square cells.

    Attributes
    ----------
    low : array, shape (2,)
        The outer corner of the first cell, m.
    size : float
        The length of a cell's edge, m.
    free : array of bool, shape (nx, ny)
        Whether each cell is free of obstacles.
    """

    low: Array
    size: float
    free: NDArray[np.bool_]

    def cell(self, point: Array) -> tuple[int, int]:
        """Return the indices of the cell nearest to a point (2,)."""
        index = np.floor((np.asarray(point)[:2] - self.low) / self.size).astype(int)
        x, y = np.clip(index, 0, np.array(self.free.shape) - 1).tolist()
        return x, y

    def middle(self, cell: tuple[int, int]) -> Array:
        """Return the middle (2,) of a cell, m."""
        place: Array = self.low + (np.array(cell) + 0.5) * self.size
        return place

    # Computed once a floor: without the cache each path takes 2 ms longer in a small home.
    @cached_property
    def clearance(self) -> Array:
        """The distance (nx, ny) from each cell's middle to the nearest obstacle, m.

        Cells outside the grid count as obstacles.
        """
        padded = np.pad(self.free, 1)
        return (_distances(padded)[1:-1, 1:-1] - 0.5) * self.size


def _distances(free: NDArray[np.bool_]) -> Array:
    """Return the distance of each cell to the nearest cell that is not free, in cells.

    References
    ----------
    Meijster et al. 2000: along the columns, then the lower envelope of parabolas along the rows.
    """
    nx, ny = free.shape
    along = np.where(free, np.inf, 0.0)
    for x in range(1, nx):
        along[x] = np.minimum(along[x], along[x - 1] + 1)
    for x in range(nx - 2, -1, -1):
        along[x] = np.minimum(along[x], along[x + 1] + 1)
    squared = along**2
    best = squared.copy()
    for shift in range(1, ny):
        if shift**2 >= best.max():
            break
        best[:, shift:] = np.minimum(best[:, shift:], squared[:, :-shift] + shift**2)
        best[:, :-shift] = np.minimum(best[:, :-shift], squared[:, shift:] + shift**2)
    distance: Array = np.sqrt(best)
    return distance


def find_path(floor: Floor, start: Array, goal: Array, radius: float) -> Array:
    """Return the corner points (n, 2) of a path.

    A start or goal can be nearer to obstacles than the radius, as in front of a basin. A straight
    line then connects it with the nearest cell where the body fits.

    Parameters
    ----------
    floor : Floor
        The free floor.
    start, goal : array, shape (2,)
        The ends, m.
    radius : float
        Half of the walker's width, m.

    Raises
    ------
    NoPath
        If no path is wide enough.
    """
    wide = floor.clearance >= radius - 1e-9
    first, last = (_entry(floor, wide, np.asarray(end, float)[:2]) for end in (start, goal))
    cells = _cheapest_path(floor, wide, first, last, radius)
    points = np.array([floor.middle(cell) for cell in cells])
    points = np.concatenate([[np.asarray(start)[:2]], points, [np.asarray(goal)[:2]]])
    return _straighten(floor, points, radius)


def regions(floor: Floor, radius: float) -> NDArray[np.int64]:
    """Return the number of each cell's connected region, from 1, shape (nx, ny).

    The number is 0 where a body of `radius` m does not fit.
    """
    wide = floor.clearance >= radius - 1e-9
    nx, ny = wide.shape
    free, region, number = wide.tolist(), np.zeros((nx, ny), np.int64).tolist(), 0
    for first in np.argwhere(wide).tolist():
        if region[first[0]][first[1]]:
            continue
        number += 1
        region[first[0]][first[1]] = number
        queue = [first]
        while queue:
            x, y = queue.pop()
            for i, j in ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)):
                if 0 <= i < nx and 0 <= j < ny and free[i][j] and not region[i][j]:
                    region[i][j] = number
                    queue.append((i, j))
    return np.array(region, np.int64).reshape(nx, ny)


def entry(floor: Floor, radius: float, point: Array) -> tuple[int, int]:
    """Return the indices of the cell nearest to a point (2,) where a body of `radius` m fits.

    Raises `NoPath` if the body fits nowhere.
    """
    return _entry(floor, floor.clearance >= radius - 1e-9, np.asarray(point, float)[:2])


def _entry(floor: Floor, wide: NDArray[np.bool_], point: Array) -> tuple[int, int]:
    """Return the indices of the cell nearest to a point in the mask `wide`.

    Raises `NoPath` if the mask is empty.
    """
    cells = np.argwhere(wide)
    if not len(cells):
        raise NoPath("no floor is wide enough for a resident", point)
    places = floor.low + (cells + 0.5) * floor.size
    x, y = cells[int(np.argmin(((places - point) ** 2).sum(axis=1)))].tolist()
    return x, y


def _cheapest_path(
    floor: Floor,
    wide: NDArray[np.bool_],
    first: tuple[int, int],
    last: tuple[int, int],
    radius: float,
) -> list[tuple[int, int]]:
    """Return the cells of the cheapest path from `first` to `last` within the mask `wide`.

    Raises `NoPath` if there is none.
    """
    easy = np.clip((radius + EASY_M - floor.clearance) / EASY_M, 0.0, 1.0)
    price = (1.0 + (EASY - 1.0) * easy).tolist()
    free = wide.tolist()
    nx, ny = wide.shape
    came: dict[tuple[int, int], tuple[int, int]] = {first: first}
    cost = {first: 0.0}
    queue = [(0.0, first)]
    done: set[tuple[int, int]] = set()
    while queue:
        _, here = heapq.heappop(queue)
        if here == last:
            cells = [here]
            while cells[-1] != first:
                cells.append(came[cells[-1]])
            return cells[::-1]
        if here in done:
            continue
        done.add(here)
        x, y = here
        for dx, dy in _NEIGHBOURS:
            i, j = x + dx, y + dy
            if not (0 <= i < nx and 0 <= j < ny and free[i][j]):
                continue
            if dx and dy and not (free[i][y] and free[x][j]):
                continue
            length = _ROOT2 if dx and dy else 1.0
            total = cost[here] + length * (price[x][y] + price[i][j]) / 2
            if total < cost.get((i, j), math.inf):
                cost[i, j], came[i, j] = total, here
                wx, wy = abs(i - last[0]), abs(j - last[1])
                left = max(wx, wy) + (_ROOT2 - 1) * min(wx, wy)
                heapq.heappush(queue, (total + left, (i, j)))
    reached = np.array(sorted(done))
    nearest = reached[int(np.argmin(((reached - last) ** 2).sum(axis=1)))]
    raise NoPath("there is no way", floor.middle((int(nearest[0]), int(nearest[1]))))


def _straighten(floor: Floor, points: Array, radius: float) -> Array:
    """Remove corners where the straight line comes no nearer to obstacles.

    Beyond a distance of `radius` and `EASY_M` it can come nearer.
    """
    kept, here = [0], 0
    while here < len(points) - 1:
        ahead = len(points) - 1
        while ahead > here + 1:
            least = min(radius + EASY_M, float(_clearances(floor, points[here : ahead + 1]).min()))
            if _clearance_between(floor, points[here], points[ahead]) >= least - 1e-9:
                break
            ahead = here + 1 + (ahead - here - 1) // 2
        kept.append(ahead)
        here = ahead
    return points[kept]


def _clearances(floor: Floor, points: Array) -> Array:
    index = np.floor((points - floor.low) / floor.size).astype(int)
    x, y = np.clip(index, 0, np.array(floor.free.shape) - 1).T
    found: Array = floor.clearance[x, y]
    return found


def _clearance_between(floor: Floor, a: Array, b: Array) -> float:
    """Return the least distance to obstacles on the straight line from `a` to `b`, m."""
    steps = max(2, int(np.linalg.norm(b - a) / floor.size * 2) + 1)
    return float(_clearances(floor, a + (b - a) * np.linspace(0, 1, steps)[:, None]).min())


def length(points: Array) -> float:
    """Return the length of a path of corner points (n, 2), m."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def yaw_to(start: Array, end: Array) -> float:
    """Return the direction from one point to another as a yaw, rad."""
    return math.atan2(end[1] - start[1], end[0] - start[0])


def resample(points: Array, spacing: float = 0.03) -> Array:
    """Return points (m, 2) every `spacing` m along corner points (n, 2); n is at least 2."""
    gaps = np.hypot(*np.diff(points, axis=0).T)
    points = points[np.concatenate([[True], gaps > 1e-6])]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, s[-1], max(2, int(s[-1] / spacing) + 1))
    return np.column_stack([np.interp(at, s, points[:, k]) for k in (0, 1)])


def round_corners(floor: Floor, points: Array) -> Array:
    """Return closely spaced points (m, 2) along corner points (n, 2), with rounded corners.

    The arcs are quadratic Béziers, which are smaller near obstacles.
    """
    arcs, t = [points[:1]], np.linspace(0, 1, 9)[:, None]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        into, away = before - corner, after - corner
        lengths = math.hypot(*into), math.hypot(*away)
        if min(lengths) < 1e-6:
            continue
        trim = min(ROUNDING, 0.48 * lengths[0], 0.48 * lengths[1])
        room = min(_least_clearance(floor, corner[None]), EASY_M + 0.25) - 0.04
        for _ in range(6):
            a, b = corner + into / lengths[0] * trim, corner + away / lengths[1] * trim
            arc = (1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t**2 * b
            if _least_clearance(floor, arc) >= room:
                break
            trim *= 0.6
        arcs.append(arc)
    return resample(np.concatenate([*arcs, points[-1:]]))


def _least_clearance(floor: Floor, points: Array) -> float:
    """Return the least distance from any of the points (n, 2) to an obstacle, m."""
    cells = np.array([floor.cell(point) for point in points])
    return float(floor.clearance[cells[:, 0], cells[:, 1]].min())
