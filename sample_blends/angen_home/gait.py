# SPDX-License-Identifier: GPL-3.0-or-later
"""The walk: where the feet land along a path, and the body's pose at any moment between.

Phase counts steps: foot i carries the body alone at phase i. It lands at i − 0.55 and leaves
at i + 0.6, so both feet carry for 0.15 of each step. What is on the floor stays where it
landed; only the roll from heel to ball turns it.
"""

from dataclasses import dataclass
from math import ceil, cos, hypot, pi, radians, sin, sqrt

import numpy as np
from mathutils import Quaternion, Vector

from .pose import (
    ANKLE_HEIGHT,
    BALL_AHEAD,
    HEEL_BEHIND,
    SHIN,
    SIGN,
    STAND_HEIGHT,
    THIGH,
    TOE_AHEAD,
    Arm,
    Foot,
    Pose,
    about_x,
    about_y,
    about_z,
    ease,
    flat_foot,
)
from .skeleton import HEAD
from .surface import smooth_min, smooth_table

STEP_LENGTH = 0.60
STAND_HALF_WIDTH = 0.088
WALK_HALF_WIDTH = 0.055
TOE_OUT = radians(6)
TURN_STEP = radians(55)  # the most a step turns on the spot
LIFT, LAND = 0.6, 0.55  # of the phase after and before the middle of stance

LEG = 0.998 * (THIGH + SHIN)
HIPS = tuple(Vector(HEAD[f"thigh.{side}"] - HEAD["pelvis"]) for side in "LR")
# Pitch of the sole (degrees, toes up positive) by phase from the middle of stance.
_PITCH = np.array(
    [
        (-0.55, 18.0), (-0.40, 0.0), (0.10, 0.0), (0.40, -20.0), (0.60, -40.0),
        (0.72, -44.0), (1.00, -10.0), (1.25, 13.0), (1.45, 18.0),
    ]
)  # fmt: skip


@dataclass(frozen=True)
class Step:
    """One foot on the floor: the point under its ankle and the body's yaw there."""

    side: int
    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Stand:
    """Both feet on the floor: left, right."""

    left: Step
    right: Step

    @staticmethod
    def at(x: float, y: float, yaw: float) -> "Stand":
        return Stand(*(_beside(x, y, yaw, side, STAND_HALF_WIDTH) for side in (0, 1)))

    @property
    def centre(self) -> tuple[float, float]:
        return (self.left.x + self.right.x) / 2, (self.left.y + self.right.y) / 2

    @property
    def yaw(self) -> float:
        return (self.left.yaw + self.right.yaw) / 2


def _beside(x: float, y: float, yaw: float, side: int, width: float) -> Step:
    w = SIGN[side] * width
    return Step(side, x - w * sin(yaw), y + w * cos(yaw), yaw)


def near_turn(angle: float, near: float) -> float:
    """The angle, plus whole turns, that is nearest to another."""
    return near + (angle - near + pi) % (2 * pi) - pi


def footsteps(start: Stand, path: np.ndarray, end_yaw: float | None) -> list[Step]:
    """Steps from a stand along the points of a path (n, 2), with turns on the spot at its ends.

    The list starts with the two feet that stand and ends with the two that come to stand.
    """
    gaps = np.diff(path, axis=0)
    lengths = np.hypot(*gaps.T)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    walked = float(along[-1])
    yaw = start.yaw
    plan: list[tuple[float, float, float, float]] = []  # x, y, yaw, half width
    if walked > 0.04:
        bends = np.unwrap(np.arctan2(gaps[:, 1], gaps[:, 0]))
        middle = (along[:-1] + along[1:]) / 2
        first = near_turn(float(bends[0]), yaw)
        bends = bends + (first - float(bends[0]))
        turn = first - yaw
        if abs(turn) > radians(35):
            count = ceil(abs(turn) / TURN_STEP)
            for k in range(1, count + 1):
                plan.append((*path[0], yaw + turn * k / count, STAND_HALF_WIDTH))
        count = max(1, round(walked / STEP_LENGTH + 0.55))
        share = np.ones(count)
        share[0] -= 0.25 * (count > 1)
        share[-1] -= 0.15 * (count > 1)
        for s in np.cumsum(share) / share.sum() * walked:
            # A foot that is about to carry looks a little ahead.
            heading = float(np.interp(s + 0.15, middle, bends))
            width = STAND_HALF_WIDTH if s > walked - 1e-6 else WALK_HALF_WIDTH
            point = [float(np.interp(s, along, path[:, axis])) for axis in (0, 1)]
            plan.append((*point, heading, width))
        yaw = plan[-1][2]
    end = path[-1]
    if end_yaw is not None:
        turn = near_turn(end_yaw, yaw) - yaw
        count = ceil(abs(turn) / TURN_STEP - 0.2)
        for k in range(1, count + 1):
            plan.append((*end, yaw + turn * k / count, STAND_HALF_WIDTH))
        yaw = yaw + turn
    if not plan:
        return [start.right, start.left]
    plan.append((*end, yaw, STAND_HALF_WIDTH))
    # The foot on the inside of the first bend goes first.
    first_side = 0 if plan[0][2] >= start.yaw else 1
    standing = [start.left, start.right]
    steps = [standing[first_side], standing[1 - first_side]]
    for k, (x, y, heading, width) in enumerate(plan):
        steps.append(_beside(x, y, heading, (first_side + k) % 2, width))
    return steps


