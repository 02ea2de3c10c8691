# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of a coverage map, brighter with better coverage, and distinct in grey and for the
colour-blind (viridis)."""

from __future__ import annotations

import numpy as np

from ..model import Array
from .grid import CoverageMap

# Matplotlib's viridis (CC0) at 0, 1/4, 1/2, 3/4 and 1, sRGB.
VIRIDIS = np.array(
    [
        (0.267, 0.005, 0.329),
        (0.230, 0.322, 0.546),
        (0.128, 0.567, 0.551),
        (0.369, 0.789, 0.383),
        (0.993, 0.906, 0.144),
    ]
)
# The levels of a cell: nothing detected; less than `grid.ENOUGH`; covered by one, two, more.
LEVELS = (
    "not noticed",
    "noticed in few directions",
    "covered by one",
    "by two",
    "by three or more",
)


def levels(coverage: CoverageMap) -> np.typing.NDArray[np.intp]:
    """The index (cells,) into LEVELS of each cell."""
    count = np.minimum(coverage.count, 3)
    partly = (coverage.best > 0.0).astype(np.intp)
    found: np.typing.NDArray[np.intp] = np.where(count > 0, count + 1, partly)
    return found


def linear(colour: Array) -> Array:
    """Linear values of sRGB colours."""
    low, high = colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4
    result: Array = np.where(colour <= 0.04045, low, high)
    return result


def css(level: int) -> str:
    return "#" + "".join(f"{round(255 * c):02x}" for c in VIRIDIS[level].tolist())
