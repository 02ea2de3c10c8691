# SPDX-License-Identifier: GPL-3.0-or-later
"""Sitting down, sitting, getting up, lying down."""

from dataclasses import replace
from math import pi, sin

from mathutils import Matrix, Vector

from . import plan
from .paths import place_yaw
from .pose import HEEL_BEHIND, SIGN, Arm, Foot, Pose, about_y, about_z, ease

PELVIS_OVER_SEAT = 0.130  # of the pelvis bone, the cushion pressed in a little
LEAN_BACK = 0.20
PELVIS_OVER_BED = 0.118
LEG = 0.806  # from the hips to the ankles of one who lies


def sitting(stand: Pose, place: plan.Place, floor: float) -> Pose:
    """On the seat, the feet where they stand, the hands on the thighs."""
    x, y, z = place.seat
    yaw = stand.heading
    pelvis = Vector((x, y, z + PELVIS_OVER_SEAT))
    turn = about_z(yaw) @ about_y(-LEAN_BACK)
    arms = []
    for k, foot in enumerate(stand.feet):
        hip = pelvis + about_z(yaw) @ Vector((0.0, 0.09 * SIGN[k], -0.02))
        along = Vector((foot.ankle.x - hip.x, foot.ankle.y - hip.y, 0.0)).normalized()
        rest = hip + along * 0.24 + Vector((0.0, 0.0, 0.115))
        arms.append(Arm(forward=0.5, away=0.12, elbow=0.9, target=rest, grip=1.0))
    return replace(stand, pelvis=pelvis, turn=turn, arms=tuple(arms),
                   spine=Vector((0.0, 0.10, 0.0)), look=Vector((0.0, 0.08, 0.0)))  # fmt: skip


def sitting_down(stand: Pose, seated: Pose, t: float) -> Pose:
    """From standing (0) to sitting (1): first the trunk bends, then the hips go back and down."""
    s = ease(t)
    pose = stand.mixed(seated, s)
    bend = sin(pi * s) ** 2
    pose.turn = pose.turn @ about_y(0.42 * bend)
    pose.spine = pose.spine + Vector((0.0, 0.30 * bend, 0.0))
    pose.look = pose.look - Vector((0.0, 0.25 * bend, 0.0))
    # The hips go back before they go down, so that the weight stays over the feet.
    back = ease(min(1.0, 1.25 * t))
    pose.pelvis.xy = stand.pelvis.xy.lerp(seated.pelvis.xy, back)
    hands = ease((s - 0.55) / 0.45)
    arms = []
    for a, b in zip(stand.arms, seated.arms, strict=True):
        arm = a.mixed(b, s)
        arms.append(replace(arm, grip=hands, target=b.target))
    pose.arms = tuple(arms)
    return pose


def shifted(pose: Pose, _t: float, weight: float) -> Pose:
    """Hips to the side, trunk the other way."""
    side = about_z(pose.heading) @ Vector((0.03, 0.05, 0.008))
    return replace(
        pose,
        pelvis=pose.pelvis + side * weight,
        turn=pose.turn @ about_y(0.10 * weight) @ about_z(0.08 * weight),
        spine=pose.spine + Vector((-0.10, 0.04, -0.06)) * weight,
        look=pose.look + Vector((0.0, 0.08, 0.3)) * weight,
    )


def lying(seated: Pose, place: plan.Place) -> Pose:
    """On the back; the place's yaw is the way from the feet to the head."""
    x, y, z = place.seat
    up = about_z(place_yaw(place)) @ Vector((1, 0, 0))
    front = Vector((0, 0, 1))
    left = up.cross(front)
    turn = Matrix((front, left, up)).transposed().to_quaternion()
    pelvis = Vector((x, y, z + PELVIS_OVER_BED))
    foot_turn = turn @ about_y(0.45)
    feet = []
    for sign in SIGN:
        ankle = pelvis - up * LEG + left * (0.12 * sign)
        ankle.z = z + HEEL_BEHIND - 0.005
        out = turn @ Vector((1, 0.15 * sign, 0))
        feet.append(Foot(ankle, foot_turn, foot_turn, out))
    arms = (
        Arm(forward=-0.16, away=0.30, inward=0.5, elbow=0.35),
        Arm(forward=-0.10, away=0.28, inward=0.3, elbow=0.5,
            target=pelvis + up * 0.15 + left * -0.06 + front * 0.125, grip=1.0),
    )  # fmt: skip
    return replace(seated, pelvis=pelvis, turn=turn, feet=tuple(feet), arms=arms,
                   spine=Vector((0.0, 0.02, 0.0)), look=Vector((0.0, 0.28, 0.10)))  # fmt: skip


def lying_down(seated: Pose, lying_pose: Pose, t: float) -> Pose:
    """From the bed's edge (0) to the back (1): a turn on the hips, the legs lifted."""
    s = ease(t)
    middle = seated.mixed(lying_pose, 0.5)
    feet = []
    for a, b in zip(seated.feet, lying_pose.feet, strict=True):
        foot = a.mixed(b, 0.5)
        # The control point of a parabola: its middle is half as far off the straight line.
        foot.ankle = a.ankle.lerp(b.ankle, 0.35)
        foot.ankle.z = b.ankle.z + 0.62
        foot.knee = foot.knee + Vector((0, 0, 1.2))
        feet.append(foot)
    middle.feet = tuple(feet)
    middle.pelvis = seated.pelvis.lerp(lying_pose.pelvis, 0.5) + Vector((0, 0, 0.05))
    middle.spine = middle.spine + Vector((0.0, 0.5, 0.0))
    return seated.mixed(middle, s).mixed(middle.mixed(lying_pose, s), s)
