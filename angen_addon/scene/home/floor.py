# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the free floor of a home: the cells where a body can move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from ....sensor_logic.progress import Steps
from .evaluated_home import EvaluatedHome
from .rooms import Mask

# m above the floor: below the heads of doors, and above furniture that is no partition.
OVER_M = 1.9
# m. A surface up to RUG_M above the floor is the floor, a rug or a threshold. A surface that is
# PIT_M below it is another floor.
RUG_M, PIT_M = 0.1, 0.3
MOST_CELLS = 250_000
# The number of rays that are cast in one step of the work.
CASTS_AT_ONCE = 2000


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
    solids : (n,) array
        Numbers of the solids that are hit.
    """
    ranges, solids = np.empty(len(points)), np.empty(len(points), np.int64)
    for first in range(0, len(points), CASTS_AT_ONCE):
        part = slice(first, first + CASTS_AT_ONCE)
        starts = points[part] / home.metres
        ways = np.broadcast_to(direction, starts.shape)
        reach = np.full(len(starts), length / home.metres)
        ranges[part], solids[part] = home.caster.first_hits(home.rows, starts, ways, reach)
        yield
    return np.minimum(ranges * home.metres, length), solids


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
