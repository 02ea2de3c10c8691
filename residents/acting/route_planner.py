# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way a person can go at the present time, and where the person can stand.

A side of a door is +1 or −1, as `Door.side` returns it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...sensor_logic.model import Array
from ..body.skeleton import Build, Sort
from .activity_steps import ActivityStep
from .actor import Actor
from .floor_map import Spot
from .home_in_use import HomeInUse
from .path_search import NoPath, resample, round_corners
from .places import Door, Place

# Half of the width that a walking person needs, m.
HALF_WIDTH = {Sort.OLDER_ADULT: 0.25, Sort.ADULT: 0.25, Sort.CHILD: 0.20, Sort.CAT: 0.10}
WITH_FRAME = 0.30
# Distance that a waiting person keeps from the door or place that others come out of, m.
ASIDE = 1.2
# Who steps aside tries up to TRIED points, SPACED m apart, at least ROOM_TO_PASS m from the other's
# path.
SPACED, TRIED, ROOM_TO_PASS = 0.2, 24, 0.5


def half_width(build: Build) -> float:
    """Return half of the width that a walking person needs, m."""
    return WITH_FRAME if build.frame else HALF_WIDTH[build.sort]


class RoutePlanner:
    """Finds ways and standpoints for a person, from the present position and state of the home.

    The parameter `step` of its methods is the step for which the person walks, named in errors.

    Attributes
    ----------
    actor : Actor
        The person.
    home : HomeInUse
        The home, shared with the other persons.
    radius : float
        Half of the width that the person needs, m.
    """

    def __init__(self, actor: Actor, home: HomeInUse) -> None:
        self.actor, self.home = actor, home
        self.radius = half_width(actor.build)

    def spot_at_door(self, door: Door, side: float) -> Spot:
        """Return where the person stands on one side of a door to move it."""
        return self.home.floor_map.spot_or_estimate(door, side, self.radius)

    def inner_side(self, door: Door) -> float:
        """Return the side of an entrance that is in the home."""
        return self.home.floor_map.inner_side(door, self.radius)

    def distance_to(self, point: Array) -> float:
        """Return the distance from the person to a point (2,), m."""
        return float(np.hypot(*(point - self.actor.position)))

    def open_doors(self) -> dict[str, float]:
        """Return the openings of the open doors of the person's storey, by name."""
        return self.home.open_doors(self.actor.storey)

    def _doors_between(self, goal: Array) -> list[tuple[Door, float]] | None:
        """Return the doors on the way to a point of this storey, or None; see `FloorMap`."""
        actor = self.actor
        return self.home.floor_map.doors_between(
            actor.storey, actor.position, goal, self.radius, self.open_doors()
        )

    def find_path(
        self, goal: Array, opened: Mapping[str, float], other: Array | None = None
    ) -> Array:
        """Return a path to a point without moving a door; see `FloorMap.find_path`."""
        actor = self.actor
        return self.home.floor_map.find_path(
            actor.storey, actor.position, goal, self.radius, opened, other
        )

    # Ways.

    def doors_on_way(
        self, step: ActivityStep, goal: Array, storey: int
    ) -> list[tuple[Door, float]]:
        """Return the doors on the way to a point, each with the side from which the person arrives.

        Raises `InputError` if there is no way.
        """
        actor = self.actor
        if storey != actor.storey:
            raise step.error("it is on another floor, and residents do not climb stairs")
        doors = self._doors_between(goal)
        if doors is None:
            x, y = self.home.floor_map.nearest_reachable(storey, actor.position, goal, self.radius)
            raise step.error(
                f"{actor.name!r} cannot reach it from {actor.last_place!r}; "
                f"the nearest point that can be reached is ({x:.2f}, {y:.2f}) m"
            )
        return doors

    def path_through_leaves(self, step: ActivityStep, goal: Array) -> Array:
        """Return the path to a point as if all doors were shut.

        It is for a person between open door leaves, which are then ignored. Raises `InputError` if
        there is no path either.
        """
        try:
            return self.find_path(goal, {})
        except NoPath as error:
            x, y = error.nearest
            raise step.error(
                f"{self.actor.name!r} cannot reach it; "
                f"the nearest point that can be reached is ({x:.2f}, {y:.2f}) m"
            ) from None

    def path_around(self, goal: Array, other: Array) -> Array | None:
        """Return a path (n, 2) around a person who stands at the point `other`, or None."""
        try:
            path = self.find_path(goal, self.open_doors(), other)
        except NoPath:
            return None
        return path if self.home.traffic.find_clash(self.actor, path) is None else None

    # Where to stand.

    def nearest_entrance(self, step: ActivityStep) -> tuple[Door, float]:
        """Return the nearest entrance, and its side that is in the home.

        Raises `InputError` if the person can reach none.
        """
        reachable = []
        for door in self.home.places.entrances:
            side = self.inner_side(door)
            spot = self.spot_at_door(door, side)
            between = self._doors_between(spot.at)
            if between is not None:
                reachable.append((len(between), self.distance_to(spot.at), door, side))
        if not reachable:
            raise step.error(
                f"{self.actor.name!r} cannot reach an entrance from {self.actor.last_place!r}"
            )
        _, _, door, side = min(reachable, key=lambda entry: entry[:2])
        return door, side

    def spot_for_leaf(self, step: ActivityStep, door: Door) -> Spot:
        """Return where the person stands to move a door leaf; raise `InputError` without room."""
        place = self.home.places.places.get(door.name)
        if place is not None and door.slides:
            return Spot(place.at[:2], place.yaw)
        both = (self.home.floor_map.spot(door, side, self.radius) for side in (1.0, -1.0))
        spots = [spot for spot in both if spot is not None]
        if not spots and place is not None:
            return Spot(place.at[:2], place.yaw)
        if not spots:
            raise step.error("there is no room to stand before it")

        def effort(spot: Spot) -> float:
            between = self._doors_between(spot.at)
            return (99.0 if between is None else 5.0 * len(between)) + self.distance_to(spot.at)

        return min(spots, key=effort)

    def waiting_point(self, step: ActivityStep, place: Place) -> Array:
        """Return a point (2,) at which the person waits for a place.

        The point is before the last door on the way or, without doors, before the place. No door
        leaf sweeps over it. Without such a point, return the start of the last part of the way.
        """
        floor_map, home = self.home.floor_map, self.home
        doors = self.doors_on_way(step, place.at[:2], place.storey)
        start, goal = self.actor.position, place.at[:2]
        if doors:
            goal = self.spot_at_door(*doors[-1]).at
            if len(doors) > 1:
                door, side = doors[-2]
                start = self.spot_at_door(door, -side).at
        try:
            path = floor_map.find_path(
                place.storey, start, goal, self.radius, home.open_doors(place.storey)
            )
        except NoPath:
            return self.actor.position
        points = round_corners(floor_map.floor(place.storey, {}), path)[::-1]
        for point in points:
            swings = any(
                floor_map.in_swing(leaf, point, self.radius + 0.1)
                for leaf in home.places.doors.values()
                if leaf.storey == place.storey
            )
            if not swings and float(np.hypot(*(point - goal))) >= ASIDE:
                return point
        return start

    def spot_aside(self, other: Actor, path: Array) -> Array | None:
        """Return the nearest reachable point (2,) beside the path (n, 2) of `other`, or None.

        The point can be behind a door.
        """
        floor_map, storey, here = self.home.floor_map, self.actor.storey, self.actor.position
        floor, path = floor_map.floor(storey, self.open_doors()), resample(path, 0.1)
        every = max(round(SPACED / floor.size), 1)
        cells = np.argwhere(floor.clearance[::every, ::every] >= self.radius) * every
        points = [floor.low + (cells + 0.5) * floor.size]
        region = floor_map.region_at(storey, here, self.radius)
        points += [
            self.spot_at_door(door, -side).at[None]
            for door, side, _ in floor_map.doors_from(storey, region, self.radius)
            if not door.entrance
        ]
        every_point = np.concatenate(points)
        off = np.hypot(*(every_point[:, None] - path).transpose(2, 0, 1)).min(axis=1)
        free = every_point[off > ROOM_TO_PASS]
        order = np.argsort(np.hypot(*(free - here).T), kind="stable")[:TRIED]
        return next((free[k] for k in order if self._can_reach(free[k], other)), None)

    def _can_reach(self, point: Array, other: Actor) -> bool:
        """Return whether this person can walk to a point, or to the first shut door before it.

        This is False if somebody is in the way.
        """
        actor, home = self.actor, self.home
        doors = self._doors_between(point)
        if doors is None:
            return False
        shut = [(door, side) for door, side in doors if not home.stands_open(door, actor)]
        if len(shut) > 1 or any(home.is_open(door) for door, _ in shut):
            return False
        for door, side in shut:
            point = self.spot_at_door(door, side).at
        there = other.body.positions_at(np.array([actor.now]))[0]
        try:
            path = self.find_path(point, self.open_doors(), there)
        except NoPath:
            return False
        return home.traffic.find_clash(actor, path) is None
