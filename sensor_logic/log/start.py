# SPDX-License-Identifier: GPL-3.0-or-later
"""The date and time of a log's t = 0."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

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


def moment(start: datetime, elapsed: timedelta) -> datetime:
    """The time so long after the start, in the start's time zone if it has one."""
    if start.tzinfo is None:
        return start + elapsed
    # Added in UTC: daylight saving moves the clock, not the elapsed time.
    return (start.astimezone(UTC) + elapsed).astimezone(start.tzinfo)


def iso_time(start: datetime, seconds: float) -> str:
    """The time `seconds` after the start in ISO 8601 with milliseconds, in the start's time zone if
    it has one."""
    return moment(start, timedelta(seconds=seconds)).isoformat(timespec="milliseconds")
