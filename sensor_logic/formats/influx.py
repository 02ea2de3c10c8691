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
from pathlib import Path

from ..log import Event, Value, as_logged, format_value
from .log import Change, FormatFiles, Log
from .source import ParsedLog, since_epoch

# Comments, then a line that ends with a time.
BEGINS = rb"((#[^\n]*)?\r?\n)*[^\s,={#]+(,(\\.|[^\\\s])+)? [^\s=]+=[^\n]* -?\d+\s*(\n|\Z)"
ACTIVITY = "activity"
# Times are signed 64-bit nanoseconds.
SECONDS = -(2**63) // 10**9 + 1, 2**63 // 10**9 - 1
# Seconds since 1970 from 2001 to 2096.
CENTURY = 10**9, 4 * 10**9


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


def read(path: Path) -> ParsedLog:
    """Read the changes of sensors' fields from lines of the protocol, without the activities."""
    found = ParsedLog([], in_utc=True)
    first = None
    # Not `splitlines`: names can contain U+2028.
    for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), start=1):
        parts = re.fullmatch(r"((?:\\.|[^\\ ])+) (.+) (-?\d+)", line)
        if parts is None:
            if line.strip() and not line.startswith("#"):
                raise ValueError(
                    f"line {number}: '{line[:60]}' is not in the line protocol of InfluxDB"
                )
            continue
        measurement, *tags = re.split(r"(?<!\\),", parts[1])
        if measurement == ACTIVITY:
            found.has_activities = True
            continue
        values = dict(re.split(r"(?<!\\)=", tag, maxsplit=1) for tag in tags)
        name, room = (_plain(values.get(key, "")) for key in ("sensor", "room"))
        found.rooms[name] = room
        first = int(parts[3]) if first is None else first
        time = since_epoch(int(parts[3]) // 1000)
        for field, value in re.findall(r'((?:\\.|[^=\\])+)=("(?:\\.|[^"\\])*"|[^,]*),?', parts[2]):
            kind = _plain(measurement).upper()
            try:
                read = _value(value)
            except ValueError:
                what = "it must be a number, true, false or a text in quotes"
                raise ValueError(f"line {number}: {field} is '{value}': {what}") from None
            found.changes.append(Event(time, name, _plain(field), 0.0, kind, read, number))
    if first is not None:
        _note_precision(found, first)
    return found


def _note_precision(found: ParsedLog, first: int) -> None:
    """Add a note if the time of the first line is one of this century in s, ms or µs."""
    for unit, factor in (("s", 1), ("ms", 10**3), ("µs", 10**6)):
        if CENTURY[0] * factor <= first < CENTURY[1] * factor:
            found.notes.append(
                f"times were read as nanoseconds, and are of 1970: if {first} is in {unit}, give "
                f"them {9 - len(str(factor)) + 1} more zeros"
            )


def _plain(key: str) -> str:
    return re.sub(r"\\([,= ])", r"\1", key)


def _value(text: str) -> Value:
    if text.startswith('"'):
        return re.sub(r"\\(.)", r"\1", text[1:-1])
    if text.lower() in {"t", "true", "f", "false"}:
        return text[0] in "tT"
    number: float = as_logged(float(text.rstrip("iu")))
    return number
