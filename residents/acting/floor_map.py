# SPDX-License-Identifier: GPL-3.0-or-later
"""The map of a home's floors: regions, doors, and the paths between them.

Shut doors divide the floor of a storey into regions. A path leads from region to region through
doors. A side of a door is +1 or −1, as `Door.side` returns it.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array
from .path_search import Floor, NoPath, find_path, regions, yaw_to
from .places import DOOR, Door, Places

# The detour that a person accepts to open one door less, m.
DOOR_COST_M = 3.0
# Shut leaves are lengthened at both ends, so that no path leads through a gap at the jambs, m.
JAMB = 0.1
# Distance between the swing of a leaf and the middle of the person who opens it, m.
ARC = 0.30
# Preferred distances from walls and from the handle, for a person at a door, m.
ELBOW, ARM = 0.42, 0.50
# The openings of the doors that are open, by name.
Open = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Spot:
    """Where a person stands to open or shut a door: position (2,) in m, and yaw in rad."""

    at: Array
    yaw: float


@dataclass(frozen=True, eq=False)
class FloorWithPerson(Floor):
    """A floor on which a person is an obstacle, too.

    Attributes
    ----------
    whole : Floor
        The floor without the person.
    point : array, shape (2,)
        The person's position, m.
    radius : float
        The radius of the circle that the person occupies, m.
    """

    whole: Floor
    point: Array
    radius: float

    @cached_property
    def clearance(self) -> Array:
        """The distance (nx, ny) from each cell to the nearest obstacle or to the person, m."""
        middles = [
            self.low[axis] + (np.arange(self.free.shape[axis]) + 0.5) * self.size - self.point[axis]
            for axis in (0, 1)
        ]
        away = np.hypot(middles[0][:, None], middles[1][None]) - self.radius
        clear: Array = np.minimum(self.whole.clearance, away)
        return clear


class FloorMap:
    """The floors of a home, its doors, and the paths between them.

    All results are cached and hold for all days. A day of the sample home takes 2.6 s of CPU to
    act. It would take 13 s without cached results of `spot`, 9 s without `floor`, and 6 s without
    `find_path`. Without `regions`, it would take minutes. The Atelier home takes 4 % longer if
    `in_swing` is not cached.
    """

    def __init__(self, places: Places) -> None:
        self.places = places
        self._floors: dict[object, Floor] = {}
        self._regions: dict[tuple[int, float], NDArray[np.int64]] = {}
        self._spots: dict[tuple[str, float, float], Spot | None] = {}
        self._paths: dict[object, Array | NoPath] = {}
        self._swings: dict[str, Array] = {}

    # Floors.

    def floor(self, storey: int, opened: Open) -> Floor:
        """Return the floor of a storey on which door leaves are obstacles.

        `opened` has the openings of the doors that are open. All other doors are shut.
        """
        key = storey, tuple(sorted(opened.items()))
        if key not in self._floors:
            floor = self.places.storeys[storey].floor
            free = floor.free.copy()
            for door in self.places.doors.values():
                if door.use == DOOR and door.storey == storey:
                    _block_cells(
                        floor, free, _leaf_points(door, opened.get(door.name, door.closed))
                    )
            self._floors[key] = replace(floor, free=free)
        return self._floors[key]

    def regions(self, storey: int, radius: float) -> NDArray[np.int64]:
        """Return the number of each cell's region if all doors are shut, shape (nx, ny).

        A region is connected free floor. The number is 0 where a body of `radius` m does not fit.
        """
        key = storey, radius
        if key not in self._regions:
            self._regions[key] = regions(self.floor(storey, {}), radius)
        return self._regions[key]

    def region_at(self, storey: int, point: Array, radius: float) -> int:
        """Return the number of the region at a point, or of the nearest region within a metre.

        Return 0 if no region is that near.
        """
        regions, floor = self.regions(storey, radius), self.floor(storey, {})
        x, y = floor.cell(point)
        if regions[x, y]:
            return int(regions[x, y])
        reach = int(1.0 / floor.size)
        low = np.maximum([x - reach, y - reach], 0)
        near = regions[low[0] : x + reach + 1, low[1] : y + reach + 1]
        cells = np.argwhere(near > 0)
        if not len(cells):
            return 0
        off = floor.low + (cells + low + 0.5) * floor.size - np.asarray(point)[:2]
        first = cells[int(np.argmin(np.hypot(*off.T)))]
        return int(near[first[0], first[1]])

    # Doors.

    def spot(self, door: Door, side: float, radius: float) -> Spot | None:
        """Return where a person stands on one side of a door to move it.

        The leaf does not sweep over this point, and the handle is in reach. Return None if no
        person fits on that side, as inside a cupboard.
        """
        key = door.name, side, radius
        if key not in self._spots:
            self._spots[key] = self._find_spot(door, side, radius)
        return self._spots[key]

    def _find_spot(self, door: Door, side: float, radius: float) -> Spot | None:
        first, along, ahead = door_axes(door, side)
        floor, regions = self.floor(door.storey, {}), self.regions(door.storey, radius)
        here = 0
        for off in np.arange(radius, 1.0, floor.size):
            here = here or int(regions[floor.cell(first + along * door.width / 2 + ahead * off)])
        if not here:
            return None
        u, v = (
            a.ravel()
            for a in np.meshgrid(np.arange(0.2, door.width + 0.75, 0.05), np.arange(0.3, 1.1, 0.05))
        )
        points = first + u[:, None] * along + v[:, None] * ahead
        handle = door.handle_at(door.closed)[:2]
        cost = np.abs(np.hypot(*(points - handle).T) - ARM)
        if side < 0:
            cost += 0.7 * np.abs(u - 0.62 * door.width)
        cells = np.array([floor.cell(point) for point in points])
        cost += 2.0 * np.maximum(0.0, ELBOW - floor.clearance[cells[:, 0], cells[:, 1]])
        fits = regions[cells[:, 0], cells[:, 1]] == here
        if side > 0 and not door.slides:
            fits &= np.hypot(u, v) >= door.width + ARC
        if not fits.any():
            return None
        point = points[int(np.argmin(np.where(fits, cost, np.inf)))]
        return Spot(point, yaw_to(point, first + 0.72 * door.width * along))

    def spot_or_estimate(self, door: Door, side: float, radius: float) -> Spot:
        """Return the result of `spot` or, if that is None, an estimate from the door's size."""
        found = self.spot(door, side, radius)
        if found is not None:
            return found
        first, along, ahead = door_axes(door, side)
        point = first + 0.6 * door.width * along + 0.55 * ahead
        if side > 0 and not door.slides:
            point = first + 0.6 * door.width * along + (door.width + ARC) * ahead
        return Spot(point, yaw_to(point, first + 0.72 * door.width * along))

    def inner_side(self, door: Door, radius: float) -> float:
        """Return the side of an entrance from which most places can be reached."""
        counts = {}
        for side in (1.0, -1.0):
            spot = self.spot(door, side, radius)
            reached = (
                set() if spot is None else self._reachable_regions(door.storey, spot.at, radius)
            )
            counts[side] = sum(
                place.storey == door.storey
                and self.region_at(place.storey, place.at, radius) in reached
                for place in self.places.places.values()
            )
        return max(counts, key=lambda side: counts[side])

    def _reachable_regions(
        self, storey: int, start: Array, radius: float, outside: bool = False
    ) -> set[int]:
        """Return the numbers of the regions that can be reached from a point through doors.

        If `outside` is True, paths may also lead through entrances.
        """
        reached: set[int] = set()
        new = [self.region_at(storey, start, radius)]
        while new:
            region = new.pop()
            if region and region not in reached:
                reached.add(region)
                new += [
                    beyond
                    for door, _, beyond in self.doors_from(storey, region, radius)
                    if outside or not door.entrance
                ]
        return reached

    def crossing(self, door: Door, side: float, radius: float, opened: Open) -> Array:
        """Return the corner points (n, 2) of the path through an open door, starting on `side`.

        It begins and ends at the points where a person stands to move the door.
        """
        ends = [self.spot_or_estimate(door, one, radius).at for one in (side, -side)]
        try:
            return self.find_path(
                door.storey, ends[0], ends[1], radius, {**opened, door.name: door.open}
            )
        except NoPath:
            first, along, ahead = door_axes(door, side)
            middle = first + 0.55 * door.width * along
            return np.array([ends[0], middle + 0.3 * ahead, middle - 0.3 * ahead, ends[1]])

    def in_swing(self, door: Door, point: Array, margin: float) -> bool:
        """Return whether a door leaf, while it opens, passes within `margin` m of a point (2,)."""
        if door.name not in self._swings:
            stands = [door.line(w) for w in np.linspace(door.closed, door.open, 9)]
            self._swings[door.name] = np.concatenate(stands)
        return bool((np.hypot(*(self._swings[door.name] - point).T) < margin).any())

    # Paths.

    def find_path(
        self, storey: int, start: Array, goal: Array, radius: float, opened: Open,
        other: Array | None = None,
    ) -> Array:  # fmt: skip
        """Return the corner points (n, 2) of a path between two points of a storey.

        Parameters
        ----------
        storey : int
            The storey's index; 0 is the lowest.
        start, goal : array, shape (2,)
            The ends, m.
        radius : float
            Half of the walker's width, m.
        opened : mapping of str to float
            The openings of the open doors, rad or m.
        other : array, shape (2,), optional
            The position of a person to walk around.

        Raises
        ------
        NoPath
            If the goal cannot be reached without moving a door.
        """
        points = _pair(start), _pair(goal), _pair(other)
        key = storey, tuple(sorted(opened.items())), points, radius
        if key not in self._paths:
            floor = self.floor(storey, opened)
            if other is not None:
                floor = FloorWithPerson(floor.low, floor.size, floor.free, floor, other, radius)
            try:
                self._paths[key] = find_path(floor, start, goal, radius)
            except NoPath as error:
                self._paths[key] = error
        found = self._paths[key]
        if isinstance(found, NoPath):
            raise found
        return found

    def doors_between(
        self, storey: int, start: Array, goal: Array, radius: float, opened: Open
    ) -> list[tuple[Door, float]] | None:
        """Return the doors on the cheapest way between two points.

        The cost of a way is its length plus `DOOR_COST_M` for each shut door.

        Parameters
        ----------
        storey : int
            The storey's index; 0 is the lowest.
        start, goal : array, shape (2,)
            The points, m.
        radius : float
            Half of the walker's width, m.
        opened : mapping of str to float
            The openings of the open doors, rad or m.

        Returns
        -------
        list of tuple, or None
            The doors in the order of passing, open ones included. Each comes with the side from
            which the walker arrives. None if there is no way.
        """
        wanted = self.region_at(storey, goal, radius)
        begun = self.region_at(storey, start, radius)
        found: list[tuple[Door, float]] = []
        queue = [(0.0, 0, begun, np.asarray(start)[:2], found)]
        seen: set[int] = set()
        count = 0
        while queue and wanted and begun:
            cost, _, region, here, found = heapq.heappop(queue)
            if region == wanted:
                return found
            if region in seen:
                continue
            seen.add(region)
            for door, side, beyond in self.doors_from(storey, region, radius):
                if beyond in seen:
                    continue
                middle = door.middle
                length = float(np.hypot(*(middle - here)))
                length += 0.0 if door.name in opened else DOOR_COST_M
                if beyond == wanted:
                    length += float(np.hypot(*(np.asarray(goal)[:2] - middle)))
                count += 1
                heapq.heappush(
                    queue, (cost + length, count, beyond, middle, [*found, (door, side)])
                )
        return None

    def doors_from(self, storey: int, region: int, radius: float) -> list[tuple[Door, float, int]]:
        """Return the doors that lead out of a region: door, side, and number of the next region.

        The side, 1 or −1, is the side of the door that faces this region.
        """
        floor, regions = self.floor(storey, {}), self.regions(storey, radius)
        found = []
        for door in self.places.doors.values():
            if door.use != DOOR or door.storey != storey:
                continue
            spots = {side: self.spot(door, side, radius) for side in (1.0, -1.0)}
            for side, spot in spots.items():
                other = spots[-side]
                if spot is None or other is None or regions[floor.cell(spot.at)] != region:
                    continue
                if (beyond := int(regions[floor.cell(other.at)])) != region:
                    found.append((door, side, beyond))
        return found

    def nearest_reachable(self, storey: int, start: Array, goal: Array, radius: float) -> Array:
        """Return the point (2,) nearest to `goal` that a person at `start` can walk to.

        All doors count as open.
        """
        regions, floor = self.regions(storey, radius), self.floor(storey, {})
        reached = self._reachable_regions(storey, start, radius, outside=True)
        cells = np.argwhere(np.isin(regions, sorted(reached)))
        if not len(cells):
            return np.asarray(start)[:2]
        points = floor.low + (cells + 0.5) * floor.size
        nearest: Array = points[int(np.argmin(((points - np.asarray(goal)[:2]) ** 2).sum(axis=1)))]
        return nearest


