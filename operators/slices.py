# SPDX-License-Identifier: GPL-3.0-or-later
"""Divides the work of a modal operator into slices, between which Blender redraws."""

from __future__ import annotations

import time

# s: a slice is so long that Blender redraws a few times a second, and short enough for Esc.
LEAST, MOST = 0.25, 0.75
# A slice lasts this many times as long as Blender's last redraw, which so costs a tenth.
TIMES = 9.0


class Slices:
    """Chooses the length of slices by the time of Blender's redraws: each step of a run changes the
    scene, so that each redraw evaluates and draws everything."""

    def __init__(self) -> None:
        self._ended: float | None = None

    def begin(self) -> float:
        """Begins a slice; returns its end by `time.perf_counter`."""
        now = time.perf_counter()
        away = now - self._ended if self._ended is not None else 0.0
        return now + min(max(away * TIMES, LEAST), MOST)

    def end(self) -> None:
        """Ends a slice, once its work is done."""
        self._ended = time.perf_counter()
