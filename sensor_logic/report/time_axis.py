# SPDX-License-Identifier: GPL-3.0-or-later
"""Round times on a time axis, from fractions of a second to days."""

from __future__ import annotations

import math

from .svg import shown_number, ticks

MINUTE, HOUR, DAY = 60.0, 3600.0, 86400.0
STEPS = (
    *(MINUTE * m for m in (1 / 6, 1 / 4, 1 / 2, 1, 2, 5, 10, 15, 30)),
    *(HOUR * h for h in (1, 2, 3, 6, 12)),
    *(DAY * d for d in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)),
)
# Up to this span labels are seconds, beyond it clock times.
SECONDS_UP_TO = 300.0


def moments(first: float, last: float, count: int) -> list[float]:
    """About `count` round times (s) from `first` to `last`."""
    span = last - first
    if span <= SECONDS_UP_TO:
        found = ticks(first, last, count)
    else:
        step = next((s for s in STEPS if s * count >= span), STEPS[-1])
        found = [step * i for i in range(math.floor(first / step), math.ceil(last / step) + 1)]
    slack = span * 1e-9
    return [t for t in found if first - slack <= t <= last + slack]


def label(time: float, span: float) -> str:
    """The label of a time (s) on an axis over `span` seconds: 90, 1:30 or 2:15."""
    if span <= SECONDS_UP_TO:
        return shown_number(time)
    sign, seconds = ("−" if time < 0 else ""), round(abs(time))
    minutes, seconds = divmod(seconds, 60)
    if span < HOUR:
        return f"{sign}{minutes}:{seconds:02}"
    hours, minutes = divmod(minutes, 60)
    if span >= 5 * DAY:
        return f"{sign}{hours / 24:g}"
    return f"{sign}{hours}:{minutes:02}"


def unit(span: float) -> str:
    """The title with the unit of an axis over `span` seconds."""
    if span <= SECONDS_UP_TO:
        return "time in s"
    if span < HOUR:
        return "time in min:s"
    return "time in h:min" if span < 5 * DAY else "time in days"
