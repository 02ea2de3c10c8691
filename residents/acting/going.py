# SPDX-License-Identifier: GPL-3.0-or-later
"""How a person goes about: through doors, past others, to places that nobody else has.

Methods that take time are generators. Whoever is earliest goes on: each `yield` lets the others
catch up, so that whom one meets is known.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from ...sensor_logic.model import Array
from ..body.skeleton import Build
from .actor import NEAR_M, Actor, At, parked_on
from .ground import dense, rounded
from .home import HomeInUse, Someone
from .places import LIE, SIT, Door, Place
from .timeline import STANDING, WALKING
from .ways import NoWay, length
from .words import ActivityStep

Taking = Generator[None, None, None]
# Seconds: how long somebody waits for others to get out of the way before squeezing past; how often
# one looks.
PATIENCE, GLANCE = 20.0, 0.5
# Somebody waits so far from where others come out, m.
ASIDE = 1.2
# Two who stand in each other's way find out that one has to go back, s; the points that are tried
# for it are so far apart, m, and not more.
AGREED, SPACED, TRIED = 2.0, 0.2, 24
# Who goes aside is so far off the way of the other, m.
ROOM_TO_PASS = 0.5


class GaveUp(Exception):
    """The activity ended before others made way."""


class Going(Actor):
    def __init__(self, name: str, build: Build, home: HomeInUse, now: float) -> None:
        super().__init__(name, build, home, now)
        self._key = ""  # what others cannot have meanwhile
        self.until = math.inf  # when what is being done ends
        self.step: ActivityStep | None = None  # what is being done
        # Where one stands and looks, one after the other, who arrives at a place.
        self._ends: list[At] = []

    def look_on(self) -> Taking:
        """Waits a little for others, aside where it bars their way. Raises GaveUp where the
        activity is over."""
        if self.now >= self.until:
            raise GaveUp
        other = self._in_the_way_of()
        if other is None or not (yield from self._go_aside(other)):
            self.stay(self.now + GLANCE)
            yield

    def key(self, place: Place) -> str:
        """Whoever is at a place has it; cats mind each other alone."""
        return f"cat {place.name}" if self.build.is_cat else self.home.key(place)

    def come_to(self, step: ActivityStep, place: Place) -> Taking:
        """Standing at a place that nobody else has."""
        key = self.key(place)
        if not self.home.is_free(key, self):
            yield from self._way(step, place, self._key, short_of=True)
            while not self.home.is_free(key, self):
                yield from self.look_on()
        self.home.take(key, self)
        before, self._key = self._key, key
        self._ends = [(place.at[:2], place.yaw)]
        if place.use in (SIT, LIE):
            self._ends.append(self.before(place)[:2])
        yield from self._way(step, place, before if before != key else "")
        self._ends = []
        self.be(STANDING, place.name)

    def stop(self) -> None:
        """Gives up: others may have what the person is not at."""
        self.wish, self.cornered = None, False
        place = self.home.places.places.get(self.place)
        self._key = "" if place is None else self.key(place)
        self.home.keep_only(self._key, self)

    def _way(self, step: ActivityStep, place: Place, leaves: str, short_of: bool = False) -> Taking:
        """To where one stands at a place; `leaves` what is then free for others. `short_of`: to
        where one waits for it."""
        if self.build.is_cat:
            doors = self._doors_to(step, place.at[:2], place.storey)
            while not all(self.home.stands_open(door, self) for door, _ in doors):
                yield from self.look_on()
        self.rise()
        goal, yaw = self._aside(step, place) if short_of else (place.at[:2], place.yaw)
        yield from self.to_point(step, goal, yaw, place.storey, leaves)

    def to_point(
        self, step: ActivityStep, goal: Array, yaw: float | None, storey: int, leaves: str = ""
    ) -> Taking:
        self.rise()
        for door, side in self._doors_to(step, goal, storey):
            if self.home.stands_open(door, self):
                continue
            spot = self.home.ground.spot_before(door, side, self.radius)
            yield from self._leg(step, spot.at, None)
            yield from self.through(door, side)
            self._release(leaves)
            yield
        yield from self._leg(step, goal, yaw)
        self._release(leaves)

    def _release(self, key: str) -> None:
        if key:
            self.home.release(key, self)
            if self._key == key:
                self._key = ""

    def _doors_to(self, step: ActivityStep, goal: Array, storey: int) -> list[tuple[Door, float]]:
        opened = self.home.left_open(self.storey)
        if storey != self.storey:
            raise step.error("it is on another floor, and no stairs are marked")
        ground = self.home.ground
        found = ground.doors_between(storey, self.here, goal, self.radius, opened)
        if found is None:
            x, y = ground.nearest(storey, self.here, goal, self.radius)
            raise step.error(
                f"{self.name!r} finds no way to it from {self.last_place!r}; "
                f"the nearest point that can be reached is ({x:.2f}, {y:.2f}) m"
            )
        return found

    def _aside(self, step: ActivityStep, place: Place) -> tuple[Array, float | None]:
        """The point where a person waits for a place: before the last door on the way or before the
        place, out of the swing of leaves; or where the person is, if that is nearer."""
        ground, home = self.home.ground, self.home
        doors = self._doors_to(step, place.at[:2], place.storey)
        start, goal = self.here, place.at[:2]
        if doors:
            door, side = doors[-1]
            goal = ground.spot_before(door, side, self.radius).at
            if len(doors) > 1:
                door, side = doors[-2]
                start = ground.spot_before(door, -side, self.radius).at
        try:
            path = ground.way(place.storey, start, goal, self.radius, home.left_open(place.storey))
        except NoWay:
            return self.here, None
        points = rounded(ground.floor(place.storey, {}), path)[::-1]
        for point in points:
            swings = any(
                ground.in_swing(leaf, point, self.radius + 0.1)
                for leaf in home.places.doors.values()
                if leaf.storey == place.storey
            )
            if not swings and float(np.hypot(*(point - goal))) >= ASIDE:
                return point, None
        return start, None

    def _leg(self, step: ActivityStep, goal: Array, yaw: float | None) -> Taking:
        """Walks to a point without opening doors, around people who stand there."""
        yield
        if self.parked is not None and (
            yaw is None or float(np.hypot(*(goal - self.parked.at))) > NEAR_M
        ):
            yield from self._fetch_frame()
        ground, opened = self.home.ground, self.home.left_open(self.storey)
        until = self.now + PATIENCE
        while True:
            try:
                path = ground.way(self.storey, self.here, goal, self.radius, opened)
            except NoWay:
                path = self._past_leaves(step, goal)
            clash = self.home.clash(self, path, self.build.speed)
            if clash is None:
                break
            if self.now >= until:
                self._check_room(clash.who, path)
                break
            if clash.stands(self.now):
                around = self._around(goal, clash.at)
                # Whom waiting does not help squeezes past at once.
                if around is not None or clash.until >= until:
                    path = path if around is None else around
                    break
            if (yield from self._wait(path)):
                until = self.now + PATIENCE
        self.wish = None
        if self.build.frame and self.parked is None and yaw is not None and self._ends:
            path = self._without_frame(path, opened)
        self._walk(path, yaw, opened)

    def _without_frame(self, path: Array, opened: dict[str, float]) -> Array:
        """The rest of a way (n, 2) after the walking frame was left on it, where it does not fit at
        the end."""
        floor = self.home.ground.floor(self.storey, opened)
        points = rounded(floor, path) if length(path) > 0.05 else path
        found = parked_on(floor, points, self._ends, self.build)
        if found is None:
            return path
        k, yaw = found
        self._walk(points[: k + 1], yaw, opened)
        self.leave_frame()
        rest: Array = points[k:]
        return rest

    def _fetch_frame(self) -> Taking:
        """Back to where it was left."""
        if self.parked is None:
            return
        opened = self.home.left_open(self.storey)
        at, yaw = self.parked.at, self.parked.yaw
        try:
            path = self.home.ground.way(self.storey, self.here, at, self.radius, opened)
        except NoWay:
            path = np.array([self.here, at])
        self._walk(path, yaw, opened)
        self.take_frame()
        yield

    # --- in each other's way --------------------------------------------------------------------
    def _wait(self, path: Array) -> Generator[None, None, bool]:
        """A moment, for others to get out of a path (n, 2). Where each waits for the other, who has
        waited less goes aside; whether that was done."""
        if self.wish is None:
            self.wished = self.now
        self.wish = dense(path, 0.1)
        other = self._in_the_way_of()
        if other is not None and (yield from self._go_aside(other)):
            return True
        self.stay(self.now + GLANCE)
        yield
        return False

    def _in_the_way_of(self) -> Someone | None:
        """The person who has waited long enough for this one to go aside, or None."""
        other = self.home.who_waits_for(self)
        if other is None or self.now < other.wished + AGREED:
            return None
        first = self.wish is not None and (self.wished, self.name) < (other.wished, other.name)
        if first and not other.cornered:
            return None
        return other

    def _check_room(self, other: Someone, path: Array) -> None:
        """Raises InputError where neither can go back for the other."""
        if other.cornered and self.step is not None and self._spot_aside(other, path) is None:
            raise self.step.error(
                f"{self.name!r} and {other.name!r} meet where they cannot pass each other, and "
                "neither can go back to where there is room; give one of them another time or place"
            )

    def _go_aside(self, other: Someone) -> Generator[None, None, bool]:
        """Steps aside until another has passed or patience ends; False without a place for it."""
        spot = None if other.wish is None else self._spot_aside(other, other.wish)
        self.cornered = spot is None
        if spot is None or self.step is None:
            return False
        self.wish = None
        yield from self.to_point(self.step, spot, None, self.storey)
        until = self.now + PATIENCE
        while self.now < until and (other.wish is not None or self.home.comes_near(other, self)):
            self.stay(self.now + GLANCE)
            yield
        return True

    def _spot_aside(self, other: Someone, wish: Array) -> Array | None:
        """The nearest point off the way (n, 2) that another wants to go, which one gets to without
        passing anybody; or behind a door."""
        ground, wish = self.home.ground, dense(wish, 0.1)
        floor = ground.floor(self.storey, self.home.left_open(self.storey))
        every = max(round(SPACED / floor.size), 1)
        cells = np.argwhere(floor.clearance[::every, ::every] >= self.radius) * every
        points = [floor.low + (cells + 0.5) * floor.size]
        part = ground.part_at(self.storey, self.here, self.radius)
        points += [
            ground.spot_before(door, -side, self.radius).at[None]
            for door, side, _ in ground.doors_of(self.storey, part, self.radius)
            if not door.entrance
        ]
        every_point = np.concatenate(points)
        off = np.hypot(*(every_point[:, None] - wish).transpose(2, 0, 1)).min(axis=1)
        free = every_point[off > ROOM_TO_PASS]
        order = np.argsort(np.hypot(*(free - self.here).T), kind="stable")[:TRIED]
        return next((free[k] for k in order if self._gets_to(free[k], other)), None)

    def _gets_to(self, point: Array, other: Someone) -> bool:
        """Whether the first part of the way to a point leads past nobody."""
        if self.step is None:
            return False
        there = other.where(np.array([self.now]))[0]
        opened = self.home.left_open(self.storey)
        doors = self.home.ground.doors_between(
            self.storey, self.here, point, self.radius, opened
        )  # fmt: skip
        if doors is None:
            return False
        shut = [(door, side) for door, side in doors if not self.home.stands_open(door, self)]
        if len(shut) > 1 or any(self.home.is_open(door) for door, _ in shut):
            return False
        for door, side in shut:
            point = self.home.ground.spot_before(door, side, self.radius).at
        try:
            path = self.home.ground.way(
                self.storey, self.here, point, self.radius, opened, there
            )  # fmt: skip
        except NoWay:
            return False
        return self.home.clash(self, path, self.build.speed) is None

    def _walk(self, path: Array, yaw: float | None, opened: dict[str, float]) -> None:
        if float(np.hypot(*np.diff(path, axis=0).T).sum()) < 0.05:
            self.walk(path[:1], yaw)
            return
        self.be(WALKING)
        self.walk(rounded(self.home.ground.floor(self.storey, opened), path), yaw)
        self.be(STANDING)

    def _past_leaves(self, step: ActivityStep, goal: Array) -> Array:
        """The way as if no door stood open: a leaf that is in the way is brushed aside."""
        try:
            return self.home.ground.way(self.storey, self.here, goal, self.radius, {})
        except NoWay as error:
            x, y = error.nearest
            raise step.error(
                f"{self.name!r} finds no way to it; "
                f"the nearest point that can be reached is ({x:.2f}, {y:.2f}) m"
            ) from None

    def _around(self, goal: Array, other: Array) -> Array | None:
        opened = self.home.left_open(self.storey)
        try:
            path = self.home.ground.way(self.storey, self.here, goal, self.radius, opened, other)
        except NoWay:
            return None
        return path if self.home.clash(self, path, self.build.speed) is None else None

    def wait_for(self, door: Door) -> Taking:
        """Until nobody else is at a door or where its leaf goes; others wait from then on."""
        until = self.now + PATIENCE
        while not self.home.may_move(door, self, self.now < until):
            yield from self.look_on()
        self.home.occupy(door, self, math.inf)

    def through(self, door: Door, side: float) -> Taking:
        """Walks through a door, from its side `side`. A door that was shut is shut again behind."""
        ground, home = self.home.ground, self.home
        yield from self.wait_for(door)
        near = ground.spot_before(door, side, self.radius)
        if self.step is not None and float(np.hypot(*(near.at - self.here))) > SPACED:
            yield from self._leg(self.step, near.at, None)
        opened, found_open = home.left_open(self.storey), home.is_open(door)
        if not found_open:
            self._walk(np.array([self.here, near.at]), near.yaw, opened)
            self.move_leaf(door, door.open)
        path = ground.crossing(door, side, self.radius, opened)
        until = self.now + PATIENCE
        while self.now < until and home.clash(self, path, self.build.speed) is not None:
            yield from self._wait(path)
        self.wish = None
        far = ground.spot_before(door, -side, self.radius)
        self._walk(path, far.yaw, {**opened, door.name: door.open})
        if door.entrance or not found_open:
            self.move_leaf(door, door.closed)
        home.occupy(door, self, self.now)
