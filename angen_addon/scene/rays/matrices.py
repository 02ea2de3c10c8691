# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrices of many objects at once, and the bounds that their shapes have in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array

# A box is padded by this many units, and by the rounding of single precision at its distance, so
# that a flat object's box still catches the rays that hit it.
PADDING = 1e-5
RELATIVE_PADDING = 1e-6
# Of each row or column of a 3 × 3 matrix, the next one and the one after, in turn.
BELOW = RIGHT = np.array([1, 2, 0])
ABOVE = LEFT = np.array([2, 0, 1])


def matrices_of(flat: NDArray[np.float32]) -> Array:
    """(n, 4, 4) from what `foreach_get` gives (n, 16), which is column by column."""
    return flat.reshape(-1, 4, 4).transpose(0, 2, 1).astype(np.float64)


def invertible(matrix: Array) -> NDArray[np.bool_]:
    """Which matrices (…, 4, 4) have an inverse."""
    with np.errstate(all="ignore"):
        determinant = _determinant(matrix, _cofactors(matrix))
        good = np.isfinite(matrix).all(axis=(-2, -1)) & (determinant != 0.0)
        result: NDArray[np.bool_] = good & np.isfinite(determinant)
    return result


def inverted(matrix: Array) -> Array:
    """The inverses (…, 4, 4) of affine matrices that have one, by their cofactors.

    numpy's `inv` calls LAPACK, whose threads wait for each other: in Blender, where others are at
    work beside them, that took 4 ms for a single matrix.
    """
    cofactors = _cofactors(matrix)
    inverse = np.zeros_like(matrix)
    turn = inverse[..., :3, :3]
    turn[...] = cofactors.swapaxes(-2, -1) / _determinant(matrix, cofactors)[..., None, None]
    inverse[..., :3, 3] = -(turn @ matrix[..., :3, 3:])[..., 0]
    inverse[..., 3, 3] = 1.0
    return inverse


def _cofactors(matrix: Array) -> Array:
    """(…, 3, 3) of the linear parts of matrices (…, 4, 4)."""
    right, left = matrix[..., RIGHT], matrix[..., LEFT]
    return right[..., BELOW, :] * left[..., ABOVE, :] - left[..., BELOW, :] * right[..., ABOVE, :]


def _determinant(matrix: Array, cofactors: Array) -> Array:
    return np.asarray((matrix[..., 0, :3] * cofactors[..., 0, :]).sum(axis=-1))


def world_bounds(
    matrix: Array, invertible: NDArray[np.bool_], lo: Array, hi: Array
) -> tuple[Array, Array]:
    """Bounds (…, 3) in the world of what has the bounds `lo`, `hi` (…, 3) before its matrix
    (…, 4, 4); of what is flattened or not a number, such that nothing is in them."""
    turn = matrix[..., :3, :3]
    with np.errstate(all="ignore"):
        good = (invertible & np.isfinite(lo).all(axis=-1))[..., None]
        centre = (turn @ ((lo + hi) / 2)[..., None])[..., 0] + matrix[..., :3, 3]
        half = (np.abs(turn) @ ((hi - lo) / 2)[..., None])[..., 0]
        half += PADDING + RELATIVE_PADDING * (np.abs(centre) + half)
    return np.where(good, centre - half, np.inf), np.where(good, centre + half, -np.inf)
