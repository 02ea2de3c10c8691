# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk of a person, with or without a walking frame.

The phase of a walk counts steps. At phase i, the foot of step i alone carries the body. This foot
lands at phase i − 0.55 and leaves the floor at i + 0.6. So both feet are on the floor for 0.15 of
each step. A foot on the floor stays where it landed, apart from the roll from heel to ball.

All lengths are for an unscaled skeleton, and are multiplied by the scale of the build.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, cos, hypot, pi, radians, sin

import numpy as np

from ...sensor_logic.model import Array, Index
from .pose import Arms, BodyPose, Feet, single
from .skeleton import ADULT, ANKLE, BALL, HEEL_X, PERSON, SIGN, TOE, Build
from .solve import SHIN, THIGH
from .surface import smooth_min, smooth_table
from .turns import X, compose, compose_all, ease, rotated, rotation_x, rotation_y, rotation_z

# The walking frame and the hands on its handles.

# For an unscaled skeleton, m: the frame's centre ahead of the hips; its handles from the centre
# (x, y) and above the floor.
AHEAD = 0.40
HANDLE_BACK, HANDLE_SIDE, HANDLE_HEIGHT = -0.16, 0.25, 0.86
_WRIST = 0.07  # behind the knuckles and above the handle


def walking_frame_poses(x: Array, y: Array, yaw: Array, floor: float, build: Build) -> Array:
    """Return positions and yaws of a person's walking frame.

    Parameters
    ----------
    x, y, yaw : array, shape (n,)
        Position of the person, m, and direction, rad.
    floor : float
        Height of the floor, m.
    build : Build
        The person's build.

    Returns
    -------
    array, shape (n, 4)
        x, y and z in m, yaw in rad.
    """
    ahead = AHEAD * build.scale
    return np.stack(
        [x + ahead * np.cos(yaw), y + ahead * np.sin(yaw), np.full(len(x), floor), yaw], -1
    )


def pushing(pose: BodyPose) -> BodyPose:
    """Return the poses of pushing a walking frame: both hands on its handles, leaning forward.

    If the body model (`pose.build`) has no walking frame, return the poses unchanged.
    """
    if not pose.build.frame:
        return pose
    at = [(HANDLE_BACK - _WRIST, sign * HANDLE_SIDE, HANDLE_HEIGHT + 0.03) for sign in SIGN]
    turn = rotation_z(pose.walker[:, 3])[:, None]
    target = pose.walker[:, None, :3] + rotated(turn, np.array(at) * pose.build.scale)
    spine = pose.spine + np.array([0.0, 0.10, 0.0])
    look = pose.look - np.array([0.0, 0.10, 0.0])
    arms = replace(pose.arms, target=target, grip=np.ones((len(target), 2)))
    return replace(pose, arms=arms, spine=spine, look=look)


ANKLE_HEIGHT = float(ANKLE[2])
BALL_AHEAD = float(BALL[0] - ANKLE[0])  # from the ankle, along the sole
TOE_AHEAD = float(TOE[0] - ANKLE[0])
HEEL_BEHIND = float(ANKLE[0] - HEEL_X)
STAND_HEIGHT = 0.932  # pelvis above the sole, with slightly bent knees
STAND_HALF_WIDTH = 0.088
WALK_HALF_WIDTH = 0.055
TOE_OUT = radians(6)
TURN_STEP = radians(55)  # largest turn of one step on the spot
LIFT, LAND = 0.6, 0.55  # phase after and before mid-stance
LEG = 0.998 * (THIGH + SHIN)
_HIPS = [PERSON.head[f"thigh.{side}"] - PERSON.head["pelvis"] for side in "LR"]
# Pitch of the sole (degrees, toes up positive) by phase from mid-stance.
_PITCH = np.array(
    [
        (-0.55, 18.0), (-0.40, 0.0), (0.10, 0.0), (0.40, -20.0), (0.60, -40.0),
        (0.72, -44.0), (1.00, -10.0), (1.25, 13.0), (1.45, 18.0),
    ]
)  # fmt: skip


