# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways through a home: from point to point, and which doors are to be opened for it.

With all its doors shut a storey falls into parts; a way leads from part to part through doors.
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
from .places import DOOR, Door, Places
from .ways import EASY_M, Floor, NoWay, parts, way

# How much longer than the shortest a way may be for a door less to open, m.
TROUBLE = 3.0
# How far a shut leaf is drawn out at its ends, so that nobody slips through at the jambs, m.
JAMB = 0.1
# Between the edge of a leaf that opens and the middle of who stands there, m.
ARC = 0.30
# What somebody would like to keep to walls at a door, and to its handle, m.
ELBOW, ARM = 0.42, 0.50
# How far before a corner a walker begins to turn, m.
ROUNDING = 0.45
# Doors that stand open, and how far.
Open = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Spot:
    """Where a person stands (2,) to move a door, and the yaw there."""

    at: Array
    yaw: float


@dataclass(frozen=True, eq=False)
class Around(Floor):
    """A floor on which somebody stands at a point (2,), as wide as a radius (m)."""

    whole: Floor
    point: Array
    radius: float

    @cached_property
    def clearance(self) -> Array:
        middles = [
            self.low[axis] + (np.arange(self.free.shape[axis]) + 0.5) * self.size - self.point[axis]
            for axis in (0, 1)
        ]
        away = np.hypot(middles[0][:, None], middles[1][None]) - self.radius
        clear: Array = np.minimum(self.whole.clearance, away)
        return clear


