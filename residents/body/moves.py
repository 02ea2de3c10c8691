# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and movements of any resident: each function calls that for persons or that for cats."""

from __future__ import annotations

from ...sensor_logic.model import Array
from . import cat, gait, poses
from .gait import Footstep, Stance
from .pose import BodyPose
from .skeleton import Build


def footsteps(start: Stance, path: Array, end_yaw: float | None, build: Build) -> list[Footstep]:
    """Return the footsteps of a walk along the points (n, 2) of a path, from `start`.

    Turns on the spot at both ends are included. Without a walk, there are two footsteps.
    """
    if build.is_cat:
        return cat.footsteps(start, path, end_yaw, build)
    return gait.footsteps(start, path, end_yaw, build)


def Walk(
    steps: list[Footstep], speed: float, floor: float, build: Build
) -> gait.Walk | cat.CatWalk:  # fmt: skip
    """Return the walk over `steps` at `speed` m/s, on a floor at the height `floor` (m)."""
    if build.is_cat:
        return cat.CatWalk(steps, speed, floor, build)
    return gait.Walk(steps, speed, floor, build)


def standing(stand: Stance, floor: float, build: Build) -> BodyPose:
    """Return one pose (n = 1), standing on both feet or on four paws.

    `floor` is the height of the floor, m.
    """
    if build.is_cat:
        return cat.standing(stand, floor, build)
    return gait.standing(stand, floor, build)


def sitting(stand: BodyPose, at: Array) -> BodyPose:
    """Return one pose (n = 1), sitting on a seat at the point `at` (3,).

    `stand` is the pose in front of the seat. A cat sits on the point itself.
    """
    if stand.build.is_cat:
        return cat.sitting(stand, at)
    return poses.sitting(stand, at)


def sitting_down(stand: BodyPose, seated: BodyPose, t: Array) -> BodyPose:
    """Interpolate from standing (t = 0) to sitting (t = 1); `t` has the shape (n,)."""
    if stand.build.is_cat:
        return cat.going(stand, seated, t)
    return poses.sitting_down(stand, seated, t)


def lying(seated: BodyPose, bed: Array, yaw: float, side: int = 0) -> BodyPose:
    """Return one pose (n = 1), lying with the hips over the point `bed` (3,).

    The head points along `yaw`. A person lies on the back (side 0), the left (1) or the right side
    (−1).
    """
    if seated.build.is_cat:
        return cat.lying(seated, bed, yaw, side)
    return poses.lying(seated, bed, yaw, side)


def lying_down(seated: BodyPose, lying_pose: BodyPose, t: Array) -> BodyPose:
    """Interpolate from sitting (t = 0) to lying (t = 1); `t` has the shape (n,)."""
    if seated.build.is_cat:
        return cat.going(seated, lying_pose, t)
    return poses.lying_down(seated, lying_pose, t)


def turning_over(before: BodyPose, after: BodyPose, t: Array) -> BodyPose:
    """Interpolate between two lying poses, from `before` (t = 0) to `after` (t = 1).

    `t` has the shape (n,).
    """
    if before.build.is_cat:
        return cat.going(before, after, t)
    return poses.turning_over(before, after, t)


def shifted(pose: BodyPose, times: Array, weight: Array) -> BodyPose:
    """Return the poses with a small movement on the spot added; `weight` (n,) is 0 … 1."""
    if pose.build.is_cat:
        return cat.shifted(pose, times, weight)
    return poses.shifted(pose, times, weight)
