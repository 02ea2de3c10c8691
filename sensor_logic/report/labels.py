# SPDX-License-Identifier: GPL-3.0-or-later
"""Places marks beside the points that they label, without overlaps."""

from __future__ import annotations

import math

import numpy as np

from ..model import Array

# Distances (px) and directions to try, the nearest first.
RINGS = (0.0, 17.0, 26.0, 38.0, 54.0, 76.0, 108.0)
DIRECTIONS = 16


def spread(
    places: Array, size: tuple[float, float], box: tuple[float, float, float, float]
) -> Array:
    """The positions (n, 2) of marks of a size (width, height) for `places` (n, 2), within a box
    (left, top, right, bottom) where possible. In order, each mark gets the nearest free spot, or
    without one the spot farthest from all other marks."""
    offsets = np.array(
        [(0.0, 0.0)]
        + [
            (r * math.cos(2 * math.pi * k / DIRECTIONS), r * math.sin(2 * math.pi * k / DIRECTIONS))
            for r in RINGS[1:]
            for k in range(DIRECTIONS)
        ]
    )
    half = np.array(size) / 2
    low, high = np.array(box[:2]) + half, np.array(box[2:]) - half
    found = np.empty((len(places), 2))
    for i, at in enumerate(places):
        spots = np.clip(at + offsets, low, np.maximum(high, low))
        gaps = np.abs(spots[:, None, :] - found[None, :i, :]) / np.array(size)
        apart = gaps.max(axis=2).min(axis=1, initial=np.inf)
        free = np.flatnonzero(apart >= 1.0)
        found[i] = spots[free[0] if len(free) else int(np.argmax(apart))]
    return found
