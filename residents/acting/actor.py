# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the timeline of one person's day from clips and gestures.

A clip is a piece of the body's motion. A gesture is a movement added to the poses of clips. Each
method of `Actor` appends the next movement: walking, sitting, lying, or work of the hands. A person
who uses a walking frame leaves the frame behind where it does not fit.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ...sensor_logic.model import Array
from ..body.gait import Stance
from ..body.moves import (
    Walk,
    footsteps,
    lying,
    lying_down,
    shifted,
    sitting,
    sitting_down,
    standing,
    turning_over,
)
from ..body.pose import BodyPose
from ..body.poses import carrying, drinking, looking_around, reaching, seat_distance
from ..body.skeleton import Build, Sort
from ..body.turns import ease
from ..routine.timetable import Stream
from .home_in_use import HomeInUse
from .path_search import resample, yaw_to
from .places import LIE, Door, Place
from .timeline import AWAY, LYING, SITTING, STANDING, Clip, Gesture, Hold, Stay, Timeline
from .walking_frame import ParkedWalkingFrame, parking_near, walking_frame_pose

# The hands while they work or hold a door handle.

# Working hands stay at a spot for SPOT_TIME s (median, log-normal spread) and take MOVE_TIME s to
# the next spot. Spots are up to WIDE m to the sides and DEEP m towards the body.
SPOT_TIME, MOVE_TIME, WIDE, DEEP = (2.5, 1.0), 0.7, 0.18, 0.08
# How far a hand follows a leaf: rad, by the side of the door (see `Door.side`); m if it slides.
FOLLOWS = {1.0: 0.73, -1.0: 0.49}
SLIDES_ALONG = 0.6
GRIP = 0.05  # from the handle's point in the leaf to the hand, m


def working_hands(
    point: Array, yaw: float, began: float, seconds: float, stream: Stream
) -> Callable[[float, Array], Array]:
    """Return a function that gives the positions of a hand at work.

    The function takes a sign (+1 for the left hand, −1 for the right one) and times (n,) in s. It
    returns the hand's positions (n, 3). The hands move between random points around `point`.

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
    """
    across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    nearer = -np.array([math.cos(yaw), math.sin(yaw), 0.0])
    begins, spots = _random_offsets(seconds, stream)
    spots = spots @ np.stack([across, nearer])

    def hand(sign: float, times: Array) -> Array:
        since = times - began
        index = np.searchsorted(begins, since, side="right") - 1
        share = ease((since - begins[index]) / MOVE_TIME)[:, None]
        spot = spots[index] + (spots[index + 1] - spots[index]) * share
        rub = np.stack(
            [0.02 * np.sin(7 * since), 0 * since, 0.012 * np.sin(5.1 * since + sign)], -1
        )
        moved: Array = spot + point + sign * (0.045 * across + rub)
        return moved

    return hand


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


def _random_offsets(seconds: float, stream: Stream) -> tuple[Array, Array]:
    """Draw random positions of working hands, as offsets (to the left, towards the body) in m.

    Return two arrays: the times (n,) at which the hands move on, in s from 0, and the offsets (n +
    1, 2).
    """
    begins, spots = [0.0], [(0.0, 0.0), (0.0, 0.0)]
    while (after := begins[-1] + max(stream.log_normal(*SPOT_TIME), MOVE_TIME)) < seconds:
        begins.append(after)
        spots.append((WIDE * (2 * stream.uniform() - 1), DEEP * stream.uniform()))
    return np.array(begins), np.array(spots)


# Where the hips of a sitting person are.


def find_seat(place: Place) -> tuple[Array, float]:
    """Return the point (3,) under the hips of a person who sits at a place, and the yaw, rad.

    On a bed, the person sits on the edge.
    """
    if place.use != LIE:
        return place.target, place.yaw
    up = np.array([math.cos(place.yaw), math.sin(place.yaw)])
    off = (place.at - place.target)[:2]
    across = off - (off @ up) * up
    if math.hypot(*across) < 0.2:
        across = off
    ahead = across / max(math.hypot(*across), 1e-9)
    yaw = math.atan2(ahead[1], ahead[0])
    if place.edge is not None:
        return place.edge, yaw
    seat = np.array(place.target)
    seat[:2] += ahead * min(0.45, max(math.hypot(*across) - 0.5, 0.0))
    return seat, yaw


