# SPDX-License-Identifier: GPL-3.0-or-later
"""The hands of a person: work, things that are carried, and the handles of doors and drawers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...sensor_logic.model import Array
from ..body.moves import shifted
from ..body.poses import carrying, drinking, reaching, swaying
from ..body.turns import ease
from ..routine.timetable import Stream
from .actor import Actor
from .home_in_use import HomeInUse
from .path_search import yaw_to
from .places import Door, Place
from .timeline import LYING, SITTING, Gesture, Hold


@dataclass(frozen=True)
class Work:
    """How hands move at a kind of work. All numbers are assumed.

    Attributes
    ----------
    spot_time : tuple of float
        How long the hands stay at a spot, s: median and log-normal spread.
    wide, deep : float
        How far spots are to the sides, and towards the body, m.
    rub : float
        How far each hand goes to and fro at a spot, m.
    rate : float
        How often a hand does that, rad/s.
    """

    spot_time: tuple[float, float]
    wide: float
    deep: float
    rub: float
    rate: float


# At a stove or counter, hands change the spot; at a basin they rub each other; at a desk they type
# or write, and reach for a thing now and then.
AT_COUNTER = Work((2.5, 1.0), 0.18, 0.08, 0.020, 7.0)
AT_BASIN = Work((3.5, 0.8), 0.07, 0.05, 0.035, 9.0)
AT_DESK = Work((6.0, 1.0), 0.15, 0.06, 0.008, 12.0)
# The time that hands take to the next spot, s.
MOVE_TIME = 0.7
# How far a hand follows a leaf: rad, by the side of the door (see `Door.side`); m if it slides.
FOLLOWS = {1.0: 0.73, -1.0: 0.49}
SLIDES_ALONG = 0.6
GRIP = 0.05  # from the handle's point in the leaf to the hand, m
# A leaf that is open for less than this is held all the time, and opened the less the shorter, s.
BRIEF = 5.0
# Durations of a hand's way to a point, of the movement of a leaf, and of drinking, s.
REACH, SWING, DRINK = 0.6, 1.7, 3.6


def working_hands(
    point: Array, yaw: float, began: float, seconds: float, stream: Stream, work: Work
) -> tuple[Callable[[float, Array], Array], Callable[[Array], Array]]:
    """Return functions that give the positions of a hand at work, and how far aside both are.

    The first function takes a sign (+1 for the left hand, −1 for the right one) and times (n,) in
    s, and returns the hand's positions (n, 3). The second takes times and returns how far the spot
    is to the left (n,), m. The hands move between random points around `point`.

    Parameters
    ----------
    point : array, shape (3,)
        The point at which the person works, m.
    yaw : float
        The direction in which the person looks, rad.
    began, seconds : float
        Start and duration of the work, s.
    stream : Stream
        Source of the random numbers.
    work : Work
        The kind of work.
    """
    across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    nearer = -np.array([math.cos(yaw), math.sin(yaw), 0.0])
    begins, offsets = _random_offsets(seconds, stream, work)
    basis = np.stack([across, nearer])

    def offset(times: Array) -> Array:
        since = times - began
        index = np.searchsorted(begins, since, side="right") - 1
        share = ease((since - begins[index]) / MOVE_TIME)[:, None]
        moved: Array = offsets[index] + (offsets[index + 1] - offsets[index]) * share
        return moved

    def hand(sign: float, times: Array) -> Array:
        turned = work.rate * (times - began)
        rub = np.stack([np.sin(turned), 0 * turned, 0.6 * np.sin(0.73 * turned + sign)], -1)
        return offset(times) @ basis + point + sign * (0.045 * across + work.rub * rub)

    return hand, lambda times: offset(times)[:, 0]


def hand_on_handle(
    door: Door, here: Array, moves: tuple[float, float], start: float, seconds: float
) -> Callable[[Array], Array]:
    """Return a function that gives the positions of a hand on a door handle.

    The function takes times (n,) in s and returns positions (n, 3). The hand follows the moving
    door leaf as far as the arm reaches.

    Parameters
    ----------
    door : Door
        The door or drawer.
    here : array, shape (2,)
        Where the person stands, m.
    moves : tuple of 2 floats
        The leaf's rotation (rad) or shift (m) before and after the movement.
    start, seconds : float
        Start and duration of the movement, s.
    """
    limit = SLIDES_ALONG if door.slides else FOLLOWS[door.side(here)]
    away = yaw_to(door.handle_at(door.closed), here)
    towards = GRIP * np.array([math.cos(away), math.sin(away), 0.0])
    before, after = moves

    def grip(times: Array) -> Array:
        out = before + (after - before) * ease((times - start) / seconds) - door.closed
        near = door.closed + limit * np.tanh(out / limit)
        return np.array([door.handle_at(float(one)) for one in near]) + towards

    return grip


def _random_offsets(seconds: float, stream: Stream, work: Work) -> tuple[Array, Array]:
    """Draw random positions of working hands, as offsets (to the left, towards the body) in m.

    Return two arrays: the times (n,) at which the hands move on, in s from 0, and the offsets (n +
    1, 2).
    """
    begins, spots = [0.0], [(0.0, 0.0), (0.0, 0.0)]
    while (after := begins[-1] + max(stream.log_normal(*work.spot_time), MOVE_TIME)) < seconds:
        begins.append(after)
        spots.append((work.wide * (2 * stream.uniform() - 1), work.deep * stream.uniform()))
    return np.array(begins), np.array(spots)


class Hands:
    """The hands of a person, and what they hold.

    Attributes
    ----------
    actor : Actor
        The person.
    home : HomeInUse
        The home, which records what the hands change.
    held : dict of str to tuple
        For each thing in a hand, by its name: the hand (0 left, 1 right), and the time, s, at which
        it was taken.
    """

    def __init__(self, actor: Actor, home: HomeInUse) -> None:
        self.actor, self.home = actor, home
        self.held: dict[str, tuple[int, float]] = {}

    def free_hand_for(self, point: Array) -> int:
        """Return the hand that reaches for a point (3,): 0 left, 1 right.

        This is the hand nearer to the point, or the other one if that hand holds something.
        """
        x, y = self.actor.body.pose.pelvis[0, :2]
        yaw = float(self.actor.body.pose.heading[0])
        side = 0 if -(point[0] - x) * math.sin(yaw) + (point[1] - y) * math.cos(yaw) > 0.02 else 1
        return 1 - side if side in self._full else side

    @property
    def _full(self) -> list[int]:
        """The hands that hold something."""
        return [hand for hand, _ in self.held.values()]

    def move_hand(
        self, side: int, point: Callable[[Array], Array], seconds: float,
        rise: float = REACH, fall: float = 0.55, most: float = 1.0, begins: float = 0.0,
    ) -> None:  # fmt: skip
        """Add a gesture that moves a hand.

        Parameters
        ----------
        side : int
            0 for the left hand, 1 for the right one.
        point : callable
            Takes times (n,) and returns the positions of the hand, shape (n, 3), m.
        seconds : float
            The duration.
        rise, fall : float, optional
            The time in which the hand reaches the positions, and leaves them at the end, s.
        most : float, optional
            Limit to how far the trunk leans towards the point, 0 … 1. A lying person never leans.
        begins : float, optional
            The time from now to the start, s.
        """
        sits, lies = self.actor.posture == SITTING, self.actor.posture == LYING
        slide, most = (0.12 if sits else -0.03), (0.0 if lies else most)
        self.actor.body.add_gesture(
            seconds, rise, fall,
            lambda pose, t, w: reaching(pose, side, point(t), w, slide, most), begins,
        )  # fmt: skip

    def touch(self, point: Array) -> float:
        """Touch a point (3,) with a free hand, and return the time of contact, s."""
        self.move_hand(self.free_hand_for(point), lambda _t: point, 1.8, 0.9, 0.8)
        at = self.actor.now + 0.95
        self.actor.stay_until(self.actor.now + 1.85)
        return at

    def work(self, point: Array, seconds: float, stream: Stream, work: Work = AT_COUNTER) -> None:
        """Work with both hands around a point (3,), as in cooking; a cat makes small movements."""
        body, rise = self.actor.body, min(0.8, seconds / 2)
        if self.actor.build.is_cat:
            body.add_gesture(seconds, rise, rise, shifted)
        else:
            yaw = float(body.pose.heading[0])
            hand, aside = working_hands(point, yaw, body.now, seconds, stream, work)
            if self.actor.posture != LYING:
                body.add_gesture(seconds, rise, rise, lambda pose, t, w: swaying(pose, aside(t), w))
            for side, sign in ((0, 1.0), (1, -1.0)):
                if side not in self._full:
                    self.move_hand(side, partial(hand, sign), seconds, rise, rise)
        self.actor.stay_until(body.now + seconds)

    def take(self, thing: str, point: Array) -> None:
        """Touch an object at a point (3,), such as a cup, and take it into the hand.

        `thing` is the object's name.
        """
        side = self.free_hand_for(point)
        at = self.touch(point)
        self.held[thing] = side, at
        self.home.holds.setdefault(thing, []).append(Hold(at, side, person=self.actor.name))

    def put(self, thing: str, place: Place) -> None:
        """Put a held object down at a place; `thing` is the object's name."""
        at = self.touch(place.target)
        self._release(thing, at)
        self.home.holds[thing].append(Hold(at, None, self.home.put_position(thing, place)))

    def drink(self, thing: str) -> None:
        """Move the hand that holds a cup to the mouth; `thing` is the cup's name."""
        side, _ = self.held[thing]
        self.actor.body.add_gesture(DRINK, 1.1, 1.0, lambda pose, _t, w: drinking(pose, side, w))
        self.home.sips.setdefault(thing, []).append(sip_gesture(self.actor.now))
        self.actor.stay_until(self.actor.now + DRINK + 0.1)

    def _release(self, thing: str, at: float) -> None:
        """Take an object out of the hand at the time `at`, and add the gesture of carrying it."""
        side, since = self.held.pop(thing)
        carried = Gesture(since - 0.4, at + 0.5, 0.8, 0.7,
                          lambda pose, _t, w: carrying(pose, side, w), steady=True)  # fmt: skip
        self.actor.body.timeline.gestures.append(carried)

    def empty(self) -> None:
        """Take all things out of the hands, at the end of a day."""
        for thing in list(self.held):
            self._release(thing, self.actor.now + 1.0)

    # Doors and drawers.

    def move_leaf(self, door: Door, after: float) -> None:
        """Move a door leaf to the opening `after` (rad or m), with a hand on the handle.

        While the leaf opens, the hand follows the first part of the movement. While it closes, the
        hand follows the last part.
        """
        actor, hand = self.actor, self.free_hand_for(door.handle_at(door.closed))
        opening = abs(after - door.closed) > 0.02
        start = actor.now + (REACH if opening else 0.1)
        end = start + SWING
        grip = hand_on_handle(door, actor.position, (self.home.opening(door), after), start, SWING)
        self.home.record_swing(door, start, end, after, actor.name)
        if opening:
            self.move_hand(hand, grip, start + 1.1 - actor.now, most=0.25)
            actor.stay_until(end - 0.25)
        else:
            self.move_hand(hand, grip, 1.7, most=0.25, begins=end - 1.15 - actor.now)
            actor.stay_until(end + 0.55)

    def look_into(self, door: Door, seconds: float, stream: Stream) -> None:
        """Open a leaf, take or look for something behind it, and shut it, all in `seconds` s."""
        closed, middle = door.closed, door.middle
        inside = np.array([*middle, door.handle_at(closed)[2]])
        if seconds >= BRIEF:
            was_open = abs(self.home.opening(door) - closed) > 0.02
            began = self.actor.now + REACH
            if not was_open:
                self.move_leaf(door, door.open)
            # Shutting takes the last part of the time.
            left = began + seconds - SWING - 0.1 - self.actor.now
            self.work(inside, max(left, 0.5), stream)
            self.move_leaf(door, closed)
            return
        actor, hand = self.actor, self.free_hand_for(door.handle_at(closed))
        swing = min(SWING, 0.4 * seconds)
        start = actor.now + REACH
        end = start + seconds
        before = self.home.opening(door)
        after = closed + (door.open - closed) * seconds / BRIEF
        opens = hand_on_handle(door, actor.position, (before, after), start, swing)
        shuts = hand_on_handle(door, actor.position, (after, closed), end - swing, swing)
        self.home.record_swing(door, start, start + swing, after, actor.name)
        self.home.record_swing(door, end - swing, end, closed, actor.name)

        def grip(times: Array) -> Array:
            is_shutting = (times > end - swing)[:, None]
            held: Array = np.where(is_shutting, shuts(times), opens(times))
            return held

        self.move_hand(hand, grip, seconds + REACH + 0.4, fall=0.4, most=0.25)
        if 1 - hand not in self._full:
            reach = min(REACH, 0.4 * seconds)
            self.move_hand(
                1 - hand, lambda _t: inside, seconds, reach, reach, 0.5, start + 0.3 - actor.now
            )
        actor.stay_until(end + 0.45)


def sip_gesture(began: float) -> Gesture:
    """Return a gesture whose weight (0 to 1) is how far a cup is tilted.

    The person begins to drink at the time `began`, s. The gesture does not move the body.
    """
    return Gesture(began + 0.5, began + 3.1, 0.9, 0.8, lambda pose, _t, _w: pose)
