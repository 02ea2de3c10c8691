# SPDX-License-Identifier: GPL-3.0-or-later
"""A log as columns: {name: (type, values)}."""

from __future__ import annotations

import math
from typing import Any

from ..kinds import KINDS
from ..log.event_log import format_value
from .log import Log

Columns = dict[str, tuple[type, list[Any]]]


def event_columns(log: Log) -> Columns:
    """The columns of the event log, with the value as text and as a number."""
    changes = log.changes
    numbers = [None if isinstance(c.value, str) else float(c.value) for c in changes]
    return {
        "time_s": (float, [c.time / 1e6 for c in changes]),
        "sensor": (str, [c.channel.sensor.name for c in changes]),
        "kind": (str, [c.channel.sensor.kind for c in changes]),
        "room": (str, [c.channel.sensor.room for c in changes]),
        "field": (str, [c.channel.field for c in changes]),
        "value": (str, [format_value(c.value) for c in changes]),
        "number": (float, numbers),
    }


def sample_columns(log: Log) -> Columns:
    """The columns of all updates, ordered by sensor name and time."""
    assert log.samples is not None
    tracks = [log.samples.tracks[name] for name in sorted(log.samples.tracks)]
    types = {
        f.name: f.type for kind in KINDS.values() for f in kind.samples if _is_used(f.name, tracks)
    }
    columns: Columns = {
        "time_s": (float, []),
        "frame": (float, []),
        "sensor": (str, []),
        "kind": (str, []),
        "room": (str, []),
        **{name: (of, []) for name, of in types.items()},
    }
    rooms = {sensor.name: sensor.room for sensor in log.sensors}
    for track in tracks:
        count = len(track)
        columns["time_s"][1].extend(track.times)
        columns["frame"][1].extend(track.frames)
        columns["sensor"][1].extend([track.sensor] * count)
        columns["kind"][1].extend([track.kind_name] * count)
        columns["room"][1].extend([rooms.get(track.sensor, "")] * count)
        for name, of in types.items():
            columns[name][1].extend(_plain(of, track.columns.get(name), count))
    return columns


def _is_used(name: str, tracks: list[Any]) -> bool:
    return any(name in track.columns for track in tracks)


def _plain(of: type, column: Any, count: int) -> list[Any]:
    """A column's values as Python objects; None where nothing was measured."""
    if column is None:
        return [None] * count
    if of is float:
        return [None if math.isnan(value) else value for value in column]
    return [of(value) for value in column]