def spline(points: np.ndarray, at: float) -> np.ndarray:
    """Uniform cubic B-spline near the points (n, …), held at its ends."""
    i = int(np.floor(at))
    t = at - i
    a, b, c, d = (points[min(max(i + k, 0), len(points) - 1)] for k in (-1, 0, 1, 2))
    return (
        a * (1 - t) ** 3 + b * (3 * t**3 - 6 * t**2 + 4)
        + c * (-3 * t**3 + 3 * t**2 + 3 * t + 1) + d * t**3
    ) / 6  # fmt: skip


class Walk:
    """A walk over given steps from phase −1.5 (both feet stand) to its end (they stand again)."""

    def __init__(self, steps: list[Step], speed: float, floor: float) -> None:
        # steps[0] and steps[1] are the feet −1 and 0.
        self.steps = steps
        self.floor = floor
        self.last = len(steps) - 2  # number of the last foot that lands
        middles = np.array([[a.x, a.y, a.yaw] for a in steps])
        self.middles = (middles[:-1] + middles[1:]) / 2  # at phase k − 0.5, k from 0
        travel = [0.0, 0.0] + [
            min(1.0, hypot(b.x - a.x, b.y - a.y) / (2 * STEP_LENGTH) + abs(b.yaw - a.yaw) * 0.12)
            for a, b in zip(steps, steps[2:], strict=False)
        ]
        self.effort = np.array(travel)  # of the swing that brings each foot
        # Seconds a step: short steps are a little quicker, the ends are settling.
        step_time = STEP_LENGTH / speed
        seconds = [0.30] + [step_time * (0.84 + 0.16 * e) for e in travel[2:]] + [0.35]
        self.clock = np.concatenate([[0.0], np.cumsum(seconds)])
        self.phases = np.arange(len(self.clock)) - 1.5
        self.duration = float(self.clock[-1])
        self.left_step = next(k for k, step in enumerate(steps) if step.side == 0) - 1

    @property
    def end(self) -> Stand:
        a, b = self.steps[-2:]
        return Stand(a, b) if a.side == 0 else Stand(b, a)

    def _effort_at(self, phase: float) -> float:
        """How much of a full stride the body does now; foot k swings about phase k − 1."""
        k = np.arange(len(self.effort)) - 2.0
        return float(smooth_table(
            np.concatenate([[-1.5], k[2:], [self.last + 0.3]]),
            np.concatenate([[0.0], self.effort[2:], [0.0]]), np.array([phase])
        )[0])  # fmt: skip

    def pose(self, seconds: float) -> Pose:
        """The body so many seconds after the start of the walk."""
        phase = float(smooth_table(self.clock, self.phases, np.array([seconds]))[0])
        x, y, yaw = spline(self.middles, phase + 0.5)
        effort = self._effort_at(phase)
        beat = pi * (phase - self.left_step)
        forth, carry = sin(beat), cos(beat)  # left arm forward; weight on the left foot
        sway = 0.022 * carry * min(1.0, 1.6 * effort)
        dip = 0.012 * min(1.0, 2 * effort) + 0.030 * effort**2 * (1 - cos(2 * beat)) / 2
        height = self.floor + STAND_HEIGHT - dip
        pelvis_yaw, roll = radians(5) * effort * forth, radians(2.5) * effort * carry
        turn = about_z(yaw + pelvis_yaw) @ about_y(radians(2) * effort) @ about_x(roll)
        spine = Vector((-0.9 * roll, radians(1.5) * effort, -1.9 * pelvis_yaw))
        ahead = float(spline(self.middles, phase + 1.6)[2])
        look = Vector(
            (
                -0.1 * roll,
                -radians(1) * effort,
                0.9 * pelvis_yaw + max(-0.6, min(0.6, 0.8 * (ahead - yaw))),
            )
        )
        swing = radians(23) * effort
        arms = tuple(
            Arm(
                forward=0.03 + sign * swing * forth - 0.05 * effort,
                away=0.09 + 0.03 * effort,
                elbow=0.22 + 0.06 * effort + 0.40 * swing * (1 + sign * forth),
            )
            for sign in SIGN
        )
        feet = (self._foot(0, phase), self._foot(1, phase))
        pelvis = Vector((x - sway * sin(yaw), y + sway * cos(yaw), height))
        pelvis.z = _within_reach(pelvis, turn, feet)
        return Pose(yaw, pelvis, turn, feet, arms, spine, look)

    def _foot(self, side: int, phase: float) -> Foot:
        """The foot of a side: the step it stands on or swings from, rolled and lifted."""
        mine = [k for k, step in enumerate(self.steps) if step.side == side]
        numbers = [k - 1 for k in mine]
        i = max((j for j, n in enumerate(numbers) if phase >= n - LAND), default=0)
        here, u = self.steps[mine[i]], phase - numbers[i]
        last = i == len(mine) - 1
        after = here if last else self.steps[mine[i] + 2]
        leaving = 0.0 if last else float(self.effort[mine[i] + 2])
        arriving = float(self.effort[mine[i]]) if u < 0 else leaving
        pitch = float(smooth_table(_PITCH[:, 0], _PITCH[:, 1], np.array([min(u, 1.45)]))[0])
        pitch = radians(pitch) * (leaving if pitch < 0 else arriving)
        air = 0.0 if last else min(max((u - LIFT) / (2 - LIFT - LAND), 0.0), 1.0)
        go = air * air * (3 - 2 * air) - 0.4 * air * air * (1 - air)  # lands a little late
        out = SIGN[side] * TOE_OUT
        x, y = here.x + go * (after.x - here.x), here.y + go * (after.y - here.y)
        yaw = here.yaw + go * (after.yaw - here.yaw) + out
        return rolled_foot(x, y, yaw, self.floor, pitch, air, 0.02 + 0.012 * (1 - leaving))


