# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations as unit quaternions, shape (…, 4), and interpolation, for whole arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...sensor_logic.model import Array

X, Y, Z = np.eye(3)


def rotation(axis: int, angle: ArrayLike) -> Array:
    """Return the rotations by `angle` (…), rad, about the axis 0 (x), 1 (y) or 2 (z)."""
    # A contiguous copy: numpy's sine rounds strided arrays differently.
    half = np.array(0.5 * np.asarray(angle, float), order="C")
    turn = np.zeros((*half.shape, 4))
    turn[..., 0], turn[..., 1 + axis] = np.cos(half), np.sin(half)
    return turn


def rotation_x(angle: ArrayLike) -> Array:
    """Return the rotations by `angle` (…), rad, about the x axis."""
    return rotation(0, angle)


def rotation_y(angle: ArrayLike) -> Array:
    """Return the rotations by `angle` (…), rad, about the y axis."""
    return rotation(1, angle)


def rotation_z(angle: ArrayLike) -> Array:
    """Return the rotations by `angle` (…), rad, about the z axis."""
    return rotation(2, angle)


def axis_angle(axis: Array, angle: ArrayLike) -> Array:
    """Return the rotations by `angle` (…), rad, about unit vectors `axis` (…, 3)."""
    half = np.array(0.5 * np.asarray(angle, float)[..., None], order="C")
    vector = np.sin(half) * axis
    return np.concatenate([np.broadcast_to(np.cos(half), (*vector.shape[:-1], 1)), vector], -1)


def compose(a: Array, b: Array) -> Array:
    """Return the rotations that rotate by `b` and then by `a`.

    Parameters
    ----------
    a, b : array, shape (…, 4)
        Unit quaternions.
    """
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    w = aw * bw - ax * bx - ay * by - az * bz
    # `np.stack` takes three times as long for small arrays.
    result = np.empty((*w.shape, 4))
    result[..., 0] = w
    result[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    result[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    result[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return result


def compose_all(*turns: Array) -> Array:
    """Return the product of rotations (…, 4); the last one is applied first, as with matrices."""
    result = turns[0]
    for turn in turns[1:]:
        result = compose(result, turn)
    return result


def inverse(turn: Array) -> Array:
    """Return the inverse rotations of unit quaternions (…, 4)."""
    result: Array = turn * np.array([1.0, -1.0, -1.0, -1.0])
    return result


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of vectors (…, 3)."""
    # `np.cross` takes three times as long for small arrays.
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    x = ay * bz - az * by
    result = np.empty((*x.shape, 3))
    result[..., 0], result[..., 1] = x, az * bx - ax * bz
    result[..., 2] = ax * by - ay * bx
    return result


def rotated(turn: Array, v: ArrayLike) -> Array:
    """Return vectors rotated by quaternions.

    Parameters
    ----------
    turn : array, shape (…, 4)
        Unit quaternions.
    v : array, shape (…, 3)
        The vectors.
    """
    vector = np.asarray(v, float)
    w, u = turn[..., :1], turn[..., 1:]
    twice = 2.0 * cross(u, vector)
    result: Array = vector + w * twice + cross(u, twice)
    return result


def from_columns(x: Array, y: Array, z: Array) -> Array:
    """Return the rotations that turn the coordinate axes into the vectors x, y and z.

    Parameters
    ----------
    x, y, z : array, shape (…, 3)
        Orthonormal, right-handed vectors.

    Returns
    -------
    array, shape (…, 4)
        Unit quaternions.
    """
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
    return normalised(np.take_along_axis(square, largest[..., None, None], -2)[..., 0, :])


def normalised(v: Array) -> Array:
    """Return vectors (…, k) scaled to length 1."""
    result: Array = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)
    return result


def add_axes(t: ArrayLike, values: Array) -> Array:
    """Return `t` (n,) with axes of length 1 appended, to broadcast it against `values` (n, …)."""
    shares = np.asarray(t, float)
    return shares.reshape(shares.shape + (1,) * (values.ndim - shares.ndim))


def lerp(a: Array, b: Array, t: ArrayLike) -> Array:
    """Interpolate linearly from `a` (t = 0) to `b` (t = 1).

    Parameters
    ----------
    a, b : array, shape (n, …)
        The values to interpolate.
    t : float or array, shape (n,)
        The weight of `b`, 0 … 1.
    """
    result: Array = a + (b - a) * add_axes(t, b)
    return result


def slerp(a: Array, b: Array, t: ArrayLike) -> Array:
    """Interpolate rotations from `a` (t = 0) to `b` (t = 1), along the shorter arc.

    The angular speed is constant over t.

    Parameters
    ----------
    a, b : array, shape (n, …, 4)
        Unit quaternions.
    t : float or array, shape (n,)
        The weight of `b`, 0 … 1.
    """
    cosine = (a * b).sum(-1, keepdims=True)
    b = np.where(cosine < 0, -b, b)
    cosine = np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    near = sine < 1e-5
    sine = np.where(near, 1.0, sine)
    shares = add_axes(t, cosine)
    first = np.where(near, 1 - shares, np.sin((1 - shares) * angle) / sine)
    second = np.where(near, shares, np.sin(shares * angle) / sine)
    return normalised(first * a + second * b)


def ease(t: ArrayLike) -> Array:
    """Return 3t² − 2t³, with `t` clipped to 0 … 1: a step that starts and ends slowly."""
    s = np.clip(np.asarray(t, float), 0.0, 1.0)
    result: Array = s * s * (3 - 2 * s)
    return result
