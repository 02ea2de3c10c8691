# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses of a person: sitting, lying, reaching, looking, carrying, drinking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...sensor_logic.model import Array
from .gait import ANKLE_HEIGHT, HEEL_BEHIND
from .pose import Arms, BodyPose, Feet, single
from .skeleton import FOREARM, SIDES, SIGN, UPPER_ARM, Build
from .solve import SHIN, THIGH, Bones, joint, trunk
from .turns import (
    X,
    add_axes,
    compose,
    compose_all,
    cross,
    ease,
    from_columns,
    inverse,
    lerp,
    normalised,
    rotated,
    rotation_y,
    rotation_z,
)

# Sitting, lying and the movements between.
#
# A seat is the point (3,) under the hips of a sitting person, and a bed the point (3,) under the
# hips of a lying person, in the world, m.

PELVIS_OVER_SEAT = 0.130  # height of the pelvis bone; the cushion is a little compressed
LEAN_BACK = 0.20
PELVIS_OVER_BED = 0.118
PELVIS_ON_SIDE = 0.195
_LYING_LEG = 0.806  # from the hips to the ankles while lying
# Of somebody whose hands work to one side: the part of it by which the hips move along, and the
# distance of the hands for which the trunk turns to them, m: twice that of the hands. Assumed.
SWAY_HIPS, SWAY_TURN = 0.25, 0.9
_Z = np.array([0.0, 0.0, 1.0])


def seat_distance(build: Build) -> float:
    """Return the distance at which a person stands before a seat to sit down, m."""
    return 0.57 * build.scale


def sitting(stand: BodyPose, seat: Array) -> BodyPose:
    """Return one pose (n = 1) on a seat (3,), with the hands on the thighs.

    The feet stay in place. If the legs do not reach the floor, they hang down.
    """
    scale = stand.build.scale
    ahead = rotation_z(stand.heading)
    pelvis = np.asarray(seat, float) + PELVIS_OVER_SEAT * scale * _Z + np.zeros((1, 3))
    hips = pelvis[:, None] + rotated(
        ahead[:, None], np.stack([0 * SIGN, 0.09 * SIGN, 0 * SIGN - 0.02], -1) * scale
    )
    feet = replace(
        stand.feet, ankle=_reachable_ankles(stand.feet.ankle, hips, rotated(ahead, X), scale)
    )
    along = (feet.ankle - hips) * (1.0, 1.0, 0.0)
    rest = hips + scale * (0.24 * normalised(along) + 0.115 * _Z)
    arms = Arms(
        forward=np.full((1, 2), 0.5), away=np.full((1, 2), 0.12), elbow=np.full((1, 2), 0.9),
        target=rest, grip=np.ones((1, 2)),
    )  # fmt: skip
    turn = compose(ahead, rotation_y(-LEAN_BACK))
    return replace(stand, pelvis=pelvis, turn=turn, feet=feet, arms=arms,
                   spine=single((0.0, 0.10, 0.0)), look=single((0.0, 0.08, 0.0)))  # fmt: skip


def _reachable_ankles(ankle: Array, hips: Array, ahead: Array, scale: float) -> Array:
    """Return the ankles (n, 2, 3), which hang below the knees if the floor is out of reach."""
    way = np.linalg.norm(ankle - hips, axis=-1) / scale
    hanging = hips + scale * (0.95 * THIGH + 0.02) * ahead[:, None]
    hanging[..., 2] -= 0.97 * SHIN * scale
    return lerp(ankle, hanging, ease((way - 0.97 * (THIGH + SHIN)) / 0.05))


