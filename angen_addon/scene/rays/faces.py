# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts faces into triangles as Blender does, for meshes so large that asking Blender takes long."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Faces cut in one go, to bound the memory.
AT_ONCE = 1 << 16


def cut_faces(
    points: NDArray[np.float32], corners: NDArray[np.int32], starts: NDArray[np.int32]
) -> NDArray[np.int32] | None:
    """Triangles (m, 3) of the vertices `points` (n, 3), in the order of the faces, of which
    `corners` are the vertices and `starts` say where those of each begin; None where a face has
    more than four, which need more thought."""
    ends = np.append(starts[1:], np.int32(len(corners)))
    sizes = ends - starts
    if len(sizes) and (sizes.min() < 3 or sizes.max() > 4):
        return None
    triangles = np.empty((len(corners) - 2 * len(starts), 3), np.int32)
    done = 0
    for first in range(0, len(starts), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        found = _cut(points, corners, starts[part], sizes[part] == 4)
        triangles[done : done + len(found)] = found
        done += len(found)
    return triangles


def _cut(
    points: NDArray[np.float32],
    corners: NDArray[np.int32],
    starts: NDArray[np.int32],
    quads: NDArray[np.bool_],
) -> NDArray[np.int32]:
    row = np.arange(len(starts)) + np.cumsum(quads) - quads
    triangles = np.empty((len(starts) + int(quads.sum()), 3), np.int32)
    for column in range(3):
        triangles[row, column] = corners[starts + column]
    starts, row = starts[quads], row[quads]
    a, b, c, d = (corners[starts + column] for column in range(4))
    # By the other diagonal where that from the first corner would fold the face.
    other = _folds(*(np.take(points, vertices, axis=0).T for vertices in (a, b, c, d)))
    triangles[row[other], 2] = d[other]
    triangles[row + 1, 0] = np.where(other, b, a)
    triangles[row + 1, 1], triangles[row + 1, 2] = c, d
    return triangles


def _folds(
    a: NDArray[np.float32],
    b: NDArray[np.float32],
    c: NDArray[np.float32],
    d: NDArray[np.float32],
) -> NDArray[np.bool_]:
    """Whether the corners b and d (3, n) are on the same side of the diagonal from a to c, in
    single precision as Blender works it out."""
    one, two, (x, y, z) = b - a, d - a, c - a
    products = np.zeros(a.shape[1], np.float32)
    for i, j, (u, v) in ((0, 1, (x, y)), (1, 2, (y, z)), (2, 0, (z, x))):
        products += (one[i] * v - one[j] * u) * (two[i] * v - two[j] * u)
    return np.asarray(products > 0.0)
