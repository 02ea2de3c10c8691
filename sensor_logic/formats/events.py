# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log as `angen simulate` writes it."""

from __future__ import annotations

from ..event_log import HEADER, format_frame, format_time, format_value, to_csv
from .log import Log
from .written import Written


def write(log: Log) -> Written:
    """A row for each change, those at the start among them."""
    rows = (
        (
            format_time(change.time / 1e6),
            format_frame(change.frame),
            change.channel.sensor.name,
            change.channel.sensor.kind,
            change.channel.field,
            format_value(change.value),
        )
        for change in log.changes
    )
    return Written({"": to_csv(HEADER, rows)})
