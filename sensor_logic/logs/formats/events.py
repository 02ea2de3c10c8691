# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log as `angen simulate` writes it."""

from __future__ import annotations

from ..log import rows_csv
from .log import DEFAULT_START, FormatFiles, Log

# The first names in the header of an event log, and of the events of simulated days.
BEGINS = rb"\"?(time_s\"?,\"?frame|time\"?,\"?sensor)\b"


def write(log: Log) -> FormatFiles:
    """Return the event log: a row for each change, including initial states.

    The rows have dates if the log has any.
    """
    # `is`, because a log with dates can also begin in 1970.
    start = None if log.start is DEFAULT_START else log.start
    return FormatFiles({"": rows_csv((change.event for change in log.changes), start)})
