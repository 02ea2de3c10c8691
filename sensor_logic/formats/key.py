# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of sensors beside a log, for formats whose lines have only a name and a word."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from ..kinds import KINDS
from ..log.event_log import Event, Value, format_value, to_csv
from .log import Channel, Log
from .read import ParsedLog, at_line, field_of

HEADER = ("id", "sensor", "field", "kind", "room", "unit", "initial")
# The words of CASAS, and those of pandas' booleans.
WORDS = {"ON": True, "OFF": False, "OPEN": True, "CLOSE": False, "CLOSED": False}
WORDS |= {"PRESENT": True, "ABSENT": False, "TRUE": True, "FALSE": False}
# The quantity by the letters of a CASAS name; names of the release of 2025 are places instead.
NUMBERED = {"M": "motion", "MA": "motion", "D": "opening", "I": "occupancy", "L": "light"}
# The quantity by the word, where the name does not tell.
OF_WORD = dict.fromkeys(("OPEN", "CLOSE", "CLOSED"), "opening")
OF_WORD |= dict.fromkeys(("PRESENT", "ABSENT"), "occupancy")
# A word into which the next sensor's name ran, as in ONM026.
GLUED = re.compile(rf"({'|'.join(sorted(WORDS, reverse=True))})[A-Z]{{1,2}}\d+")


class TextRow(NamedTuple):
    """A row of a log, as text; `line`: where the file has it."""

    line: int
    time: datetime
    name: str
    text: str


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
    """The table for the fields that a log lists under these names; without initial states where
    the log has none."""
    initial = log.initial()
    rows = [
        (
            name,
            channel.sensor.name,
            channel.field,
            channel.sensor.kind,
            channel.sensor.room,
            channel.unit,
            word(channel, initial[channel].value) if channel in initial else "",
        )
        for channel, name in sorted(names.items(), key=lambda item: item[1])
    ]
    return to_csv(HEADER, rows)


def read_rows(table: Path, rows: Iterable[TextRow], has_initial: bool = False) -> ParsedLog:
    """The changes in the rows. The table, if it exists, gives their sensors and fields; else they
    are guessed from their names. `has_initial`: the rows include the initial states."""
    entries = _read_table(table)
    states = [entry for entry in entries.values() if entry.initial]
    found = ParsedLog([], {entry.sensor: entry.room for entry in entries.values()}, bool(states))
    numbers = {name for name, entry in entries.items() if not _is_boolean(entry)}
    booleans = entries.keys() - numbers
    mended, left_out = Told("word", "mended"), Told("row", "left out")
    for row in rows:
        line, time, name, text = row
        is_plain = name in numbers or (name in booleans and text in {"0", "1"})
        word = text if is_plain else mended_word(text)
        # CASAS has single letters where a name was damaged.
        is_name = has_initial or not (len(name) == 1 and name.islower())
        if word is None or not is_name or (name in numbers and not is_number(text)):
            left_out.add(line, f"'{name} {text}'")
            continue
        if not is_plain and word != text.upper():
            mended.add(line, f"'{text}' is {word}")
        if name not in entries:
            entries[name] = _guessed(name, word)
        found.changes.append(_change(time, entries[name], word, line))
    if found.changes and not has_initial:
        begin = found.changes[0].time
        found.changes[:0] = [_change(begin, entry, entry.initial, 0) for entry in states]
        found.undated = len(states)
    texts = [told.text for told in (mended, left_out) if told.count]
    found.notes += ["; ".join(texts)] if texts else []
    return found


def _change(time: datetime, entry: KeyRow, word: str, line: int) -> Event[datetime]:
    value: Value = WORDS.get(word.upper(), word)
    return Event(time, entry.sensor, entry.field, 0.0, entry.kind, value, line)


def _is_boolean(entry: KeyRow) -> bool:
    fields = KINDS[entry.kind].events if entry.kind in KINDS else ()
    return any(field.name == entry.field and field.type is bool for field in fields)


def is_number(text: str) -> bool:
    """Whether a text is a finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def mended_word(text: str) -> str | None:
    """The word of `WORDS` that a text is, or was before it was damaged: OFFc, OFcF, OF, ONM026.
    None where it is not obvious."""
    upper = text.upper()
    if upper in WORDS:
        return upper
    capitals = re.sub(r"[^A-Z]", "", text)
    for word in (re.sub(r"[^A-Z]", "", upper), capitals):
        if word in WORDS:
            return word
    if glued := GLUED.fullmatch(text):
        return glued[1]
    cut = [word for word in WORDS if word.startswith(capitals)] if len(capitals) > 1 else []
    return cut[0] if len({WORDS[word] for word in cut}) == 1 else None


@dataclass
class Told:
    """Counts what was done to rows of a file, and keeps the first of them."""

    noun: str
    done: str
    count: int = 0
    first: str = ""

    def add(self, line: int, what: str) -> None:
        self.first = self.first or f"{at_line(line)}{what}"
        self.count += 1

    @property
    def text(self) -> str:
        noun = self.noun if self.count == 1 else f"{self.noun}s"
        return f"{self.count} {noun} {self.done}, first {self.first}"


def _read_table(table: Path) -> dict[str, KeyRow]:
    if not table.is_file():
        return {}
    with open(table, newline="", encoding="utf-8-sig") as file:
        return {
            row["id"]: KeyRow(*(row[name] for name in KeyRow._fields))
            for row in csv.DictReader(file)
        }


def _guessed(name: str, word: str) -> KeyRow:
    letters = re.fullmatch(r"([A-Z]+)\d+", name)
    quantity = OF_WORD.get(word, "opening" if name.lower().endswith("door") else "motion")
    if letters and letters[1] in NUMBERED:
        quantity = NUMBERED[letters[1]]
    kind, field = field_of(quantity)
    return KeyRow(name, field, kind, "", "")
