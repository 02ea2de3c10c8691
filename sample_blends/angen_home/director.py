# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a story from top to bottom and lays everything out in time.

Body and hands are those of the residents of days; ways, and doors that fall shut, are the film's.
"""

from collections.abc import Callable
from dataclasses import replace
from math import hypot, inf, radians
from types import SimpleNamespace

import numpy as np
from angen_sensors.residents.acting.actor import REACH, SWING, Actor
from angen_sensors.residents.acting.home import HomeInUse
from angen_sensors.residents.acting.places import LIE, SIT
from angen_sensors.residents.acting.timeline import SITTING, Acted, Gesture, Hold, Swing, swung
from angen_sensors.residents.acting.words import ActivityStep, read_step
from angen_sensors.residents.body.pose import BodyPose
from angen_sensors.residents.body.poses import carrying
from angen_sensors.residents.body.skeleton import ADULT
from angen_sensors.residents.body.turns import ease

from . import places, plan
from .checks import along, distance_to_box, solids
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
from .stage import CLOSED, GRIPS, HINGED, PLACES, SEATS
from .story import PROPS, SPOTS, START, STORY

PERSON = "person"
# Behind whoever goes on these doors fall shut by themselves; the others a hand shuts.
FALLS_SHUT = ("kitchen", "bathroom", "bedroom")
CLEAR = 0.42  # between a leaf that falls shut and the body's middle, m
BESIDE = {"Coat": 0.08}  # rad by which what hangs far down is held away from the leg
ARM_WAY = 1.2  # on the floor from the hips to what a hand, the trunk bent, can reach, m
# Hands at work stay where they are: it is drawn for how long, and that is for ever.
STEADY = SimpleNamespace(log_normal=lambda *_: inf)
_WALLS = tuple(box for name, box in solids() if name == "wall")


class Director(Actor):
    """Where everybody and everything is while the story goes on."""

    def __init__(self, start: str) -> None:
        super().__init__(PERSON, ADULT, HomeInUse(PLACES, None), 0.0)
        place = PLACES.places[start]
        self.put_down(place.at, place.yaw, 0)
        self.gate = ""  # the waypoint by which a narrow place is left
        self.seat_gate = ""  # that by which one comes to the seat
        self.doors = {name: door.closed_yaw for name, door in plan.DOORS.items()}
        self.opened_from: dict[str, float] = {}
        self.falling: dict[str, float] = {}  # doors that fall shut: since when they may
        self.step = ""  # the one that is being done, for error messages
        self.let_by: dict[str, str] = {}  # the step that let a door fall shut
        self.things_open: set[str] = set()
        for prop, where in PROPS.items():
            if prop not in GRIPS:
                raise ValueError(f"PROPS: there is no prop {prop!r}; known: {_listed(GRIPS)}")
            if where == "hand":
                self._into_hand(prop, 0)
            else:
                self.home.holds[prop] = [Hold(0.0, None, _spot(where))]

    @property
    def floor(self) -> float:
        return plan.FLOOR_Z

    def _wind_back(self) -> None:
        """A film's keys go on from whole turns."""

    # --- walking --------------------------------------------------------------------------
    def go(self, x: float, y: float, yaw: float, gate: str) -> None:
        """Walks to a point and turns to a yaw (radians)."""
        self.rise()
        start = self.stand.centre
        if hypot(x - start[0], y - start[1]) < 0.05:
            path = np.array([start])
        else:
            points: list[tuple[float, float]] = []
            here = start
            if self.gate and self.gate != gate:
                here = places.WAYPOINTS[self.gate]
                points = [start]
            points += route(here, (x, y), gate, self.doors)
            path = rounded(points, self.doors)
        self.gate = gate if clearance((x, y), []) < 0.26 else ""
        self.walk(path, yaw)
        for name in list(self.falling):
            self._fall_shut(name)

    def _fall_shut(self, name: str) -> None:
        """Shuts a door behind the person, as soon as nobody is in its way."""
        door = plan.DOORS[name]
        times = np.arange(self.falling[name], self.now + SWING, 0.1)
        where = self.line.base(np.minimum(times, self.now)).pelvis[:, :2]
        count = int(SWING / 0.1)
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

    def go_to(self, step: ActivityStep) -> None:
        place = places.PLACES.get(step.name)
        if place is None:
            raise ValueError(f"one cannot go there; places: {_listed(places.PLACES)}")
        self.go(place.x, place.y, place_yaw(place), place.waypoint)

    # --- doors ----------------------------------------------------------------------------
    def open_or_close(self, step: ActivityStep) -> None:
        name, opens = step.name.removeprefix("Door "), step.word == "open"
        if name in HINGED:
            is_open = name in self.things_open
        else:
            is_open = self.doors[name] != plan.DOORS[name].closed_yaw
        if is_open == opens:
            raise ValueError(f"it is {'open' if opens else 'closed'} already")
        if name in HINGED:
            self._turn_thing(name, opens)
        elif opens:
            self._open_door(name)
        elif name in FALLS_SHUT:
            self.falling[name] = self.home.swings[step.name][-1].end
            self.let_by[name] = self.step
            self._fall_shut(name)
        else:
            self._close_door(name)

    def _to_handle(self, name: str) -> float:
        """Steps to where the door can be moved from; returns the side."""
        self.rise()
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

    def _open_door(self, name: str) -> None:
        door = plan.DOORS[name]
        side = self._to_handle(name)
        last = self.home.swings.get(f"Door {name}", [])
        if last and last[-1].end > self.now - 0.2:
            self.stay(last[-1].end + 0.2)
        self._move_leaf(name, side, door.closed_yaw, door.open_yaw)
        self.doors[name] = door.open_yaw
        self.opened_from[name] = side

    def _close_door(self, name: str) -> None:
        door = plan.DOORS[name]
        side = self._to_handle(name)
        self._move_leaf(name, side, door.open_yaw, door.closed_yaw)
        self.doors[name] = door.closed_yaw

    def _swing(self, name: str, start: float, before: float, after: float) -> float:
        end = start + SWING
        self.home.swings.setdefault(name, []).append(Swing(start, end, before, after))
        return end

    def _yaws(self, name: str, times: np.ndarray) -> np.ndarray:
        return swung(self.home.swings[name], times, CLOSED[name])

    def _move_leaf(self, name: str, side: float, before: float, after: float) -> None:
        """A hand at the handle while the leaf is within reach: first or last part of its way."""
        door = plan.DOORS[name]
        hand = self.hand_for(np.array(handle_at(name, door.closed_yaw, side)))
        opening = after != door.closed_yaw
        start = self.now + (REACH if opening else 0.1)
        end = self._swing(f"Door {name}", start, before, after)

        def grip(t: np.ndarray) -> np.ndarray:
            # The hand stays behind softly where the leaf goes out of reach.
            limit = 42.0 if side > 0 else 28.0
            yaws = self._yaws(f"Door {name}", t)
            yaws = door.closed_yaw - limit * np.tanh((door.closed_yaw - yaws) / limit)
            return np.array([handle_at(name, yaw, side) for yaw in yaws])

        if opening:
            self.draw_hand(hand, grip, start + 1.1 - self.now, most=0.25)
            self.stay(end - 0.25)
        else:
            self.draw_hand(hand, grip, 1.7, most=0.25, begins=end - 1.15 - self.now)
            self.stay(end + 0.25)

    def _turn_thing(self, name: str, opens: bool) -> None:
        thing = HINGED[name]
        before, after = thing.closed_yaw, thing.open_yaw
        if not opens:
            before, after = after, before
        self._check_reach("the handle", thing.handle_at(before))
        hand = self.hand_for(thing.handle_at(thing.closed_yaw))
        end = self._swing(name, self.now + REACH, before, after)

        def grip(t: np.ndarray) -> np.ndarray:
            return thing.handle_at(80.0 * np.tanh(self._yaws(name, t) / 80.0))

        self.draw_hand(hand, grip, end + 0.3 - self.now)
        self.stay(end)
        self.things_open ^= {name}

    # --- hands ----------------------------------------------------------------------------
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

    def _into_hand(self, prop: str, side: int) -> None:
        self.hands[prop] = side, self.now
        self.home.holds.setdefault(prop, []).append(Hold(self.now, side))

    def _check_held(self, prop: str) -> None:
        if prop not in self.hands:
            raise ValueError(f"in the hands is: {', '.join(self.hands) or 'nothing'}")

    def take_prop(self, step: ActivityStep) -> None:
        if step.name not in PROPS:
            raise ValueError(f"one cannot take that; props: {_listed(PROPS)}")
        if step.name in self.hands:
            raise ValueError("the prop is in the hand already")
        if len(self.hands) == 2:
            raise ValueError(f"both hands are full: {', '.join(self.hands)}")
        stands = self.home.holds[step.name][-1].at
        self._check_reach("the prop", stands)
        at = stands + np.array((0.0, 0.0, 0.10))
        side = 1 if 1 not in [hand for hand, _ in self.hands.values()] else 0
        self.draw_hand(side, lambda _t: at, 1.8, 0.9, 0.8)
        self.stay(self.now + 0.95)
        self._into_hand(step.name, side)
        self.stay(self.now + 0.75)

    def put_prop(self, step: ActivityStep) -> None:
        at = _spot(step.at)
        self._check_held(step.name)
        self._check_reach("the spot", at)
        grip = at + np.array((0.0, 0.0, 0.10 if at[2] < 1.4 else -0.02))
        self.draw_hand(self.hands[step.name][0], lambda _t: grip, 2.0, 1.0, 0.9)
        self.stay(self.now + 1.05)
        self._let_go(step.name, self.now)
        self.home.holds[step.name].append(Hold(self.now, None, at))
        self.stay(self.now + 0.9)

    def _let_go(self, prop: str, at: float) -> None:
        side, since = self.hands.pop(prop)
        beside = BESIDE.get(prop, 0.0)
        carried = Gesture(
            since - 0.4, at + 0.5, 0.8, 0.7, lambda pose, _t, w: carrying(pose, side, w, beside)
        )
        self.line.gestures.append(carried)

    def drink_from(self, step: ActivityStep) -> None:
        self._check_held(step.name)
        self.drink(step.name)

    def use(self, step: ActivityStep) -> None:
        at = _spot(step.name)
        self._check_reach("the spot", at)
        self.busy(at, step.lasts or 10.0, STEADY)

    # --- sitting and lying ------------------------------------------------------------------
    def sit_down(self, step: ActivityStep) -> None:
        place = PLACES.places[step.name]
        if place.use != SIT:
            raise ValueError(f"one cannot sit there; seats: {', '.join(SEATS)}")
        self.rise()
        self.seat_gate = places.PLACES[step.name].waypoint
        self.sit(place)
        self.stay(self.now + 0.4)

    def _step_to(self, point: np.ndarray, yaw: float) -> None:
        self.go(*point.tolist(), yaw, self.seat_gate)

    def lie_down(self, step: ActivityStep) -> None:
        place = PLACES.places[step.name]
        if self._seated is None or place.use != LIE:
            raise ValueError("one lies down from sitting: sit on the bed's edge first")
        self.lie(place)

    # --- the rest -------------------------------------------------------------------------
    def do(self, step: ActivityStep) -> None:
        if step.word in _VERBS:
            _VERBS[step.word](self, step)
        elif step.word == "wait":
            self.stay(self.now + step.lasts)
        elif step.word == "look around":
            self.look_around(step.lasts)
        elif step.word == "shift":
            if self._seated is None:
                raise ValueError("the person does not sit")
            self.shift()
        elif step.word == "switch":
            if self.posture == SITTING:
                self.rise()
            self.home.switch(step.name, step.on, self.now, self.name)
        else:
            raise ValueError(f"stories do not have this word; they have {_listed(WORDS)}")

    def played(self) -> Acted:
        for door in self.falling:
            raise ValueError(f"{self.let_by[door]}: nobody goes through the open door {door!r}")
        if not self.line.clips:
            raise ValueError('the story takes no time: let it go on, for example with "wait 5 s"')
        self.line.gestures.append(Gesture(-9.0, self.now + 9.0, 1.0, 1.0, _breathing))
        self.finish()
        home = self.home
        bodies = {PERSON: self.line}
        return Acted(bodies, home.swings, home.switches, home.holds, sips=home.sips)


