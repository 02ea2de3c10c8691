# SPDX-License-Identifier: GPL-3.0-or-later
"""When the moments of a story are due."""

from __future__ import annotations

import time
from collections.abc import Callable

# s: so often something else may be done while waiting.
SLICE_S = 0.2


class Pace:
    """Goes through a story at `speed` times real time (0: without waiting).

    Each moment is due by the time since the start, on a clock that never jumps: what one wait takes
    too long does not move the moments after it.
    """

    def __init__(
        self,
        speed: float,
        idle: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.is_at_once = speed == 0.0
        self._speed, self._idle = speed, idle
        self._clock, self._sleep = clock, sleep
        self._begin = 0.0
        self._at = 0

    def start(self, at: int) -> None:
        """From now on, `at` (microseconds of the story) being now."""
        self._begin, self._at = self._clock(), at

    def wait(self, until: int) -> float:
        """Waits until a moment (microseconds of the story) is due; returns how many seconds it
        is late. `idle` is called once at least, and may raise."""
        self._idle()
        if self.is_at_once:
            return 0.0
        due = self._begin + (until - self._at) / 1e6 / self._speed
        while (left := due - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()
        return self._clock() - due

    def rest(self, seconds: float) -> None:
        """Waits for so long on the clock, whatever the speed."""
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()
