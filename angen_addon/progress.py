# SPDX-License-Identifier: GPL-3.0-or-later
"""Report the progress of long work, and estimate the time left.

Long work is a generator. It yields a `Doing` from time to time, and its result as the last item or
as its return value.
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
# A generator that yields its share, how much of the work is done (0 to 1), and returns the result.
Shares = Generator[float, None, T]

# The estimate is given after this many seconds, and once this share of the work is done.
SURE_AFTER_S, SURE_AFTER = 3.0, 0.02
# Two estimates agree if neither is more than this many times the other.
AGREE = 1.5


@dataclass(frozen=True)
class Doing:
    """The progress of long work.

    Attributes
    ----------
    share
        How much of the work is done, from 0 to 1.
    text
        What is being done now.
    slow
        Whether the next step takes long. A window then shows this text before the step begins.
    found
        Whether there is a first result, which stays if the user presses Esc.
    """

    share: float
    text: str
    slow: bool = False
    found: bool = False


class Enough(Exception):
    """Exception that is thrown into long work to end it early.

    The work then gives its best result so far. If it has none, it raises the exception again.
    """


def finished(work: Generator[Any, None, T]) -> T:
    """Run the work to its end at once, and return what the generator returns."""
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
    """Run work that is a part of larger work, from the share `low` to the share `high` of that.

    Yield the share of the larger work that is done, and return the result of the part.
    """
    while True:
        try:
            share = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        yield low + (high - low) * share


def doing(text: str, work: Shares[T]) -> Generator[Doing, None, T]:
    """Run work that yields shares; yield each share as a `Doing` with this text instead."""
    while True:
        try:
            share = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        yield Doing(share, text)


class TimeLeft:
    """An estimate of the seconds that the rest of the work takes.

    It is the mean of two estimates: one from all of the time so far, one from its latter half only.
    It is given once they agree, because a run can begin with a slow part. An example is the first
    pictures of the light.
    """

    def __init__(self) -> None:
        self._start = time.perf_counter()
        # (seconds since the start, share done) in the latter half of the time so far.
        self._noted: deque[tuple[float, float]] = deque()
        self._sure = False

    def note(self, share: float) -> None:
        """Note how much of the work (0 to 1) is done now."""
        elapsed = time.perf_counter() - self._start
        self._noted.append((elapsed, share))
        while self._noted[0][0] < elapsed / 2:
            self._noted.popleft()

    def seconds(self) -> float | None:
        """Return the estimate in seconds; None until the two estimates have agreed once."""
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
        """Return the time left in round numbers; an empty text if there is no estimate."""
        seconds = self.seconds()
        if seconds is None:
            return ""
        if seconds < 60:
            return f"about {5 * math.ceil(seconds / 5)} s left"
        minutes = round(seconds / 60)
        if minutes < 60:
            return f"about {minutes} min left"
        return f"about {minutes // 60} h {minutes % 60} min left"
