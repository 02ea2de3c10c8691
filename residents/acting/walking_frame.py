# SPDX-License-Identifier: GPL-3.0-or-later
"""The walking frame: where it fits, and where its user leaves it behind.

The user leaves the frame where it does not fit at the destination, as at a stove.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...sensor_logic.model import Array
from ..body.gait import AHEAD, walking_frame_poses
from ..body.skeleton import Build
from .path_search import Floor

# Half length and half width of the frame for an unscaled skeleton, and the spacing of the points
# tested for free floor, m.
SIDES_M, SPACING_M = (0.33, 0.30), 0.06
# The frame is left at most SEARCH_M before the destination, and fetched for destinations more
# than FETCH_M away from it, m.
SEARCH_M, FETCH_M = 2.0, 1.6
# Turns of person and walking frame that are tried, rad.
_TURNS = [sign * math.radians(k * 30.0) for k in range(1, 7) for sign in (1.0, -1.0)]
Standpoint = tuple[Array, float]  # position (2,) and yaw (rad) of a standing person


@dataclass(frozen=True, eq=False)
class ParkedWalkingFrame:
    """A walking frame that its user has left behind.

    Attributes
    ----------
    frame : array, shape (4,)
        The pose of the walking frame: x, y, z (m) and yaw (rad).
    at : array, shape (2,)
        Where the user stands to take hold of it again, m.
    yaw : float
        The direction in which the user then looks, rad.
    """

    frame: Array
    at: Array
    yaw: float


def walking_frame_pose(at: Array, yaw: float, floor: float, build: Build) -> Array:
    """Return x, y, z (m) and yaw (rad) of a person's walking frame.

    The person stands at the point `at` (2,), looks along `yaw`, and is on a floor of height
    `floor`.
    """
    placed: Array = walking_frame_poses(at[:1], at[1:2], np.array([yaw]), floor, build)[0]
    return placed


def walking_frame_fits(floor: Floor, at: Array, yaw: float, build: Build) -> bool:
    """Return whether all floor under a person's walking frame is free.

    The person stands at the point `at` (2,) and looks along `yaw`.
    """
    x, y, _, _ = walking_frame_pose(at, yaw, 0.0, build)
    ahead, across = (np.arange(-s, s + 1e-9, SPACING_M) * build.scale for s in SIDES_M)
    u, v = (a.ravel() for a in np.meshgrid(ahead, across))
    c, s = math.cos(yaw), math.sin(yaw)
    points = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    cells = np.floor((points - floor.low) / floor.size).astype(int)
    inside = ((cells >= 0) & (cells < floor.free.shape)).all()
    return bool(inside) and bool(floor.free[cells[:, 0], cells[:, 1]].all())


def parking_on_path(
    floor: Floor, points: Array, ends: Sequence[Standpoint], build: Build
) -> tuple[int, float] | None:
    """Find the point of a path at which a person leaves the walking frame behind.

    Parameters
    ----------
    floor : Floor
        The free floor.
    points : array, shape (n, 2)
        Closely spaced points of the path, m.
    ends : sequence of Standpoint
        The positions and yaws of the person at the destination.
    build : Build
        The person's build.

    Returns
    -------
    tuple of int and float, or None
        Index of the point, and the yaw to turn to there. None if the walking frame fits
        at the destination, or nowhere on the last `SEARCH_M` m of the path.
    """
    if all(walking_frame_fits(floor, at, yaw, build) for at, yaw in ends):
        return None
    gaps = np.diff(points, axis=0)
    far = np.concatenate([np.cumsum(np.hypot(*gaps.T)[::-1])[::-1], [0.0]])
    for k in range(len(points) - 1, 0, -3):
        if far[k] > SEARCH_M:
            break
        before = points[k] - points[max(k - 5, 0)]
        heading = math.atan2(before[1], before[0])
        for turn in (0.0, *_TURNS):
            steps = np.linspace(0.0, turn, 1 + round(abs(turn) / math.radians(30.0)))
            frame = walking_frame_pose(points[k], heading + turn, 0.0, build)
            off = np.hypot(*(points[k:] - frame[:2]).T).min()
            if off >= 0.9 * AHEAD * build.scale and all(
                walking_frame_fits(floor, points[k], heading + step, build) for step in steps
            ):
                return k, heading + turn
    return None


def parking_near(floor: Floor, at: Array, build: Build) -> Standpoint | None:
    """Return the nearest position and yaw at which a person's walking frame stands on free floor.

    The search covers 1.2 m around the point `at` (2,). Return None if it finds no position.
    """
    for point in _points_around(at):
        if floor.clearance[floor.cell(point)] < 0.2:
            continue
        for k in range(12):
            yaw = k * math.pi / 6
            if walking_frame_fits(floor, point, yaw, build):
                return point, yaw
    return None


def _points_around(at: Array) -> Iterable[Array]:
    """Yield the point `at` (2,), then points on growing circles around it."""
    yield at
    for radius in (0.3, 0.6, 0.9, 1.2):
        for k in range(12):
            yield at + radius * np.array([math.cos(k * math.pi / 6), math.sin(k * math.pi / 6)])
