# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints progress on standard error: on a terminal one line that changes, else a line every 10
s."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import TextIO

from ..runtime.simulation import Progress
from .console import tell

TERMINAL_INTERVAL_S = 0.2
LOG_INTERVAL_S = 10.0


# An estimate needs this many seconds of the run, and this share of it done.
SURE_AFTER_S, SURE_AFTER = 3.0, 0.02
# Two estimates agree if neither is more than this many times the other.
AGREE = 1.5


class TimeLeft:
    """Estimates how long the rest of a run will take, from the whole run so far and from its latter
    half, and only once both agree: a run may begin with something slow, such as the first pictures
    of the light."""

    def __init__(self) -> None:
        self._start = time.perf_counter()
        # Seconds since then, and seconds of the scene done; those of the latter half.
        self._noted: deque[tuple[float, float]] = deque()
        self._last: Progress | None = None
        self._sure = False

    def note(self, progress: Progress) -> None:
        elapsed = time.perf_counter() - self._start
        self._noted.append((elapsed, progress.seconds_done))
        self._last = progress
        while self._noted[0][0] < elapsed / 2:
            self._noted.popleft()

    def seconds(self) -> float | None:
        """The estimate in seconds; None as long as the estimates disagree."""
        if self._last is None or not self._last.seconds_done:
            return None
        (since, before), (elapsed, done) = self._noted[0], self._noted[-1]
        if done <= before:
            return None
        rest = self._last.seconds_total - done
        whole, latter = rest * elapsed / done, rest * (elapsed - since) / (done - before)
        enough = elapsed >= SURE_AFTER_S and done >= SURE_AFTER * self._last.seconds_total
        self._sure |= enough and max(whole, latter) <= AGREE * min(whole, latter)
        return (whole + latter) / 2 if self._sure else None

    def text(self) -> str:
        """The time left in round numbers, or empty."""
        seconds = self.seconds()
        if seconds is None:
            return ""
        if seconds < 60:
            return f"about {5 * math.ceil(seconds / 5)} s left"
        minutes = round(seconds / 60)
        if minutes < 60:
            return f"about {minutes} min left"
        return f"about {minutes // 60} h {minutes % 60} min left"


class ProgressLine:
    """Prints the progress, speed and time left of a run."""

    def __init__(self, stream: TextIO, quiet: bool) -> None:
        self._stream = stream
        self._quiet = quiet
        self._terminal = stream.isatty()
        self._start = self._shown = time.perf_counter()
        self._drawn = False
        self._left = TimeLeft()
        self._announced = {""}
        self._last: Progress | None = None

    def show(self, progress: Progress) -> None:
        self._left.note(progress)
        self._last = progress
        now = time.perf_counter()
        interval = TERMINAL_INTERVAL_S if self._terminal else LOG_INTERVAL_S
        # A slow step is announced when it begins; off a terminal, only the first time.
        news = bool(progress.doing) if self._terminal else progress.doing not in self._announced
        if self._quiet or (now - self._shown < interval and not news):
            return
        self._announced.add(progress.doing)
        self._shown = now
        elapsed = now - self._start
        rate = progress.seconds_done / elapsed
        left = self._left.text()
        share = 100 * progress.seconds_done / max(progress.seconds_total, 1e-9)
        parts = [f"frame {progress.frame:g}", f"{share:.0f} %"]
        if progress.seconds_done:
            parts.append(f"{rate:.0f} times real time")
        text = ", ".join(filter(None, [*parts, left, progress.doing]))
        self._drawn = self._terminal
        tell(f"\r{text:<70}" if self._terminal else f"{text}\n", self._stream)

    def finish(self, seconds: float, updates: int) -> None:
        """The closing line: what was simulated and how fast."""
        if self._drawn:
            tell("\r" + " " * 70 + "\r", self._stream)
        if self._quiet:
            return
        elapsed = max(time.perf_counter() - self._start, 1e-9)
        last, still = self._last, ""
        share = round(100 * (1 - last.evaluated / last.steps)) if last and last.steps else 0
        if share:
            still = f"; nothing moved at {share} % of the steps"
        elif last is not None and last.moving:
            still = f"; every step was evaluated: {last.moving}"
        tell(
            f"simulated {seconds:.1f} s in {elapsed:.1f} s "
            f"({seconds / elapsed:.0f} times real time), {updates} updates{still}\n",
            self._stream,
        )
