# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log as `angen simulate` writes it."""

from __future__ import annotations

from ..log.event_log import rows_csv
from .log import Log
from .written import FormatFiles


def write(log: Log) -> FormatFiles:
    """A row for each change, initial states included."""
    return FormatFiles({"": rows_csv(change.event for change in log.changes)})