@dataclass(frozen=True)
class Footstep:
    """A foot on the floor: its side (0 left, 1 right), position and yaw.

    The position is the point under the ankle, m. The yaw is the body's, rad.
    """

    side: int
    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Stance:
    """The positions of both feet of a standing person."""

    left: Footstep
    right: Footstep

    @staticmethod
    def at(x: float, y: float, yaw: float, build: Build = ADULT) -> Stance:
        """Return the stance with its centre at x, y (m) that faces along `yaw` (rad)."""
        half = STAND_HALF_WIDTH * build.scale
        return Stance(_footstep_beside(x, y, yaw, 0, half), _footstep_beside(x, y, yaw, 1, half))

    @property
    def centre(self) -> tuple[float, float]:
        """The point midway between the feet, m."""
        return (self.left.x + self.right.x) / 2, (self.left.y + self.right.y) / 2

    @property
    def yaw(self) -> float:
        """The mean yaw of both feet, rad."""
        return (self.left.yaw + self.right.yaw) / 2


def _footstep_beside(x: float, y: float, yaw: float, side: int, width: float) -> Footstep:
    """Return the footstep of one foot, `width` m to the left or right of the point x, y."""
    w = float(SIGN[side]) * width
    return Footstep(side, x - w * sin(yaw), y + w * cos(yaw), yaw)


def near_turn(angle: float, near: float) -> float:
    """Return `angle` plus the multiple of 2π that brings it nearest to `near`, rad."""
    return near + (angle - near + pi) % (2 * pi) - pi


# x, y, yaw, and half of the distance between the feet.
_Landing = tuple[float, float, float, float]


def footsteps(
    start: Stance, path: Array, end_yaw: float | None, build: Build = ADULT
) -> list[Footstep]:  # fmt: skip
    """Return the footsteps of a walk along the points (n, 2) of a path.

    The person turns on the spot before the path and, if `end_yaw` is given, after it. The first two
    footsteps are the stance of `start`, the last two the stance at the end.
    """
    scale, yaw = build.scale, start.yaw
    landings: list[_Landing] = []
    if np.hypot(*np.diff(path, axis=0).T).sum() > 0.04:
        landings = _steps_along(path, yaw, build)
        yaw = landings[-1][2]
    x, y = map(float, path[-1])
    if end_yaw is not None:
        turn = near_turn(end_yaw, yaw) - yaw
        landings += _turn_on_spot(x, y, yaw, turn, ceil(abs(turn) / TURN_STEP - 0.2), scale)
        yaw = yaw + turn
    if not landings:
        return [start.right, start.left]
    landings.append((x, y, yaw, STAND_HALF_WIDTH * scale))
    # The foot on the inside of the first bend leads.
    first_side = 0 if landings[0][2] >= start.yaw else 1
    standing = [start.left, start.right]
    steps = [standing[first_side], standing[1 - first_side]]
    for k, (x, y, heading, width) in enumerate(landings):
        steps.append(_footstep_beside(x, y, heading, (first_side + k) % 2, width))
    return steps


def _turn_on_spot(
    x: float, y: float, yaw: float, turn: float, count: int, scale: float
) -> list[_Landing]:
    """Return `count` footsteps that turn a person by `turn` (rad) on the spot."""
    half = STAND_HALF_WIDTH * scale
    return [(x, y, yaw + turn * k / count, half) for k in range(1, count + 1)]


def _steps_along(path: Array, yaw: float, build: Build) -> list[_Landing]:
    """Return the footsteps of a turn on the spot towards a path, and along the path."""
    gaps = np.diff(path, axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*gaps.T))])
    walked = float(along[-1])
    bends = np.unwrap(np.arctan2(gaps[:, 1], gaps[:, 0]))
    middle = (along[:-1] + along[1:]) / 2
    first = near_turn(float(bends[0]), yaw)
    bends = bends + (first - float(bends[0]))
    turn = first - yaw
    landings: list[_Landing] = []
    if abs(turn) > radians(35):
        x, y = map(float, path[0])
        landings = _turn_on_spot(x, y, yaw, turn, ceil(abs(turn) / TURN_STEP), build.scale)
    count = max(1, round(walked / build.step_length + 0.55))
    shares = np.ones(count)
    shares[0] -= 0.25 * (count > 1)
    shares[-1] -= 0.15 * (count > 1)
    for s in np.cumsum(shares) / shares.sum() * walked:
        # Feet land with the heading of the path a little ahead.
        heading = float(np.interp(s + 0.15, middle, bends))
        width = STAND_HALF_WIDTH if s > walked - 1e-6 else WALK_HALF_WIDTH
        x, y = (float(np.interp(s, along, path[:, axis])) for axis in (0, 1))
        landings.append((x, y, heading, width * build.scale))
    return landings


