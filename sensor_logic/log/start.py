# SPDX-License-Identifier: GPL-3.0-or-later
"""The date and time that a log's t = 0 stands for."""

from __future__ import annotations

from datetime import datetime, timedelta

COLUMN = "time"


def parse_start(text: str) -> datetime | None:
    """What a user typed, in ISO 8601; None for nothing. Raises ValueError, whose text names it."""
    if not text.strip():
        return None
    try:
        start = datetime.fromisoformat(text.strip())
        # What is shown must be a date for a scene of any length.
        start + timedelta(days=40_000)
    except (ValueError, OverflowError):
        raise ValueError(
            f"'{text}' is no date and time in ISO 8601, such as 2026-03-01T08:00"
        ) from None
    return start


def moment(start: datetime, seconds: float) -> str:
    """`seconds` after the start, in ISO 8601 with milliseconds; in the start's own time zone, or
    without one."""
    return (start + timedelta(seconds=seconds)).isoformat(timespec="milliseconds")
