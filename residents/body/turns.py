# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns as unit quaternions (…, 4), and mixtures, for whole arrays at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...sensor_logic.model import Array

X, Y, Z = np.eye(3)


def about(axis: int, angle: ArrayLike) -> Array:
    """The turn by an angle (…,) about the axis 0, 1 or 2."""
    # In one piece: numpy's sine rounds otherwise where the angles lie apart in memory.
    half = np.array(0.5 * np.asarray(angle, float), order="C")
    turn = np.zeros((*half.shape, 4))
    turn[..., 0], turn[..., 1 + axis] = np.cos(half), np.sin(half)
    return turn


def about_x(angle: ArrayLike) -> Array:
    return about(0, angle)


def about_y(angle: ArrayLike) -> Array:
    return about(1, angle)


def about_z(angle: ArrayLike) -> Array:
    return about(2, angle)


def about_axis(axis: Array, angle: ArrayLike) -> Array:
    """The turn about unit axes (…, 3)."""
    half = np.array(0.5 * np.asarray(angle, float)[..., None], order="C")
    vector = np.sin(half) * axis
    return np.concatenate([np.broadcast_to(np.cos(half), (*vector.shape[:-1], 1)), vector], -1)


def times(a: Array, b: Array) -> Array:
    """First b, then a."""
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    w = aw * bw - ax * bx - ay * by - az * bz
    # `np.stack` takes three times as long for so few.
    result = np.empty((*w.shape, 4))
    result[..., 0] = w
    result[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    result[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    result[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return result


def chained(*turns: Array) -> Array:
    """The last first, as in a product of matrices."""
    result = turns[0]
    for turn in turns[1:]:
        result = times(result, turn)
    return result


def back(turn: Array) -> Array:
    """The turn back."""
    result: Array = turn * np.array([1.0, -1.0, -1.0, -1.0])
    return result


def cross(a: Array, b: Array) -> Array:
    # numpy's own costs three times as much for arrays of so few vectors.
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    x = ay * bz - az * by
    result = np.empty((*x.shape, 3))
    result[..., 0], result[..., 1] = x, az * bx - ax * bz
    result[..., 2] = ax * by - ay * bx
    return result


def turned(turn: Array, v: ArrayLike) -> Array:
    """Vectors (…, 3), turned."""
    vector = np.asarray(v, float)
    w, u = turn[..., :1], turn[..., 1:]
    twice = 2.0 * cross(u, vector)
    result: Array = vector + w * twice + cross(u, twice)
    return result


def from_columns(x: Array, y: Array, z: Array) -> Array:
    """The turn that takes the axes to the columns (…, 3), which are orthonormal."""
    m = np.stack([x, y, z], -1)
    a, b, c = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    square = np.empty((*m.shape[:-2], 4, 4))  # 4 q qᵀ
    square[..., 0, 0], square[..., 1, 1] = 1 + a + b + c, 1 + a - b - c
    square[..., 2, 2], square[..., 3, 3] = 1 - a + b - c, 1 - a - b + c
    for i, j, value in (
        (0, 1, m[..., 2, 1] - m[..., 1, 2]),
        (0, 2, m[..., 0, 2] - m[..., 2, 0]),
        (0, 3, m[..., 1, 0] - m[..., 0, 1]),
        (1, 2, m[..., 1, 0] + m[..., 0, 1]),
        (1, 3, m[..., 0, 2] + m[..., 2, 0]),
        (2, 3, m[..., 2, 1] + m[..., 1, 2]),
    ):
        square[..., i, j] = square[..., j, i] = value
    largest = np.argmax(np.diagonal(square, axis1=-2, axis2=-1), -1)
    return unit(np.take_along_axis(square, largest[..., None, None], -2)[..., 0, :])


def unit(v: Array) -> Array:
    """Vectors (…, k) of length 1."""
    result: Array = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)
    return result


def share(t: ArrayLike, of: Array) -> Array:
    """Shares (n,) with further axes of length 1, to be multiplied with `of` (n, …)."""
    shares = np.asarray(t, float)
    return shares.reshape(shares.shape + (1,) * (of.ndim - shares.ndim))


def mix(a: Array, b: Array, t: ArrayLike) -> Array:
    """Mixes a (t = 0) and b (t = 1); t (n,) or a number, a and b with n as their first axis."""
    result: Array = a + (b - a) * share(t, b)
    return result


def mix_turns(a: Array, b: Array, t: ArrayLike) -> Array:
    """The shorter way from turn a (t = 0) to turn b (1), at an even pace."""
    cosine = (a * b).sum(-1, keepdims=True)
    b = np.where(cosine < 0, -b, b)
    cosine = np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    near = sine < 1e-5
    sine = np.where(near, 1.0, sine)
    shares = share(t, cosine)
    first = np.where(near, 1 - shares, np.sin((1 - shares) * angle) / sine)
    second = np.where(near, shares, np.sin(shares * angle) / sine)
    return unit(first * a + second * b)


def ease(t: ArrayLike) -> Array:
    """0 to 1 with soft ends."""
    s = np.clip(np.asarray(t, float), 0.0, 1.0)
    result: Array = s * s * (3 - 2 * s)
    return result