def spline(points: Array, at: Array) -> Array:
    """Evaluate a uniform cubic B-spline.

    Parameters
    ----------
    points : array, shape (k, d)
        Control points. The first and the last one are repeated.
    at : array, shape (n,)
        Curve parameters. At the parameter i, the curve is near the control point i.

    Returns
    -------
    array, shape (n, d)
        The points of the curve.
    """
    i = np.floor(at).astype(int)
    t = (at - i)[:, None]
    a, b, c, d = (points[np.clip(i + k, 0, len(points) - 1)] for k in (-1, 0, 1, 2))
    result: Array = (
        a * (1 - t) ** 3 + b * (3 * t**3 - 6 * t**2 + 4)
        + c * (-3 * t**3 + 3 * t**2 + 3 * t + 1) + d * t**3
    ) / 6  # fmt: skip
    return result


class Walk:
    """A person's walk over given footsteps, from standing to standing.

    It begins at phase −1.5. `speed` is in m/s, and `floor` is the height of the floor in m.
    """

    def __init__(
        self, steps: list[Footstep], speed: float, floor: float, build: Build = ADULT
    ) -> None:  # fmt: skip
        # steps[0] and steps[1] have the numbers −1 and 0.
        self.steps, self.floor, self.build = steps, floor, build
        self.last = len(steps) - 2  # number of the last landing
        self.places = np.array([[a.x, a.y, a.yaw] for a in steps])
        self.middles = (self.places[:-1] + self.places[1:]) / 2  # row k holds at phase k − 0.5
        length = build.step_length
        travel = [0.0, 0.0] + [
            min(1.0, hypot(b.x - a.x, b.y - a.y) / (2 * length) + abs(b.yaw - a.yaw) * 0.12)
            for a, b in zip(steps, steps[2:], strict=False)
        ]
        self.effort = np.array(travel)  # share of a full swing, by footstep
        # Seconds a step: short steps are quicker; the first and last only shift the weight.
        step_time = length / speed
        seconds = [0.30] + [step_time * (0.84 + 0.16 * e) for e in travel[2:]] + [0.35]
        self.clock = np.concatenate([[0.0], np.cumsum(seconds)])
        self.phases = np.array([k - 1.5 for k in range(len(self.clock))])
        self.duration = float(self.clock[-1])
        self.left_step = next(k for k, step in enumerate(steps) if step.side == 0) - 1
        self.stride = min(1.0, length / (0.60 * build.scale))

    @property
    def end(self) -> Stance:
        """The stance at the end of the walk."""
        a, b = self.steps[-2:]
        return Stance(a, b) if a.side == 0 else Stance(b, a)

    def track(self) -> tuple[Array, Array]:
        """Return times (k,) since the start, s, and the body's positions (k, 2) at them, m."""
        return self.clock[1 : len(self.steps)], self.middles[:, :2]

    def _swing_at(self, phase: Array) -> Array:
        """Return the swing of the feet at phases (n,), divided by the swing of a full stride.

        Footstep k is in the air around phase k − 1.
        """
        at: Array = np.array([-1.5, *range(self.last), self.last + 0.3])
        full: Array = np.array([0.0, *self.effort[2:], 0.0])
        return self.stride * smooth_table(at, full, phase)

    def pose(self, seconds: Array) -> BodyPose:
        """Return the poses at times `seconds` (n,) since the start of the walk."""
        phase = smooth_table(self.clock, self.phases, np.asarray(seconds, float))
        x, y, yaw = np.ascontiguousarray(spline(self.middles, phase + 0.5).T)
        ahead = (spline(self.middles, phase + 1.6)[:, 2] - yaw) * ease((phase + 1.5) / 0.2)
        effort = self._swing_at(phase)
        scale = self.build.scale
        beat = pi * (phase - self.left_step)
        forth, carry = np.sin(beat), np.cos(beat)  # +1: left arm forward; weight on the left foot
        sway = 0.022 * scale * carry * np.minimum(1.0, 1.6 * effort)
        dip = 0.012 * np.minimum(1.0, 2 * effort)
        dip += 0.030 * effort**2 * (1 - np.cos(2 * beat)) / 2
        pelvis_yaw, roll = radians(5) * effort * forth, radians(2.5) * effort * carry
        turn = compose_all(
            rotation_z(yaw + pelvis_yaw), rotation_y(radians(2) * effort), rotation_x(roll)
        )
        stoop = self.build.stoop
        spine = np.stack([-0.9 * roll, stoop + radians(1.5) * effort, -1.9 * pelvis_yaw], -1)
        glance = 0.9 * pelvis_yaw + np.clip(0.8 * ahead, -0.6, 0.6)
        look = np.stack([-0.1 * roll, -stoop - radians(1) * effort, glance], -1)
        feet = self._feet(phase)
        pelvis = np.stack(
            [x - sway * np.sin(yaw), y + sway * np.cos(yaw),
             self.floor + scale * (STAND_HEIGHT - dip)], -1
        )  # fmt: skip
        pelvis[:, 2] = _pelvis_height(pelvis, turn, feet, scale)
        walker = walking_frame_poses(x, y, yaw, self.floor, self.build)
        arms = _swinging_arms(effort, forth)
        return pushing(
            BodyPose(self.build, yaw, pelvis, turn, feet, arms, spine, look, walker)
        )  # fmt: skip

    def _feet(self, phase: Array) -> Feet:
        left, right = (self._foot(side, phase) for side in (0, 1))
        return Feet(*(np.stack(pair, 1) for pair in zip(left, right, strict=True)))

    def _foot(self, side: int, phase: Array) -> tuple[Array, Array, Array, Array]:
        """Return the pose of one foot at phases (n,), with the arrays of `rolled_foot`."""
        mine: Index = np.array([k for k, step in enumerate(self.steps) if step.side == side])
        numbers = mine - 1
        i = np.maximum(np.searchsorted(numbers - LAND, phase, side="right") - 1, 0)
        here, u = self.places[mine[i]], phase - numbers[i]
        last = i == len(mine) - 1
        following = np.where(last, mine[i], np.minimum(mine[i] + 2, len(self.steps) - 1))
        after = self.places[following]
        leaving = np.where(last, 0.0, self.effort[following])
        arriving = np.where(u < 0, self.effort[mine[i]], leaving)
        pitch = np.radians(smooth_table(_PITCH[:, 0], _PITCH[:, 1], np.minimum(u, 1.45)))
        pitch = pitch * np.where(pitch < 0, leaving, arriving)
        air = np.where(last, 0.0, np.clip((u - LIFT) / (2 - LIFT - LAND), 0.0, 1.0))
        go = air * air * (3 - 2 * air) - 0.4 * air * air * (1 - air)  # slower towards the landing
        x, y, yaw = (here + go[:, None] * (after - here)).T
        clearance = 0.02 + 0.012 * (1 - leaving)
        yaw = yaw + SIGN[side] * TOE_OUT
        return rolled_foot(x, y, yaw, self.floor, pitch, air, clearance, self.build.scale)