def sitting_down(stand: BodyPose, seated: BodyPose, t: Array) -> BodyPose:
    """Interpolate from standing (t = 0) to sitting (t = 1).

    The trunk bends first, then the hips move back and down.
    """
    s = ease(t)
    pose = stand.interpolated(seated, s)
    bend = np.sin(np.pi * s) ** 2
    # The hips go back before they go down, so that the weight stays over the feet.
    pelvis = pose.pelvis.copy()
    pelvis[:, :2] = lerp(stand.pelvis, seated.pelvis, ease(np.minimum(1.0, 1.25 * t)))[:, :2]
    hands = np.maximum(ease((s - 0.55) / 0.45), stand.arms.grip[:, 0] * ease((0.3 - s) / 0.3))
    target = np.where(s[:, None, None] > 0.3, seated.arms.target, stand.arms.target)
    arms = replace(pose.arms, grip=np.stack([hands, hands], -1), target=target)
    return replace(pose, pelvis=pelvis, arms=arms, turn=compose(pose.turn, rotation_y(0.42 * bend)),
                   spine=pose.spine + bend[:, None] * (0.0, 0.30, 0.0),
                   look=pose.look - bend[:, None] * (0.0, 0.25, 0.0))  # fmt: skip


def shifted(pose: BodyPose, _times: Array, weight: Array) -> BodyPose:
    """Return the poses with the hips moved to one side and the trunk bent to the other.

    `weight` (n,) is 0 for no movement, and 1 for the whole movement.
    """
    w = weight[:, None]
    aside = rotated(rotation_z(pose.heading), np.array((0.03, 0.05, 0.008)) * pose.build.scale)
    turn = compose(compose(pose.turn, rotation_y(0.10 * weight)), rotation_z(0.08 * weight))
    return replace(pose, pelvis=pose.pelvis + aside * w, turn=turn,
                   spine=pose.spine + w * (-0.10, 0.04, -0.06),
                   look=pose.look + w * (0.0, 0.08, 0.3))  # fmt: skip


def swaying(pose: BodyPose, aside: Array, weight: Array) -> BodyPose:
    """Return the poses of somebody at work, with the trunk turned to the side of the hands.

    Parameters
    ----------
    pose : BodyPose
        The poses at n times.
    aside : array, shape (n,)
        How far the hands are to the left of where the person looks, m. The hips move along by a
        part of it, and the trunk turns about half-way to the hands.
    weight : array, shape (n,)
        0 for the pose without a change, 1 for the whole movement.
    """
    far = weight * aside
    left = rotated(rotation_z(pose.heading), np.array((0.0, 1.0, 0.0)))
    turn = np.arctan2(far, SWAY_TURN)
    return replace(pose, pelvis=pose.pelvis + SWAY_HIPS * far[:, None] * left,
                   spine=pose.spine + turn[:, None] * (0.0, 0.0, 1.0))  # fmt: skip


def lying(seated: BodyPose, bed: Array, yaw: float, side: int = 0) -> BodyPose:
    """Return one pose (n = 1) on a bed: on the back (side 0), the left (1) or the right side (−1).

    On a side the knees are drawn up. `bed` (3,) is the point under the hips, m. `yaw` points from
    the feet to the head, rad.
    """
    up = rotated(rotation_z(yaw), X)
    front = _Z if side == 0 else side * cross(up, _Z)
    left = cross(front, -up)
    turn = from_columns(front, left, up)
    return (_on_back if side == 0 else _on_side)(seated, np.asarray(bed, float), turn, side)


def _on_back(seated: BodyPose, bed: Array, turn: Array, _side: int) -> BodyPose:
    scale = seated.build.scale
    front, left, up = (rotated(turn, axis) for axis in np.eye(3))
    pelvis = bed + PELVIS_OVER_BED * scale * _Z
    ankle = pelvis - scale * (_LYING_LEG * up - 0.12 * SIGN[:, None] * left)
    ankle[:, 2] = bed[2] + (HEEL_BEHIND - 0.005) * scale
    sole = compose(turn, rotation_y(0.45))
    out = rotated(turn, np.stack([1 + 0 * SIGN, 0.15 * SIGN, 0 * SIGN], -1))
    feet = Feet(ankle[None], np.tile(sole, (1, 2, 1)), np.tile(sole, (1, 2, 1)), out[None])
    hand = pelvis + scale * (up * 0.15 + left * -0.06 + front * 0.125)
    arms = Arms(
        forward=single((-0.16, -0.10)), away=single((0.30, 0.28)), inward=single((0.5, 0.3)),
        elbow=single((0.35, 0.5)), target=np.stack([0 * hand, hand])[None], grip=single((0.0, 1.0)),
    )  # fmt: skip
    return replace(seated, pelvis=pelvis[None], turn=turn[None], feet=feet, arms=arms,
                   spine=single((0.0, 0.02, 0.0)), look=single((0.0, 0.28, 0.10)))  # fmt: skip


