# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the places that residents cannot reach, and how far residents get on the way there."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array
from ...sensor_logic.progress import Doing, Work, finished
from .path_search import Floor, NoPath, entry, find_path, regions
from .places import BODY_M, Place, Places

# A place is out of reach if free floor for a body is farther away from it, m.
SQUEEZE_M = 0.6
# Cost factors of cells where a body does not fit, and of cells that are not free: the path then
# leads through a shut door rather than through a wall.
NARROW, THROUGH = 4.0, 30.0


@dataclass(frozen=True, eq=False)
class Unreached:
    """A place that cannot be reached.

    Attributes
    ----------
    place : Place
        The place.
    start : str
        The name of the door or place from which the search began.
    way : array, shape (n, 2)
        The path from there to the reachable point nearest to the place, m. Empty if the place is on
        another storey.
    short : float
        The distance from that point to the place, m.
    """

    place: Place
    start: str
    way: Array
    short: float

    @property
    def nearest(self) -> Array:
        """The last point (2,) of the path, m."""
        point: Array = self.way[-1]
        return point


def unreached(places: Places) -> list[Unreached]:
    """Return the places that an adult cannot reach, sorted by name."""
    return finished(unreached_in_steps(places))


def unreached_in_steps(places: Places) -> Work[list[Unreached]]:
    """Find the places that an adult cannot reach; yield the progress.

    Return the places sorted by name.
    """
    found, looked = [], 0
    home = places.entrances[0].storey if places.entrances else None
    for number, storey in enumerate(places.storeys):
        here = [place for place in places.places.values() if place.storey == number]
        start = _start_point(places, number, here, storey.floor)
        if start is None:
            continue
        name, point = start
        lost = []
        for place in here:
            yield Doing(looked / len(places.places))
            looked += 1
            if not _is_reached(storey.floor, point, place):
                lost.append(place)
        if home not in (None, number):
            entrance = next(door for door in places.entrances if door.storey == home)
            nowhere = np.empty((0, 2))
            found += [Unreached(place, entrance.name, nowhere, np.inf) for place in here]
        elif lost:
            ends = _partial_paths(storey.floor, point, lost)
            for place, points in zip(lost, ends, strict=True):
                short = float(np.linalg.norm(points[-1] - place.at[:2]))
                found.append(Unreached(place, name, points, short))
    return sorted(found, key=lambda lost: lost.place.name)


def _start_point(
    places: Places, number: int, candidates: list[Place], floor: Floor
) -> tuple[str, Array] | None:
    """Return the name and point (2,) from which a storey's places should be reachable.

    This is an entrance. Without one, it is the first place in the region with most places.
    """
    for door in places.entrances:
        if door.storey == number:
            return door.name, door.middle
    if not candidates:
        return None
    region = regions(floor, BODY_M)
    try:
        numbers = [int(region[entry(floor, BODY_M, place.at)]) for place in candidates]
    except NoPath:
        return candidates[0].name, candidates[0].at[:2]
    most = Counter(numbers).most_common(1)[0][0]
    first = candidates[numbers.index(most)]
    return first.name, first.at[:2]


def _is_reached(floor: Floor, start: Array, place: Place) -> bool:
    """Return whether a path leads to a place, or to a point at most `SQUEEZE_M` from it."""
    try:
        last = floor.middle(entry(floor, BODY_M, place.at))
        find_path(floor, start, place.at[:2], BODY_M)
    except NoPath:
        return False
    return float(np.linalg.norm(last - place.at[:2])) <= SQUEEZE_M


def _partial_paths(floor: Floor, start: Array, unreachable: list[Place]) -> list[Array]:
    """Return, for each place in `unreachable`, the path (n, 2) towards it up to the first obstacle.

    It is the reachable first part of the cheapest path, which may lead through obstacles.
    """
    try:
        first = entry(floor, BODY_M, start)
    except NoPath:
        return [start[None] for _ in unreachable]
    region = regions(floor, BODY_M)
    came = _predecessors(floor, region > 0, first)
    found = []
    for place in unreachable:
        here = floor.cell(place.at)
        while region[here] != region[first]:
            here = came[here]
        found.append(find_path(floor, start, floor.middle(here), BODY_M))
    return found


def _predecessors(
    floor: Floor, wide: NDArray[np.bool_], first: tuple[int, int]
) -> dict[tuple[int, int], tuple[int, int]]:
    """Return, for each cell, the cell before it on the cheapest path from `first` (Dijkstra).

    `wide` is the mask (nx, ny) of the cells where a body fits. All other cells cost more: NARROW
    times for a narrow free cell, THROUGH times for an obstacle.
    """
    price = np.where(wide, 1.0, np.where(floor.free, NARROW, THROUGH)).tolist()
    nx, ny = floor.free.shape
    cost, came = {first: 0.0}, {first: first}
    queue, done = [(0.0, first)], set()
    while queue:
        so_far, here = heapq.heappop(queue)
        if here in done:
            continue
        done.add(here)
        x, y = here
        for i, j in ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)):
            if 0 <= i < nx and 0 <= j < ny:
                total = so_far + (price[x][y] + price[i][j]) / 2.0
                if total < cost.get((i, j), math.inf):
                    cost[i, j], came[i, j] = total, here
                    heapq.heappush(queue, (total, (i, j)))
    return came
