# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a story from top to bottom and lays everything out in time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import cos, hypot, inf, radians, sin

import numpy as np
from angen_sensors.sensor_logic.residents.body import seat
from angen_sensors.sensor_logic.residents.body.build import ADULT
from angen_sensors.sensor_logic.residents.body.gait import Stand, Walk, footsteps, standing
from angen_sensors.sensor_logic.residents.body.pose import Pose
from angen_sensors.sensor_logic.residents.body.reach import (
    carrying,
    drinking,
    looking_around,
    reaching,
)
from angen_sensors.sensor_logic.residents.body.turns import ease
from angen_sensors.sensor_logic.residents.timeline import Clip, Gesture, Hold, Swing

from . import actions, plan
from .checks import along, distance_to_box, solids
from .film import Film
from .paths import (
    clearance,
    door_side,
    door_spot,
    handle_at,
    leaf_clear,
    place_yaw,
    rounded,
    route,
    yaw_between,
)
from .story import PROPS, SPOTS, START, STORY

REACH_TIME = 0.6
SWING_TIME = 1.7
CLEAR = 0.42  # between a leaf that falls shut and the body's middle, m
BESIDE = {"Coat": 0.08}  # rad by which what hangs far down is held away from the leg
SEAT_DISTANCE = seat.seat_distance(ADULT)
ARM_WAY = 1.2  # on the floor from the hips to what a hand, the trunk bent, can reach, m
# Where a prop is held, in its own frame; a prop without an entry cannot be in a story.
GRIPS = {"Bottle": (0.0, 0.0, 0.10), "Coat": (-0.09, 0.0, -0.03)}
_WALLS = tuple(box for name, box in solids() if name == "wall")


def _can_be_sat_on(place: plan.Place) -> bool:
    """Whether the seat is straight behind one who stands there: one sits down backwards."""
    if place.seat is None:
        return False
    yaw = place_yaw(place)
    dx, dy = place.x - place.seat[0], place.y - place.seat[1]
    ahead, beside = dx * cos(yaw) + dy * sin(yaw), dy * cos(yaw) - dx * sin(yaw)
    return abs(beside) <= 0.15 and ahead >= 0.40


SEATS = tuple(name for name, place in plan.PLACES.items() if _can_be_sat_on(place))


@dataclass(frozen=True)
class Hinged:
    """A thing's own door: hinge (x, y), yaws in degrees, its handle in the leaf's frame."""

    box: plan.Box  # the thing itself: what is inside is behind the door
    hinge: tuple[float, float]
    closed_yaw: float
    open_yaw: float
    handle: tuple[float, float, float]

    def handle_at(self, yaw: np.ndarray) -> np.ndarray:
        """Where the handle is (…, 3) at yaws (…,)."""
        c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
        u, v, z = self.handle
        x, y = self.hinge[0] + u * c - v * s, self.hinge[1] + u * s + v * c
        return np.stack([x, y, np.full_like(x, z)], -1)


_FRIDGE = plan.FURNITURE["Fridge"]
HINGED = {
    "Fridge door": Hinged(
        _FRIDGE, (_FRIDGE.x0, _FRIDGE.y0), 0.0, -105.0,
        (_FRIDGE.x1 - _FRIDGE.x0 - 0.05, -0.035, 1.12),
    )
}  # fmt: skip


