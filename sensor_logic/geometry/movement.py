# SPDX-License-Identifier: GPL-3.0-or-later
"""Interpolates the motion of a body between two known poses.

By Chasles' theorem a rigid body can always move between them by a screw: a rotation about an axis
and a translation along it. At a constant rate this is exact for bodies that move in a straight
line without turning, and for those that turn about a hinge, wherever their origin is. A body that
changes its size is also stretched at a constant rate (by the polar decomposition).
"""

from __future__ import annotations

import math

import numpy as np

from ..model import Array

# Rotations in single precision deviate from rigid ones by less than this.
RIGID = 1e-5
# rad: a smaller rotation is a rounding error; its centre would be too far away to compute.
SMALLEST_TURN = 1e-7
# rad: the arc over which a path's deviation from a straight line is estimated.
ARC = math.pi / 8.0
# The least number of such arcs for a stretched body.
FEWEST = 8
# Safety factor, because the deviation of an arc is only about that of a parabola.
ENOUGH = 0.8
# The most pieces that a path is cut into.
MOST = 10_000


class Movement:
    """The motion from the matrix `before` to `after` (4, 4), which are invertible and of the same
    handedness: `angle` (rad, 0 to π) of its rotation; `rigid`: it does not change the size. For
    precision, give both relative to a near point."""

    def __init__(self, before: Array, after: Array) -> None:
        self.before, self.after = before, after
        self.still = bool(np.array_equal(before, after))
        left, sizes, right = np.linalg.svd(after[:3, :3] @ np.linalg.inv(before[:3, :3]))
        turn = left @ right
        self.rigid = bool(np.abs(sizes - 1.0).max() < RIGID)
        # The change of size along the principal directions, as a matrix.
        self._longer = (right.T * (sizes - 1.0)) @ right
        self._axis, angle = _axis_and_angle(turn)
        self.angle = angle if angle > SMALLEST_TURN else 0.0
        if self.angle:
            shift = after[:3, 3] - turn @ before[:3, 3]
            self._glide = self._axis * (self._axis @ shift)
            across = shift - self._glide
            half = 1.0 / math.tan(self.angle / 2.0)
            self._centre = (across + half * np.cross(self._axis, across)) / 2.0

    def at(self, shares: Array) -> Array:
        """The body's matrices (n, 4, 4) at these shares (n,) of the time, 0 to 1."""
        between = shares[:, None, None]
        if not self.angle:
            return np.asarray(self.before + between * (self.after - self.before))
        turns = _turns(self._axis, self.angle * shares)
        matrices = np.tile(np.eye(4), (len(shares), 1, 1))
        size = np.eye(3) if self.rigid else np.eye(3) + between * self._longer
        matrices[:, :3, :3] = turns @ size @ self.before[:3, :3]
        matrices[:, :3, 3] = turns @ (self.before[:3, 3] - self._centre) + self._centre
        matrices[:, :3, 3] += shares[:, None] * self._glide
        return matrices


def _axis_and_angle(turn: Array) -> tuple[Array, float]:
    """The axis (3,) and the angle (rad, 0 to π) of a rotation."""
    odd = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    sine, cosine = float(np.linalg.norm(odd)), (float(np.trace(turn)) - 1.0) / 2.0
    angle = math.atan2(sine, cosine)
    if cosine > 0.0:
        return (odd / sine if sine > 0.0 else np.zeros(3)), angle
    # Towards a half turn the odd part vanishes; the even one is cos·I + (1 − cos)·axis axisᵀ.
    even = (turn + turn.T) / 2.0 - cosine * np.eye(3)
    axis = even[:, int(np.argmax(np.diag(even)))]
    axis = axis / np.linalg.norm(axis)
    return (-axis if axis @ odd < 0.0 else axis), angle


def _turns(axis: Array, angles: Array) -> Array:
    """Rotations (n, 3, 3) about an axis by angles (n,) in rad: Rodrigues' formula."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, rest = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + rest * (cross @ cross))


def seen_from(body: Movement, sensor: Movement, shares: Array, ends: Array) -> Array:
    """Points that move with a sensor, in the local space of a moving body: (n, k, 3) at shares (n,)
    of the time; `ends` (k, 3) are their final positions in the world."""
    carried = sensor.at(shares) @ np.linalg.inv(sensor.after)
    into = np.linalg.inv(body.at(shares)) @ carried
    seen = np.einsum("nij,kj->nki", into[:, :3, :3], ends) + into[:, None, :3, 3]
    return np.asarray(seen)


def pieces_needed(body: Movement, sensor: Movement, ends: Array, tolerance: float) -> int:
    """The number of equal time intervals in each of which points (k, 3) of the sensor, seen from
    the body, deviate by at most `tolerance` from a straight line, measured in the world."""
    straight = body.rigid and sensor.rigid and not (body.angle or sensor.angle)
    if straight:
        return 1
    first = max(1 if body.rigid else FEWEST, math.ceil((body.angle + sensor.angle) / ARC))
    seen = seen_from(body, sensor, np.linspace(0.0, 1.0, 2 * first + 1), ends)
    strays = (seen[1::2] - (seen[:-1:2] + seen[2::2]) / 2.0) @ body.after[:3, :3].T
    stray = float(np.linalg.norm(strays, axis=2).max())
    # A short arc deviates most in its middle, by the square of its length.
    return min(MOST, first * max(1, math.ceil(math.sqrt(stray / ENOUGH / tolerance))))
