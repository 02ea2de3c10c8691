# SPDX-License-Identifier: GPL-3.0-or-later
"""Which tilts a motion detector scans at a frame, and which of its rays saw movement: those of the
tilt that it scans, against its own scan of that tilt before, as the detector itself compares."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array

NO_TILTS = range(0)


class Sweep:
    """`tilts`: those scanned at the last update; `lit` (tilts, rays): where movement was seen then,
    None where nowhere, or nothing is known to compare with. Noise is left out: this is what moved.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Starts anew: nothing was seen yet."""
        self.tilts = NO_TILTS
        self.lit: NDArray[np.bool_] | None = None
        self._last: int | None = None
        self._before: dict[int, Array] = {}

    def due(self, schedule: Any, step: int, parameters: Any, count: int) -> tuple[range, bool]:
        """The tilts, of `count`, that are scanned at a frame; and whether the updates before were
        seen too. To be called at each frame in turn."""
        if step < 0:
            self.forget()
            return NO_TILTS, False
        number = schedule.last_update(step)
        if number == self._last:
            return NO_TILTS, True
        # As the live sensor does: after a jump there is nothing to compare with.
        follows = (
            self._last is not None and number == self._last + 1 and schedule.step(number) == step
        )
        self._last = number
        if not follows:
            self._before.clear()
        first = number % count
        whole = parameters.sweep == "ALL"
        self.tilts = range(count) if whole else range(first, first + 1)
        return self.tilts, follows

    def compare(self, ranges: Array, threshold: float) -> None:
        """Takes down the ranges (tilts, rays), m, of an update that is due."""
        lit = np.zeros(ranges.shape, bool)
        for tilt in self.tilts:
            before = self._before.get(tilt)
            if before is not None and before.shape == ranges[tilt].shape:
                lit[tilt] = np.abs(ranges[tilt] - before) > threshold
            self._before[tilt] = ranges[tilt].copy()
        self.lit = lit if lit.any() else None