def _swinging_arms(effort: Array, forth: Array) -> Arms:
    """Return the pose of arms that swing opposite to the legs.

    Parameters
    ----------
    effort : array, shape (n,)
        The amplitude of the swing, 0 … 1.
    forth : array, shape (n,)
        +1 with the left arm fully forward, −1 with the right arm fully forward.
    """
    swing = radians(23) * effort[:, None]
    both = SIGN * forth[:, None]
    whole = np.broadcast_to(effort[:, None], both.shape)
    return Arms(
        forward=0.03 + swing * both - 0.05 * whole,
        away=0.09 + 0.03 * whole,
        elbow=0.22 + 0.06 * whole + 0.40 * swing * (1 + both),
    )


def _pelvis_height(pelvis: Array, turn: Array, feet: Feet, scale: float) -> Array:
    """Return the pelvis height (n,), smoothly lowered where a leg does not reach its ankle."""
    height = pelvis[:, 2]
    for k, hip in enumerate(_HIPS):
        joint = rotated(turn, hip * scale)
        ankle = feet.ankle[:, k]
        flat = np.hypot(*(pelvis + joint - ankle)[:, :2].T)
        leg = np.sqrt(np.maximum(0.01, (LEG * scale) ** 2 - flat**2))
        most = ankle[:, 2] + leg - joint[:, 2]
        height = smooth_min(height, most, 0.012 * scale)
    return height


