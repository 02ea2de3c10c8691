# SPDX-License-Identifier: GPL-3.0-or-later
"""The Hann window of a radar's spectrum over the distance, of which the gates are the bins."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array

# Cells of distance in a gate, each of which has its own random sum of echoes. The lobe of a Hann
# window is two gates long on each side.
CELLS = 4
LOBE = 2 * CELLS


def hann(x: ArrayLike) -> Array:
    """Return the amplitude (n,) that a bin has of a point x (n,) bins away, with a Hann window.

    It is sinc(x)/(1 − x²) in the main lobe, which is two bins long on each side, and 0 beyond.

    References
    ----------
    F. J. Harris (1978), On the use of windows for harmonic analysis, Proc. IEEE 66, section V.C.
    """
    x = np.abs(np.asarray(x, np.float64))
    edge = np.abs(x - 1.0) < 1e-9
    found = np.where(edge, 0.5, np.sinc(x) / np.where(edge, 1.0, 1.0 - x * x))
    return np.where(x < LOBE / CELLS, found, 0.0)
