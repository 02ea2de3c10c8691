# SPDX-License-Identifier: GPL-3.0-or-later
"""How a person walks through the home: through doors, around others, to free places.

Methods that take simulated time are generators. A yield lets other people move: of all persons, the
one whose time `now` is earliest goes on. So when a person looks, the positions of the others are
known. A side of a door is +1 or −1, as `Door.side` returns it.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from ...sensor_logic.model import Array
from ..body.skeleton import Build
from .actor import Actor
from .home_in_use import HomeInUse, Occupant
from .path_search import NoPath, length, resample, round_corners
from .places import LIE, SIT, Door, Place
from .timeline import STANDING, WALKING, Wait
from .walking_frame import FETCH_M, Standpoint, parking_on_path
from .words import ActivityStep

Process = Generator[None, None, None]
# How long a person waits for others before squeezing past, and how often the person looks, s.
PATIENCE, GLANCE = 20.0, 0.5
# Distance that a waiting person keeps from the door or place that others come out of, m.
ASIDE = 1.2
# Two people who block each other notice after AGREED s that one must step aside. For that, up to
# TRIED points are tested, SPACED m apart.
AGREED, SPACED, TRIED = 2.0, 0.2, 24
# Distance from the other's path when stepping aside, m.
ROOM_TO_PASS = 0.5


class ActivityAbandoned(Exception):
    """Raised when an activity's time is over while the person still waits for others."""