def rolled_foot(
    x: Array, y: Array, yaw: Array, floor: float, pitch: Array, air: Array, clearance: Array,
    scale: float,
) -> tuple[Array, Array, Array, Array]:  # fmt: skip
    """Return the pose of a foot that rolls about the heel (toes up) or the ball (heel up).

    Parameters
    ----------
    x, y, yaw : array, shape (n,)
        The point under the ankle of the flat foot, m, and its yaw, rad.
    floor : float
        Height of the floor, m.
    pitch : array, shape (n,)
        Pitch of the foot's sole, rad; positive with the toes up.
    air : array, shape (n,)
        0 while the foot is on the floor; from 0 to 1 while it swings.
    clearance : array, shape (n,)
        Height of the foot's sole in mid-swing, m.
    scale : float
        Scale of the build.

    Returns
    -------
    ankle : array, shape (n, 3)
        Position of the ankle, m.
    sole, toes : array, shape (n, 4)
        Rotations of the foot and of its toes.
    knee : array, shape (n, 3)
        The direction in which the knee points.
    """
    flat, tilt = rotation_z(yaw), rotation_y(-pitch)
    nothing = np.zeros_like(pitch)
    pivot = np.stack([np.where(pitch > 0, -HEEL_BEHIND, BALL_AHEAD), nothing, nothing], -1)
    ankle = pivot + rotated(tilt, np.array([0.0, 0.0, ANKLE_HEIGHT]) - pivot)
    # On the floor the toes stay flat while the heel rises; in the air they follow the sole.
    toe_tilt = rotation_y(-np.where(pitch > 0, pitch, pitch * ease(air / 0.3)))
    ball = ankle + rotated(tilt, (BALL_AHEAD, 0.0, -ANKLE_HEIGHT))
    tip = ball + rotated(toe_tilt, (TOE_AHEAD + 0.012 - BALL_AHEAD, 0.0, 0.0))
    heel = ankle + rotated(tilt, (-HEEL_BEHIND, 0.0, -ANKLE_HEIGHT))
    lowest = np.minimum(np.minimum(ball, tip), heel)[:, 2]
    ankle[:, 2] += np.where(air > 0, clearance * np.sin(pi * air) - lowest, 0.0)
    ankle = rotated(flat, ankle * scale) + np.stack([x, y, nothing + floor], -1)
    return ankle, compose(flat, tilt), compose(flat, toe_tilt), rotated(flat, X)


def standing(stand: Stance, floor: float, build: Build = ADULT) -> BodyPose:
    """Return one pose (n = 1) of a standing person, with which a walk begins and ends.

    Both feet are flat on the floor, and the arms hang down.
    """
    x, y = stand.centre
    scale = build.scale
    steps = (stand.left, stand.right)
    turn = rotation_z([[step.yaw + SIGN[step.side] * TOE_OUT for step in steps]])
    ankle = single([(step.x, step.y, floor + ANKLE_HEIGHT * scale) for step in steps])
    yaw = np.array([stand.yaw])
    feet = Feet(ankle, turn, turn, rotated(turn, X))
    pelvis = single((x, y, floor + STAND_HEIGHT * scale))
    pelvis[:, 2] = _pelvis_height(pelvis, rotation_z(yaw), feet, scale)
    pose = BodyPose(
        build, yaw, pelvis, rotation_z(yaw), feet, Arms(),
        single((0.0, build.stoop, 0.0)), single((0.0, -build.stoop, 0.0)),
        walking_frame_poses(np.array([x]), np.array([y]), yaw, floor, build),
    )  # fmt: skip
    return pushing(pose)
