# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log as `angen simulate` writes it."""

from __future__ import annotations

from ..log.event_log import rows_csv
from .log import Log
from .written import Written


def write(log: Log) -> Written:
    """A row for each change, those at the start among them."""
    return Written({"": rows_csv(change.event for change in log.changes)})