def _on_side(seated: BodyPose, bed: Array, turn: Array, side: int) -> BodyPose:
    scale = seated.build.scale
    front, _, up = (rotated(turn, axis) for axis in np.eye(3))
    pelvis = bed + PELVIS_ON_SIDE * scale * _Z
    # The upper leg lies a little before the lower one.
    upper = side * SIGN < 0
    forward = np.where(upper, 0.20, 0.08)[:, None]
    ankle = pelvis + scale * (forward * front - 0.66 * up)
    ankle[:, 2] = bed[2] + scale * np.where(upper, 0.15, 0.055)
    sole = compose(turn, rotation_y(0.35))
    knee = np.stack([rotated(turn, (1.0, 0.0, 0.15))] * 2)
    feet = Feet(ankle[None], np.tile(sole, (1, 2, 1)), np.tile(sole, (1, 2, 1)), knee[None])
    # The lower arm lies before the chest, the other hand rests on the bed before the hips.
    hand = pelvis + scale * (0.10 * up + 0.24 * front)
    hand[2] = bed[2] + 0.075 * scale
    arms = Arms(
        forward=single((1.3, 1.3)), away=single((0.0, 0.0)), inward=single((0.0, 0.0)),
        elbow=single((0.9, 0.9)), target=np.stack([hand, hand])[None], grip=single(upper),
    )  # fmt: skip
    return replace(seated, pelvis=pelvis[None], turn=turn[None], feet=feet, arms=arms,
                   spine=single((-0.05 * side, 0.16, 0.0)),
                   look=single((0.12 * side, 0.10, 0.0)))  # fmt: skip


def lying_down(seated: BodyPose, lying_pose: BodyPose, t: Array) -> BodyPose:
    """Interpolate from sitting on the bed's edge (t = 0) to lying (t = 1).

    The body turns on the hips while the legs are lifted.
    """
    s = ease(t)
    a, b, scale = seated.feet, lying_pose.feet, seated.build.scale
    middle = seated.interpolated(lying_pose, 0.5)
    # The control point of a parabola: its middle is half as far off the straight line.
    ankle = lerp(a.ankle, b.ankle, 0.35)
    ankle[..., 2] = b.ankle[..., 2] + 0.62 * scale
    feet = replace(middle.feet, ankle=ankle, knee=middle.feet.knee + 1.2 * _Z)
    middle = replace(middle, feet=feet, pelvis=middle.pelvis + 0.05 * scale * _Z,
                     spine=middle.spine + np.array([0.0, 0.5, 0.0]))  # fmt: skip
    return seated.interpolated(middle, s).interpolated(middle.interpolated(lying_pose, s), s)


def turning_over(before: BodyPose, after: BodyPose, t: Array) -> BodyPose:
    """Interpolate between two lying poses, from `before` (t = 0) to `after` (t = 1).

    In between, the hips are lifted a little and the knees drawn up.
    """
    s = ease(t)
    pose = before.interpolated(after, s)
    lift = np.sin(np.pi * s) ** 2
    scale = pose.build.scale
    pelvis = pose.pelvis + 0.04 * scale * lift[:, None] * _Z
    up = rotated(pose.turn, _Z)
    ankle = pose.feet.ankle + add_axes(lift, pose.feet.ankle) * scale * (
        0.16 * up[:, None] + 0.05 * _Z
    )
    knee = pose.feet.knee + add_axes(lift, pose.feet.knee) * 0.8 * _Z
    # The hands let go before the body turns over them.
    first = add_axes(s, pose.arms.grip) < 0.5
    grip = np.where(first, before.arms.grip, after.arms.grip) * ease(
        add_axes(np.abs(2 * s - 1), pose.arms.grip)
    )
    target = np.where(first[..., None], before.arms.target, after.arms.target)
    arms = replace(pose.arms, target=target, grip=grip)
    feet = replace(pose.feet, ankle=ankle, knee=knee)
    return replace(pose, pelvis=pelvis, feet=feet, arms=arms,
                   spine=pose.spine + lift[:, None] * (0.0, 0.15, 0.0))  # fmt: skip


