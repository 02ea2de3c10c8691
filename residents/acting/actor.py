# SPDX-License-Identifier: GPL-3.0-or-later
"""One person's body through the day: each method adds what is done next, with hands at work, seats,
and the place where a walking frame is left."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...sensor_logic.model import Array
from ..body.gait import AHEAD, Stand, placed_frame
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
from .ground import dense, yaw_to
from .home import HomeInUse
from .places import LIE, Door, Place
from .timeline import AWAY, LYING, SITTING, STANDING, Clip, Gesture, Hold, Stay, Timeline
from .ways import Floor

# Hands at work: washing, cooking, tidying, and on the handles of doors.

# Hands are so long at a spot, s (median, log-normal), and go so fast to another, up to so far to
# the sides and nearer, m.
AT_SPOT, GOES, WIDE, DEEP = (2.5, 1.0), 0.7, 0.18, 0.08
# A hand follows a leaf about so far (rad, or m of what slides), where it opens to and behind it.
FOLLOWS = {1.0: 0.73, -1.0: 0.49}
SLIDES_ALONG = 0.6
GRIP = 0.05  # from the middle of a leaf to the hand on its handle, m


def hands_at_work(
    point: Array, yaw: float, began: float, seconds: float, stream: Stream
) -> Callable[[float, Array], Array]:
    """The places (n, 3) of a hand, +1 the left and -1 the right, at times (n,), of a person who
    looks along a yaw and works for so many seconds: now here, now there about a point, never
    still."""
    across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    nearer = -np.array([math.cos(yaw), math.sin(yaw), 0.0])
    begins, spots = _spots(seconds, stream)
    spots = spots @ np.stack([across, nearer])

    def hand(sign: float, times: Array) -> Array:
        since = times - began
        index = np.searchsorted(begins, since, side="right") - 1
        share = ease((since - begins[index]) / GOES)[:, None]
        spot = spots[index] + (spots[index + 1] - spots[index]) * share
        rub = np.stack(
            [0.02 * np.sin(7 * since), 0 * since, 0.012 * np.sin(5.1 * since + sign)], -1
        )
        moved: Array = spot + point + sign * (0.045 * across + rub)
        return moved

    return hand


def hand_on_leaf(
    door: Door, here: Array, moves: tuple[float, float], start: float, seconds: float
) -> Callable[[Array], Array]:
    """The places (n, 3) of a hand on the handle at times (n,), of a person who stands `here` (2,),
    while the leaf moves from one opening to another; the hand follows while it reaches."""
    limit = SLIDES_ALONG if door.slides else FOLLOWS[door.side(here)]
    away = yaw_to(door.handle_at(door.closed), here)
    towards = GRIP * np.array([math.cos(away), math.sin(away), 0.0])
    before, after = moves

    def grip(times: Array) -> Array:
        out = before + (after - before) * ease((times - start) / seconds) - door.closed
        near = door.closed + limit * np.tanh(out / limit)
        return np.array([door.handle_at(float(one)) for one in near]) + towards

    return grip


def _spots(seconds: float, stream: Stream) -> tuple[Array, Array]:
    """When hands at work go elsewhere (n,), s, the first at 0, and where they are before and after
    (n + 1, 2): m to the left and towards the body."""
    begins, spots = [0.0], [(0.0, 0.0), (0.0, 0.0)]
    while (after := begins[-1] + max(stream.log_normal(*AT_SPOT), GOES)) < seconds:
        begins.append(after)
        spots.append((WIDE * (2 * stream.uniform() - 1), DEEP * stream.uniform()))
    return np.array(begins), np.array(spots)


# Finds where the hips of a sitting person go.


def seat_of(place: Place) -> tuple[Array, float]:
    """What carries the hips (3,), and the yaw of who sits there; at a bed, on its edge."""
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


# Finds where a person leaves the walking frame where it does not fit, as at a stove.

# The frame's sides from its middle, ahead and across, m, for one of the skeleton's size; how far
# apart the points are that are looked at.
SIDES_M, SPACING_M = (0.33, 0.30), 0.06
# So far before where one goes the frame is left, m; so far from it one walks without.
BACK_M, NEAR_M = 2.0, 1.6
# Ways to turn with it, beside none, rad.
_TURNS = [sign * math.radians(k * 30.0) for k in range(1, 7) for sign in (1.0, -1.0)]
At = tuple[Array, float]  # where one stands (2,), and looks (rad)


@dataclass(frozen=True, eq=False)
class Parked:
    """The frame (4,), as `placed_frame` has it, and where one stands with a hand on it."""

    frame: Array
    at: Array
    yaw: float


def frame_of(at: Array, yaw: float, floor: float, build: Build) -> Array:
    """(4,): the frame before one who stands at a point (2,)."""
    placed: Array = placed_frame(at[:1], at[1:2], np.array([yaw]), floor, build)[0]
    return placed


def fits(floor: Floor, at: Array, yaw: float, build: Build) -> bool:
    """Whether the frame of one who stands there stands on free floor."""
    x, y, _, _ = frame_of(at, yaw, 0.0, build)
    ahead, across = (np.arange(-s, s + 1e-9, SPACING_M) * build.scale for s in SIDES_M)
    u, v = (a.ravel() for a in np.meshgrid(ahead, across))
    c, s = math.cos(yaw), math.sin(yaw)
    points = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    cells = np.floor((points - floor.low) / floor.size).astype(int)
    inside = ((cells >= 0) & (cells < floor.free.shape)).all()
    return bool(inside) and bool(floor.free[cells[:, 0], cells[:, 1]].all())


def parked_on(
    floor: Floor, points: Array, ends: Sequence[At], build: Build
) -> tuple[int, float] | None:
    """The point of a way of dense points (n, 2) at which the walking frame is left, and the yaw
    that it is turned to; None if it fits to the end, or nowhere."""
    if all(fits(floor, at, yaw, build) for at, yaw in ends):
        return None
    gaps = np.diff(points, axis=0)
    far = np.concatenate([np.cumsum(np.hypot(*gaps.T)[::-1])[::-1], [0.0]])
    for k in range(len(points) - 1, 0, -3):
        if far[k] > BACK_M:
            break
        before = points[k] - points[max(k - 5, 0)]
        heading = math.atan2(before[1], before[0])
        for turn in (0.0, *_TURNS):
            steps = np.linspace(0.0, turn, 1 + round(abs(turn) / math.radians(30.0)))
            frame = frame_of(points[k], heading + turn, 0.0, build)
            off = np.hypot(*(points[k:] - frame[:2]).T).min()
            if off >= 0.9 * AHEAD * build.scale and all(
                fits(floor, points[k], heading + step, build) for step in steps
            ):
                return k, heading + turn
    return None


def parked_beside(floor: Floor, at: Array, build: Build) -> At | None:
    """The nearest stand to a point from which the frame fits."""
    for point in _around(at):
        if floor.clearance[floor.cell(point)] < 0.2:
            continue
        for k in range(12):
            yaw = k * math.pi / 6
            if fits(floor, point, yaw, build):
                return point, yaw
    return None


def _around(at: Array) -> Iterable[Array]:
    yield at
    for radius in (0.3, 0.6, 0.9, 1.2):
        for k in range(12):
            yield at + radius * np.array([math.cos(k * math.pi / 6), math.sin(k * math.pi / 6)])


# Half of the width that somebody needs on the way, m.
RADIUS = {Sort.OLDER_ADULT: 0.25, Sort.ADULT: 0.25, Sort.CHILD: 0.20, Sort.CAT: 0.10}
WITH_FRAME = 0.30
# Seconds.
REACH, SWING, SIT_DOWN, LIE_DOWN, TURN_OVER, LOOK = 0.6, 1.7, 1.7, 3.2, 2.6, 4.0
# To drink; to let go of the walking frame or take hold of it.
DRINK, HANDS = 3.6, 0.8
# So long somebody has stood still before whole turns are taken back, s: more than a frame.
WOUND = 0.5


class Actor:
    """Times are seconds since midnight. `place` is the name of where the person is; empty on the
    way."""

    def __init__(self, name: str, build: Build, home: HomeInUse, now: float) -> None:
        self.name, self.build, self.home = name, build, home
        self.now = self.since = now
        self.unseen = build.is_cat
        self.radius = WITH_FRAME if build.frame else RADIUS[build.sort]
        self.storey, self.place, self.posture = 0, "", STANDING
        self.last_place = ""
        self.line = Timeline()
        self.stays: list[Stay] = []
        self.wish: Array | None = None
        self.wished, self.cornered = now, False
        self.parked: Parked | None = None
        self.hands: dict[str, tuple[int, float]] = {}
        self._track: list[tuple[float, float, float]] = []
        self._posed_since = now
        self._seat: Place | None = None
        self._seated: BodyPose | None = None
        self.side = 0
        self.put_down(np.zeros(2), 0.0, 0)

    # --- where the person is ------------------------------------------------------------------
    def put_down(self, at: Array, yaw: float, storey: int) -> None:
        """Standing there, without having come."""
        self.storey = storey
        self.stand = Stand.at(float(at[0]), float(at[1]), yaw, self.build)
        self.pose = self._standing()
        self._track.append((self.now, *self.stand.centre))

    def _standing(self) -> BodyPose:
        return _beside(self.parked, standing(self.stand, self.floor, self._walks_as))

    @property
    def _walks_as(self) -> Build:
        """Without the frame where that was left behind."""
        return self.build if self.parked is None else replace(self.build, frame=False)

    @property
    def floor(self) -> float:
        storeys = self.home.places.storeys
        return storeys[self.storey].height if storeys else 0.0

    @property
    def here(self) -> Array:
        return np.array(self.stand.centre)

    def where(self, times: Array) -> Array:
        """Middles (n, 2) at times (n,), as far as is known; after that where the person stands."""
        first = bisect_right(self._track, (float(times.min()), math.inf)) - 1
        track = np.array(self._track[max(first, 0) :])
        return np.column_stack([np.interp(times, track[:, 0], track[:, k]) for k in (1, 2)])

    def be(self, posture: str, place: str = "") -> None:
        """Changes the posture and the place."""
        if (posture, place) != (self.posture, self.place):
            self.end_stay()
            self.posture, self.place = posture, place
            self.last_place = place or self.last_place
        self.unseen = posture == AWAY or self.build.is_cat

    def end_stay(self) -> None:
        if self.now > self._posed_since:
            stay = Stay(self._posed_since, self.now, self.name, self.place, self.posture)
            self.stays.append(stay)
        self._posed_since = self.now

    # --- pieces -------------------------------------------------------------------------------
    def clip(self, seconds: float, pose: Callable[[Array], BodyPose]) -> None:
        self.line.clips.append(Clip(self.now, self.now + seconds, pose))
        self.now += seconds
        self.pose = pose(np.array([seconds]))

    def stay(self, until: float) -> None:
        """Still, as the person is."""
        if until <= self.now:
            return
        if abs(self.stand.yaw) > math.pi and self._seated is None and until > self.now + WOUND:
            self._keep_still(self.now + WOUND)
            self._wind_back()
        self._keep_still(until)

    def _wind_back(self) -> None:
        """Whole turns are taken back, while nothing moves that would show it."""
        turn = -2 * math.pi * round(self.stand.yaw / (2 * math.pi))
        left, right = (replace(f, yaw=f.yaw + turn) for f in (self.stand.left, self.stand.right))
        self.stand = Stand(left, right)
        walker = self.pose.walker + (0.0, 0.0, 0.0, turn if self.parked is None else 0.0)
        self.pose = replace(self.pose, heading=self.pose.heading + turn, walker=walker)
        pose = self.pose
        self.line.clips.append(
            Clip(self.now, self.now, lambda _times: pose, still=True, away=self.posture == AWAY)
        )

    def _keep_still(self, until: float) -> None:
        pose, gone, clips = self.pose, self.posture == AWAY, self.line.clips
        if clips and clips[-1].still and clips[-1].away == gone:
            clips[-1] = replace(clips[-1], end=until)
        else:
            clips.append(Clip(self.now, until, lambda _times: pose, still=True, away=gone))
        self.now = until

    def gesture(
        self, seconds: float, rise: float, fall: float,
        apply: Callable[[BodyPose, Array, Array], BodyPose], begins: float = 0.0,
    ) -> None:  # fmt: skip
        start = self.now + begins
        self.line.gestures.append(Gesture(start, start + seconds, rise, fall, apply))

    def walk(self, path: Array, yaw: float | None) -> None:
        """Along dense points (n, 2) and then turned to a yaw."""
        build = self._walks_as
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

        self.clip(walk.duration, lambda since: _beside(left, walk.pose(since)))
        self.stand, self.since = walk.end, self.now
        self._track.append((self.now, *self.stand.centre))

    # --- sitting and lying --------------------------------------------------------------------
    def sit(self, place: Place) -> None:
        """Sits down: the last steps to the seat, a turn, and down."""
        point, yaw, seat = self.before(place)
        self._step_to(point, yaw)
        stand = self.pose
        seated = sitting(stand, seat)
        self.clip(SIT_DOWN, lambda t: sitting_down(stand, seated, t / SIT_DOWN))
        self._seat, self._seated = place, seated
        self.be(SITTING, place.name)

    # --- the walking frame ----------------------------------------------------------------------
    def leave_frame(self) -> None:
        """Lets go of the walking frame, which stays here."""
        yaw = self.stand.yaw
        self.parked = Parked(frame_of(self.here, yaw, self.floor, self.build), self.here, yaw)
        self._hands_off_or_on()

    def take_frame(self) -> None:
        """Takes hold of the walking frame again, beside which the person stands."""
        self.parked = None
        self._hands_off_or_on()

    def _hands_off_or_on(self) -> None:
        before, after = self.pose, self._standing()
        self.clip(HANDS, lambda t: before.mixed(after, ease(t / HANDS)))

    def before(self, place: Place) -> tuple[Array, float, Array]:
        """Where the feet (2,) of somebody stand who sits there, the yaw, and the seat (3,). A cat
        leaps from the floor."""
        if self.build.is_cat:
            return place.at[:2], place.yaw, place.target
        seat, yaw = seat_of(place)
        ahead = np.array([math.cos(yaw), math.sin(yaw)])
        return seat[:2] + seat_distance(self.build) * ahead, yaw, seat

    def _step_to(self, point: Array, yaw: float) -> None:
        """A step or two to where no way leads, as between a chair and its table."""
        path = np.array([self.here, point])
        far = math.hypot(*(path[1] - path[0])) > 0.04
        self.walk(dense(path) if far else path[:1], yaw)

    def lie(self, place: Place) -> None:
        """Lies down from sitting on the edge."""
        assert self._seated is not None
        seated, flat = self._seated, lying(self._seated, place.target, place.yaw)
        self.clip(LIE_DOWN, lambda t: lying_down(seated, flat, t / LIE_DOWN))
        self.side = 0
        self.be(LYING, place.name)

    def rest_at(self, place: Place, posture: str) -> None:
        """Starts in a posture at a place, without a way to it."""
        if self.build.frame:
            floor = self.home.ground.floor(place.storey, {})
            beside = parked_beside(floor, place.at[:2], self.build)
            if beside is not None:
                frame = frame_of(*beside, self.floor, self.build)
                self.parked = Parked(frame, *beside)
        self.put_down(place.at[:2], place.yaw, place.storey)
        if posture in (SITTING, LYING):
            point, yaw, seat = self.before(place)
            self.put_down(point, yaw, place.storey)
            self._seat, self._seated = place, sitting(self.pose, seat)
            self.pose = self._seated
        if posture == LYING:
            self.pose = lying(self.pose, place.target, place.yaw)
        self.posture, self.place = posture, place.name
        self.last_place = place.name

    def rise(self) -> None:
        """Gets up, to stand before the seat or bed."""
        if self._seated is None or self._seat is None:
            return
        seated, flat = self._seated, self.pose
        if self.posture == LYING:
            self.be(SITTING)
            self.clip(LIE_DOWN, lambda t: lying_down(seated, flat, 1.0 - t / LIE_DOWN))
        self.be(STANDING)
        stand = self._standing()
        self.clip(SIT_DOWN, lambda t: sitting_down(stand, seated, 1.0 - t / SIT_DOWN))
        at, self._seat, self._seated = self._seat.at[:2], None, None
        if math.hypot(*(at - self.here)) > 0.3:
            self.walk(dense(np.array([self.here, at])), None)

    def turn_over(self, side: int) -> None:
        """Turns over in bed: to the back (0), the left (1) or the right side (-1)."""
        if self._seat is None or self._seated is None:
            return
        before = self.pose
        after = lying(self._seated, self._seat.target, self._seat.yaw, side)
        self.clip(TURN_OVER, lambda t: turning_over(before, after, t / TURN_OVER))
        self.side = side

    # --- hands --------------------------------------------------------------------------------
    def shift(self, size: float = 1.0) -> None:
        """Moves a little on the spot; what is larger takes longer."""
        slow = math.sqrt(size)
        self.gesture(2.6 * slow, slow, 1.2 * slow, lambda pose, t, w: shifted(pose, t, w * size))
        self.stay(self.now + 2.6 * slow + 0.1)

    def look_around(self, seconds: float = LOOK) -> None:
        if self.build.is_cat:
            self.shift()
            return
        began = self.now
        self.gesture(
            seconds, 0.5, 0.5, lambda pose, t, w: looking_around(pose, t - began, seconds, w)
        )
        self.stay(self.now + seconds)

    def hand_for(self, point: Array) -> int:
        """The hand that is nearer to a point, or the one that holds nothing."""
        x, y = self.pose.pelvis[0, :2]
        yaw = float(self.pose.heading[0])
        side = 0 if -(point[0] - x) * math.sin(yaw) + (point[1] - y) * math.cos(yaw) > 0.02 else 1
        full = [hand for hand, _ in self.hands.values()]
        return 1 - side if side in full else side

    def draw_hand(
        self, side: int, point: Callable[[Array], Array], seconds: float,
        rise: float = REACH, fall: float = 0.55, most: float = 1.0, begins: float = 0.0,
    ) -> None:  # fmt: skip
        """A hand goes to points (n, 3) at times (n,)."""
        sits, lies = self.posture == SITTING, self.posture == LYING
        slide, most = (0.12 if sits else -0.03), (0.0 if lies else most)
        self.gesture(
            seconds, rise, fall,
            lambda pose, t, w: reaching(pose, side, point(t), w, slide, most), begins,
        )  # fmt: skip

    def touch(self, point: Array) -> float:
        """A hand at a point for a moment; when it is there."""
        self.draw_hand(self.hand_for(point), lambda _t: point, 1.8, 0.9, 0.8)
        at = self.now + 0.95
        self.stay(self.now + 1.85)
        return at

    def busy(self, point: Array, seconds: float, stream: Stream) -> None:
        """Both hands at something: washing, cooking. They are now here, now there. A cat has
        none."""
        if self.build.is_cat:
            self.gesture(seconds, min(0.8, seconds / 2), min(0.8, seconds / 2), shifted)
            self.stay(self.now + seconds)
            return
        full = [hand for hand, _ in self.hands.values()]
        hand = hands_at_work(point, float(self.pose.heading[0]), self.now, seconds, stream)
        rise = min(0.8, seconds / 2)
        for side, sign in ((0, 1.0), (1, -1.0)):
            if side not in full:
                self.draw_hand(side, partial(hand, sign), seconds, rise, rise)
        self.stay(self.now + seconds)

    def take(self, thing: str, point: Array) -> None:
        side = self.hand_for(point)
        at = self.touch(point)
        self.hands[thing] = side, at
        self.home.holds.setdefault(thing, []).append(Hold(at, side, person=self.name))

    def put(self, thing: str, place: Place) -> None:
        at = self.touch(place.target)
        self._let_go(thing, at)
        self.home.holds[thing].append(Hold(at, None, self.home.put_at(thing, place)))

    def drink(self, thing: str) -> None:
        """The hand that holds a thing goes to the mouth."""
        side, _ = self.hands[thing]
        self.gesture(DRINK, 1.1, 1.0, lambda pose, _t, w: drinking(pose, side, w))
        self.home.sips.setdefault(thing, []).append(sip(self.now))
        self.stay(self.now + DRINK + 0.1)

    def _let_go(self, thing: str, at: float) -> None:
        side, since = self.hands.pop(thing)
        carried = Gesture(since - 0.4, at + 0.5, 0.8, 0.7,
                          lambda pose, _t, w: carrying(pose, side, w), steady=True)  # fmt: skip
        self.line.gestures.append(carried)

    # --- leaves -------------------------------------------------------------------------------
    def move_leaf(self, door: Door, after: float) -> None:
        """A hand on the handle while the leaf is in reach: first or last part of its way."""
        hand = self.hand_for(door.handle_at(door.closed))
        opening = abs(after - door.closed) > 0.02
        start = self.now + (REACH if opening else 0.1)
        end = start + SWING
        grip = hand_on_leaf(door, self.here, (self.home.opening(door), after), start, SWING)
        self.home.swing(door, start, end, after, self.name)
        if opening:
            self.draw_hand(hand, grip, start + 1.1 - self.now, most=0.25)
            self.stay(end - 0.25)
        else:
            begins = end - 1.15 - self.now
            self.draw_hand(hand, grip, 1.7, most=0.25, begins=begins)
            self.stay(end + 0.55)

    def finish(self) -> None:
        for thing in list(self.hands):
            self._let_go(thing, self.now + 1.0)
        self.end_stay()
        # A hand that carries is drawn elsewhere only after that.
        self.line.gestures.sort(key=lambda gesture: gesture.start)


def sip(began: float) -> Gesture:
    """When what is drunk from is tilted, by somebody who begins to drink."""
    return Gesture(began + 0.5, began + 3.1, 0.9, 0.8, lambda pose, _t, _w: pose)


def _beside(parked: Parked | None, pose: BodyPose) -> BodyPose:
    """A frame that was left stays where it is."""
    return pose if parked is None else replace(pose, walker=parked.frame[None])
