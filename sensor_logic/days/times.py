# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames and the clock of a day: 10 frames a second, midnight at frame 1."""

from __future__ import annotations

import math

from ..clock import Clock
from .truth import DAY_S

FPS = 10
# s: so long before midnight a day's run begins, for detectors to have settled by then.
LEAD_S = 120.0


def frame_at(time: float) -> int:
    """The first whole frame at or after a time in s since midnight."""
    return 1 + math.ceil(time * FPS - 1e-6)


def time_at(frame: float) -> float:
    """s since midnight."""
    return (frame - 1) / FPS


def hours_minutes(time: float) -> str:
    """A time in s since midnight as text, such as 07:05."""
    return f"{int(time // 3600):02d}:{int(time // 60 % 60):02d}"


def clock_of_day(number: int) -> Clock:
    """The clock of day `number` in a run of days, from `LEAD_S` before the first midnight on, in
    that day's frames: as in one long run, each update has a number and a time of its own."""
    return Clock(frame_at(-LEAD_S) - round(number * DAY_S) * FPS, FPS)