# Reaching, looking, carrying and drinking.

ARM_REACH = 0.97 * (UPPER_ARM + FOREARM)
PALM = 0.08  # from the wrist to a thing in the hand
# For points lower than _BEND_BELOW above the soles a standing person also bends the knees.
_BEND_BELOW, _STANDS_ABOVE, _DEEPEST = 0.75, 0.75, 0.60
_MOUTH = np.array([0.255, 0.035, -0.030])  # the drinking wrist, from the head's joint


def palm(bones: Bones, side: int, scale: float) -> Array:
    """Return the points (n, 3) in the palm of a hand, where it holds an object, m."""
    name, sign = f"hand.{SIDES[side]}", SIGN[side]
    down, inward = np.array([0.0, 0.5 * sign, -0.866]), np.array([0.0, -0.866 * sign, -0.5])
    return bones.at[name] + rotated(bones.turn[name], scale * (down * PALM + inward * 0.035))


def looking(pose: BodyPose, target: Array, weight: Array) -> BodyPose:
    """Return the poses with the head turned towards points.

    Parameters
    ----------
    pose : BodyPose
        The poses at n times.
    target : array, shape (n, 3)
        The points in the world, m.
    weight : array, shape (n,)
        0 for the pose without a change, 1 for looking at the point.
    """
    bones = trunk(pose)
    local = rotated(inverse(bones.turn["chest"]), target - bones.at["head"])
    x, y, z = np.ascontiguousarray(np.moveaxis(local, -1, 0))
    yaw = np.clip(np.arctan2(y, x), -1.1, 1.1)
    pitch = np.clip(np.arctan2(-z, np.maximum(np.hypot(x, y), 0.1)), -0.5, 0.65)
    return replace(pose, look=lerp(pose.look, np.stack([0 * yaw, pitch, yaw], -1), weight))


def looking_around(pose: BodyPose, since: Array, seconds: float, weight: Array) -> BodyPose:
    """Return the poses with the head turned to one side and then to the other.

    Parameters
    ----------
    pose : BodyPose
        The poses at n times.
    since : array, shape (n,)
        Time since the start, s.
    seconds : float
        Period of the movement, s.
    weight : array, shape (n,)
        Weight of the movement, 0 … 1.
    """
    yaw = 0.75 * np.sin(2 * np.pi * since / seconds) * weight
    about = np.stack([0 * yaw, 0 * yaw, yaw], -1)
    return replace(pose, look=pose.look + about, spine=pose.spine + 0.25 * about)


def _leaning(pose: BodyPose, lean: Array, slide: float) -> BodyPose:
    """Return the poses bent forward by `lean` (n,), from 0 to 1 for the furthest lean.

    At 1, the hips have moved forward by `slide` m.
    """
    scale = pose.build.scale
    nothing = np.zeros_like(lean)
    offset = np.stack([slide * scale * lean, nothing, -0.012 * scale * lean], -1)
    return replace(
        pose,
        turn=compose(pose.turn, rotation_y(0.45 * lean)),
        pelvis=pose.pelvis + rotated(rotation_z(pose.heading), offset),
        spine=pose.spine + np.stack([nothing, 0.75 * lean, nothing], -1),
    )