def _within_reach(pelvis: Vector, turn: Quaternion, feet: tuple[Foot, Foot]) -> float:
    """Height of the pelvis, lowered softly where a leg would be too short."""
    height = pelvis.z
    for foot, hip in zip(feet, HIPS, strict=True):
        joint = turn @ hip
        flat = hypot(pelvis.x + joint.x - foot.ankle.x, pelvis.y + joint.y - foot.ankle.y)
        most = foot.ankle.z + sqrt(max(0.01, LEG**2 - flat**2)) - joint.z
        height = float(smooth_min(np.array(height), np.array(most), 0.012))
    return height


def rolled_foot(
    x: float, y: float, yaw: float, floor: float, pitch: float, air: float, clearance: float
) -> Foot:
    """A foot over (x, y), turned about its heel (toes up) or its ball (heel up).

    air: 0 on the floor, 0 … 1 through the swing; clearance: of the sole in mid-swing.
    """
    flat = about_z(yaw)
    tilt = about_y(-pitch)
    pivot = Vector((-HEEL_BEHIND if pitch > 0 else BALL_AHEAD, 0, 0))
    ankle = pivot + tilt @ (Vector((0, 0, ANKLE_HEIGHT)) - pivot)
    # On the floor the toes stay flat behind the heel that rises; in the air they follow.
    toe_pitch = pitch if pitch > 0 else pitch * ease(air / 0.3)
    toe_tilt = about_y(-toe_pitch)
    if air > 0:
        ball = ankle + tilt @ Vector((BALL_AHEAD, 0, -ANKLE_HEIGHT))
        tip = ball + toe_tilt @ Vector((TOE_AHEAD + 0.012 - BALL_AHEAD, 0, 0))
        heel = ankle + tilt @ Vector((-HEEL_BEHIND, 0, -ANKLE_HEIGHT))
        ankle.z += clearance * sin(pi * air) - min(ball.z, tip.z, heel.z)
    ankle = flat @ ankle + Vector((x, y, floor))
    return Foot(ankle, flat @ tilt, flat @ toe_tilt, flat @ Vector((1, 0, 0)))


def standing(stand: Stand, floor: float) -> Pose:
    """Both feet flat, arms down; what a walk starts from and ends in."""
    x, y = stand.centre
    feet = tuple(
        flat_foot(step.x, step.y, step.yaw + SIGN[step.side] * TOE_OUT, floor)
        for step in (stand.left, stand.right)
    )
    pelvis = Vector((x, y, floor + STAND_HEIGHT))
    return Pose(stand.yaw, pelvis, about_z(stand.yaw), feet)
