# SPDX-License-Identifier: GPL-3.0-or-later
"""How far long work is, and an estimate of the time left.

Long work is a generator: it yields a `Doing` from time to time, and last its result.
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
# Work that yields the share of it that is done, 0 to 1, and returns its result.
Shares = Generator[float, None, T]

# An estimate needs this many seconds of the work, and this share of it done.
SURE_AFTER_S, SURE_AFTER = 3.0, 0.02
# Two estimates agree if neither is more than this many times the other.
AGREE = 1.5


@dataclass(frozen=True)
class Doing:
    """The share of the work that is done, 0 to 1, and what is being done. `slow`: the next step
    takes long, so that a window shows this one before."""

    share: float
    text: str
    slow: bool = False


class Enough(Exception):
    """Thrown into long work to end it: it yields its best result so far, or raises this without
    one."""


def finished(work: Generator[Any, None, T]) -> T:
    """Does the work at once, and returns its result."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def saying(told: S, work: Generator[Any, None, T]) -> Generator[S, None, T]:
    """Tells the same before each step of the work, and hands on what it returns."""
    while True:
        yield told
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def scaled(work: Shares[T], low: float, high: float) -> Shares[T]:
    """The work as the part from `low` to `high` of a larger one."""
    while True:
        try:
            share = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        yield low + (high - low) * share


def doing(text: str, work: Shares[T]) -> Generator[Doing, None, T]:
    """The work, as a window tells it."""
    while True:
        try:
            share = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        yield Doing(share, text)


class TimeLeft:
    """Estimates how long the rest of the work will take, from all of it so far and from its latter
    half, and only once both agree: a run may begin with something slow, such as the first pictures
    of the light."""

    def __init__(self) -> None:
        self._start = time.perf_counter()
        # Seconds since then, and the share done; those of the latter half.
        self._noted: deque[tuple[float, float]] = deque()
        self._sure = False

    def note(self, share: float) -> None:
        elapsed = time.perf_counter() - self._start
        self._noted.append((elapsed, share))
        while self._noted[0][0] < elapsed / 2:
            self._noted.popleft()

    def seconds(self) -> float | None:
        """The estimate in seconds; None as long as the estimates disagree."""
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
