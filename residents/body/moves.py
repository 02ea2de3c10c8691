# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways in which any body stands, walks, sits and lies: a person's or a cat's."""

from __future__ import annotations

from ...sensor_logic.model import Array
from . import cat, gait, poses
from .gait import Footstep, Stand
from .pose import BodyPose
from .skeleton import Build


def footsteps(start: Stand, path: Array, end_yaw: float | None, build: Build) -> list[Footstep]:
    """The steps for a `Walk`: from a stand along the points of a path (n, 2), with turns on the
    spot at its ends. Two steps are no walk."""
    if build.is_cat:
        return cat.footsteps(start, path, end_yaw, build)
    return gait.footsteps(start, path, end_yaw, build)


def Walk(
    steps: list[Footstep], speed: float, floor: float, build: Build
) -> gait.Walk | cat.CatWalk:  # fmt: skip
    if build.is_cat:
        return cat.CatWalk(steps, speed, floor, build)
    return gait.Walk(steps, speed, floor, build)


def standing(stand: Stand, floor: float, build: Build) -> BodyPose:
    if build.is_cat:
        return cat.standing(stand, floor, build)
    return gait.standing(stand, floor, build)


def sitting(stand: BodyPose, at: Array) -> BodyPose:
    """The pose on a seat, before which the body stood; a cat sits on the point itself."""
    if stand.build.is_cat:
        return cat.sitting(stand, at)
    return poses.sitting(stand, at)


def sitting_down(stand: BodyPose, seated: BodyPose, t: Array) -> BodyPose:
    """The poses from standing (t = 0) to sitting (1)."""
    if stand.build.is_cat:
        return cat.going(stand, seated, t)
    return poses.sitting_down(stand, seated, t)


def lying(seated: BodyPose, bed: Array, yaw: float, side: int = 0) -> BodyPose:
    """The pose with the hips over a point and the head towards the yaw; side 1: to the left, -1:
    the right."""
    if seated.build.is_cat:
        return cat.lying(seated, bed, yaw, side)
    return poses.lying(seated, bed, yaw, side)


def lying_down(seated: BodyPose, lying_pose: BodyPose, t: Array) -> BodyPose:
    """The poses from sitting (t = 0) to lying (1)."""
    if seated.build.is_cat:
        return cat.going(seated, lying_pose, t)
    return poses.lying_down(seated, lying_pose, t)


def turning_over(before: BodyPose, after: BodyPose, t: Array) -> BodyPose:
    """The poses from one way of lying (t = 0) to another (1)."""
    if before.build.is_cat:
        return cat.going(before, after, t)
    return poses.turning_over(before, after, t)


def shifted(pose: BodyPose, times: Array, weight: Array) -> BodyPose:
    """A gesture on the spot: the body moves a little."""
    if pose.build.is_cat:
        return cat.shifted(pose, times, weight)
    return poses.shifted(pose, times, weight)
