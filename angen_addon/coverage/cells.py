# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells on a floor, and what rays among the solids tell of them, in steps that can be given up."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array
from ..scene.home import EvaluatedHome

Mask = NDArray[np.bool_]
# m above the floor: under the heads of doors and over what one could look across.
OVER_M = 1.9
# What rises less is the floor itself, a rug or a threshold; what lies deeper is another floor.
RUG_M, PIT_M = 0.1, 0.3
MOST_CELLS = 250_000
# Rays that are cast between two moments at which the work can be given up.
CASTS_AT_ONCE = 2000

S = TypeVar("S")
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


def saying(told: S, work: Steps[T]) -> Generator[S, None, T]:
    """Tells the same before each step of the work, and hands on what it returns."""
    while True:
        yield told
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def finished(work: Steps[T]) -> T:
    """Does the work at once, and returns its result."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


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