class Ground:
    """What is found is kept as long as the Ground, which does for many days. A day of the sample
    home takes 2.6 s of CPU to act; without spots 13, without floors 9, without ways 6, without
    parts minutes. The Atelier home takes 4 % more without swings."""

    def __init__(self, places: Places) -> None:
        self.places = places
        self._floors: dict[object, Floor] = {}
        self._parts: dict[tuple[int, float], NDArray[np.int64]] = {}
        self._spots: dict[tuple[str, float, float], Spot | None] = {}
        self._ways: dict[object, Array | NoWay] = {}
        self._swings: dict[str, Array] = {}

    # --- floors -----------------------------------------------------------------------------
    def floor(self, storey: int, opened: Open) -> Floor:
        """The floor with leaves as they stand: the doors that are not `opened` are shut."""
        key = storey, tuple(sorted(opened.items()))
        if key not in self._floors:
            floor = self.places.storeys[storey].floor
            free = floor.free.copy()
            for door in self.places.doors.values():
                if door.use == DOOR and door.storey == storey:
                    _stand_in(floor, free, _leaf(door, opened.get(door.name, door.closed)))
            self._floors[key] = replace(floor, free=free)
        return self._floors[key]

    def parts(self, storey: int, radius: float) -> NDArray[np.int64]:
        """(nx, ny): which part a cell is in with all doors shut, from 1; 0 where nobody fits."""
        key = storey, radius
        if key not in self._parts:
            self._parts[key] = parts(self.floor(storey, {}), radius)
        return self._parts[key]

    def part_at(self, storey: int, point: Array, radius: float) -> int:
        """The part of the cell nearest to a point; 0 where there is none within a metre."""
        parts, floor = self.parts(storey, radius), self.floor(storey, {})
        x, y = floor.cell(point)
        if parts[x, y]:
            return int(parts[x, y])
        reach = int(1.0 / floor.size)
        low = np.maximum([x - reach, y - reach], 0)
        near = parts[low[0] : x + reach + 1, low[1] : y + reach + 1]
        cells = np.argwhere(near > 0)
        if not len(cells):
            return 0
        off = floor.low + (cells + low + 0.5) * floor.size - np.asarray(point)[:2]
        first = cells[int(np.argmin(np.hypot(*off.T)))]
        return int(near[first[0], first[1]])

    # --- doors ------------------------------------------------------------------------------
    def spot(self, door: Door, side: float, radius: float) -> Spot | None:
        """A spot on one side of a door from which a person moves it: clear of its swing, in reach
        of the handle. None without room, as inside a cupboard."""
        key = door.name, side, radius
        if key not in self._spots:
            self._spots[key] = self._found_spot(door, side, radius)
        return self._spots[key]

    def _found_spot(self, door: Door, side: float, radius: float) -> Spot | None:
        first, along, ahead = door_axes(door, side)
        floor, parts = self.floor(door.storey, {}), self.parts(door.storey, radius)
        here = 0
        for off in np.arange(radius, 1.0, floor.size):
            here = here or int(parts[floor.cell(first + along * door.width / 2 + ahead * off)])
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
        fits = parts[cells[:, 0], cells[:, 1]] == here
        if side > 0 and not door.slides:
            fits &= np.hypot(u, v) >= door.width + ARC
        if not fits.any():
            return None
        point = points[int(np.argmin(np.where(fits, cost, np.inf)))]
        return Spot(point, yaw_to(point, first + 0.72 * door.width * along))

    def spot_before(self, door: Door, side: float, radius: float) -> Spot:
        """The spot before a door on one side of it. Where the floor there is unknown, as outside
        the home, the door's size gives it."""
        found = self.spot(door, side, radius)
        if found is not None:
            return found
        first, along, ahead = door_axes(door, side)
        point = first + 0.6 * door.width * along + 0.55 * ahead
        if side > 0 and not door.slides:
            point = first + 0.6 * door.width * along + (door.width + ARC) * ahead
        return Spot(point, yaw_to(point, first + 0.72 * door.width * along))

    def inside(self, door: Door, radius: float) -> float:
        """The side of an entrance that most places are on."""
        counts = {}
        for side in (1.0, -1.0):
            spot = self.spot(door, side, radius)
            reached = set() if spot is None else self._reached(door.storey, spot.at, radius)
            counts[side] = sum(
                place.storey == door.storey
                and self.part_at(place.storey, place.at, radius) in reached
                for place in self.places.places.values()
            )
        return max(counts, key=lambda side: counts[side])

    def _reached(self, storey: int, start: Array, radius: float, outside: bool = False) -> set[int]:
        """The parts that can be come to, all doors opened; without going out, or also `outside`."""
        reached: set[int] = set()
        new = [self.part_at(storey, start, radius)]
        while new:
            part = new.pop()
            if part and part not in reached:
                reached.add(part)
                new += [
                    beyond
                    for door, _, beyond in self.doors_of(storey, part, radius)
                    if outside or not door.entrance
                ]
        return reached

    def crossing(self, door: Door, side: float, radius: float, opened: Open) -> Array:
        """Corner points (n, 2) from where one stands on that side to where one stands on the other,
        through the open door."""
        ends = [self.spot_before(door, one, radius).at for one in (side, -side)]
        try:
            return self.way(door.storey, ends[0], ends[1], radius, {**opened, door.name: door.open})
        except NoWay:
            first, along, ahead = door_axes(door, side)
            middle = first + 0.55 * door.width * along
            return np.array([ends[0], middle + 0.3 * ahead, middle - 0.3 * ahead, ends[1]])

    def in_swing(self, door: Door, point: Array, margin: float) -> bool:
        """Whether a leaf on its way comes nearer to a point (2,) than the margin."""
        if door.name not in self._swings:
            stands = [door.line(w) for w in np.linspace(door.closed, door.open, 9)]
            self._swings[door.name] = np.concatenate(stands)
        return bool((np.hypot(*(self._swings[door.name] - point).T) < margin).any())

    # --- ways -------------------------------------------------------------------------------
    def way(
        self, storey: int, start: Array, goal: Array, radius: float, opened: Open,
        other: Array | None = None,
    ) -> Array:  # fmt: skip
        """Corner points (n, 2) with leaves as they stand, around another who stands at a point.
        Raises NoWay."""
        points = _pair(start), _pair(goal), _pair(other)
        key = storey, tuple(sorted(opened.items())), points, radius
        if key not in self._ways:
            floor = self.floor(storey, opened)
            if other is not None:
                floor = Around(floor.low, floor.size, floor.free, floor, other, radius)
            try:
                self._ways[key] = way(floor, start, goal, radius)
            except NoWay as error:
                self._ways[key] = error
        found = self._ways[key]
        if isinstance(found, NoWay):
            raise found
        return found

    def doors_between(
        self, storey: int, start: Array, goal: Array, radius: float, opened: Open
    ) -> list[tuple[Door, float]] | None:
        """The doors on the way, each with the side that one comes from; None where there is no way.
        Doors that stand open are among them."""
        wanted = self.part_at(storey, goal, radius)
        begun = self.part_at(storey, start, radius)
        found: list[tuple[Door, float]] = []
        queue = [(0.0, 0, begun, np.asarray(start)[:2], found)]
        seen: set[int] = set()
        count = 0
        while queue and wanted and begun:
            cost, _, part, here, found = heapq.heappop(queue)
            if part == wanted:
                return found
            if part in seen:
                continue
            seen.add(part)
            for door, side, beyond in self.doors_of(storey, part, radius):
                if beyond in seen:
                    continue
                middle = door.middle
                length = float(np.hypot(*(middle - here)))
                length += 0.0 if door.name in opened else TROUBLE
                if beyond == wanted:
                    length += float(np.hypot(*(np.asarray(goal)[:2] - middle)))
                count += 1
                heapq.heappush(
                    queue, (cost + length, count, beyond, middle, [*found, (door, side)])
                )
        return None

    def doors_of(self, storey: int, part: int, radius: float) -> list[tuple[Door, float, int]]:
        """The doors out of a part: the side they are on from there, and the part beyond."""
        floor, parts = self.floor(storey, {}), self.parts(storey, radius)
        found = []
        for door in self.places.doors.values():
            if door.use != DOOR or door.storey != storey:
                continue
            spots = {side: self.spot(door, side, radius) for side in (1.0, -1.0)}
            for side, spot in spots.items():
                other = spots[-side]
                if spot is None or other is None or parts[floor.cell(spot.at)] != part:
                    continue
                if (beyond := int(parts[floor.cell(other.at)])) != part:
                    found.append((door, side, beyond))
        return found

    def nearest(self, storey: int, start: Array, goal: Array, radius: float) -> Array:
        """The point (2,) next to a goal that can be reached from a start, all doors opened."""
        parts, floor = self.parts(storey, radius), self.floor(storey, {})
        reached = self._reached(storey, start, radius, outside=True)
        cells = np.argwhere(np.isin(parts, sorted(reached)))
        if not len(cells):
            return np.asarray(start)[:2]
        points = floor.low + (cells + 0.5) * floor.size
        nearest: Array = points[int(np.argmin(((points - np.asarray(goal)[:2]) ** 2).sum(axis=1)))]
        return nearest