def _crouching(pose: BodyPose, height: Array, weight: Array) -> BodyPose:
    """Return the poses with the knees bent if the target of a hand is low; only for standing.

    `height` (n,) is the target's height, m.
    """
    scale = pose.build.scale
    sole = pose.feet.ankle[..., 2].min(-1) - ANKLE_HEIGHT * scale
    stands = ease((pose.pelvis[:, 2] - sole) / scale / 0.10 - _STANDS_ABOVE / 0.10)
    depth = _DEEPEST * scale * ease((_BEND_BELOW - (height - sole) / scale) / _BEND_BELOW)
    down = depth * stands * weight
    offset = np.stack([-0.35 * down, 0 * down, -down], -1)
    return replace(pose, pelvis=pose.pelvis + rotated(rotation_z(pose.heading), offset))


def reaching(
    pose: BodyPose, side: int, point: Array, weight: Array, slide: float = -0.03, most: float = 1.0
) -> BodyPose:
    """Return the poses with a hand at points.

    The trunk leans forward if the arm is too short.

    Parameters
    ----------
    pose : BodyPose
        The poses at n times.
    side : int
        The hand: 0 left, 1 right.
    point : array, shape (n, 3)
        The targets in the world, m.
    weight : array, shape (n,)
        0 for the pose without a change, 1 for reaching the point.
    slide : float
        How far the hips move forward at a full lean, m: 0.12 for a sitting person. Negative: back.
    most : float
        The largest lean of the trunk that is allowed, from 0 (none) to 1 (a full lean).
    """
    scale, weight = pose.build.scale, np.broadcast_to(weight, len(pose))
    point = np.broadcast_to(point, (len(pose), 3))
    pose = _crouching(pose, point[:, 2], weight)
    bone = f"upper_arm.{SIDES[side]}"

    def shoulder(lean: Array) -> Array:
        leaning = _leaning(pose, lean, slide)
        return joint(trunk(leaning, head=False), leaning, bone)

    lean = np.zeros(len(pose))
    for _ in range(4):  # Newton's method with a fixed slope and count, so that it stays smooth
        way = np.linalg.norm(point - shoulder(lean), axis=-1)
        lean = np.clip(lean + (way / scale - ARM_REACH - PALM) / 0.5, 0.0, most)
    wrist = point + normalised(shoulder(lean) - point) * PALM * scale
    pose = looking(_leaning(pose, lean * weight, slide), point, 0.75 * weight)
    return _with_wrist_at(pose, side, wrist, weight)


def _with_wrist_at(pose: BodyPose, side: int, wrist: Array, weight: Array) -> BodyPose:
    arms = pose.arms.interpolated(pose.arms.one(side, target=wrist, grip=1.0), weight)
    return replace(pose, arms=arms)


def drinking(pose: BodyPose, side: int, weight: Array) -> BodyPose:
    """Return the poses with a hand at the mouth and the head tilted back.

    `weight` (n,) is 0 for the pose without a change, and 1 for the whole movement.
    """
    bones = trunk(pose)
    offset = _MOUTH * (1.0, SIGN[side], 1.0) * pose.build.scale
    pose = _with_wrist_at(
        pose, side, bones.at["head"] + rotated(bones.turn["head"], offset), weight
    )
    nod = np.stack([0 * weight, -0.2 * weight, 0 * weight], -1)
    return replace(pose, look=pose.look + nod)


def carrying(pose: BodyPose, side: int, weight: Array) -> BodyPose:
    """Return the poses with the forearm of one side held level.

    `weight` (n,) is 0 for the pose without a change, and 1 for the whole movement.
    """
    arms = pose.arms
    level = arms.one(
        side, forward=0.12 + 0.3 * (arms.forward[:, side] - 0.03), away=0.10, inward=0.30,
        elbow=1.25, grip=0.0,
    )  # fmt: skip
    return replace(pose, arms=arms.interpolated(level, weight))


def upright(pose: BodyPose, tilt: Array) -> Array:
    """Return the rotations (n, 4) of a carried object that is tilted by `tilt` (n,), rad.

    The object turns with the body's heading, and its top is tilted towards the face.
    """
    return compose_all(rotation_z(pose.heading), rotation_y(-tilt))