class Director:
    """Where everybody and everything is while the story goes on."""

    def __init__(self, start: str) -> None:
        place = _known("START", "place", start, plan.PLACES)
        self.floor = plan.FLOOR_Z
        self.line = Film()
        self.now = 0.0
        self.stand = Stand.at(place.x, place.y, place_yaw(place))
        self.pose: Pose = standing(self.stand, self.floor)
        self.seat: plan.Place | None = None
        self.gate = ""  # the waypoint by which a narrow place is left
        self.doors = {name: door.closed_yaw for name, door in plan.DOORS.items()}
        self.opened_from: dict[str, float] = {}
        self.falling: dict[str, float] = {}  # doors that fall shut: since when they may
        self.entry = ""  # the entry that is being played, for error messages
        self.let_by: dict[str, str] = {}  # the entry that let a door fall shut
        self.things_open: set[str] = set()
        self.hands: dict[str, int] = {}
        self.grabbed: dict[str, float] = {}
        self.spots = {name: np.array(at) for name, at in SPOTS.items()}
        for prop, where in PROPS.items():
            _named("PROPS", "prop", prop, GRIPS)
            if where == "hand":
                self._into_hand(prop, 0)
            else:
                at = self.spots[_named("PROPS", "spot", where, self.spots)]
                self.line.props[prop] = [Hold(0.0, None, at)]

    # --- small pieces ---------------------------------------------------------------------
    def _clip(
        self, seconds: float, pose: Callable[[np.ndarray], Pose], still: bool = False
    ) -> None:  # fmt: skip
        self.line.body.clips.append(Clip(self.now, self.now + seconds, pose, still=still))
        self.now += seconds
        self.pose = pose(np.array([seconds]))

    def _stay(self, seconds: float) -> None:
        pose = self.pose
        self._clip(seconds, lambda _t: pose, still=True)

    def _gesture(
        self, start: float, end: float, rise: float, fall: float,
        apply: Callable[[Pose, np.ndarray, np.ndarray], Pose],
    ) -> None:  # fmt: skip
        self.line.body.gestures.append(Gesture(start, end, rise, fall, apply))

    def _reach(
        self, side: int, point: Callable[[np.ndarray], np.ndarray], start: float, end: float,
        rise: float = REACH_TIME, fall: float = 0.55, most: float = 1.0,
    ) -> None:  # fmt: skip
        slide = 0.12 if self.seat else -0.03
        self._gesture(
            start,
            end,
            rise,
            fall,
            lambda pose, t, w: reaching(pose, side, point(t), w, slide, most),
        )

    def _free_hand(self, point: np.ndarray) -> int:
        """The hand that is nearer to a point, or the one that holds nothing."""
        x, y = self.pose.pelvis[0, :2]
        yaw = self.pose.heading[0]
        left = -(point[0] - x) * sin(yaw) + (point[1] - y) * cos(yaw) > 0.02
        side = 0 if left else 1
        return 1 - side if side in self.hands.values() else side

    def _into_hand(self, prop: str, side: int) -> None:
        self.hands[prop] = side
        self.grabbed[prop] = self.now
        self.line.props.setdefault(prop, []).append(Hold(self.now, side))

    def _out_of_hand(self, prop: str, at: np.ndarray, when: float) -> None:
        side = self.hands.pop(prop)
        self.line.props[prop].append(Hold(when, None, at))
        self._gesture(
            self.grabbed[prop] - 0.4,
            when + 0.5,
            0.8,
            0.7,
            lambda pose, _t, w: carrying(pose, side, w, BESIDE.get(prop, 0.0)),
        )

    def _swing(self, name: str, start: float, before: float, after: float) -> float:
        end = start + SWING_TIME
        self.line.swings.setdefault(name, []).append(Swing(start, end, before, after))
        return end

    def _on_feet(self) -> None:
        if self.seat is not None:
            raise ValueError("the person sits: StandUp() first")

    def _check_reach(self, what: str, at: np.ndarray) -> None:
        """A ValueError where a hand cannot get at a point."""
        for name, thing in HINGED.items():
            if name not in self.things_open and distance_to_box(at[:2], thing.box) == 0.0:
                raise ValueError(f"{what} is behind the closed {name!r}")
        here = self.pose.pelvis[0, :2]
        away = hypot(*(at[:2] - here))
        if away > ARM_WAY:
            raise ValueError(f"{what} is {away:.2f} m away; in reach is {ARM_WAY} m")
        if any(distance_to_box(p, wall) == 0.0 for p in along(here, at[:2]) for wall in _WALLS):
            raise ValueError(f"{what} is behind a wall")

    # --- walking --------------------------------------------------------------------------
    def go(self, x: float, y: float, yaw: float, gate: str, speed: float = 1.1) -> None:
        """Walks to a point and turns to a yaw (radians)."""
        self._on_feet()
        start = self.stand.centre
        if hypot(x - start[0], y - start[1]) < 0.05:
            path = np.array([start])
        else:
            points: list[tuple[float, float]] = []
            here = start
            if self.gate and self.gate != gate:
                here = plan.WAYPOINTS[self.gate]
                points = [start]
            points += route(here, (x, y), gate, self.doors)
            path = rounded(points, self.doors)
        self.gate = gate if clearance((x, y), []) < 0.26 else ""
        steps = footsteps(self.stand, path, yaw)
        if len(steps) > 2:
            walk = Walk(steps, speed, self.floor)
            self.stand = walk.end
            self._clip(walk.duration, walk.pose)
        for name in list(self.falling):
            self._fall_shut(name)

    def _fall_shut(self, name: str) -> None:
        """Shuts a door behind the person, as soon as nobody is in its way."""
        door = plan.DOORS[name]
        times = np.arange(self.falling[name], self.now + SWING_TIME, 0.1)
        where = self.line.body.base(np.minimum(times, self.now)).pelvis[:, :2]
        count = int(SWING_TIME / 0.1)
        for k, t in enumerate(times):
            if t > self.now:
                return
            if door_side(name, where[k]) == self.opened_from[name]:
                continue
            if all(
                leaf_clear(name, door.open_yaw + (door.closed_yaw - door.open_yaw)
                           * float(ease(j / count)), where[min(k + j, len(where) - 1)]) > CLEAR
                for j in range(count + 1)
            ):  # fmt: skip
                self._swing(f"Door {name}", float(t), door.open_yaw, door.closed_yaw)
                self.doors[name] = door.closed_yaw
                del self.falling[name]
                return

    def walk(self, action: actions.Walk) -> None:
        place = _known(action, "place", action.place, plan.PLACES)
        self.go(place.x, place.y, place_yaw(place), place.waypoint, action.speed)

    # --- doors ----------------------------------------------------------------------------
    def _to_handle(self, name: str) -> float:
        """Steps to where the door can be moved from; returns the side."""
        here = self.stand.centre
        door = plan.DOORS[name]
        side = door_side(name, here)
        handle = handle_at(name, door.closed_yaw, side)
        near = hypot(here[0] - handle[0], here[1] - handle[1])
        u, v = here[0] - door.hinge[0], here[1] - door.hinge[1]
        out_of_swing = side < 0 or hypot(u, v) > door.leaf_width + 0.24
        yaw = yaw_between(here, handle[:2])
        if 0.4 < near < 0.75 and out_of_swing:
            turn = (yaw - self.stand.yaw + np.pi) % (2 * np.pi) - np.pi
            if abs(turn) > 0.7:
                self.go(*here, yaw, self.gate)
            return side
        self.go(*door_spot(name, side, self.doors), "")
        return side

    def open_door(self, action: actions.OpenDoor) -> None:
        door = _known(action, "door", action.door, plan.DOORS)
        name = action.door
        if self.doors[name] != door.closed_yaw:
            raise ValueError("the door is open already")
        side = self._to_handle(name)
        last = self.line.swings.get(f"Door {name}", [])
        if last and last[-1].end > self.now - 0.2:
            self._stay(last[-1].end - self.now + 0.2)
        self._move_leaf(name, side, door.closed_yaw, door.open_yaw)
        self.doors[name] = door.open_yaw
        self.opened_from[name] = side

    def close_door(self, action: actions.CloseDoor) -> None:
        door = _known(action, "door", action.door, plan.DOORS)
        name = action.door
        if self.doors[name] == door.closed_yaw:
            raise ValueError("the door is closed already")
        side = self._to_handle(name)
        self._move_leaf(name, side, door.open_yaw, door.closed_yaw)
        self.doors[name] = door.closed_yaw
        self.falling.pop(name, None)

    def _move_leaf(self, name: str, side: float, before: float, after: float) -> None:
        """A hand at the handle while the leaf is within reach: first or last part of its way."""
        door = plan.DOORS[name]
        handle = np.array(handle_at(name, door.closed_yaw, side))
        hand = self._free_hand(handle)
        opening = after != door.closed_yaw
        start = self.now + (REACH_TIME if opening else 0.1)
        end = self._swing(f"Door {name}", start, before, after)
        line = self.line

        def followed(yaw: np.ndarray) -> np.ndarray:
            # The hand stays behind softly where the leaf goes out of reach.
            limit = 42.0 if side > 0 else 28.0
            return door.closed_yaw - limit * np.tanh((door.closed_yaw - yaw) / limit)

        def grip(t: np.ndarray) -> np.ndarray:
            yaws = followed(line.door_yaw(name, t))
            return np.array([handle_at(name, yaw, side) for yaw in yaws])

        if opening:
            self._reach(hand, grip, self.now, start + 1.1, most=0.25)
            self._stay(end - self.now - 0.25)
        else:
            self._reach(hand, grip, end - 1.15, end + 0.55, most=0.25)
            self._stay(end - self.now + 0.25)

    def let_door_close(self, action: actions.LetDoorClose) -> None:
        door = _known(action, "door", action.door, plan.DOORS)
        if self.doors[action.door] == door.closed_yaw:
            raise ValueError("the door is closed already")
        opened = self.line.swings[f"Door {action.door}"][-1].end
        self.falling[action.door] = opened
        self.let_by[action.door] = self.entry
        self._fall_shut(action.door)

    def open(self, action: actions.Open) -> None:
        thing = _known(action, "thing", action.thing, HINGED)
        if action.thing in self.things_open:
            raise ValueError("it is open already")
        self._turn_thing(action.thing, thing, thing.closed_yaw, thing.open_yaw)
        self.things_open.add(action.thing)

    def close(self, action: actions.Close) -> None:
        thing = _known(action, "thing", action.thing, HINGED)
        if action.thing not in self.things_open:
            raise ValueError("it is closed already")
        self._turn_thing(action.thing, thing, thing.open_yaw, thing.closed_yaw)
        self.things_open.remove(action.thing)

    def _turn_thing(self, name: str, thing: Hinged, before: float, after: float) -> None:
        line = self.line
        self._check_reach("the handle", thing.handle_at(before))
        hand = self._free_hand(thing.handle_at(thing.closed_yaw))
        start = self.now + REACH_TIME
        end = self._swing(name, start, before, after)

        def grip(t: np.ndarray) -> np.ndarray:
            return thing.handle_at(80.0 * np.tanh(line.yaw(name, t, thing.closed_yaw) / 80.0))

        self._reach(hand, grip, self.now, end + 0.3)
        self._stay(end - self.now)

    # --- hands ----------------------------------------------------------------------------
    def take(self, action: actions.Take) -> None:
        holds = _known(action, "prop", action.prop, self.line.props)
        if action.prop in self.hands:
            raise ValueError("the prop is in the hand already")
        if len(self.hands) == 2:
            raise ValueError(f"both hands are full: {', '.join(self.hands)}")
        self._check_reach("the prop", holds[-1].at)
        at = holds[-1].at + np.array((0.0, 0.0, 0.10))
        side = 1 if 1 not in self.hands.values() else 0
        self._reach(side, lambda _t: at, self.now, self.now + 1.8, 0.9, 0.8)
        self._stay(0.95)
        self._into_hand(action.prop, side)
        self._stay(0.75)

    def put(self, action: actions.Put) -> None:
        at = self.spots[_named(action, "spot", action.spot, self.spots)]
        if action.prop not in self.hands:
            raise ValueError(f"in the hands is: {', '.join(self.hands) or 'nothing'}")
        self._check_reach("the spot", at)
        side = self.hands[action.prop]
        grip = at + np.array((0.0, 0.0, 0.10 if at[2] < 1.4 else -0.02))
        self._reach(side, lambda _t: grip, self.now, self.now + 2.0, 1.0, 0.9)
        self._stay(1.05)
        self._out_of_hand(action.prop, at, self.now)
        self._stay(0.9)

    def drink(self, action: actions.Drink) -> None:
        if action.prop not in self.hands:
            raise ValueError(f"in the hands is: {', '.join(self.hands) or 'nothing'}")
        side = self.hands[action.prop]

        self._gesture(
            self.now, self.now + 3.6, 1.1, 1.0, lambda pose, _t, w: drinking(pose, side, w)
        )
        tilt = Gesture(self.now + 0.5, self.now + 3.1, 0.9, 0.8, lambda pose, _t, _w: pose)
        self.line.tilts.setdefault(action.prop, []).append(tilt)
        self._stay(3.7)

    def use_both_hands(self, action: actions.UseBothHands) -> None:
        at = self.spots[_named(action, "spot", action.spot, self.spots)]
        self._check_reach("the spot", at)
        yaw = self.pose.heading[0]
        across = np.array((-sin(yaw), cos(yaw), 0.0))
        began = self.now
        for side, sign in ((0, 1.0), (1, -1.0)):
            if side in self.hands.values():
                continue

            def point(t: np.ndarray, sign: float = sign) -> np.ndarray:
                since = t - began
                rub = [0.02 * np.sin(7 * since), 0 * t, 0.012 * np.sin(5.1 * since + sign)]
                return at + across * 0.045 * sign + np.stack(rub, -1) * sign

            self._reach(side, point, began, began + action.seconds, 0.8, 0.8)
        self._stay(action.seconds)

    def look_around(self, action: actions.LookAround) -> None:
        began = self.now

        def turn(pose: Pose, t: np.ndarray, w: np.ndarray) -> Pose:
            return looking_around(pose, t - began, action.seconds, w)

        self._gesture(began, began + action.seconds, 0.5, 0.5, turn)
        self._stay(action.seconds)

    # --- sitting and lying ------------------------------------------------------------------
    def sit(self, action: actions.Sit) -> None:
        place = _known(action, "place", action.place, plan.PLACES)
        if action.place not in SEATS:
            raise ValueError(f"one cannot sit there; seats: {', '.join(SEATS)}")
        yaw = place_yaw(place)
        x = place.seat[0] + SEAT_DISTANCE * cos(yaw)
        y = place.seat[1] + SEAT_DISTANCE * sin(yaw)
        self.go(x, y, yaw, place.waypoint)
        stand, seated = self.pose, seat.sitting(self.pose, np.array(place.seat))
        self._clip(1.7, lambda t: seat.sitting_down(stand, seated, t / 1.7))
        self.seat = place
        self._stay(0.4)

    def stand_up(self, _action: actions.StandUp) -> None:
        if self.seat is None:
            raise ValueError("the person does not sit")
        seated, stand = self.pose, standing(self.stand, self.floor)
        self._clip(1.7, lambda t: seat.sitting_down(stand, seated, 1 - t / 1.7))
        self.seat = None

    def shift(self, _action: actions.Shift) -> None:
        if self.seat is None:
            raise ValueError("the person does not sit")
        self._gesture(self.now, self.now + 2.6, 1.0, 1.2, seat.shifted)
        self._stay(2.7)

    def lie(self, action: actions.Lie) -> None:
        place = _known(action, "place", action.place, plan.PLACES)
        if self.seat is None or place.seat is None or action.place in SEATS:
            raise ValueError("one lies down from sitting: Sit on the bed's edge first")
        seated = self.pose
        lying = seat.lying(self.pose, np.array(place.seat), place_yaw(place))
        self._clip(3.2, lambda t: seat.lying_down(seated, lying, t / 3.2))

    # --- the rest -------------------------------------------------------------------------
    def wait(self, action: actions.Wait) -> None:
        self._stay(action.seconds)

    def switch(self, action: actions.Switch) -> None:
        _named(action, "lamp", action.lamp, plan.LAMPS)
        self.line.lamps.append((self.now, action.lamp, action.on))

    def finish(self) -> Film:
        for prop, side in self.hands.items():
            self._gesture(
                self.grabbed[prop] - 0.4,
                self.now + 1,
                0.8,
                0.7,
                lambda pose, _t, w, side=side, prop=prop: carrying(
                    pose, side, w, BESIDE.get(prop, 0.0)
                ),
            )
        for door in self.falling:
            raise ValueError(f"{self.let_by[door]}: nobody goes through the open door {door!r}")
        if not self.line.body.clips:
            raise ValueError("the story takes no time: let it go on, for example with Wait(5.0)")
        self._gesture(-9.0, self.now + 9.0, 1.0, 1.0, _breathing)
        # A hand that carries is drawn elsewhere only after that.
        self.line.body.gestures.sort(key=lambda g: g.start)
        return self.line