def _breathing(pose: BodyPose, t: np.ndarray, _w: np.ndarray) -> BodyPose:
    breath = np.stack([0 * t, radians(0.5) * np.sin(1.6 * t), 0 * t], -1)
    return replace(pose, spine=pose.spine - breath, look=pose.look + breath)


def _spot(name: str) -> np.ndarray:
    if name not in SPOTS:
        raise ValueError(f"there is no spot {name!r}; known: {_listed(SPOTS)}")
    return np.array(SPOTS[name])


def _listed(names: object) -> str:
    return ", ".join(sorted(names))


_VERBS: dict[str, Callable[[Director, ActivityStep], None]] = {
    "go": Director.go_to,
    "open": Director.open_or_close,
    "close": Director.open_or_close,
    "take": Director.take_prop,
    "put": Director.put_prop,
    "drink": Director.drink_from,
    "use": Director.use,
    "sit": Director.sit_down,
    "lie": Director.lie_down,
}
WORDS = (*_VERBS, "wait", "look around", "shift", "switch")


def direct(story: str = STORY, start: str = START) -> Acted:
    """Everything that moves in a story, one step a line; a ValueError names the step that cannot be
    done."""
    director = Director(start)
    for number, text in enumerate(filter(None, map(str.strip, story.splitlines())), 1):
        director.step = f"step {number} of the story, {text!r}"
        step = read_step(text, director.step, PLACES)
        try:
            director.do(step)
        except ValueError as error:
            raise ValueError(f"{director.step}: {error}") from error
    return director.played()
