# SPDX-License-Identifier: GPL-3.0-or-later
"""Report the progress of long work, and estimate the time left.

Long work is a generator, of the type `Work`. From time to time it yields a `Doing`, or None where
there is nothing new to say. It returns its result.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

T = TypeVar("T")

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
        The fraction of the work that is done, from 0 to 1.
    text
        A text that says what is being done now; empty if the caller knows.
    slow
        Whether the next step takes long. A window then shows this text before the step begins.
    found
        Whether there is a first result, which stays if the user presses Esc.
    """

    share: float
    text: str = ""
    slow: bool = False
    found: bool = False


class Working(NamedTuple):
    """The progress of the operator that works in the window.

    Attributes
    ----------
    operator
        The operator's `bl_idname`, such as "angen.simulate".
    share
        The fraction of the work that is done, from 0 to 1.
    far
        A text on this fraction and on the time left.
    doing
        A text that says what is being done now; empty if the user knows.
    """

    operator: str
    share: float
    far: str
    doing: str = ""


# None while no operator works in the window.
working: Working | None = None

Work = Generator[Doing | None, None, T]
# Work that yields only so that it can be ended between its steps.
Steps = Generator[None, None, T]


class Enough(Exception):
    """Exception that a caller throws into long work (a generator) to end it early.

    The work then returns its best result so far. If it has no result, it raises the exception
    again.
    """


def finished(work: Generator[Any, None, T]) -> T:
    """Run a generator to its end, and return its return value."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def saying(progress: Doing, work: Work[T]) -> Work[T]:
    """Run work; yield `progress` before each of its steps, and return its result."""
    while True:
        yield progress
        try:
            next(work)
        except StopIteration as end:
            result: T = end.value
            return result


def part_of(work: Work[T], low: float, high: float, text: str = "") -> Work[T]:
    """Run work that is a part of larger work, and return its result.

    Its shares from 0 to 1 become `low` to `high`. A `text` replaces its texts.
    """
    while True:
        try:
            now = next(work)
        except StopIteration as end:
            result: T = end.value
            return result
        if now is not None:
            share = low + (high - low) * now.share
            now = replace(now, share=share, text=text or now.text)
        yield now


class TimeLeft:
    """Estimates the seconds that the rest of the work takes.

    The estimate is the mean of two: one from all of the time so far, one from its latter half only.
    There is no estimate until the two agree, because a run can begin with a slow part.
    """

    def __init__(self) -> None:
        self._start = time.perf_counter()
        # (seconds since the start, share done) in the latter half of the time so far.
        self._noted: deque[tuple[float, float]] = deque()
        self._sure = False

    def note(self, share: float) -> None:
        """Note that a fraction `share` (0 to 1) of the work is done now."""
        elapsed = time.perf_counter() - self._start
        self._noted.append((elapsed, share))
        while self._noted[0][0] < elapsed / 2:
            self._noted.popleft()

    def seconds(self) -> float | None:
        """Return the estimate in seconds, or None until the two estimates have agreed once."""
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
