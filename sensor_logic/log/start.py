# SPDX-License-Identifier: GPL-3.0-or-later
"""The date and time of a log's t = 0."""

from __future__ import annotations

from datetime import datetime, timedelta

COLUMN = "time"


def parse_start(text: str) -> datetime | None:
    """The date and time that a user typed in ISO 8601; None for an empty text. Raises ValueError,
    which quotes the text."""
    if not text.strip():
        return None
    try:
        start = datetime.fromisoformat(text.strip())
        # Dates must stay valid for a scene of any length.
        start + timedelta(days=40_000)
    except (ValueError, OverflowError):
        raise ValueError(
            f"'{text}' is no date and time in ISO 8601, such as 2026-03-01T08:00"
        ) from None
    return start


def iso_time(start: datetime, seconds: float) -> str:
    """The time `seconds` after the start in ISO 8601 with milliseconds, in the start's time zone if
    it has one."""
    return (start + timedelta(seconds=seconds)).isoformat(timespec="milliseconds")