def door_axes(door: Door, side: float) -> tuple[Array, Array, Array]:
    """Return the axes of a shut door on the floor as three arrays (2,).

    They are the hinge's position (m), and unit vectors along the leaf and from the leaf towards
    `side`.
    """
    first, last = door.line(door.closed, 2)
    along = (last - first) / max(math.hypot(*(last - first)), 1e-9)
    ahead = np.array([-along[1], along[0]])
    middle = (first + last) / 2
    return first, along, ahead if door.side(middle + 0.3 * ahead) == side else -ahead


def _pair(point: Array | None) -> tuple[float, float] | None:
    return None if point is None else (float(point[0]), float(point[1]))


def _leaf_points(door: Door, opening: float) -> Array:
    """Return closely spaced points (n, 2) along a leaf on the floor."""
    first, last = door.line(opening, 2)
    if opening == door.closed:
        out = (last - first) / max(math.hypot(*(last - first)), 1e-9) * JAMB
        first, last = first - out, last + out
    count = max(2, int(math.hypot(*(last - first)) / 0.02))
    points: Array = first + (last - first) * np.linspace(0, 1, count)[:, None]
    return points


def _block_cells(floor: Floor, free: NDArray[np.bool_], points: Array) -> None:
    """Mark the cells of the mask `free` that have one of the points (n, 2) as not free."""
    index = np.floor((points - floor.low) / floor.size).astype(int)
    index = index[((index >= 0) & (index < free.shape)).all(axis=1)]
    free[index[:, 0], index[:, 1]] = False
