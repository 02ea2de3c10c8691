# SPDX-License-Identifier: GPL-3.0-or-later
"""The colours of kinds of sensors, and of temperatures and other numbers in pictures.

Numbers go from black over red to pale yellow. Brightness grows evenly with the value, so the order
is also visible to colour-blind people.

References
----------
N. Smith, S. van der Walt, "inferno", a colour map of matplotlib (CC0): ten of its colours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .model import Array

# The colour-blind-safe colours of Okabe and Ito, a brown, an indigo, a teal, a wine red, an olive.
BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#cc79a7"
YELLOW, SKY, BLACK, BROWN = "#e69f00", "#56b4e9", "#000000", "#7f4f24"
INDIGO, TEAL, WINE, OLIVE = "#4b3f8f", "#11696f", "#8c1c4b", "#6b7a00"
# Of each kind by its number, on white and on dark ground.
KIND_COLOURS = (
    (BLUE, SKY),
    (ORANGE, "#f0803c"),
    (GREEN, "#2fc197"),
    (YELLOW, "#f0b73c"),
    (PURPLE, "#dd9abf"),
    (BROWN, "#c89b6d"),
    (INDIGO, "#a99fe6"),
    (TEAL, "#58bfc4"),
    (WINE, "#e0648f"),
    (OLIVE, "#b7c44a"),
)

INFERNO = (
    *("000004", "1b0c41", "4a0c6b", "781c6d", "a52c60"),
    *("cf4446", "ed6925", "fb9b06", "f7d13d", "fcffa4"),
)
STOPS = np.array([[int(code[i : i + 2], 16) for i in (0, 2, 4)] for code in INFERNO]) / 255.0


def colours(values: ArrayLike, low: float, high: float) -> Array:
    """Return colours (…, 3) of values (…), as sRGB from 0 to 1.

    `low` is black and `high` pale yellow. Values outside have these colours too.
    """
    share = (np.asarray(values, np.float64) - low) / max(high - low, 1e-12)
    at = np.clip(share, 0.0, 1.0) * (len(STOPS) - 1)
    each = [np.interp(at, np.arange(len(STOPS)), STOPS[:, channel]) for channel in range(3)]
    return np.stack(each, axis=-1)


def limits(values: ArrayLike, least: float) -> tuple[float, float]:
    """Return the lowest and the highest value, at least `least` apart: the ends of a colour scale.

    Without a finite value, return 0 and `least`.
    """
    known = np.asarray(values, np.float64)
    known = known[np.isfinite(known)]
    if not known.size:
        return 0.0, least
    low, high = float(known.min()), float(known.max())
    return low, max(high, low + least)


def rgba(code: str) -> tuple[float, float, float, float]:
    """Return a colour such as "#0072b2" as red, green, blue and opacity from 0 to 1."""
    red, green, blue = (int(code[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return red, green, blue, 1.0
