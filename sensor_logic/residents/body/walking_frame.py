# SPDX-License-Identifier: GPL-3.0-or-later
"""The walking frame: where it rolls before who walks with it, and the hands on its handles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...model import Array
from .build import Build
from .pose import BodyPose
from .skeleton import SIGN
from .turns import about_z, turned

# Lengths for one of the skeleton's size, m: the frame's middle before the hips; its handles, from
# there back, to the sides and above the floor.
AHEAD = 0.40
HANDLE_BACK, HANDLE_SIDE, HANDLE_HEIGHT = -0.16, 0.25, 0.86
_WRIST = 0.07  # behind the knuckles and above the handle


def placed_frame(x: Array, y: Array, yaw: Array, floor: float, build: Build) -> Array:
    """Where the frame stands (n, 4): x, y, z and yaw, before one who stands at x, y (n,)."""
    ahead = AHEAD * build.scale
    return np.stack(
        [x + ahead * np.cos(yaw), y + ahead * np.sin(yaw), np.full(len(x), floor), yaw], -1
    )


def pushing(pose: BodyPose) -> BodyPose:
    """Both hands on the handles, where one walks with a frame."""
    if not pose.build.frame:
        return pose
    at = [(HANDLE_BACK - _WRIST, sign * HANDLE_SIDE, HANDLE_HEIGHT + 0.03) for sign in SIGN]
    turn = about_z(pose.walker[:, 3])[:, None]
    target = pose.walker[:, None, :3] + turned(turn, np.array(at) * pose.build.scale)
    spine = pose.spine + np.array([0.0, 0.10, 0.0])
    look = pose.look - np.array([0.0, 0.10, 0.0])
    arms = replace(pose.arms, target=target, grip=np.ones((len(target), 2)))
    return replace(pose, arms=arms, spine=spine, look=look)
