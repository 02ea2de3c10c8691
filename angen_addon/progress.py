# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress on standard error: one line that renews itself on a terminal, else one now and then."""

from __future__ import annotations

import sys
import time
from typing import TextIO

from .simulation import Progress

TERMINAL_INTERVAL_S = 0.2
LOG_INTERVAL_S = 10.0


class ProgressLine:
    """Prints how far a run is, how fast, and how long it will take."""

    def __init__(self, stream: TextIO, quiet: bool) -> None:
        self._stream = stream
        self._quiet = quiet
        self._terminal = stream.isatty()
        self._start = self._shown = time.perf_counter()
        self._drawn = False

    def show(self, progress: Progress) -> None:
        now = time.perf_counter()
        interval = TERMINAL_INTERVAL_S if self._terminal else LOG_INTERVAL_S
        if self._quiet or now - self._shown < interval:
            return
        self._shown = now
        elapsed = now - self._start
        rate = progress.seconds_done / elapsed
        left = (progress.seconds_total - progress.seconds_done) / rate if rate > 0 else 0.0
        share = 100 * progress.seconds_done / max(progress.seconds_total, 1e-9)
        text = (
            f"frame {progress.frame:g}, {share:.0f} %, "
            f"{rate:.0f} times real time, {left:.0f} s left"
        )
        self._drawn = self._terminal
        print(
            f"\r{text:<70}" if self._terminal else text,
            end="" if self._terminal else "\n",
            file=self._stream,
            flush=True,
        )

    def finish(self, seconds: float, updates: int) -> None:
        """The closing line: what was simulated and how fast."""
        if self._drawn:
            print("\r" + " " * 70 + "\r", end="", file=self._stream)
        if self._quiet:
            return
        elapsed = max(time.perf_counter() - self._start, 1e-9)
        print(
            f"simulated {seconds:.1f} s in {elapsed:.1f} s "
            f"({seconds / elapsed:.0f} times real time), {updates} updates",
            file=self._stream,
            flush=True,
        )


def note(text: str) -> None:
    """A line for the user, out of the way of the events on standard output."""
    print(f"angen: {' '.join(text.split())}", file=sys.stderr, flush=True)
