# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets hands and eyes of a pose reach, look, carry and drink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...model import Array
from .gait import ANKLE_HEIGHT
from .pose import BodyPose
from .skeleton import FOREARM, SIDES, SIGN, UPPER_ARM
from .solve import Bones, joint, trunk
from .turns import about_y, about_z, back, chained, ease, mix, times, turned, unit

ARM_REACH = 0.97 * (UPPER_ARM + FOREARM)
PALM = 0.08  # from the wrist to where a hand holds a thing
# What is lower than this above the soles is bent down for, in the knees too.
_BEND_BELOW, _STANDS_ABOVE, _DEEPEST = 0.75, 0.75, 0.60
_MOUTH = np.array([0.255, 0.035, -0.030])  # of the wrist that drinks, from the head's joint


def palm(bones: Bones, side: int, scale: float) -> Array:
    """The points (n, 3) in the world where a hand holds things."""
    name, sign = f"hand.{SIDES[side]}", SIGN[side]
    down, inward = np.array([0.0, 0.5 * sign, -0.866]), np.array([0.0, -0.866 * sign, -0.5])
    return bones.at[name] + turned(bones.turn[name], scale * (down * PALM + inward * 0.035))


def looking(pose: BodyPose, target: Array, weight: Array) -> BodyPose:
    """The head turned towards points (n, 3)."""
    bones = trunk(pose)
    local = turned(back(bones.turn["chest"]), target - bones.at["head"])
    x, y, z = np.ascontiguousarray(np.moveaxis(local, -1, 0))
    yaw = np.clip(np.arctan2(y, x), -1.1, 1.1)
    pitch = np.clip(np.arctan2(-z, np.maximum(np.hypot(x, y), 0.1)), -0.5, 0.65)
    return replace(pose, look=mix(pose.look, np.stack([0 * yaw, pitch, yaw], -1), weight))


def looking_around(pose: BodyPose, since: Array, seconds: float, weight: Array) -> BodyPose:
    """Looks to both sides, once in so many seconds."""
    yaw = 0.75 * np.sin(2 * np.pi * since / seconds) * weight
    about = np.stack([0 * yaw, 0 * yaw, yaw], -1)
    return replace(pose, look=pose.look + about, spine=pose.spine + 0.25 * about)


def _leaning(pose: BodyPose, lean: Array, slide: float) -> BodyPose:
    """Bent forward; lean 1 is as far as one goes without a step."""
    scale = pose.build.scale
    nothing = np.zeros_like(lean)
    offset = np.stack([slide * scale * lean, nothing, -0.012 * scale * lean], -1)
    return replace(
        pose,
        turn=times(pose.turn, about_y(0.45 * lean)),
        pelvis=pose.pelvis + turned(about_z(pose.heading), offset),
        spine=pose.spine + np.stack([nothing, 0.75 * lean, nothing], -1),
    )


def _crouching(pose: BodyPose, height: Array, weight: Array) -> BodyPose:
    """The knees bent by who stands and reaches for what is low; height (n,) m in the world."""
    scale = pose.build.scale
    sole = pose.feet.ankle[..., 2].min(-1) - ANKLE_HEIGHT * scale
    stands = ease((pose.pelvis[:, 2] - sole) / scale / 0.10 - _STANDS_ABOVE / 0.10)
    depth = _DEEPEST * scale * ease((_BEND_BELOW - (height - sole) / scale) / _BEND_BELOW)
    down = depth * stands * weight
    offset = np.stack([-0.35 * down, 0 * down, -down], -1)
    return replace(pose, pelvis=pose.pelvis + turned(about_z(pose.heading), offset))


def reaching(
    pose: BodyPose, side: int, point: Array, weight: Array, slide: float = -0.03, most: float = 1.0
) -> BodyPose:
    """The hand drawn to points (n, 3), the body bent (0 … most) only as far as the arm is too
    short. The hips slide forward with that: 0.12 m of who sits."""
    scale, weight = pose.build.scale, np.broadcast_to(weight, len(pose))
    point = np.broadcast_to(point, (len(pose), 3))
    pose = _crouching(pose, point[:, 2], weight)
    bone = f"upper_arm.{SIDES[side]}"

    def shoulder(lean: Array) -> Array:
        leaning = _leaning(pose, lean, slide)
        return joint(trunk(leaning, head=False), leaning, bone)

    lean = np.zeros(len(pose))
    for _ in range(4):  # Newton with a fixed slope: always the same smooth function
        way = np.linalg.norm(point - shoulder(lean), axis=-1)
        lean = np.clip(lean + (way / scale - ARM_REACH - PALM) / 0.5, 0.0, most)
    wrist = point + unit(shoulder(lean) - point) * PALM * scale
    pose = looking(_leaning(pose, lean * weight, slide), point, 0.75 * weight)
    return _drawn(pose, side, wrist, weight)


def _drawn(pose: BodyPose, side: int, wrist: Array, weight: Array) -> BodyPose:
    """One wrist drawn to points (n, 3)."""
    arms = pose.arms.mixed(pose.arms.one(side, target=wrist, grip=1.0), weight)
    return replace(pose, arms=arms)


def drinking(pose: BodyPose, side: int, weight: Array) -> BodyPose:
    """The hand at the mouth, the head back a little."""
    bones = trunk(pose)
    offset = _MOUTH * (1.0, SIGN[side], 1.0) * pose.build.scale
    pose = _drawn(pose, side, bones.at["head"] + turned(bones.turn["head"], offset), weight)
    nod = np.stack([0 * weight, -0.2 * weight, 0 * weight], -1)
    return replace(pose, look=pose.look + nod)


def carrying(pose: BodyPose, side: int, weight: Array, beside: float = 0.0) -> BodyPose:
    """The forearm held level; beside: how far out, clear of the leg (rad)."""
    arms = pose.arms
    level = arms.one(
        side, forward=0.12 + 0.3 * (arms.forward[:, side] - 0.03), away=0.10 + beside,
        inward=0.30 - 2 * beside, elbow=1.25, grip=0.0,
    )  # fmt: skip
    return replace(pose, arms=arms.mixed(level, weight))


def upright(pose: BodyPose, tilt: Array) -> Array:
    """How a carried thing is turned (n, 4): with the body, its top tilted back towards the face."""
    return chained(about_z(pose.heading), about_y(-tilt))
