# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where a person leaves the walking frame where it does not fit, as at a stove."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...model import Array
from ..body.build import Build
from ..body.walking_frame import AHEAD, placed_frame
from ..ways import Floor

# The frame's sides from its middle, ahead and across, m, for one of the skeleton's size; how far
# apart the points are that are looked at.
SIDES_M, SPACING_M = (0.33, 0.30), 0.06
# So far before where one goes the frame is left, m; so far from it one walks without.
BACK_M, NEAR_M = 2.0, 1.6
# Ways to turn with it, beside none, rad.
_TURNS = [sign * math.radians(k * 30.0) for k in range(1, 7) for sign in (1.0, -1.0)]
At = tuple[Array, float]  # where one stands (2,), and looks (rad)


@dataclass(frozen=True, eq=False)
class Parked:
    """The frame (4,), as `placed_frame` has it, and where one stands with a hand on it."""

    frame: Array
    at: Array
    yaw: float


def frame_of(at: Array, yaw: float, floor: float, build: Build) -> Array:
    """(4,): the frame before one who stands at a point (2,)."""
    placed: Array = placed_frame(at[:1], at[1:2], np.array([yaw]), floor, build)[0]
    return placed


def fits(floor: Floor, at: Array, yaw: float, build: Build) -> bool:
    """Whether the frame of one who stands there stands on free floor."""
    x, y, _, _ = frame_of(at, yaw, 0.0, build)
    ahead, across = (np.arange(-s, s + 1e-9, SPACING_M) * build.scale for s in SIDES_M)
    u, v = (a.ravel() for a in np.meshgrid(ahead, across))
    c, s = math.cos(yaw), math.sin(yaw)
    points = np.column_stack([x + c * u - s * v, y + s * u + c * v])
    cells = np.floor((points - floor.low) / floor.size).astype(int)
    inside = ((cells >= 0) & (cells < floor.free.shape)).all()
    return bool(inside) and bool(floor.free[cells[:, 0], cells[:, 1]].all())


def parked_on(
    floor: Floor, points: Array, ends: Sequence[At], build: Build
) -> tuple[int, float] | None:
    """The point of a way of dense points (n, 2) at which the walking frame is left, and the yaw
    that it is turned to; None if it fits to the end, or nowhere."""
    if all(fits(floor, at, yaw, build) for at, yaw in ends):
        return None
    gaps = np.diff(points, axis=0)
    far = np.concatenate([np.cumsum(np.hypot(*gaps.T)[::-1])[::-1], [0.0]])
    for k in range(len(points) - 1, 0, -3):
        if far[k] > BACK_M:
            break
        before = points[k] - points[max(k - 5, 0)]
        heading = math.atan2(before[1], before[0])
        for turn in (0.0, *_TURNS):
            steps = np.linspace(0.0, turn, 1 + round(abs(turn) / math.radians(30.0)))
            frame = frame_of(points[k], heading + turn, 0.0, build)
            off = np.hypot(*(points[k:] - frame[:2]).T).min()
            if off >= 0.9 * AHEAD * build.scale and all(
                fits(floor, points[k], heading + step, build) for step in steps
            ):
                return k, heading + turn
    return None


def parked_beside(floor: Floor, at: Array, build: Build) -> At | None:
    """The nearest stand to a point from which the frame fits."""
    for point in _around(at):
        if floor.clearance[floor.cell(point)] < 0.2:
            continue
        for k in range(12):
            yaw = k * math.pi / 6
            if fits(floor, point, yaw, build):
                return point, yaw
    return None


def _around(at: Array) -> Iterable[Array]:
    yield at
    for radius in (0.3, 0.6, 0.9, 1.2):
        for k in range(12):
            yield at + radius * np.array([math.cos(k * math.pi / 6), math.sin(k * math.pi / 6)])
