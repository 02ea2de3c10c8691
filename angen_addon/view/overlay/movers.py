# SPDX-License-Identifier: GPL-3.0-or-later
"""What moved among the solids since the last look, so that only rays near it are cast again."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from ...scene.rays.solids import Solids

NOWHERE = np.empty((0, 3))


class Movers:
    """Bounds `lo`, `hi` (k, 3) of what moved at the last look, there and where it came from;
    `everything`: the list of solids itself changed."""

    def __init__(self, solids: Solids) -> None:
        self.solids = solids
        self.everything = True
        self.lo, self.hi = NOWHERE, NOWHERE
        self._listed: tuple[int, int] | None = None
        self._matrix = np.empty((0, 4, 4))
        self._shapes: list[Any] = []
        self._bounds: tuple[Array, Array] = NOWHERE, NOWHERE

    def follow(self) -> None:
        """To be called after each look at the solids."""
        solids = self.solids
        rows = np.flatnonzero(solids.moving)
        listed = solids.listing, len(solids.gone)
        matrix, bounds = solids.matrix[rows], (solids.lo[rows], solids.hi[rows])
        shapes = [solids.solids[row].geometry.state for row in rows.tolist()]
        self.everything = listed != self._listed
        if self.everything:
            self.lo = self.hi = NOWHERE
        else:
            changed = (matrix != self._matrix).any(axis=(1, 2))
            pairs = zip(shapes, self._shapes, strict=True)
            changed |= np.fromiter((a is not b for a, b in pairs), bool, len(shapes))
            self.lo = np.concatenate([bounds[0][changed], self._bounds[0][changed]])
            self.hi = np.concatenate([bounds[1][changed], self._bounds[1][changed]])
        self._listed, self._matrix, self._bounds, self._shapes = listed, matrix, bounds, shapes

    def near(self, lo: Array, hi: Array) -> NDArray[np.bool_]:
        """Which of the boxes `lo`, `hi` (n, 3) something moved in."""
        if self.everything:
            return np.ones(len(lo), bool)
        meets = (self.lo[:, None] <= hi) & (self.hi[:, None] >= lo)
        return np.asarray(meets.all(axis=2).any(axis=0), bool)
