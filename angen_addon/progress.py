# SPDX-License-Identifier: GPL-3.0-or-later
"""Report the progress of long work, and estimate the time left.

Long work is a generator: it yields a `Doing` from time to time, and returns or last yields its
result.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, TypeVar

S = TypeVar("S")
T = TypeVar("T")
# A generator that yields the share of the work that is done, 0 to 1, and returns its result.
Shares = Generator[float, None, T]

# An estimate is given after this many seconds and this share of the work.
SURE_AFTER_S, SURE_AFTER = 3.0, 0.02
# Two estimates agree if neither is more than this many times the other.
AGREE = 1.5


@dataclass(frozen=True)
class Doing:
    """The progress of long work: the share that is done, 0 to 1, and the present activity.

    `slow` marks a next step that takes long, so that a window shows this text before it starts.
    `found` says that there is a first result, which Esc keeps.
    """

    share: float
    text: str
    slow: bool = False
    found: bool = False


class Enough(Exception):
    """Thrown into long work to end it early.

    The work then returns its best result so far, or raises this again if it has none.
    """


def finished(work: Generator[Any, None, T]) -> T:
    """Run the work to its end at once, and return its result."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def saying(progress: S, work: Generator[Any, None, T]) -> Generator[S, None, T]:
    """Yield `progress` before each step of the work, and return the result of the work."""
    while True:
        yield progress
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def scaled(work: Shares[T], low: float, high: float) -> Shares[T]:
    """Run the work as the part from `low` to `high` of a larger work."""
    while True:
        try:
            share = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        yield low + (high - low) * share


def doing(text: str, work: Shares[T]) -> Generator[Doing, None, T]:
    """Yield each share of the work as a `Doing` with this text."""
    while True:
        try:
            share = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        yield Doing(share, text)


class TimeLeft:
    """An estimate of the seconds that the rest of the work takes.

    One estimate uses all of the work so far, another only its latter half. Their mean is given once
    both agree, since a run may begin with a slow part, such as the first pictures of the light.
    """

    def __init__(self) -> None:
        self._start = time.perf_counter()
        # (seconds since the start, share done) in the latter half of the time so far.
        self._noted: deque[tuple[float, float]] = deque()
        self._sure = False

    def note(self, share: float) -> None:
        """Note the share of the work that is done now."""
        elapsed = time.perf_counter() - self._start
        self._noted.append((elapsed, share))
        while self._noted[0][0] < elapsed / 2:
            self._noted.popleft()

    def seconds(self) -> float | None:
        """Return the estimate in seconds; None while the two estimates disagree."""
        if not self._noted or not self._noted[-1][1]:
            return None
        (since, before), (elapsed, done) = self._noted[0], self._noted[-1]
        if done <= before:
            return None
        rest = 1.0 - done
        whole, latter = rest * elapsed / done, rest * (elapsed - since) / (done - before)
        enough = elapsed >= SURE_AFTER_S and done >= SURE_AFTER
        self._sure |= enough and max(whole, latter) <= AGREE * min(whole, latter)
        return (whole + latter) / 2 if self._sure else None

    def text(self) -> str:
        """Return the time left in round numbers; empty while there is no estimate."""
        seconds = self.seconds()
        if seconds is None:
            return ""
        if seconds < 60:
            return f"about {5 * math.ceil(seconds / 5)} s left"
        minutes = round(seconds / 60)
        if minutes < 60:
            return f"about {minutes} min left"
        return f"about {minutes // 60} h {minutes % 60} min left"
