# SPDX-License-Identifier: GPL-3.0-or-later
"""How a body gets from one pose to the next, where only the two are known.

By Chasles' theorem a rigid body can always get there by a screw: a turn about an axis and a glide
along it. Taken at a constant rate that is exact for what goes straight without turning and for
what turns about a hinge, wherever its origin is. What changes its size is stretched at a constant
rate besides (the polar decomposition tells by what).
"""

from __future__ import annotations

import math

import numpy as np

from ..model import Array

# Single precision turns that are meant to be rigid differ from it by less than this.
RIGID = 1e-5
# rad: less of a turn is none, but rounding; its centre would be too far away to be told.
SMALLEST_TURN = 1e-7
# rad: an arc that is looked at to tell how far it strays; how many there are at least where a body
# is stretched; what is allowed for the difference to a parabola; and how many pieces there are at
# most.
ARC = math.pi / 8.0
FEWEST = 8
ENOUGH = 0.8
MOST = 10_000


class Movement:
    """From the matrix `before` to `after` (4, 4), both with an inverse and of the same handedness;
    `angle` (rad, 0 to π) is what it turns by, `rigid` whether its size stays. Both are best given
    about a near point."""

    def __init__(self, before: Array, after: Array) -> None:
        self.before, self.after = before, after
        self.still = bool(np.array_equal(before, after))
        left, sizes, right = np.linalg.svd(after[:3, :3] @ np.linalg.inv(before[:3, :3]))
        turn = left @ right
        self.rigid = bool(np.abs(sizes - 1.0).max() < RIGID)
        # How much it is longer along its main directions, as a matrix.
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
        """Matrices (n, 4, 4) after these shares (n,) of the time, 0 to 1."""
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
    """Points (n, k, 3) in the space of a moving body, after shares (n,) of the time, of points
    (k, 3) that go with a sensor; `ends` is where these are at last."""
    carried = sensor.at(shares) @ np.linalg.inv(sensor.after)
    into = np.linalg.inv(body.at(shares)) @ carried
    seen = np.einsum("nij,kj->nki", into[:, :3, :3], ends) + into[:, None, :3, 3]
    return np.asarray(seen)


def pieces_needed(body: Movement, sensor: Movement, ends: Array, tolerance: float) -> int:
    """Into how many equal times a movement is cut for points (k, 3) of the sensor to stray by no
    more than `tolerance` from straight ways in between, as measured in the world."""
    straight = body.rigid and sensor.rigid and not (body.angle or sensor.angle)
    if straight:
        return 1
    first = max(1 if body.rigid else FEWEST, math.ceil((body.angle + sensor.angle) / ARC))
    seen = seen_from(body, sensor, np.linspace(0.0, 1.0, 2 * first + 1), ends)
    strays = (seen[1::2] - (seen[:-1:2] + seen[2::2]) / 2.0) @ body.after[:3, :3].T
    stray = float(np.linalg.norm(strays, axis=2).max())
    # So short an arc strays most in its middle, by the square of its length.
    return min(MOST, first * max(1, math.ceil(math.sqrt(stray / ENOUGH / tolerance))))
