# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames and the clock of a day (10 frames a second, midnight at frame 1), and where to cut
it."""

from __future__ import annotations

import math
from datetime import date

from ..clock import Clock
from ..model import Array
from ..routine.draws import day_number
from .truth import DAY_S

FPS = 10
# s: so long before midnight a day's run begins, for detectors to have settled by then.
LEAD_S = 120.0
# Days: then noise begins again, as times in s that are too large lose digits.
CYCLE = 1 << 13
# s: a shorter rest is not cut in.
REST = 2.0


def frame_at(time: float) -> int:
    """The first whole frame at or after a time in s since midnight."""
    return 1 + math.ceil(time * FPS - 1e-6)


def time_at(frame: float) -> float:
    """s since midnight."""
    return (frame - 1) / FPS


def hours_minutes(time: float) -> str:
    """A time in s since midnight as text, such as 07:05."""
    return f"{int(time // 3600):02d}:{int(time // 60 % 60):02d}"


def calendar_number(first: date) -> int:
    """The number of a run's first day, from 0 to below `CYCLE`, by which its noise is drawn: by the
    date, not by the day that the run begins with."""
    return day_number(first) % CYCLE


def clock_of_day(number: int) -> Clock:
    """The clock of day `number`, in that day's frames: as in one long run that began `LEAD_S`
    before the midnight of day 0, each update has a number and a time of its own."""
    return Clock(frame_at(-LEAD_S) - round(number * DAY_S) * FPS, FPS)


def stretches(spans: Array, first: float, last: float, most: float) -> list[float]:
    """Times (s) at which to cut from `first` to `last`, so that there is movement for `most` s at
    most between two of them; if possible while nothing moves, in the middle of that. `spans`
    (k, 2): when anything moves."""
    cuts: list[float] = []
    moved = 0.0
    # The last rest, and how much movement came before it.
    rest: tuple[float, float] | None = None
    for number, (start, end) in enumerate(spans.tolist()):
        while moved + end - start > most:
            if rest is not None:
                cuts.append(rest[0])
                moved, rest = moved - rest[1], None
                continue
            # No rest in sight: amid the movement.
            start += most - moved
            cuts.append(start)
            moved = 0.0
        moved += end - start
        until = spans[number + 1, 0] if number + 1 < len(spans) else last
        if until - end > REST:
            rest = (end + until) / 2, moved
    return [cut for cut in cuts if first < cut < last]
