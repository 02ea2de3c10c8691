# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log as `angen simulate` writes it."""

from __future__ import annotations

from ..log import rows_csv
from .log import DEFAULT_START, FormatFiles, Log

# The first names in the header of a log, and of a day's.
BEGINS = rb"\"?(time_s\"?,\"?frame|time\"?,\"?sensor)\b"


def write(log: Log) -> FormatFiles:
    """A row for each change, initial states included; with dates, unless the log has none."""
    # Not `==`: a log may also begin in 1970.
    start = None if log.start is DEFAULT_START else log.start
    return FormatFiles({"": rows_csv((change.event for change in log.changes), start)})
