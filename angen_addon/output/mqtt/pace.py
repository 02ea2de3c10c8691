# SPDX-License-Identifier: GPL-3.0-or-later
"""Waits until the events of a log are due, at any speed."""

from __future__ import annotations

import time
from collections.abc import Callable

# s: `idle` is called this often while waiting.
SLICE_S = 0.2


class Pace:
    """Plays a log at `speed` times real time (0: without waiting).

    Each time is measured from the start, on a clock that never jumps, so that one late event does
    not delay those after it.
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
        """Starts the clock: `at` (microseconds of the log) is now."""
        self._begin, self._at = self._clock(), at

    def wait(self, until: int) -> float:
        """Waits until a time of the log (microseconds) is due; returns by how many seconds it is
        late. Calls `idle` at least once, which may raise."""
        self._idle()
        if self.is_at_once:
            return 0.0
        due = self._begin + (until - self._at) / 1e6 / self._speed
        while (left := due - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()
        return self._clock() - due

    def rest(self, seconds: float) -> None:
        """Waits for this many real seconds, whatever the speed."""
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()
