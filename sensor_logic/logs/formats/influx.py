# SPDX-License-Identifier: GPL-3.0-or-later
"""InfluxDB's line protocol: a line for each sensor and time, in nanoseconds since 1970 in UTC.

https://docs.influxdata.com/influxdb/v2/reference/syntax/line-protocol/: the measurement is the
sensor's kind. The tags are the sensor's name and room. The fields are those that the sensor
publishes. InfluxDB keeps one value of a field at a time, so further changes at the same time follow
by a nanosecond each. An activity has the measurement `activity`, with a line at its begin and one
at its end.
"""

from __future__ import annotations

import re
from itertools import groupby

from ..log import format_value
from .log import Change, FormatFiles, Log

ACTIVITY = "activity"
# Times are signed 64-bit nanoseconds.
SECONDS = -(2**63) // 10**9 + 1, 2**63 // 10**9 - 1


def write(log: Log) -> FormatFiles:
    """Return the log as lines: all changes, including initial states, then all activities."""
    times, lines = _FreeTimes(log), []
    numbered = ((times.next(change.time, change.channel), change) for change in log.changes)
    for (time, sensor), found in groupby(numbered, lambda pair: (pair[0], pair[1].channel.sensor)):
        fields = ",".join(f"{_key(c.channel.field)}={_field(c)}" for _, c in found)
        tags = _tags(sensor=sensor.name, room=sensor.room)
        lines.append(f"{_key(sensor.kind.lower())}{tags} {fields} {time}\n")
    for activity in log.activities:
        tags = _tags(person=activity.person, room=activity.room)
        for moment, going_on in ((activity.start, "true"), (activity.end, "false")):
            fields = f"name={_quoted(activity.activity)},going_on={going_on}"
            lines.append(f"{ACTIVITY}{tags} {fields} {times.next(moment, tags)}\n")
    return FormatFiles({"": "".join(lines)}, _notes(log))


class _FreeTimes:
    """Times in nanoseconds since 1970, each given once for a key such as a channel."""

    def __init__(self, log: Log) -> None:
        self._log = log
        self._free: dict[tuple[object, int], int] = {}

    def next(self, time: int, key: object) -> int:
        """Return the first free time for the key from `time` on, in microseconds of the log."""
        first = self._log.epoch_us(time) * 1000
        found = first
        while (free := self._free.get((key, found))) is not None:
            found = free
        self._free[key, first] = self._free[key, found] = found + 1
        return found


def _tags(**tags: str) -> str:
    return "".join(f",{key}={_key(value)}" for key, value in tags.items() if _key(value))


def _key(text: str) -> str:
    """Return the name of a measurement, tag or field, escaped.

    Line breaks become spaces, and backslashes at the end are removed: the format cannot hold them.
    """
    possible = re.sub(r"\s", " ", text).rstrip("\\")
    return re.sub(r"([,= ])", r"\\\1", possible)


def _field(change: Change) -> str:
    if isinstance(change.value, bool):
        return "true" if change.value else "false"
    if isinstance(change.value, str):
        return _quoted(change.value)
    return format_value(change.value)


def _quoted(text: str) -> str:
    escaped = re.sub(r"\s", " ", text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _notes(log: Log) -> tuple[str, ...]:
    changed = [s.name for s in log.sensors if re.sub(r"\s", " ", s.name).rstrip("\\") != s.name]
    names = ", ".join(map(repr, changed))
    if not names:
        return ()
    return (
        "InfluxDB allows no line breaks and no backslash at the end of names, so these names "
        f"were changed: {names}",
    )