def _breathing(pose: Pose, t: np.ndarray, _w: np.ndarray) -> Pose:
    breath = np.stack([0 * t, radians(0.5) * np.sin(1.6 * t), 0 * t], -1)
    return replace(pose, spine=pose.spine - breath, look=pose.look + breath)


def _known(action: object, kind: str, name: str, table: dict) -> object:
    return table[_named(action, kind, name, table)]


def _named(action: object, kind: str, name: str, table: dict) -> str:
    if name not in table:
        known = ", ".join(sorted(table))
        where = f"{action}: " if isinstance(action, str) else ""
        raise ValueError(f"{where}there is no {kind} {name!r}; known: {known}")
    return name


_VERBS: dict[type, Callable] = {
    actions.Walk: Director.walk,
    actions.OpenDoor: Director.open_door,
    actions.CloseDoor: Director.close_door,
    actions.LetDoorClose: Director.let_door_close,
    actions.Open: Director.open,
    actions.Close: Director.close,
    actions.Take: Director.take,
    actions.Put: Director.put,
    actions.Drink: Director.drink,
    actions.UseBothHands: Director.use_both_hands,
    actions.LookAround: Director.look_around,
    actions.Sit: Director.sit,
    actions.Shift: Director.shift,
    actions.StandUp: Director.stand_up,
    actions.Lie: Director.lie,
    actions.Wait: Director.wait,
    actions.Switch: Director.switch,
}


def _check_action(action: object) -> None:
    """A ValueError for what is no action, and for times and speeds that do not go forward."""
    if type(action) not in _VERBS:
        raise ValueError("this is no action; are the brackets () missing?")
    for name in ("seconds", "speed"):
        value = getattr(action, name, 1.0)
        if not isinstance(value, int | float) or not 0 < value < inf:
            raise ValueError(f"{name} must be a number above 0")


def direct(story: Sequence[actions.Action] = STORY, start: str = START) -> Film:
    """The film of a story; a ValueError names the entry that cannot be played."""
    director = Director(start)
    for number, action in enumerate(story, 1):
        director.line.marks.append((director.now, repr(action)))
        director.entry = f"entry {number} of the story, {action}"
        try:
            _check_action(action)
            _VERBS[type(action)](director, action)
        except ValueError as error:
            raise ValueError(f"{director.entry}: {error}") from error
    return director.finish()