def door_axes(door: Door, side: float) -> tuple[Array, Array, Array]:
    """The hinge of a shut door on the floor, the direction along the leaf, and the one straight
    away from it to a side; each (2,)."""
    first, last = door.line(door.closed, 2)
    along = (last - first) / max(math.hypot(*(last - first)), 1e-9)
    ahead = np.array([-along[1], along[0]])
    middle = (first + last) / 2
    return first, along, ahead if door.side(middle + 0.3 * ahead) == side else -ahead


def _pair(point: Array | None) -> tuple[float, float] | None:
    return None if point is None else (float(point[0]), float(point[1]))


def yaw_to(start: Array, end: Array) -> float:
    return math.atan2(end[1] - start[1], end[0] - start[0])


def dense(points: Array, spacing: float = 0.03) -> Array:
    """Points (m, 2) along a way of corner points (n, 2), n > 1."""
    gaps = np.hypot(*np.diff(points, axis=0).T)
    points = points[np.concatenate([[True], gaps > 1e-6])]
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, s[-1], max(2, int(s[-1] / spacing) + 1))
    return np.column_stack([np.interp(at, s, points[:, k]) for k in (0, 1)])


def rounded(floor: Floor, points: Array) -> Array:
    """A way of corner points (n, 2) as dense points (m, 2), its corners as arcs (quadratic Béziers)
    as wide as there is room for."""
    arcs, t = [points[:1]], np.linspace(0, 1, 9)[:, None]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        into, away = before - corner, after - corner
        lengths = math.hypot(*into), math.hypot(*away)
        if min(lengths) < 1e-6:
            continue
        trim = min(ROUNDING, 0.48 * lengths[0], 0.48 * lengths[1])
        room = min(_room(floor, corner[None]), EASY_M + 0.25) - 0.04
        for _ in range(6):
            a, b = corner + into / lengths[0] * trim, corner + away / lengths[1] * trim
            arc = (1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t**2 * b
            if _room(floor, arc) >= room:
                break
            trim *= 0.6
        arcs.append(arc)
    return dense(np.concatenate([*arcs, points[-1:]]))


def _room(floor: Floor, points: Array) -> float:
    cells = np.array([floor.cell(point) for point in points])
    return float(floor.clearance[cells[:, 0], cells[:, 1]].min())


def _leaf(door: Door, opening: float) -> Array:
    """Points (n, 2) that a leaf stands on."""
    first, last = door.line(opening, 2)
    if opening == door.closed:
        out = (last - first) / max(math.hypot(*(last - first)), 1e-9) * JAMB
        first, last = first - out, last + out
    count = max(2, int(math.hypot(*(last - first)) / 0.02))
    points: Array = first + (last - first) * np.linspace(0, 1, count)[:, None]
    return points


def _stand_in(floor: Floor, free: NDArray[np.bool_], points: Array) -> None:
    index = np.floor((points - floor.low) / floor.size).astype(int)
    index = index[((index >= 0) & (index < free.shape)).all(axis=1)]
    free[index[:, 0], index[:, 1]] = False