# Half of the width that a walking person needs, m.
RADIUS = {Sort.OLDER_ADULT: 0.25, Sort.ADULT: 0.25, Sort.CHILD: 0.20, Sort.CAT: 0.10}
WITH_FRAME = 0.30
# Durations of movements, s.
REACH, SWING, SIT_DOWN, LIE_DOWN, TURN_OVER, LOOK = 0.6, 1.7, 1.7, 3.2, 2.6, 4.0
# Durations of drinking, and of taking or releasing the walking frame, s.
DRINK, HANDS = 3.6, 0.8
# Whole turns of the heading are removed after standing still for this long, s: more than a frame.
UNWIND_AFTER = 0.5


class Actor:
    """A person's state during a day: body, posture, position and the timeline built so far.

    Times are in seconds since midnight. `place` is the name of the place where the person is. It is
    empty while the person walks from one place to another.
    """

    def __init__(self, name: str, build: Build, home: HomeInUse, now: float) -> None:
        self.name, self.build, self.home = name, build, home
        self.now = self.since = now
        self.is_ignored = build.is_cat
        self.radius = WITH_FRAME if build.frame else RADIUS[build.sort]
        self.storey, self.place, self.posture = 0, "", STANDING
        self.last_place = ""
        self.timeline = Timeline()
        self.stays: list[Stay] = []
        self.wanted_path: Array | None = None
        self.waiting_since, self.is_cornered = now, False
        self.parked: ParkedWalkingFrame | None = None
        self.hands: dict[str, tuple[int, float]] = {}
        self._track: list[tuple[float, float, float]] = []
        self._posed_since = now
        self._seat: Place | None = None
        self._seated: BodyPose | None = None
        self.side = 0
        self.place_at(np.zeros(2), 0.0, 0)

    # Position and posture.

    def place_at(self, at: Array, yaw: float, storey: int) -> None:
        """Put the person at a point (2,) at once, standing and looking along `yaw`."""
        self.storey = storey
        self.stand = Stance.at(float(at[0]), float(at[1]), yaw, self.build)
        self.pose = self._standing()
        self._track.append((self.now, *self.stand.centre))

    def _standing(self) -> BodyPose:
        return _with_parked_walking_frame(
            self.parked, standing(self.stand, self.floor, self._walking_build)
        )

    @property
    def _walking_build(self) -> Build:
        """The person's build, without the walking frame while it is left behind."""
        return self.build if self.parked is None else replace(self.build, frame=False)

    @property
    def floor(self) -> float:
        """The height of the floor under the person, m."""
        storeys = self.home.places.storeys
        return storeys[self.storey].height if storeys else 0.0

    @property
    def position(self) -> Array:
        """The point (2,) between the feet, m."""
        return np.array(self.stand.centre)

    def positions_at(self, times: Array) -> Array:
        """Return the body's positions (n, 2) at times (n,), m.

        After the last known position, the position stays the same.
        """
        first = bisect_right(self._track, (float(times.min()), math.inf)) - 1
        track = np.array(self._track[max(first, 0) :])
        return np.column_stack([np.interp(times, track[:, 0], track[:, k]) for k in (1, 2)])

    def set_posture(self, posture: str, place: str = "") -> None:
        """Set posture and place; if either changes, end the present stay and begin another.

        A stay is a time that the person spends at one place in one posture.
        """
        if (posture, place) != (self.posture, self.place):
            self.end_stay()
            self.posture, self.place = posture, place
            self.last_place = place or self.last_place
        self.is_ignored = posture == AWAY or self.build.is_cat

    def end_stay(self) -> None:
        """End and record the present stay, a time spent at one place in one posture."""
        if self.now > self._posed_since:
            stay = Stay(self._posed_since, self.now, self.name, self.place, self.posture)
            self.stays.append(stay)
        self._posed_since = self.now

    # Clips, gestures and walking.

    def add_clip(self, seconds: float, pose: Callable[[Array], BodyPose]) -> None:
        """Append a clip of `seconds` s, a piece of motion, to the timeline.

        `pose` takes the seconds (n,) since the start of the clip and returns the poses.
        """
        self.timeline.clips.append(Clip(self.now, self.now + seconds, pose))
        self.now += seconds
        self.pose = pose(np.array([seconds]))

    def stay_until(self, until: float) -> None:
        """Keep the body still until a time, s; do nothing if this time has passed."""
        if until <= self.now:
            return
        if (
            abs(self.stand.yaw) > math.pi
            and self._seated is None
            and until > self.now + UNWIND_AFTER
        ):
            self._keep_still(self.now + UNWIND_AFTER)
            self._unwind_heading()
        self._keep_still(until)

    def _unwind_heading(self) -> None:
        """Subtract whole turns (2π) from the heading of a body that is still."""
        turn = -2 * math.pi * round(self.stand.yaw / (2 * math.pi))
        left, right = (replace(f, yaw=f.yaw + turn) for f in (self.stand.left, self.stand.right))
        self.stand = Stance(left, right)
        walker = self.pose.walker + (0.0, 0.0, 0.0, turn if self.parked is None else 0.0)
        self.pose = replace(self.pose, heading=self.pose.heading + turn, walker=walker)
        pose = self.pose
        self.timeline.clips.append(
            Clip(self.now, self.now, lambda _times: pose, still=True, away=self.posture == AWAY)
        )

    def _keep_still(self, until: float) -> None:
        """Append a still clip that ends at a time, or extend the last clip if it is still."""
        pose, gone, clips = self.pose, self.posture == AWAY, self.timeline.clips
        if clips and clips[-1].still and clips[-1].away == gone:
            clips[-1] = replace(clips[-1], end=until)
        else:
            clips.append(Clip(self.now, until, lambda _times: pose, still=True, away=gone))
        self.now = until

    def add_gesture(
        self, seconds: float, rise: float, fall: float,
        apply: Callable[[BodyPose, Array, Array], BodyPose], begins: float = 0.0,
    ) -> None:  # fmt: skip
        """Add a gesture, which changes the poses of clips while its weight is above 0.

        Parameters
        ----------
        seconds : float
            The duration.
        rise, fall : float
            The time in which the weight rises from 0 to 1, and falls to 0 at the end, s.
        apply : callable
            Takes poses, times (n,) and weights (n,), and returns the changed poses.
        begins : float, optional
            The time from now to the start, s.
        """
        start = self.now + begins
        self.timeline.gestures.append(Gesture(start, start + seconds, rise, fall, apply))

    def walk(self, path: Array, yaw: float | None) -> None:
        """Walk along closely spaced points (n, 2), then turn to look along `yaw`, rad.

        If `yaw` is None, the person does not turn at the end.
        """
        build = self._walking_build
        steps = footsteps(self.stand, path, yaw, build)
        if len(steps) <= 2:
            return
        walk, left = Walk(steps, build.speed, self.floor, build), self.parked
        times, points = walk.track()
        self._track.append((self.now, *self.stand.centre))
        self._track += [
            (self.now + float(time), float(x), float(y))
            for time, (x, y) in zip(times, points, strict=True)
        ]

        self.add_clip(
            walk.duration, lambda since: _with_parked_walking_frame(left, walk.pose(since))
        )
        self.stand, self.since = walk.end, self.now
        self._track.append((self.now, *self.stand.centre))

    # Sitting and lying.

    def sit(self, place: Place) -> None:
        """Step to the seat, turn around and sit down."""
        point, yaw, seat = self.seat_approach(place)
        self._step_to(point, yaw)
        stand = self.pose
        seated = sitting(stand, seat)
        self.add_clip(SIT_DOWN, lambda t: sitting_down(stand, seated, t / SIT_DOWN))
        self._seat, self._seated = place, seated
        self.set_posture(SITTING, place.name)

    # The walking frame.

    def leave_walking_frame(self) -> None:
        """Let go of the walking frame and leave it behind at the present position."""
        yaw = self.stand.yaw
        self.parked = ParkedWalkingFrame(
            walking_frame_pose(self.position, yaw, self.floor, self.build), self.position, yaw
        )
        self._move_hands_to_frame()

    def take_walking_frame(self) -> None:
        """Take hold of the walking frame that was left at the present position."""
        self.parked = None
        self._move_hands_to_frame()

    def _move_hands_to_frame(self) -> None:
        """Move the hands to the handles of the walking frame, or away from a frame left behind."""
        before, after = self.pose, self._standing()
        self.add_clip(HANDS, lambda t: before.interpolated(after, ease(t / HANDS)))

    def seat_approach(self, place: Place) -> tuple[Array, float, Array]:
        """Return where a person stands before sitting down (2,), the yaw there, and the seat (3,).

        A cat stands at the place itself and leaps from there.
        """
        if self.build.is_cat:
            return place.at[:2], place.yaw, place.target
        seat, yaw = find_seat(place)
        ahead = np.array([math.cos(yaw), math.sin(yaw)])
        return seat[:2] + seat_distance(self.build) * ahead, yaw, seat

    def _step_to(self, point: Array, yaw: float) -> None:
        """Walk straight to a nearby point (2,), then look along `yaw`."""
        path = np.array([self.position, point])
        far = math.hypot(*(path[1] - path[0])) > 0.04
        self.walk(resample(path) if far else path[:1], yaw)

    def lie(self, place: Place) -> None:
        """Lie down on a bed; the person must sit on its edge."""
        assert self._seated is not None
        seated, flat = self._seated, lying(self._seated, place.target, place.yaw)
        self.add_clip(LIE_DOWN, lambda t: lying_down(seated, flat, t / LIE_DOWN))
        self.side = 0
        self.set_posture(LYING, place.name)

    def rest_at(self, place: Place, posture: str) -> None:
        """Put the person at a place in a posture at once, as at the start of a day."""
        if self.build.frame:
            floor = self.home.floor_map.floor(place.storey, {})
            beside = parking_near(floor, place.at[:2], self.build)
            if beside is not None:
                frame = walking_frame_pose(*beside, self.floor, self.build)
                self.parked = ParkedWalkingFrame(frame, *beside)
        self.place_at(place.at[:2], place.yaw, place.storey)
        if posture in (SITTING, LYING):
            point, yaw, seat = self.seat_approach(place)
            self.place_at(point, yaw, place.storey)
            self._seat, self._seated = place, sitting(self.pose, seat)
            self.pose = self._seated
        if posture == LYING:
            self.pose = lying(self.pose, place.target, place.yaw)
        self.posture, self.place = posture, place.name
        self.last_place = place.name

    def rise(self) -> None:
        """Get up from a seat or bed and stand before it; do nothing if the person stands."""
        if self._seated is None or self._seat is None:
            return
        seated, flat = self._seated, self.pose
        if self.posture == LYING:
            self.set_posture(SITTING)
            self.add_clip(LIE_DOWN, lambda t: lying_down(seated, flat, 1.0 - t / LIE_DOWN))
        self.set_posture(STANDING)
        stand = self._standing()
        self.add_clip(SIT_DOWN, lambda t: sitting_down(stand, seated, 1.0 - t / SIT_DOWN))
        at, self._seat, self._seated = self._seat.at[:2], None, None
        if math.hypot(*(at - self.position)) > 0.3:
            self.walk(resample(np.array([self.position, at])), None)

    def turn_over(self, side: int) -> None:
        """Turn over in bed: to the back (0), the left (1) or the right side (−1)."""
        if self._seat is None or self._seated is None:
            return
        before = self.pose
        after = lying(self._seated, self._seat.target, self._seat.yaw, side)
        self.add_clip(TURN_OVER, lambda t: turning_over(before, after, t / TURN_OVER))
        self.side = side

    # Hands.

    def shift(self, size: float = 1.0) -> None:
        """Make a small movement on the spot; a larger `size` makes it wider and slower."""
        slow = math.sqrt(size)
        self.add_gesture(
            2.6 * slow, slow, 1.2 * slow, lambda pose, t, w: shifted(pose, t, w * size)
        )
        self.stay_until(self.now + 2.6 * slow + 0.1)

    def look_around(self, seconds: float = LOOK) -> None:
        """Look to both sides for `seconds` s; a cat makes a small movement instead."""
        if self.build.is_cat:
            self.shift()
            return
        began = self.now
        self.add_gesture(
            seconds, 0.5, 0.5, lambda pose, t, w: looking_around(pose, t - began, seconds, w)
        )
        self.stay_until(self.now + seconds)

    def free_hand_for(self, point: Array) -> int:
        """Return the hand that reaches for a point (3,): 0 left, 1 right.

        This is the hand nearer to the point, or the other one if that hand holds something.
        """
        x, y = self.pose.pelvis[0, :2]
        yaw = float(self.pose.heading[0])
        side = 0 if -(point[0] - x) * math.sin(yaw) + (point[1] - y) * math.cos(yaw) > 0.02 else 1
        full = [hand for hand, _ in self.hands.values()]
        return 1 - side if side in full else side

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
        sits, lies = self.posture == SITTING, self.posture == LYING
        slide, most = (0.12 if sits else -0.03), (0.0 if lies else most)
        self.add_gesture(
            seconds, rise, fall,
            lambda pose, t, w: reaching(pose, side, point(t), w, slide, most), begins,
        )  # fmt: skip

    def touch(self, point: Array) -> float:
        """Touch a point (3,) with a free hand, and return the time of contact, s."""
        self.move_hand(self.free_hand_for(point), lambda _t: point, 1.8, 0.9, 0.8)
        at = self.now + 0.95
        self.stay_until(self.now + 1.85)
        return at

    def work(self, point: Array, seconds: float, stream: Stream) -> None:
        """Work with both hands around a point (3,), as in cooking; a cat makes small movements."""
        if self.build.is_cat:
            self.add_gesture(seconds, min(0.8, seconds / 2), min(0.8, seconds / 2), shifted)
            self.stay_until(self.now + seconds)
            return
        full = [hand for hand, _ in self.hands.values()]
        hand = working_hands(point, float(self.pose.heading[0]), self.now, seconds, stream)
        rise = min(0.8, seconds / 2)
        for side, sign in ((0, 1.0), (1, -1.0)):
            if side not in full:
                self.move_hand(side, partial(hand, sign), seconds, rise, rise)
        self.stay_until(self.now + seconds)

    def take(self, thing: str, point: Array) -> None:
        """Touch an object at a point (3,), such as a cup, and take it into the hand.

        `thing` is the object's name.
        """
        side = self.free_hand_for(point)
        at = self.touch(point)
        self.hands[thing] = side, at
        self.home.holds.setdefault(thing, []).append(Hold(at, side, person=self.name))

    def put(self, thing: str, place: Place) -> None:
        """Put a held object down at a place; `thing` is the object's name."""
        at = self.touch(place.target)
        self._release_object(thing, at)
        self.home.holds[thing].append(Hold(at, None, self.home.put_position(thing, place)))

    def drink(self, thing: str) -> None:
        """Move the hand that holds a cup to the mouth; `thing` is the cup's name."""
        side, _ = self.hands[thing]
        self.add_gesture(DRINK, 1.1, 1.0, lambda pose, _t, w: drinking(pose, side, w))
        self.home.sips.setdefault(thing, []).append(sip_gesture(self.now))
        self.stay_until(self.now + DRINK + 0.1)

    def _release_object(self, thing: str, at: float) -> None:
        """Take an object out of the hand at the time `at`, and add the gesture of carrying it."""
        side, since = self.hands.pop(thing)
        carried = Gesture(since - 0.4, at + 0.5, 0.8, 0.7,
                          lambda pose, _t, w: carrying(pose, side, w), steady=True)  # fmt: skip
        self.timeline.gestures.append(carried)

    # Doors and drawers.

    def move_leaf(self, door: Door, after: float) -> None:
        """Move a door leaf to the opening `after` (rad or m), with a hand on the handle.

        While the leaf opens, the hand follows the first part of the movement. While it closes, the
        hand follows the last part.
        """
        hand = self.free_hand_for(door.handle_at(door.closed))
        opening = abs(after - door.closed) > 0.02
        start = self.now + (REACH if opening else 0.1)
        end = start + SWING
        grip = hand_on_handle(door, self.position, (self.home.opening(door), after), start, SWING)
        self.home.record_swing(door, start, end, after, self.name)
        if opening:
            self.move_hand(hand, grip, start + 1.1 - self.now, most=0.25)
            self.stay_until(end - 0.25)
        else:
            begins = end - 1.15 - self.now
            self.move_hand(hand, grip, 1.7, most=0.25, begins=begins)
            self.stay_until(end + 0.55)

    def finish(self) -> None:
        """End the day: empty the hands, record the last stay, and sort the gestures by start."""
        for thing in list(self.hands):
            self._release_object(thing, self.now + 1.0)
        self.end_stay()
        # Gestures apply in order: a carrying hand must be posed before it reaches.
        self.timeline.gestures.sort(key=lambda gesture: gesture.start)


def sip_gesture(began: float) -> Gesture:
    """Return a gesture whose weight (0 to 1) is how far a cup is tilted.

    The person begins to drink at the time `began`, s. The gesture does not move the body.
    """
    return Gesture(began + 0.5, began + 3.1, 0.9, 0.8, lambda pose, _t, _w: pose)


def _with_parked_walking_frame(parked: ParkedWalkingFrame | None, pose: BodyPose) -> BodyPose:
    """Return the pose with the walking frame where it was left; unchanged if it was not left."""
    return pose if parked is None else replace(pose, walker=parked.frame[None])
