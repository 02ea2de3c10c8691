# SPDX-License-Identifier: GPL-3.0-or-later
"""Make meshes from signed distance functions.

A shape is a function of points (n, 3) in metres. It returns their distances (n,) to its surface,
negative inside. `mesh` samples a shape on a grid and makes quads (naive surface nets).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...sensor_logic.model import Array, Index

Shape = Callable[[Array], Array]
Corner = tuple[float, float, float]


def ball(centre: ArrayLike, radii: ArrayLike) -> Shape:
    """Return the shape of an ellipsoid with half axes `radii`, m.

    Its distance is exact only near the surface.
    """
    c, r = np.asarray(centre, float), np.broadcast_to(np.asarray(radii, float), (3,))

    def shape(p: Array) -> Array:
        k0 = np.linalg.norm((p - c) / r, axis=1)
        k1 = np.linalg.norm((p - c) / r**2, axis=1)
        d: Array = k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)
        return d

    return shape


def capsule(a: ArrayLike, b: ArrayLike, ra: float, rb: float) -> Shape:
    """Return the shape of a cone with round ends.

    Parameters
    ----------
    a, b : array, shape (3,)
        Centres of the two ends, m.
    ra, rb : float
        Radii of the two ends, m.
    """
    start, axis = np.asarray(a, float), np.subtract(b, a)

    def shape(p: Array) -> Array:
        t = np.clip((p - start) @ axis / (axis @ axis), 0.0, 1.0)
        off: Array = np.linalg.norm(p - start - t[:, None] * axis, axis=1)
        d: Array = off - (ra + t * (rb - ra))
        return d

    return shape


def loft(
    table: ArrayLike,
    origin: ArrayLike = (0, 0, 0),
    axes: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    power: float = 2.0,
    cap: float = 0.02,
) -> Shape:
    """Return the shape of a solid with superelliptic cross-sections along its third axis.

    Parameters
    ----------
    table : array, shape (k, 4)
        A row for each cross-section, in m: height along the third axis, offset along the first
        axis, half axis along the first axis, and half axis along the second axis.
    origin : array, shape (3,)
        The point at height 0, m.
    axes : array, shape (3, 3)
        The three axes as rows.
    power : float
        Exponent of the superellipse; 2 gives ellipses.
    cap : float
        Radius by which the edges of the two ends are rounded, m.
    """
    rows = np.asarray(table, float)
    base, frame = np.asarray(origin, float), np.asarray(axes, float)

    def shape(p: Array) -> Array:
        u, v, w = frame @ (p - base).T
        offset, half_u, half_v = (smooth_table(rows[:, 0], rows[:, k], w) for k in (1, 2, 3))
        ring = (np.abs((u - offset) / half_u) ** power + np.abs(v / half_v) ** power) ** (1 / power)
        side = (ring - 1.0) * np.minimum(half_u, half_v)
        end = np.maximum(rows[0, 0] - w, w - rows[-1, 0])
        return -smooth_min(-side, -end, cap)

    return shape


def smooth_table(x: Array, y: Array, at: Array) -> Array:
    """Interpolate a table with monotone cubics; outside the table, values are constant.

    Parameters
    ----------
    x, y : array, shape (k,)
        The points of the table, with x increasing.
    at : array, shape (n,)
        The values of x to interpolate at.

    Returns
    -------
    array, shape (n,)
        The interpolated y, without overshoot.

    References
    ----------
    Fritsch and Carlson.
    """
    step = np.diff(x)
    slope = np.diff(y) / step
    same = slope[:-1] * slope[1:] > 0
    inner = np.zeros(len(slope) - 1)
    inner[same] = 2 / (1 / slope[:-1][same] + 1 / slope[1:][same])
    tangent = np.concatenate([[slope[0]], inner, [slope[-1]]])
    at = np.clip(at, x[0], x[-1])
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    h, t = step[i], (at - x[i]) / step[i]
    result: Array = (
        (1 + 2 * t) * (1 - t) ** 2 * y[i]
        + t * (1 - t) ** 2 * h * tangent[i]
        + t**2 * (3 - 2 * t) * y[i + 1]
        + t**2 * (t - 1) * h * tangent[i + 1]
    )
    return result


def smooth_min(a: Array, b: Array, k: float) -> Array:
    """Return the smaller of two distances, with a smooth transition where they are similar.

    Parameters
    ----------
    a, b : array, shape (n,)
        Distances to two surfaces, m.
    k : float
        Difference of the distances up to which the transition is smooth, m.
    """
    h = np.maximum(k - np.abs(a - b), 0.0) / k
    result: Array = np.minimum(a, b) - h * h * k / 4
    return result


def union(k: float, *shapes: Shape) -> Shape:
    """Return the union of shapes, with smooth transitions `k` m wide."""

    def shape(p: Array) -> Array:
        d = shapes[0](p)
        for other in shapes[1:]:
            d = smooth_min(d, other(p), k)
        return d

    return shape


def cut(k: float, body: Shape, *tools: Shape) -> Shape:
    """Return the shape `body` without the shapes `tools`, with edges rounded over `k` m."""

    def shape(p: Array) -> Array:
        d = body(p)
        for tool in tools:
            d = -smooth_min(-d, tool(p), k)
        return d

    return shape


def mirrored(shape: Shape) -> Shape:
    """Return the shape mirrored at the xz plane."""
    return lambda p: shape(p * (1.0, -1.0, 1.0))


def mesh(shape: Shape, low: Corner, high: Corner, cell: float) -> tuple[Array, Index]:
    """Make a mesh of a shape inside a box.

    Parameters
    ----------
    shape : Shape
        The signed distance function.
    low, high : tuple of 3 floats
        The corners of the box, m.
    cell : float
        Edge length of the grid's cells, m.

    Returns
    -------
    points : array, shape (n, 3)
        The vertices, m.
    quads : array, shape (m, 4)
        Vertex indices of each face, whose normal points outward.
    """
    axes = [np.arange(a - cell, b + 2 * cell, cell) for a, b in zip(low, high, strict=True)]
    size = tuple(len(a) for a in axes)
    corners = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    d = shape(corners.reshape(-1, 3)).reshape(size)

    total = np.zeros(tuple(n - 1 for n in size) + (3,))
    count = np.zeros(total.shape[:3])
    crossings = []
    for axis in range(3):
        a = np.moveaxis(d, axis, 0)
        near, far = a[:-1], a[1:]
        hit = np.moveaxis((near < 0) != (far < 0), 0, axis)
        step = near - far
        t = np.moveaxis(near / np.where(step == 0, 1.0, step), 0, axis)
        inside_first = np.moveaxis(near < 0, 0, axis)
        crossings.append((hit, inside_first))
        base = corners[tuple(slice(0, n - (k == axis)) for k, n in enumerate(size))].copy()
        base[..., axis] += np.clip(t, 0, 1) * cell
        u, v = [k for k in range(3) if k != axis]
        for du in (0, 1):
            for dv in (0, 1):
                window = [slice(None)] * 3
                window[u] = slice(du, size[u] - 1 + du)
                window[v] = slice(dv, size[v] - 1 + dv)
                h = hit[tuple(window)]
                total += np.where(h[..., None], base[tuple(window)], 0.0)
                count += h
    used = count > 0
    number = np.full(used.shape, -1)
    number[used] = np.arange(used.sum())
    points = total[used] / count[used][:, None]

    quads = []
    for axis, (hit, inside_first) in enumerate(crossings):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        at = np.argwhere(hit)
        at = at[(at[:, u] > 0) & (at[:, v] > 0)]
        ring = []
        for du, dv in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
            c = at.copy()
            c[:, u] += du
            c[:, v] += dv
            ring.append(number[tuple(c.T)])
        q = np.stack(ring, 1)
        flip = ~inside_first[tuple(at.T)]
        q[flip] = q[flip][:, ::-1]
        quads.append(q)
    return _project(shape, points, cell), np.concatenate(quads)


def _project(shape: Shape, points: Array, cell: float) -> Array:
    """Move points onto the surface by two Newton steps, which smooths the grid's staircase."""
    eps = cell * 0.1
    for _ in range(2):
        d = shape(points)
        grad = np.stack([shape(points + e) - shape(points - e) for e in np.eye(3) * eps], 1) / (
            2 * eps
        )
        length2 = np.maximum((grad**2).sum(1), 0.25)
        points = points - np.clip(d / length2, -0.4 * cell, 0.4 * cell)[:, None] * grad
    return points
