# SPDX-License-Identifier: GPL-3.0-or-later
"""A person in a home: walking, sitting, lying and small movements.

Each movement is appended to the timeline of the person's body. What hands do is in `hands`, and
which way a person walks in `navigator`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from ..body.poses import looking_around, seat_distance
from ..body.skeleton import Build
from ..body.turns import ease
from .moving_body import MovingBody
from .path_search import Floor, resample
from .places import LIE, Place, Storey
from .timeline import AWAY, LYING, SITTING, STANDING, Stay
from .walking_frame import ParkedWalkingFrame, parking_near, walking_frame_pose

# Durations of movements, s: the last is that of taking or releasing the walking frame.
SIT_DOWN, LIE_DOWN, TURN_OVER, LOOK, HANDS = 1.7, 3.2, 2.6, 4.0, 0.8
# Whole turns of the heading are removed after standing still for this long, s: more than a frame.
UNWIND_AFTER = 0.5


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


@dataclass(frozen=True, eq=False)
class Seated:
    """How a person sits, or sat before lying down.

    Attributes
    ----------
    place : Place
        The seat or bed.
    pose : BodyPose
        The pose of the sitting person (n = 1).
    side : int
        The side on which the person lies: the back (0), the left (1) or the right side (−1).
    """

    place: Place
    pose: BodyPose
    side: int = 0


class Actor:
    """A person or cat in a home: where the person is, in which posture, and the body's motion.

    Times are in seconds since midnight.

    Attributes
    ----------
    name : str
        The person's name in the routine.
    build : Build
        The person's build.
    body : MovingBody
        The body at the present time, and its motion so far.
    storey : int
        The index of the present storey; 0 is the lowest.
    posture : str
        STANDING, WALKING, SITTING, LYING or AWAY.
    place : str
        The name of the present place; empty while the person walks from one place to another.
    last_place : str
        The name of the last place, which is the present one if there is one.
    stays : list of Stay
        The stays that have ended. A stay is a time spent at one place in one posture.
    seated : Seated or None
        How the person sits; None for a person who neither sits nor lies.
    parked_frame : ParkedWalkingFrame or None
        The person's walking frame while it is left behind.
    """

    def __init__(self, name: str, build: Build, storeys: Sequence[Storey], now: float) -> None:
        self.name, self.build = name, build
        self.storey, self._storeys = 0, storeys
        self.posture, self.place, self.last_place = STANDING, "", ""
        self.stays: list[Stay] = []
        self._stay_began = now
        self.seated: Seated | None = None
        self.parked_frame: ParkedWalkingFrame | None = None
        stance = Stance.at(0.0, 0.0, 0.0, build)
        self.body = MovingBody(now, stance, self._standing(stance))

    # Position and posture.

    @property
    def now(self) -> float:
        """The present time of this person, s."""
        return self.body.now

    @property
    def position(self) -> Array:
        """The point (2,) between the feet, m."""
        return self.body.position

    @property
    def floor_height(self) -> float:
        """The height of the floor under the person, m."""
        return self._storeys[self.storey].height if self._storeys else 0.0

    @property
    def is_ignored(self) -> bool:
        """Whether the person is no obstacle to others: away, or a cat."""
        return self.posture == AWAY or self.build.is_cat

    def put(self, at: Array, yaw: float, storey: int) -> None:
        """Put the person at a point (2,) at once, standing and looking along `yaw`."""
        self.storey = storey
        stance = Stance.at(float(at[0]), float(at[1]), yaw, self.build)
        self.body.put(stance, self._standing(stance))

    def put_away(self, at: Array, yaw: float, storey: int) -> None:
        """Put the person at a point (2,) out of the home, as at the start of a day."""
        self.put(at, yaw, storey)
        self.posture, self.place = AWAY, ""

    def put_at_place(self, place: Place, posture: str, floor: Floor) -> None:
        """Put the person at a place in a posture at once, as at the start of a day.

        A walking frame is left beside the place, on the free floor `floor`.
        """
        if self.build.frame:
            beside = parking_near(floor, place.at[:2], self.build)
            if beside is not None:
                frame = walking_frame_pose(*beside, self.floor_height, self.build)
                self.parked_frame = ParkedWalkingFrame(frame, *beside)
        self.put(place.at[:2], place.yaw, place.storey)
        body = self.body
        if posture in (SITTING, LYING):
            point, yaw, seat = self.seat_approach(place)
            self.put(point, yaw, place.storey)
            body.pose = sitting(body.pose, seat)
            self.seated = Seated(place, body.pose)
        if posture == LYING:
            body.pose = lying(body.pose, place.target, place.yaw)
        self.posture, self.place, self.last_place = posture, place.name, place.name

    def set_posture(self, posture: str, place: str = "") -> None:
        """Set posture and place; if either changes, end the present stay and begin another."""
        if (posture, place) != (self.posture, self.place):
            self.end_stay()
            self.posture, self.place = posture, place
            self.last_place = place or self.last_place

    def end_stay(self) -> None:
        """End and record the present stay, a time spent at one place in one posture."""
        if self.now > self._stay_began:
            stay = Stay(self._stay_began, self.now, self.name, self.place, self.posture)
            self.stays.append(stay)
        self._stay_began = self.now

    # Standing and walking.

    @property
    def _walking_build(self) -> Build:
        """The person's build, without the walking frame while it is left behind."""
        return self.build if self.parked_frame is None else replace(self.build, frame=False)

    def _standing(self, stance: Stance) -> BodyPose:
        pose = standing(stance, self.floor_height, self._walking_build)
        return _with_parked_frame(self.parked_frame, pose)

    def stay_until(self, until: float) -> None:
        """Keep the body still until a time, s; do nothing if this time has passed."""
        if until <= self.now:
            return
        body, away = self.body, self.posture == AWAY
        if (
            abs(body.stance.yaw) > math.pi
            and self.seated is None
            and until > self.now + UNWIND_AFTER
        ):
            body.keep_still(self.now + UNWIND_AFTER, away)
            body.unwind_heading(self.parked_frame is None, away)
        body.keep_still(until, away)

    def walk(self, path: Array, yaw: float | None) -> None:
        """Walk along closely spaced points (n, 2), then turn to look along `yaw`, rad.

        If `yaw` is None, the person does not turn at the end.
        """
        build, parked = self._walking_build, self.parked_frame
        steps = footsteps(self.body.stance, path, yaw, build)
        if len(steps) <= 2:
            return
        walk = Walk(steps, build.speed, self.floor_height, build)
        self.body.add_walk(walk, lambda t: _with_parked_frame(parked, walk.pose(t)))

    def leave_walking_frame(self) -> None:
        """Let go of the walking frame and leave it behind at the present position."""
        at, yaw = self.position, self.body.stance.yaw
        frame = walking_frame_pose(at, yaw, self.floor_height, self.build)
        self.parked_frame = ParkedWalkingFrame(frame, at, yaw)
        self._move_hands_to_frame()

    def take_walking_frame(self) -> None:
        """Take hold of the walking frame that was left at the present position."""
        self.parked_frame = None
        self._move_hands_to_frame()

    def _move_hands_to_frame(self) -> None:
        """Move the hands to the handles of the walking frame, or away from a frame left behind."""
        before, after = self.body.pose, self._standing(self.body.stance)
        self.body.add_clip(HANDS, lambda t: before.interpolated(after, ease(t / HANDS)))

    # Sitting and lying.

    def seat_approach(self, place: Place) -> tuple[Array, float, Array]:
        """Return where a person stands before sitting down (2,), the yaw there, and the seat (3,).

        A cat stands at the place itself and leaps from there.
        """
        if self.build.is_cat:
            return place.at[:2], place.yaw, place.target
        seat, yaw = find_seat(place)
        ahead = np.array([math.cos(yaw), math.sin(yaw)])
        return seat[:2] + seat_distance(self.build) * ahead, yaw, seat

    def sit(self, place: Place) -> None:
        """Step to the seat, turn around and sit down."""
        point, yaw, seat = self.seat_approach(place)
        path = np.array([self.position, point])
        far = math.hypot(*(path[1] - path[0])) > 0.04
        self.walk(resample(path) if far else path[:1], yaw)
        stand = self.body.pose
        pose = sitting(stand, seat)
        self.body.add_clip(SIT_DOWN, lambda t: sitting_down(stand, pose, t / SIT_DOWN))
        self.seated = Seated(place, pose)
        self.set_posture(SITTING, place.name)

    def lie(self, place: Place) -> None:
        """Lie down on a bed; the person must sit on its edge."""
        assert self.seated is not None
        seated, flat = self.seated.pose, lying(self.seated.pose, place.target, place.yaw)
        self.body.add_clip(LIE_DOWN, lambda t: lying_down(seated, flat, t / LIE_DOWN))
        self.seated = replace(self.seated, side=0)
        self.set_posture(LYING, place.name)

    def rise(self) -> None:
        """Get up from a seat or bed and stand before it; do nothing if the person stands."""
        if self.seated is None:
            return
        place, seated, flat = self.seated.place, self.seated.pose, self.body.pose
        if self.posture == LYING:
            self.set_posture(SITTING)
            self.body.add_clip(LIE_DOWN, lambda t: lying_down(seated, flat, 1.0 - t / LIE_DOWN))
        self.set_posture(STANDING)
        stand = self._standing(self.body.stance)
        self.body.add_clip(SIT_DOWN, lambda t: sitting_down(stand, seated, 1.0 - t / SIT_DOWN))
        self.seated = None
        if math.hypot(*(place.at[:2] - self.position)) > 0.3:
            self.walk(resample(np.array([self.position, place.at[:2]])), None)

    def turn_over(self, side: int) -> None:
        """Turn over in bed: to the back (0), the left (1) or the right side (−1).

        Do nothing if the person does not lie.
        """
        if self.seated is None or self.posture != LYING:
            return
        place, before = self.seated.place, self.body.pose
        after = lying(self.seated.pose, place.target, place.yaw, side)
        self.body.add_clip(TURN_OVER, lambda t: turning_over(before, after, t / TURN_OVER))
        self.seated = replace(self.seated, side=side)

    # Small movements.

    def shift(self, size: float = 1.0) -> None:
        """Make a small movement on the spot; a larger `size` makes it wider and slower."""
        slow = math.sqrt(size)
        self.body.add_gesture(
            2.6 * slow, slow, 1.2 * slow, lambda pose, t, w: shifted(pose, t, w * size)
        )
        self.stay_until(self.now + 2.6 * slow + 0.1)

    def look_around(self, seconds: float = LOOK) -> None:
        """Look to both sides for `seconds` s; a cat makes a small movement instead."""
        if self.build.is_cat:
            self.shift()
            return
        began = self.now
        self.body.add_gesture(
            seconds, 0.5, 0.5, lambda pose, t, w: looking_around(pose, t - began, seconds, w)
        )
        self.stay_until(self.now + seconds)


def _with_parked_frame(parked: ParkedWalkingFrame | None, pose: BodyPose) -> BodyPose:
    """Return the pose with the walking frame where it was left; unchanged if it was not left."""
    return pose if parked is None else replace(pose, walker=parked.frame[None])
