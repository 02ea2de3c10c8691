# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of sensors beside a log, for formats whose lines have only a name and a word."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from ..log.event_log import format_value, to_csv
from .log import Channel, Log, Value
from .read import DatedChange, ParsedLog, field_of

HEADER = ("id", "sensor", "field", "kind", "room", "unit", "initial")
WORDS = {"ON": "1", "OFF": "0", "OPEN": "1", "CLOSE": "0", "CLOSED": "0"}
# The quantity by the letters of a CASAS name; names of the release of 2025 are places instead.
NUMBERED = {"M": "motion", "MA": "motion", "D": "opening", "I": "occupancy", "L": "light"}


class KeyRow(NamedTuple):
    """A row of the table: the sensor and field of an identifier in the log."""

    sensor: str
    field: str
    kind: str
    room: str
    initial: str


def word(channel: Channel, value: Value) -> str:
    """A value in CASAS: ON, OFF, OPEN, CLOSE, or a number."""
    if channel.type is not bool:
        return format_value(value)
    words = ("CLOSE", "OPEN") if channel.quantity == "opening" else ("OFF", "ON")
    return words[bool(value)]


def to_text(log: Log, names: Mapping[Channel, str]) -> str:
    """The table for the fields that a log lists under these names."""
    initial = log.initial()
    rows = [
        (
            name,
            channel.sensor.name,
            channel.field,
            channel.sensor.kind,
            channel.sensor.room,
            channel.unit,
            word(channel, initial[channel].value),
        )
        for channel, name in sorted(names.items(), key=lambda item: item[1])
    ]
    return to_csv(HEADER, rows)


def read_rows(
    table: Path, rows: Iterable[tuple[datetime, str, str]], has_initial: bool = False
) -> ParsedLog:
    """The changes of rows (time, identifier, word). The table, if it exists, gives their sensors
    and fields; else they are guessed from their names. `has_initial`: the rows include the initial
    states."""
    known = _read_table(table)
    found = ParsedLog([], {entry.sensor: entry.room for entry in known.values()}, bool(known))
    for time, name, text in rows:
        if not found.changes and not has_initial:
            found.changes.extend(_change(time, entry, entry.initial) for entry in known.values())
        entry = known.get(name) or _guessed(name, text)
        if name in known or text.upper() in WORDS:
            found.changes.append(_change(time, entry, text))
    return found


def _change(time: datetime, entry: KeyRow, text: str) -> DatedChange:
    value = WORDS.get(text.upper(), text)
    return DatedChange(time, entry.sensor, entry.kind, entry.field, value)


def _read_table(table: Path) -> dict[str, KeyRow]:
    if not table.is_file():
        return {}
    with open(table, newline="", encoding="utf-8-sig") as file:
        return {
            row["id"]: KeyRow(*(row[name] for name in KeyRow._fields))
            for row in csv.DictReader(file)
        }


def _guessed(name: str, text: str) -> KeyRow:
    letters = re.fullmatch(r"([A-Z]+)\d+", name)
    is_door = text.upper() not in {"ON", "OFF"} or name.lower().endswith("door")
    quantity = "opening" if is_door else "motion"
    if letters and letters[1] in NUMBERED:
        quantity = NUMBERED[letters[1]]
    kind, field = field_of(quantity)
    return KeyRow(name, field, kind, "", "")
