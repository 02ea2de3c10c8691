# SPDX-License-Identifier: GPL-3.0-or-later
"""The date and time of a log's t = 0."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

COLUMN = "time"
# Dates must stay within the years 1 to 9999 in any time zone, and for a scene of any length.
EARLIEST, LATEST = datetime(1, 1, 3), datetime(9890, 1, 1)


def parse_start(text: str) -> datetime | None:
    """The date and time that a user typed in ISO 8601; None for an empty text. Raises ValueError,
    which quotes the text."""
    if not text.strip():
        return None
    try:
        start = datetime.fromisoformat(text.strip())
    except ValueError:
        raise ValueError(
            f"'{text}' is no date and time in ISO 8601, such as 2026-03-01T08:00"
        ) from None
    if not EARLIEST <= start.replace(tzinfo=None) <= LATEST:
        raise ValueError(f"'{text}': a start lies between {EARLIEST.date()} and {LATEST.date()}")
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
