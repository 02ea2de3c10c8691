# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways over a floor: the shortest for a body of some width that rather keeps off what stands about.

The floor is a grid of free cells. A way is the cheapest over neighbouring cells (A*), where cells
near to things cost more, with the corners left out that a walker cuts.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array

# What a walker likes to keep to things beside the own half width, m, and how many times as long a
# way may be for it.
EASY_M, EASY = 0.15, 3.0
_ROOT2 = math.sqrt(2.0)
_NEIGHBOURS = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)]


class NoWay(ValueError):
    """Nobody of that width gets there; `nearest` (2,) m is the place next to it that can be
    reached."""

    def __init__(self, text: str, nearest: Array) -> None:
        super().__init__(text)
        self.nearest = nearest


@dataclass(frozen=True, eq=False)
class Floor:
    """Squares of `size` m; `low` (2,) m is the corner of the first, `free` (nx, ny) where nothing
    stands."""

    low: Array
    size: float
    free: NDArray[np.bool_]

    def cell(self, point: Array) -> tuple[int, int]:
        """The cell of a point (2,); the nearest one of a point outside."""
        index = np.floor((np.asarray(point)[:2] - self.low) / self.size).astype(int)
        x, y = np.clip(index, 0, np.array(self.free.shape) - 1).tolist()
        return x, y

    def middle(self, cell: tuple[int, int]) -> Array:
        place: Array = self.low + (np.array(cell) + 0.5) * self.size
        return place

    # Once a floor; without it 2 ms for each way that is looked for in a small home.
    @cached_property
    def clearance(self) -> Array:
        """(nx, ny) m: from the middle of each cell to the edge of the nearest that is not free,
        those outside included."""
        padded = np.pad(self.free, 1)
        return (_distance(padded)[1:-1, 1:-1] - 0.5) * self.size


def _distance(free: NDArray[np.bool_]) -> Array:
    """Euclidean distance in cells to the nearest cell that is not free: first along the columns,
    then the lower envelope of parabolas along the rows, all columns at once (Meijster et al. 2000).
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


def way(floor: Floor, start: Array, goal: Array, radius: float) -> Array:
    """Corner points (n, 2) in m of a way from `start` to `goal` (2,) for a body of that half width.

    Both ends may be nearer to things than the radius, as somebody at a basin is: there the body
    squeezes out to the nearest cell that is wide enough. Raises NoWay.
    """
    wide = floor.clearance >= radius - 1e-9
    first, last = (_entry(floor, wide, np.asarray(end, float)[:2]) for end in (start, goal))
    cells = _cheapest(floor, wide, first, last, radius)
    points = np.array([floor.middle(cell) for cell in cells])
    points = np.concatenate([[np.asarray(start)[:2]], points, [np.asarray(goal)[:2]]])
    return _straightened(floor, points, radius)


def parts(floor: Floor, radius: float) -> NDArray[np.int64]:
    """(nx, ny): the number, from 1, of the part of the floor that each cell is in: a body of that
    half width gets everywhere in one part and to no other. 0 where it does not fit."""
    wide = floor.clearance >= radius - 1e-9
    nx, ny = wide.shape
    free, part, number = wide.tolist(), np.zeros((nx, ny), np.int64).tolist(), 0
    for first in np.argwhere(wide).tolist():
        if part[first[0]][first[1]]:
            continue
        number += 1
        part[first[0]][first[1]] = number
        queue = [first]
        while queue:
            x, y = queue.pop()
            for i, j in ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)):
                if 0 <= i < nx and 0 <= j < ny and free[i][j] and not part[i][j]:
                    part[i][j] = number
                    queue.append((i, j))
    return np.array(part, np.int64).reshape(nx, ny)


def entry(floor: Floor, radius: float, point: Array) -> tuple[int, int]:
    """The cell with room for a body of that half width that is nearest to a point (2,), where its
    way begins or ends. Raises NoWay."""
    return _entry(floor, floor.clearance >= radius - 1e-9, np.asarray(point, float)[:2])


def _entry(floor: Floor, wide: NDArray[np.bool_], point: Array) -> tuple[int, int]:
    """The wide cell that is nearest to a point. Raises NoWay where there is none."""
    cells = np.argwhere(wide)
    if not len(cells):
        raise NoWay("there is no room for anybody", point)
    places = floor.low + (cells + 0.5) * floor.size
    x, y = cells[int(np.argmin(((places - point) ** 2).sum(axis=1)))].tolist()
    return x, y


def _cheapest(
    floor: Floor,
    wide: NDArray[np.bool_],
    first: tuple[int, int],
    last: tuple[int, int],
    radius: float,
) -> list[tuple[int, int]]:
    """The cells of the cheapest way. Raises NoWay."""
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
    raise NoWay("there is no way", floor.middle((int(nearest[0]), int(nearest[1]))))


def _straightened(floor: Floor, points: Array, radius: float) -> Array:
    """Without the corners that a walker cuts: never nearer to things than the way itself gets."""
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
    """The least clearance on the straight line."""
    steps = max(2, int(np.linalg.norm(b - a) / floor.size * 2) + 1)
    return float(_clearances(floor, a + (b - a) * np.linspace(0, 1, steps)[:, None]).min())


def length(points: Array) -> float:
    """m, of a way's corner points (n, 2)."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
