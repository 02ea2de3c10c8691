# SPDX-License-Identifier: GPL-3.0-or-later
"""How a person walks through the home: through doors, around others, to free places.

Methods that take simulated time are generators. A yield lets other people move: of all persons, the
one whose time `now` is earliest goes on. So when a person looks, the positions of the others are
known. `route_planner` finds the ways.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence

import numpy as np

from ...sensor_logic.model import Array
from .activity_steps import ActivityStep
from .actor import Actor
from .hands import Hands
from .home_in_use import HomeInUse
from .path_search import NoPath, length, resample, round_corners
from .places import LIE, SIT, Door, Place
from .route_planner import RoutePlanner
from .timeline import STANDING, WALKING, Wait
from .walking_frame import FETCH_M, Standpoint, parking_on_path

Process = Generator[None, None, None]
# How long a person waits for others before squeezing past, and how often the person looks, s.
PATIENCE, GLANCE = 20.0, 0.5
# A person who is this near to the point where a door is moved stays where they are, m.
AT_DOOR = 0.2


class ActivityAbandoned(Exception):
    """Raised when an activity's time is over while the person still waits for others."""


class Navigator:
    """Walks a person through the home, waits for others, and reserves places and doors.

    The parameter `step` of its methods is the step for which the person walks, named in errors.

    Attributes
    ----------
    actor : Actor
        The person.
    hands : Hands
        The person's hands, which move the leaves of doors.
    planner : RoutePlanner
        Finds the ways.
    home : HomeInUse
        The home, shared with the other persons.
    deadline : float
        The end of the present activity, s. A person who then still waits abandons the activity.
    """

    def __init__(self, actor: Actor, hands: Hands, home: HomeInUse) -> None:
        self.actor, self.hands, self.home = actor, hands, home
        self.planner = RoutePlanner(actor, home)
        self.deadline = math.inf
        # Since when this person waits for a place, its name, and who uses it.
        self._waits: tuple[float, str, str] | None = None
        self._key = ""  # the name under which this person has reserved the present place

    # Places and their reservations.

    def _key_of(self, place: Place) -> str:
        """Return the name under which this person reserves a place.

        Cats have names of their own, so that a cat waits only for cats.
        """
        if self.actor.build.is_cat:
            return f"cat {place.name}"
        return self.home.reservation_key(place)

    def is_free(self, place: Place) -> bool:
        """Return whether this person can now reserve a place."""
        return self.home.is_free(self._key_of(place), self.actor)

    def reserve(self, place: Place) -> None:
        """Reserve a place at which the person is put at the start of a day."""
        self._key = self._key_of(place)
        self.home.reserve(self._key, self.actor)

    def release_place(self) -> None:
        """End the reservation of the present place; do nothing without one."""
        self._release(self._key)

    def _release(self, key: str) -> None:
        """End the reservation named `key`; do nothing if `key` is ""."""
        if key:
            self.home.release(key, self.actor)
            if self._key == key:
                self._key = ""

    def go_to_place(self, step: ActivityStep, place: Place) -> Process:
        """Wait until a place is free, walk to it and stand there."""
        actor, key = self.actor, self._key_of(place)
        if not self.home.is_free(key, actor):
            self._waits = actor.now, place.name, self.home.holder_of(key)
            yield from self._set_out(step, place)
            goal = self.planner.waiting_point(step, place)
            yield from self.walk_to_point(step, goal, None, place.storey, self._key)
            while not self.home.is_free(key, actor):
                yield from self.wait_briefly(step)
            self.end_wait(came=True)
        self.home.reserve(key, actor)
        before, self._key = self._key, key
        standpoints = [(place.at[:2], place.yaw)]
        if place.use in (SIT, LIE):
            standpoints.append(actor.seat_approach(place)[:2])
        yield from self._set_out(step, place)
        yield from self.walk_to_point(
            step, place.at[:2], place.yaw, place.storey, before if before != key else "",
            standpoints,
        )  # fmt: skip
        actor.set_posture(STANDING, place.name)

    def go_to_leaf(self, step: ActivityStep, door: Door) -> Process:
        """Wait until nobody else uses a door, drawer or curtain, occupy it and walk to it."""
        yield from self.wait_for_door(step, door)
        spot = self.planner.spot_for_leaf(step, door)
        if self.planner.distance_to(spot.at) > 0.3:
            yield from self.walk_to_point(step, spot.at, spot.yaw, door.storey, self._key)

    def end_wait(self, came: bool) -> None:
        """Record the wait for a place, if there is one; `came` is whether the place is free."""
        if self._waits is not None:
            since, place, other = self._waits
            wait = Wait(since, self.actor.now, self.actor.name, place, other, came)
            self.home.waits.append(wait)
            self._waits = None

    def abandon(self) -> None:
        """Abandon the activity, and end all reservations of places except the present one."""
        actor = self.actor
        self.end_wait(came=False)
        self.home.traffic.unblock(actor)
        self.home.traffic.record_cornered(actor, False)
        place = self.home.places.places.get(actor.place)
        self._key = "" if place is None else self._key_of(self.home.place_for(place, actor.name))
        self.home.release_all_but(self._key, actor)

    def _set_out(self, step: ActivityStep, place: Place) -> Process:
        """Rise to walk to a place; a cat first waits until all doors on the way are open."""
        if self.actor.build.is_cat:
            doors = self.planner.doors_on_way(step, place.at[:2], place.storey)
            while not all(self.home.stands_open(door, self.actor) for door, _ in doors):
                yield from self.wait_briefly(step)
        self.actor.rise()

    # Walking.

    def walk_to_point(
        self, step: ActivityStep, goal: Array, yaw: float | None, storey: int,
        earlier_key: str = "", standpoints: Sequence[Standpoint] = (),
    ) -> Process:  # fmt: skip
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
        standpoints : sequence of Standpoint, optional
            Where the person will stand at the point. A walking frame that does not fit there is
            left behind on the way.
        """
        self.actor.rise()
        for door, side in self.planner.doors_on_way(step, goal, storey):
            if self.home.stands_open(door, self.actor):
                continue
            spot = self.planner.spot_at_door(door, side)
            yield from self._walk_without_doors(step, spot.at, None)
            yield from self.pass_door(step, door, side)
            self._release(earlier_key)
            yield
        yield from self._walk_without_doors(step, goal, yaw, standpoints)
        self._release(earlier_key)

    def _walk_without_doors(
        self, step: ActivityStep, goal: Array, yaw: float | None,
        standpoints: Sequence[Standpoint] = (),
    ) -> Process:  # fmt: skip
        """Walk to a point (2,) around other people, without opening doors."""
        yield
        actor, traffic = self.actor, self.home.traffic
        parked = actor.parked_frame
        if parked is not None and (yaw is None or float(np.hypot(*(goal - parked.at))) > FETCH_M):
            yield from self.fetch_walking_frame()
        opened = self.planner.open_doors()
        until = actor.now + PATIENCE
        while True:
            try:
                path = self.planner.find_path(goal, opened)
            except NoPath:
                path = self.planner.path_through_leaves(step, goal)
            clash = traffic.find_clash(actor, path)
            if clash is None:
                break
            if actor.now >= until:
                self._check_can_pass(step, clash.who, path)
                break
            if clash.is_standing_at(actor.now):
                around = self.planner.path_around(goal, clash.at)
                # Squeeze past at once if waiting does not help.
                if around is not None or clash.until >= until:
                    path = path if around is None else around
                    break
            if (yield from self._wait(step, path)):
                until = actor.now + PATIENCE
        traffic.unblock(actor)
        if actor.build.frame and actor.parked_frame is None and yaw is not None and standpoints:
            path = self._leave_walking_frame_on_path(path, opened, standpoints)
        self._walk(path, yaw, opened)

    def _walk(self, path: Array, yaw: float | None, opened: Mapping[str, float]) -> None:
        """Walk along corner points (n, 2), with the corners rounded."""
        actor = self.actor
        if length(path) < 0.05:
            actor.walk(path[:1], yaw)
            return
        actor.set_posture(WALKING)
        actor.walk(round_corners(self.home.floor_map.floor(actor.storey, opened), path), yaw)
        actor.set_posture(STANDING)

    def _leave_walking_frame_on_path(
        self, path: Array, opened: Mapping[str, float], standpoints: Sequence[Standpoint]
    ) -> Array:
        """Leave the walking frame on the path if it does not fit at the destination.

        Return the remaining points (n, 2) of the path.
        """
        floor = self.home.floor_map.floor(self.actor.storey, opened)
        points = round_corners(floor, path) if length(path) > 0.05 else path
        parking = parking_on_path(floor, points, standpoints, self.actor.build)
        if parking is None:
            return path
        k, yaw = parking
        self._walk(points[: k + 1], yaw, opened)
        self.actor.leave_walking_frame()
        rest: Array = points[k:]
        return rest

    def fetch_walking_frame(self) -> Process:
        """Walk to the walking frame that was left behind, and take hold of it."""
        parked = self.actor.parked_frame
        if parked is None:
            return
        opened = self.planner.open_doors()
        try:
            path = self.planner.find_path(parked.at, opened)
        except NoPath:
            path = np.array([self.actor.position, parked.at])
        self._walk(path, parked.yaw, opened)
        self.actor.take_walking_frame()
        yield

    # Doors.

    def wait_for_door(self, step: ActivityStep, door: Door) -> Process:
        """Wait until nobody else uses a door or is in the way of its leaf, then occupy the door."""
        until = self.actor.now + PATIENCE
        while not self.home.can_move(door, self.actor, self.actor.now < until):
            yield from self.wait_briefly(step)
        self.home.occupy(door, self.actor, math.inf)

    def pass_door(self, step: ActivityStep, door: Door, side: float) -> Process:
        """Walk through a door, starting on the side `side` (+1 or −1).

        Afterwards, shut the door if it is an entrance or was shut before.
        """
        actor, home = self.actor, self.home
        yield from self.wait_for_door(step, door)
        near = self.planner.spot_at_door(door, side)
        if self.planner.distance_to(near.at) > AT_DOOR:
            yield from self._walk_without_doors(step, near.at, None)
        opened, found_open = self.planner.open_doors(), home.is_open(door)
        if not found_open:
            self._walk(np.array([actor.position, near.at]), near.yaw, opened)
            self.hands.move_leaf(door, door.open)
        path = home.floor_map.crossing(door, side, self.planner.radius, opened)
        until = actor.now + PATIENCE
        while actor.now < until and home.traffic.find_clash(actor, path) is not None:
            yield from self._wait(step, path)
        home.traffic.unblock(actor)
        far = self.planner.spot_at_door(door, -side)
        self._walk(path, far.yaw, {**opened, door.name: door.open})
        if door.entrance or not found_open:
            self.hands.move_leaf(door, door.closed)
        home.occupy(door, actor, actor.now)

    # People in each other's way.

    def wait_briefly(self, step: ActivityStep) -> Process:
        """Wait `GLANCE` s, or step aside for somebody who needs to pass.

        Raises `ActivityAbandoned` if the activity is over.
        """
        if self.actor.now >= self.deadline:
            raise ActivityAbandoned
        other = self.home.traffic.person_to_let_pass(self.actor)
        if other is None or not (yield from self._step_aside(step, other)):
            self.actor.stay_until(self.actor.now + GLANCE)
            yield

    def _wait(self, step: ActivityStep, path: Array) -> Generator[None, None, bool]:
        """Wait `GLANCE` s for others to leave a path (n, 2); return True after stepping aside."""
        self.home.traffic.block(self.actor, resample(path, 0.1))
        other = self.home.traffic.person_to_let_pass(self.actor)
        if other is not None and (yield from self._step_aside(step, other)):
            return True
        self.actor.stay_until(self.actor.now + GLANCE)
        yield
        return False

    def _check_can_pass(self, step: ActivityStep, other: Actor, path: Array) -> None:
        """Raise `InputError` if neither this person nor `other` can step aside."""
        if self.home.traffic.is_cornered(other) and self.planner.spot_aside(other, path) is None:
            raise step.error(
                f"{self.actor.name!r} and {other.name!r} meet where they cannot pass each other, "
                "and neither can step aside; give one of them another time or place"
            )

    def _step_aside(self, step: ActivityStep, other: Actor) -> Generator[None, None, bool]:
        """Step aside until the other person has passed, at most for `PATIENCE` s.

        Return False if there is no room to step aside.
        """
        actor, traffic = self.actor, self.home.traffic
        path = traffic.blocked_path(other)
        spot = None if path is None else self.planner.spot_aside(other, path)
        traffic.record_cornered(actor, spot is None)
        if spot is None:
            return False
        traffic.unblock(actor)
        yield from self.walk_to_point(step, spot, None, actor.storey)
        until = actor.now + PATIENCE
        while actor.now < until and (
            traffic.blocked_path(other) is not None or traffic.will_come_near(other, actor)
        ):
            actor.stay_until(actor.now + GLANCE)
            yield
        return True
