# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays of one plane against the triangles of a surface that changes shape.

A fan's rays lie in a plane, and they can meet only the triangles that it cuts: of a person some
hundred. Met all at once, that costs a fifth of building a hierarchy for this one use.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Share of 1: directions and, by the size of the fan, origins that are this near to a plane lie in
# it.
FLAT = 1e-9
# Units, and share of the plane's distance from the origin: triangles this near to it are cut.
SLACK = 1e-6
RELATIVE_SLACK = 1e-9
# A ray this little beside a triangle, as share of it, meets it: no gap opens along an edge.
RIM = 1e-9


def plane_of(origins: Array, directions: Array) -> tuple[Array, Array] | None:
    """A point (3,) and the normal (3,) of a plane that rays (n, 3) lie in; None if they do not."""
    first = directions[0]
    aside = _cross(directions, first)
    sizes = np.einsum("ij,ij->i", aside, aside)
    widest = int(np.argmax(sizes))
    normal = aside[widest]
    if sizes[widest] < FLAT:
        # All one way: side by side, or a single ray.
        apart = _cross(origins - origins[0], first)
        normal = apart[int(np.argmax(np.einsum("ij,ij->i", apart, apart)))]
    if float(normal @ normal) < FLAT * FLAT:
        normal = _cross(first, np.eye(3)[int(np.argmin(np.abs(first)))])
    normal = normal / np.sqrt(normal @ normal)
    arms = origins - origins[0]
    size = 1.0 + float(np.abs(arms).max())
    flat = max(np.abs(directions @ normal).max(), np.abs(arms @ normal).max() / size)
    return (origins[0], normal) if flat <= FLAT else None


def cut(
    vertices: NDArray[np.float32], corners: NDArray[np.intp], normal: Array, offset: float
) -> NDArray[np.intp]:
    """Which of the triangles `corners` (3, m) of `vertices` (n, 3) the plane normal · x = offset
    cuts or touches."""
    height = vertices @ normal - offset
    slack = SLACK + RELATIVE_SLACK * abs(offset)
    side = (height > slack).view(np.int8) - (height < -slack).view(np.int8)
    sides = side[corners[0]] + side[corners[1]] + side[corners[2]]
    return np.flatnonzero(np.abs(sides) < 3)


def meet(triangles: Array, origins: Array, ways: Array) -> Array:
    """How far (n,), in lengths of their `ways` (n, 3), rays from `origins` (n, 3) go to the nearest
    of the triangles (m, 3, 3); inf where they meet none.

    Möller and Trumbore's equations, written so that all but the last step are products of
    matrices.
    """
    if not len(triangles):
        return np.full(len(origins), np.inf)
    # About the first ray's origin, so that nothing is lost far from the world's.
    corner = triangles[:, 0] - origins[0]
    one, two = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    starts = origins - origins[0]
    normal = _cross(one, two)
    moments = _cross(starts, ways)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = -1.0 / (ways @ normal.T)
        u = (moments @ two.T - ways @ _cross(two, corner).T) * inverse
        v = (ways @ _cross(one, corner).T - moments @ one.T) * inverse
        far = (starts @ normal.T - np.einsum("ij,ij->i", corner, normal)) * inverse
        met = (u >= -RIM) & (v >= -RIM) & (u + v <= 1.0 + RIM) & (far >= 0.0)
    nearest: Array = np.where(met, far, np.inf).min(axis=1)
    return nearest


def _cross(one: Array, two: Array) -> Array:
    """Vector products along the last axis; numpy's own takes several times as long on few."""
    a, b, c = one[..., 0], one[..., 1], one[..., 2]
    x, y, z = two[..., 0], two[..., 1], two[..., 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
