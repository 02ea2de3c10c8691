# SPDX-License-Identifier: GPL-3.0-or-later
"""What a story becomes: functions of time for body, hands, doors, lamps and props. No bpy objects.

Times are seconds from the start, yaws of leaves degrees, as in `plan`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import atan2, hypot, radians, sin

from mathutils import Quaternion, Vector

from . import plan
from .pose import Arm, Pose, about_y, about_z, ease, mix, solve
from .skeleton import FOREARM, UPPER_ARM

ARM_REACH = 0.97 * (UPPER_ARM + FOREARM)
PALM = 0.08  # from the wrist to where a hand holds a thing


@dataclass(frozen=True)
class Clip:
    """The body from start to end; `pose` takes the seconds since the start."""

    start: float
    end: float
    pose: Callable[[float], Pose]


@dataclass(frozen=True)
class Gesture:
    """Something done on top of the clips; `apply` takes pose, time and weight."""

    start: float
    end: float
    rise: float
    fall: float
    apply: Callable[[Pose, float, float], Pose]

    def weight(self, t: float) -> float:
        if not self.start < t < self.end:
            return 0.0
        return ease((t - self.start) / self.rise) * ease((self.end - t) / self.fall)


@dataclass(frozen=True)
class Swing:
    """A leaf that turns from one yaw to another."""

    start: float
    end: float
    before: float
    after: float


@dataclass(frozen=True)
class Hold:
    """Where a prop is from a time on: in a hand (side 0 or 1) or standing at a point."""

    start: float
    hand: int | None
    at: Vector = field(default_factory=Vector)


@dataclass
class Timeline:
    """Everything that moves."""

    clips: list[Clip] = field(default_factory=list)
    gestures: list[Gesture] = field(default_factory=list)
    swings: dict[str, list[Swing]] = field(default_factory=dict)
    lamps: list[tuple[float, str, bool]] = field(default_factory=list)
    props: dict[str, list[Hold]] = field(default_factory=dict)
    tilts: dict[str, list[Gesture]] = field(default_factory=dict)
    marks: list[tuple[float, str]] = field(default_factory=list)

    @property
    def duration(self) -> float:
        return self.clips[-1].end

    def base(self, t: float) -> Pose:
        """The body without gestures."""
        clip = next((c for c in self.clips if t < c.end), self.clips[-1])
        return clip.pose(min(max(t - clip.start, 0.0), clip.end - clip.start))

    def pose(self, t: float) -> Pose:
        """The body at a time."""
        pose = self.base(t)
        breath = Vector((0.0, radians(0.5) * sin(1.6 * t), 0.0))
        pose = replace(pose, spine=pose.spine - breath, look=pose.look + breath)
        for gesture in self.gestures:
            weight = gesture.weight(t)
            if weight > 0:
                pose = gesture.apply(pose, t, weight)
        return pose

    def yaw(self, name: str, t: float, closed: float) -> float:
        """Yaw of a leaf at a time, degrees."""
        yaw = closed
        for swing in self.swings.get(name, ()):
            if t >= swing.start:
                share = ease((t - swing.start) / (swing.end - swing.start))
                yaw = mix(swing.before, swing.after, share)
        return yaw

    def door_yaw(self, name: str, t: float) -> float:
        return self.yaw(f"Door {name}", t, plan.DOORS[name].closed_yaw)


def palm(bones: tuple[dict, dict], side: int) -> Vector:
    """Where a hand holds things, in the world."""
    turn, at = bones
    name = f"hand.{'LR'[side]}"
    sign = 1.0 if side == 0 else -1.0
    down = Vector((0.0, 0.5 * sign, -0.866))
    inward = Vector((0.0, -0.866 * sign, -0.5))
    return at[name] + turn[name] @ (down * PALM + inward * 0.035)


def looking(pose: Pose, target: Vector, weight: float) -> Pose:
    """The head turned towards a point."""
    turn, at = solve(pose)
    local = turn["chest"].inverted() @ (target - at["head"])
    yaw = max(-1.1, min(1.1, atan2(local.y, local.x)))
    pitch = max(-0.5, min(0.65, atan2(-local.z, max(hypot(local.x, local.y), 0.1))))
    return replace(pose, look=pose.look.lerp(Vector((0.0, pitch, yaw)), weight))


def _leaning(pose: Pose, lean: float, slide: float) -> Pose:
    """Bent forward; lean 1 is as far as one goes without a step."""
    turn = pose.turn @ about_y(0.45 * lean)
    ahead = about_z(pose.heading) @ Vector((slide * lean, 0.0, -0.012 * lean))
    return replace(pose, turn=turn, pelvis=pose.pelvis + ahead,
                   spine=pose.spine + Vector((0.0, 0.75 * lean, 0.0)))  # fmt: skip


def reaching(
    pose: Pose, side: int, point: Vector, weight: float, slide: float, most: float
) -> Pose:
    """The hand drawn to a point, the body bent (0 … most) only as far as the arm is too short."""

    def shoulder(lean: float) -> Vector:
        return solve(_leaning(pose, lean, slide))[1][f"upper_arm.{'LR'[side]}"]

    lean = 0.0
    for _ in range(4):  # Newton with a fixed slope: always the same smooth function
        short = (point - shoulder(lean)).length - ARM_REACH - PALM
        lean = min(max(lean + short / 0.5, 0.0), most)
    pose = looking(_leaning(pose, lean * weight, slide), point, 0.75 * weight)
    wrist = point + (shoulder(lean) - point).normalized() * PALM
    arm = pose.arms[side]
    return pose.with_arm(side, arm.mixed(replace(arm, target=wrist, grip=1.0), weight))


def carrying(pose: Pose, side: int, weight: float, beside: float) -> Pose:
    """The forearm held level; beside: how far out, clear of the leg (rad)."""
    arm = pose.arms[side]
    held = Arm(forward=0.12 + 0.3 * (arm.forward - 0.03), away=0.10 + beside,
               inward=0.30 - 2 * beside, elbow=1.25)  # fmt: skip
    return pose.with_arm(side, arm.mixed(held, weight))


def upright(pose: Pose, tilt: float) -> Quaternion:
    """How a carried thing is turned: with the body, its top tilted back towards the face."""
    return about_z(pose.heading) @ about_y(-tilt)