class Navigator(Actor):
    """A person who finds ways through the home, waits for others, and reserves places and doors."""

    def __init__(self, name: str, build: Build, home: HomeInUse, now: float) -> None:
        super().__init__(name, build, home, now)
        # Since when this person waits for a place, its name, and who uses it.
        self._waits: tuple[float, str, str] | None = None
        self._key = ""  # the string under which this person has reserved a place
        self.until = math.inf  # end of the present segment
        self.step: ActivityStep | None = None  # the present step
        # The standpoints on arrival at a place, in order.
        self._standpoints: list[Standpoint] = []

    def wait_briefly(self) -> Process:
        """Wait `GLANCE` s, or step aside for somebody who needs to pass.

        Raises `ActivityAbandoned` if the activity is over.
        """
        if self.now >= self.until:
            raise ActivityAbandoned
        other = self._blocked_person()
        if other is None or not (yield from self._step_aside(other)):
            self.stay_until(self.now + GLANCE)
            yield

    def key(self, place: Place) -> str:
        """Return the name under which this person reserves a place.

        Cats have names of their own, so that a cat waits only for cats.
        """
        return f"cat {place.name}" if self.build.is_cat else self.home.reservation_key(place)

    def go_to_place(self, step: ActivityStep, place: Place) -> Process:
        """Wait until a place is free, walk to it and stand there."""
        key = self.key(place)
        if not self.home.is_free(key, self):
            self._waits = self.now, place.name, self.home.holder_of(key)
            yield from self._walk_to_place(step, place, self._key, short_of=True)
            while not self.home.is_free(key, self):
                yield from self.wait_briefly()
            self.end_wait(came=True)
        self.home.reserve(key, self)
        before, self._key = self._key, key
        self._standpoints = [(place.at[:2], place.yaw)]
        if place.use in (SIT, LIE):
            self._standpoints.append(self.seat_approach(place)[:2])
        yield from self._walk_to_place(step, place, before if before != key else "")
        self._standpoints = []
        self.set_posture(STANDING, place.name)

    def end_wait(self, came: bool) -> None:
        """Record the wait for a place, if there is one; `came` is whether the place is free."""
        if self._waits is not None:
            since, place, other = self._waits
            self.home.waits.append(Wait(since, self.now, self.name, place, other, came))
            self._waits = None

    def abandon(self) -> None:
        """Abandon the activity, and end all reservations of places except the present one."""
        self.wanted_path, self.is_cornered = None, False
        place = self.home.places.places.get(self.place)
        self._key = "" if place is None else self.key(self.home.place_for(place, self.name))
        self.home.release_all_but(self._key, self)

    def _walk_to_place(
        self, step: ActivityStep, place: Place, earlier_key: str, short_of: bool = False
    ) -> Process:
        """Walk to a place or, if `short_of`, to a point where the person waits for it.

        On the way, end the reservation named `earlier_key`.
        """
        if self.build.is_cat:
            doors = self._doors_on_way(step, place.at[:2], place.storey)
            while not all(self.home.stands_open(door, self) for door, _ in doors):
                yield from self.wait_briefly()
        self.rise()
        goal, yaw = self._waiting_point(step, place) if short_of else (place.at[:2], place.yaw)
        yield from self.walk_to_point(step, goal, yaw, place.storey, earlier_key)

    def walk_to_point(
        self, step: ActivityStep, goal: Array, yaw: float | None, storey: int, earlier_key: str = ""
    ) -> Process:
        """Walk to a point (2,) through doors.

        Parameters
        ----------
        step : ActivityStep
            The step for which the person walks, named in errors.
        goal : array, shape (2,)
            The point, m.
        yaw : float or None
            The direction in which the person looks at the end, rad; None for any.
        storey : int
            The storey's index; 0 is the lowest.
        earlier_key : str, optional
            The name under which the earlier place is reserved. The reservation ends after the
            first door that the person has opened, or at the point.
        """
        self.rise()
        for door, side in self._doors_on_way(step, goal, storey):
            if self.home.stands_open(door, self):
                continue
            spot = self.home.floor_map.spot_or_estimate(door, side, self.radius)
            yield from self._walk_without_doors(step, spot.at, None)
            yield from self.pass_door(door, side)
            self._release(earlier_key)
            yield
        yield from self._walk_without_doors(step, goal, yaw)
        self._release(earlier_key)

    def _release(self, key: str) -> None:
        """End the reservation named `key`; do nothing if `key` is ""."""
        if key:
            self.home.release(key, self)
            if self._key == key:
                self._key = ""

    def _doors_on_way(
        self, step: ActivityStep, goal: Array, storey: int
    ) -> list[tuple[Door, float]]:
        """Return the doors on the way to a point, each with the side from which the person arrives.

        Raises `InputError` if there is no way.
        """
        opened = self.home.open_doors(self.storey)
        if storey != self.storey:
            raise step.error("it is on another floor, and residents do not climb stairs")
        floor_map = self.home.floor_map
        found = floor_map.doors_between(storey, self.position, goal, self.radius, opened)
        if found is None:
            x, y = floor_map.nearest_reachable(storey, self.position, goal, self.radius)
            raise step.error(
                f"{self.name!r} cannot reach it from {self.last_place!r}; "
                f"the nearest point that can be reached is ({x:.2f}, {y:.2f}) m"
            )
        return found

    def _waiting_point(self, step: ActivityStep, place: Place) -> tuple[Array, float | None]:
        """Return a point (2,) at which the person waits for a place, and a yaw or None.

        The point is before the last door on the way or, without doors, before the place. No door
        leaf sweeps over it. Without such a point, return the start of the last part of the way.
        """
        floor_map, home = self.home.floor_map, self.home
        doors = self._doors_on_way(step, place.at[:2], place.storey)
        start, goal = self.position, place.at[:2]
        if doors:
            door, side = doors[-1]
            goal = floor_map.spot_or_estimate(door, side, self.radius).at
            if len(doors) > 1:
                door, side = doors[-2]
                start = floor_map.spot_or_estimate(door, -side, self.radius).at
        try:
            path = floor_map.find_path(
                place.storey, start, goal, self.radius, home.open_doors(place.storey)
            )
        except NoPath:
            return self.position, None
        points = round_corners(floor_map.floor(place.storey, {}), path)[::-1]
        for point in points:
            swings = any(
                floor_map.in_swing(leaf, point, self.radius + 0.1)
                for leaf in home.places.doors.values()
                if leaf.storey == place.storey
            )
            if not swings and float(np.hypot(*(point - goal))) >= ASIDE:
                return point, None
        return start, None

    def _walk_without_doors(self, step: ActivityStep, goal: Array, yaw: float | None) -> Process:
        """Walk to a point (2,) around other people, without opening doors."""
        yield
        if self.parked is not None and (
            yaw is None or float(np.hypot(*(goal - self.parked.at))) > FETCH_M
        ):
            yield from self._fetch_walking_frame()
        floor_map, opened = self.home.floor_map, self.home.open_doors(self.storey)
        until = self.now + PATIENCE
        while True:
            try:
                path = floor_map.find_path(self.storey, self.position, goal, self.radius, opened)
            except NoPath:
                path = self._path_through_leaves(step, goal)
            clash = self.home.find_clash(self, path, self.build.speed)
            if clash is None:
                break
            if self.now >= until:
                self._check_can_pass(clash.who, path)
                break
            if clash.is_standing_at(self.now):
                around = self._path_around(goal, clash.at)
                # Squeeze past at once if waiting does not help.
                if around is not None or clash.until >= until:
                    path = path if around is None else around
                    break
            if (yield from self._wait(path)):
                until = self.now + PATIENCE
        self.wanted_path = None
        if self.build.frame and self.parked is None and yaw is not None and self._standpoints:
            path = self._leave_walking_frame_on_path(path, opened)
        self._walk(path, yaw, opened)

    def _leave_walking_frame_on_path(self, path: Array, opened: dict[str, float]) -> Array:
        """Leave the walking frame on the path if it does not fit at the destination.

        Return the remaining points (n, 2) of the path.
        """
        floor = self.home.floor_map.floor(self.storey, opened)
        points = round_corners(floor, path) if length(path) > 0.05 else path
        found = parking_on_path(floor, points, self._standpoints, self.build)
        if found is None:
            return path
        k, yaw = found
        self._walk(points[: k + 1], yaw, opened)
        self.leave_walking_frame()
        rest: Array = points[k:]
        return rest

    def _fetch_walking_frame(self) -> Process:
        if self.parked is None:
            return
        opened = self.home.open_doors(self.storey)
        at, yaw = self.parked.at, self.parked.yaw
        try:
            path = self.home.floor_map.find_path(
                self.storey, self.position, at, self.radius, opened
            )
        except NoPath:
            path = np.array([self.position, at])
        self._walk(path, yaw, opened)
        self.take_walking_frame()
        yield

    # People in each other's way.

    def _wait(self, path: Array) -> Generator[None, None, bool]:
        """Wait `GLANCE` s for others to leave a path (n, 2); return True after stepping aside.

        If two people wait for each other, the one who has waited less steps aside.
        """
        if self.wanted_path is None:
            self.waiting_since = self.now
        self.wanted_path = resample(path, 0.1)
        other = self._blocked_person()
        if other is not None and (yield from self._step_aside(other)):
            return True
        self.stay_until(self.now + GLANCE)
        yield
        return False

    def _blocked_person(self) -> Occupant | None:
        """Return the person for whom this one should step aside now, or None."""
        other = self.home.longest_waiting(self)
        if other is None or self.now < other.waiting_since + AGREED:
            return None
        first = self.wanted_path is not None and (self.waiting_since, self.name) < (
            other.waiting_since,
            other.name,
        )
        if first and not other.is_cornered:
            return None
        return other

    def _check_can_pass(self, other: Occupant, path: Array) -> None:
        """Raise `InputError` if neither this person nor `other` can step aside."""
        if other.is_cornered and self.step is not None and self._spot_aside(other, path) is None:
            raise self.step.error(
                f"{self.name!r} and {other.name!r} meet where they cannot pass each other, and "
                "neither can step aside; give one of them another time or place"
            )

    def _step_aside(self, other: Occupant) -> Generator[None, None, bool]:
        """Step aside until the other person has passed, at most for `PATIENCE` s.

        Return False if there is no room to step aside.
        """
        spot = None if other.wanted_path is None else self._spot_aside(other, other.wanted_path)
        self.is_cornered = spot is None
        if spot is None or self.step is None:
            return False
        self.wanted_path = None
        yield from self.walk_to_point(self.step, spot, None, self.storey)
        until = self.now + PATIENCE
        while self.now < until and (
            other.wanted_path is not None or self.home.will_come_near(other, self)
        ):
            self.stay_until(self.now + GLANCE)
            yield
        return True

    def _spot_aside(self, other: Occupant, wanted_path: Array) -> Array | None:
        """Return the nearest reachable point (2,) beside the path of `other`, or None.

        The point can be behind a door.
        """
        floor_map, wanted_path = self.home.floor_map, resample(wanted_path, 0.1)
        floor = floor_map.floor(self.storey, self.home.open_doors(self.storey))
        every = max(round(SPACED / floor.size), 1)
        cells = np.argwhere(floor.clearance[::every, ::every] >= self.radius) * every
        points = [floor.low + (cells + 0.5) * floor.size]
        part = floor_map.region_at(self.storey, self.position, self.radius)
        points += [
            floor_map.spot_or_estimate(door, -side, self.radius).at[None]
            for door, side, _ in floor_map.doors_from(self.storey, part, self.radius)
            if not door.entrance
        ]
        every_point = np.concatenate(points)
        off = np.hypot(*(every_point[:, None] - wanted_path).transpose(2, 0, 1)).min(axis=1)
        free = every_point[off > ROOM_TO_PASS]
        order = np.argsort(np.hypot(*(free - self.position).T), kind="stable")[:TRIED]
        return next((free[k] for k in order if self._can_reach(free[k], other)), None)

    def _can_reach(self, point: Array, other: Occupant) -> bool:
        """Return whether this person can walk to a point, or to the first shut door before it.

        This is False if somebody is in the way.
        """
        if self.step is None:
            return False
        there = other.positions_at(np.array([self.now]))[0]
        opened = self.home.open_doors(self.storey)
        doors = self.home.floor_map.doors_between(
            self.storey, self.position, point, self.radius, opened
        )  # fmt: skip
        if doors is None:
            return False
        shut = [(door, side) for door, side in doors if not self.home.stands_open(door, self)]
        if len(shut) > 1 or any(self.home.is_open(door) for door, _ in shut):
            return False
        for door, side in shut:
            point = self.home.floor_map.spot_or_estimate(door, side, self.radius).at
        try:
            path = self.home.floor_map.find_path(
                self.storey, self.position, point, self.radius, opened, there
            )  # fmt: skip
        except NoPath:
            return False
        return self.home.find_clash(self, path, self.build.speed) is None

    def _walk(self, path: Array, yaw: float | None, opened: dict[str, float]) -> None:
        """Walk along corner points (n, 2), with the corners rounded."""
        if float(np.hypot(*np.diff(path, axis=0).T).sum()) < 0.05:
            self.walk(path[:1], yaw)
            return
        self.set_posture(WALKING)
        self.walk(round_corners(self.home.floor_map.floor(self.storey, opened), path), yaw)
        self.set_posture(STANDING)

    def _path_through_leaves(self, step: ActivityStep, goal: Array) -> Array:
        """Return the path to a point as if all doors were shut.

        It is for a person between open door leaves, which are then ignored. Raises `InputError` if
        there is no path either.
        """
        try:
            return self.home.floor_map.find_path(self.storey, self.position, goal, self.radius, {})
        except NoPath as error:
            x, y = error.nearest
            raise step.error(
                f"{self.name!r} cannot reach it; "
                f"the nearest point that can be reached is ({x:.2f}, {y:.2f}) m"
            ) from None

    def _path_around(self, goal: Array, other: Array) -> Array | None:
        """Return a path (n, 2) around a person who stands at the point `other`, or None."""
        opened = self.home.open_doors(self.storey)
        try:
            path = self.home.floor_map.find_path(
                self.storey, self.position, goal, self.radius, opened, other
            )
        except NoPath:
            return None
        return path if self.home.find_clash(self, path, self.build.speed) is None else None

    def wait_for_door(self, door: Door) -> Process:
        """Wait until nobody else uses a door or is in the way of its leaf, then occupy the door."""
        until = self.now + PATIENCE
        while not self.home.can_move(door, self, self.now < until):
            yield from self.wait_briefly()
        self.home.occupy(door, self, math.inf)

    def pass_door(self, door: Door, side: float) -> Process:
        """Walk through a door, starting on the side `side` (+1 or −1).

        Afterwards, shut the door if it is an entrance or was shut before.
        """
        floor_map, home = self.home.floor_map, self.home
        yield from self.wait_for_door(door)
        near = floor_map.spot_or_estimate(door, side, self.radius)
        if self.step is not None and float(np.hypot(*(near.at - self.position))) > SPACED:
            yield from self._walk_without_doors(self.step, near.at, None)
        opened, found_open = home.open_doors(self.storey), home.is_open(door)
        if not found_open:
            self._walk(np.array([self.position, near.at]), near.yaw, opened)
            self.move_leaf(door, door.open)
        path = floor_map.crossing(door, side, self.radius, opened)
        until = self.now + PATIENCE
        while self.now < until and home.find_clash(self, path, self.build.speed) is not None:
            yield from self._wait(path)
        self.wanted_path = None
        far = floor_map.spot_or_estimate(door, -side, self.radius)
        self._walk(path, far.yaw, {**opened, door.name: door.open})
        if door.entrance or not found_open:
            self.move_leaf(door, door.closed)
        home.occupy(door, self, self.now)
