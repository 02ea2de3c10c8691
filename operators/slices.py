# SPDX-License-Identifier: GPL-3.0-or-later
"""How long a modal operator works before Blender has its turn."""

from __future__ import annotations

import time

# s: long enough for a few redraws a second at most, and short enough for Esc.
LEAST, MOST = 0.25, 0.75
# A slice lasts this many times as long as Blender's last turn, so that drawing costs a tenth.
TIMES = 9.0


class Slices:
    """Slices of work, each long against what Blender's turn before it took: each step of a run
    changes the scene, so that Blender draws everything anew whenever it has its turn."""

    def __init__(self) -> None:
        self._ended: float | None = None

    def begin(self) -> float:
        """Until when to work now, by the clock of `time.perf_counter`."""
        now = time.perf_counter()
        away = now - self._ended if self._ended is not None else 0.0
        return now + min(max(away * TIMES, LEAST), MOST)

    def end(self) -> None:
        """To be called when the work of a slice is done."""
        self._ended = time.perf_counter()
