# SPDX-License-Identifier: GPL-3.0-or-later
"""Durations ("1 h 30 min") and times of day ("07:30") as people write them."""

from __future__ import annotations

import re

_UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_PART = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(s|min|h)\s*")


def seconds(text: object) -> float:
    """A duration in seconds. Raises ValueError, whose text says what would be one."""
    total, at, last = 0.0, 0, float("inf")
    shown = str(text)
    while isinstance(text, str) and at < len(text):
        part = _PART.match(text, at)
        if part is None or _UNITS[part.group(2)] >= last:
            break
        last = _UNITS[part.group(2)]
        total += float(part.group(1)) * last
        at = part.end()
    if not isinstance(text, str) or not text.strip() or at < len(text):
        raise ValueError(f'{shown!r} is no duration, such as "20 s", "25 min" or "1 h 30 min"')
    return total


def time_of_day(text: object) -> float:
    """Seconds since midnight; "24:00" is the end of the day. Raises ValueError."""
    found = re.fullmatch(r"(\d{1,2}):(\d{2})(?::(\d{2}))?", text) if isinstance(text, str) else None
    if found is not None:
        hours, minutes, rest = (int(part or 0) for part in found.groups())
        total = hours * 3600.0 + minutes * 60 + rest
        if minutes < 60 and rest < 60 and total <= 86_400:
            return total
    raise ValueError(f'{text!r} is no time of day, such as "07:30"')
