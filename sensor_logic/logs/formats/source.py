# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a `Log` from events, or from what a format's reader returned.

Data about the home and its sensors come from one of three files: `home.toml`, the list of sensors
as JSON, or a table of sensors beside the log. Activities come from `activities.csv`.
"""

from __future__ import annotations

import csv
import json
import math
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta, tzinfo
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from ..error import InputError, decoded, explained, replaced
from ..fields import LOGGED_KINDS, Field
from ..files import read_text
from ..log import (
    COLUMN,
    HEADER,
    Event,
    Time,
    Value,
    format_value,
    parse_start,
    read_events,
    to_csv,
)
from .log import (
    DEFAULT_START,
    Change,
    Channel,
    Log,
    LoggedActivity,
    LoggedSamples,
    SensorFacts,
    in_zone,
    since,
)
from .units import UnitOf

# The result of a reader: changes with dates.

EPOCH = datetime(1970, 1, 1)


@dataclass
class ParsedLog:
    """The changes in a file, in time order, as the reader of a format returns them.

    Attributes
    ----------
    rooms
        The room of each sensor, by the sensor's name.
    has_states
        Whether the first change of each field is its initial state.
    has_activities
        Whether the file also has activities; readers ignore them.
    in_utc
        Whether times without a zone are in UTC. If not, they are in the home's time zone.
    undated
        The number of initial states at the begin of `changes`. The file does not date them, so they
        have the time of the first row.
    notes
        A sentence for each repair or omission.
    end
        The local time until which the sensors were observed; None if unknown.
    units
        The name and unit in the file of each field whose numbers are not in its own unit, or may
        not be, by sensor and field.
    """

    changes: list[Event[datetime]]
    rooms: dict[str, str] = field(default_factory=dict)
    has_states: bool = True
    has_activities: bool = False
    in_utc: bool = False
    undated: int = 0
    notes: list[str] = field(default_factory=list)
    end: datetime | None = None
    units: dict[tuple[str, str], UnitOf] = field(default_factory=dict)

    def sort(self) -> None:
        """Sort the changes as `sort_rows` does; undated initial states stay first."""
        states, changes = self.changes[: self.undated], self.changes[self.undated :]
        changes, note = sort_rows(changes)
        self.changes = [state.at(changes[0].time) for state in states] + changes
        self.notes.append(note)


def field_of(quantity: str) -> tuple[str, str]:
    """Return the first kind that has a boolean field of a quantity, and the field's name.

    Raise ValueError if there is none.
    """
    for kind in LOGGED_KINDS.values():
        for published in kind.events:
            if published.type is bool and published.quantity == quantity:
                return kind.identifier, published.name
    raise ValueError(f"no kind of sensor publishes {quantity}")


def events_of(
    read: ParsedLog, start: datetime | None, zone: tzinfo | None = None
) -> tuple[list[Event[float]], datetime | None]:
    """Return the events of a parsed log, in seconds since its start, and the start.

    Parameters
    ----------
    read
        The parsed log.
    start
        The date and time of t = 0; None means the time of the first change.
    zone
        The time zone of the home, if known.

    Raises
    ------
    ValueError
        If a time is earlier than the previous one.
    """
    times = [change.time for change in read.changes]
    if not any(time.utcoffset() for time in times):
        # Writers store a start without a time zone as UTC.
        times = [time.replace(tzinfo=None) for time in times]
    if zone is not None:
        times = in_zone(times, zone, read.in_utc)
    start = start or (times[0] if times else None)
    found: list[Event[float]] = []
    last: datetime | None = None
    for time, change in zip(times, read.changes, strict=True):
        assert start is not None
        # A start without a time zone is in local time of the home.
        clock = time.replace(tzinfo=None) if start.tzinfo is None else time
        seconds = since(start, clock) / 1e6
        if found and seconds < found[-1].time:
            raise ValueError(
                f"{at_line(change.line)}out of order: {change.time} comes after {last}; sort the "
                "log with `convert --sort`, or give --timezone if clocks were put back"
            )
        found.append(change.at(seconds))
        last = change.time
    return found, start


def at_line(number: int) -> str:
    """Return the beginning of a message about a line; empty if `number` is 0."""
    return f"line {number}: " if number else ""


def sort_rows(rows: Iterable[Event[Time]]) -> tuple[list[Event[Time]], str]:
    """Return the rows sorted by time and without repeated rows, and a note about what was changed.

    Rows of the same time keep their order. Raise TypeError if only some times have a zone.
    """
    given = list(rows)
    late = sum(after.time < before.time for before, after in pairwise(given))
    kept = list(dict.fromkeys(sorted(given, key=lambda row: row.time)))
    repeated = len(given) - len(kept)
    note = f"sorted by time; rows out of order: {late}; repeated rows, left out: {repeated}"
    return kept, note


DAY_HEADER = ("time", "sensor", "kind", "field", "value", "person", "because")
# The quantity, by type, of a field that declares none.
ANY_QUANTITY = {bool: "state", str: "text", float: "number", int: "number"}
ACTIVITY_HEADER = ("start", "end", "person", "activity", "room")


def make_log(
    events: Iterable[Event[float]],
    sensors: Mapping[str, SensorFacts] | None = None,
    start: datetime = DEFAULT_START,
    activities: Iterable[LoggedActivity] = (),
    about: Mapping[str, str] | None = None,
    samples: tuple[LoggedSamples, ...] | None = None,
    has_states: bool = True,
) -> Log:
    """Return a `Log` of events, after a check of their kinds, fields, values and times.

    Parameters
    ----------
    sensors
        The sensors by name. A sensor that is not among them has no room.
    start
        Date and time of t = 0.
    about
        Texts about the home, by name.
    samples
        All updates of each sensor, if they are known.
    has_states
        Whether the first event of each field is its initial state.

    Raises
    ------
    InputError
        For an unknown kind or field, an invalid value, or decreasing times.
    """
    channels: dict[tuple[str, str], Channel] = {}
    facts = dict(sensors or {})
    changes = []
    last = float("-inf")
    for number, event in enumerate(events, start=1):
        where = f"line {event.line}" if event.line else f"event {number}"
        if event.time < last:
            raise InputError(
                f"{where}: {event.time:.6f} s comes after {last:.6f} s; sort the events by "
                "time, as `convert --sort` does"
            )
        last = event.time
        published = _field(where, event)
        key = (event.sensor, event.field)
        if key not in channels:
            known = facts.setdefault(event.sensor, SensorFacts(event.sensor, event.kind))
            channels[key] = channel_of(known, published)
        channel = channels[key]
        if channel.sensor.kind != event.kind:
            raise InputError(
                f"{where}: '{event.sensor}' has the kind {event.kind} here, and the kind "
                f"{channel.sensor.kind} elsewhere"
            )
        value = _value(where, event, published.type)
        changes.append(Change(round(event.time * 1e6), channel, value, event.frame))
    activities, about = tuple(sorted(activities)), dict(about or {})
    return Log(tuple(changes), start, activities, about, samples, has_states)


def channel_of(sensor: SensorFacts, published: Field) -> Channel:
    """Return the channel of a field that a sensor publishes."""
    quantity = published.quantity or ANY_QUANTITY[published.type]
    return Channel(sensor, published.name, published.type, quantity, published.unit)


def _field(where: str, event: Event[float]) -> Field:
    kind = LOGGED_KINDS.get(event.kind)
    if kind is None:
        raise InputError(
            f"{where}: kind '{event.kind}' is unknown: choose one of {', '.join(LOGGED_KINDS)}"
        )
    for published in kind.events:
        if published.name == event.field:
            return published
    names = ", ".join(f.name for f in kind.events)
    raise InputError(f"{where}: {event.kind} has no field '{event.field}': its fields are {names}")


def _value(where: str, event: Event[float], field_type: type) -> Value:
    """Return the value of an event, which can be text, with the type of its field."""
    text = format_value(event.value)
    if field_type is str:
        return text
    if field_type is bool and text in {"0", "1"}:
        return text == "1"
    try:
        if field_type is not bool and math.isfinite(number := float(event.value)):
            return number
    except (ValueError, TypeError):
        pass
    wanted = "0 or 1" if field_type is bool else "a finite number"
    raise InputError(f"{where}: '{event.field}' is '{text}', not {wanted}")


def read_log_events(
    path: Path, start: datetime | None
) -> tuple[list[Event[float]], datetime | None] | ParsedLog:
    """Read an event log, and return its events and their start.

    If the file has dates instead of seconds, as the `events.csv` of simulated days does, return a
    `ParsedLog`. If `start` is None, the start follows from the dates in the file, if it has any.
    Raise InputError or OSError.
    """
    not_text = decoded(path)
    with not_text, open(path, newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(file)
        header = tuple(next(rows, ()))
        if header == DAY_HEADER:
            return ParsedLog(list(_dated_changes(path, rows)), end=_end_of_days(path.parent))
        if header == (*HEADER, COLUMN) and start is None:
            start = _start_by_row(next(rows, []))
    try:
        return read_events(path), start
    except InputError as error:
        raise InputError(
            f"{error}; `angen simulate` writes the header {','.join(HEADER)}"
        ) from None


def _end_of_days(folder: Path) -> datetime | None:
    """Return the midnight that ends the last day in a folder of simulated days; None if unknown."""
    home = home_beside(folder)
    return home.start + timedelta(days=home.days) if home.start and home.days else None


def _start_by_row(row: Sequence[str]) -> datetime | None:
    """Return the date and time of t = 0 from a row of an event log; None for an invalid row."""
    try:
        return datetime.fromisoformat(row[-1]) - timedelta(seconds=float(row[0]))
    except (ValueError, IndexError, OverflowError):
        return None


def _dated_changes(path: Path, rows: Iterable[list[str]]) -> Iterator[Event[datetime]]:
    for number, row in enumerate(rows, start=2):
        try:
            when, sensor, kind, name, value, _person, _because = row
            time = datetime.fromisoformat(when)
        except ValueError:
            raise InputError(f"{path}: line {number} is not an event") from None
        yield Event(time, sensor, name, 0.0, kind, value, number)


@dataclass(frozen=True)
class DescribedHome:
    """The content of a `home.toml`, which describes the home of a log.

    Attributes
    ----------
    sensors
        The sensors by name.
    start
        The begin of the first day.
    about
        Texts about the home, by name.
    days
        The number of days in the folder, or 0 if unknown.
    labels
        The names of activities in other vocabularies: for each vocabulary, a label by activity.
    """

    sensors: dict[str, SensorFacts] = field(default_factory=dict)
    start: datetime | None = None
    about: dict[str, str] = field(default_factory=dict)
    days: int = 0
    labels: dict[str, dict[str, str]] = field(default_factory=dict)


def format_labels(name: str, labels: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """Return the label of each activity in the vocabulary of the format `name`.

    The labels of the format before the hyphen count too: `casas-csv` also uses the labels of
    `casas`.
    """
    return {**labels.get(name.partition("-")[0], {}), **labels.get(name, {})}


def read_home(path: Path) -> DescribedHome:
    """Read a `home.toml`, or the list of sensors that `angen list --json` printed.

    Raise InputError or OSError.
    """
    text, is_json = read_text(path), path.suffix.lower() == ".json"
    with replaced(f"{path} is nested too deeply", RecursionError), explained(str(path), ValueError):
        found: Any = json.loads(text) if is_json else tomllib.loads(text)
    home = {"sensors": found} if isinstance(found, list) else found
    entries = home.get("sensors") if isinstance(home, dict) else None
    if not isinstance(entries, list):
        raise InputError(
            f"{path} has no list of sensors: give a home.toml, or the output of `list --json`"
        )
    sensors: dict[str, SensorFacts] = {}
    for entry in entries:
        facts = _sensor_facts(path, entry)
        if facts.name in sensors:
            raise InputError(f"{path}: two sensors are called '{facts.name}'")
        sensors[facts.name] = facts
    start = home.get("start")
    if start is not None and not isinstance(start, datetime):
        start = parse_start(str(start))
    days = home.get("days")
    count = days if isinstance(days, int) and days > 0 else 0
    return DescribedHome(sensors, start, _about(home), count, _labels(home.get("labels")))


def home_beside(events: Path) -> DescribedHome:
    """Return the content of the `home.toml` in the folder `events`, which has simulated days.

    Return an empty `DescribedHome` if there is no such file. Raise InputError or OSError.
    """
    path = events / "home.toml"
    return read_home(path) if path.is_file() else DescribedHome()


def _labels(found: Any) -> dict[str, dict[str, str]]:
    """Return the tables of labels in a `home.toml`; entries that are no tables are ignored."""
    tables = found.items() if isinstance(found, dict) else ()
    return {
        vocabulary: {activity: str(label) for activity, label in table.items()}
        for vocabulary, table in tables
        if isinstance(table, dict)
    }


def _sensor_facts(path: Path, entry: Any) -> SensorFacts:
    name, kind = (entry.get("name"), entry.get("kind")) if isinstance(entry, dict) else (None, None)
    if not (isinstance(name, str) and isinstance(kind, str)):
        raise InputError(f"{path}: a sensor has no name or no kind: {str(entry)[:80]}")
    room, parameters = entry.get("room", ""), entry.get("parameters", {})
    return SensorFacts(
        name,
        kind,
        room if isinstance(room, str) else "",
        parameters if isinstance(parameters, dict) else {},
    )


def _about(home: Mapping[str, Any]) -> dict[str, str]:
    """Return the texts about the home by name; a text in a table has the name `table.name`."""
    found: dict[str, str] = {}
    for key, value in home.items():
        if key == "labels":
            continue
        if isinstance(value, Mapping):
            found |= {f"{key}.{name}": str(text) for name, text in value.items()}
        elif key not in {"sensors", "start"}:
            found[key] = str(value)
    return found


def read_activities(
    path: Path, start: datetime, labels: Mapping[str, str] | None = None
) -> list[LoggedActivity]:
    """Read an `activities.csv`, with the columns start, end, person, activity, room.

    `labels` has, for some activities, the names that replace them. Raise InputError or OSError.
    """
    not_text = decoded(path)
    with not_text, open(path, newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(file)
        if tuple(next(rows, ())) != ACTIVITY_HEADER:
            raise InputError(f"{path}: line 1 is not {','.join(ACTIVITY_HEADER)}")
        found = [
            _activity(path, number, row, start, labels or {}) for number, row in enumerate(rows, 2)
        ]
    return sorted(found)


def _activity(
    path: Path, number: int, row: Sequence[str], start: datetime, labels: Mapping[str, str]
) -> LoggedActivity:
    try:
        begin, end, person, activity, room = row
        first, last = (since(start, datetime.fromisoformat(text)) for text in (begin, end))
    except (ValueError, TypeError):
        raise InputError(f"{path}: line {number} is not an activity") from None
    if last < first:
        raise InputError(f"{path}: line {number}: '{activity}' ends before it begins")
    return LoggedActivity(first, last, person, labels.get(activity, activity), room)


# The table of sensors beside a log, for formats whose lines have only a name and a word.

KEY_HEADER = ("id", "sensor", "field", "kind", "room", "unit", "initial")
# The words of CASAS, and the words for booleans in pandas.
WORDS = {"ON": True, "OFF": False, "OPEN": True, "CLOSE": False, "CLOSED": False}
WORDS |= {"PRESENT": True, "ABSENT": False, "TRUE": True, "FALSE": False}
# The quantity by the letters of a CASAS name. In the release of 2025, names are places instead.
NUMBERED = {"M": "motion", "MA": "motion", "D": "opening", "I": "occupancy", "L": "light"}
# The quantity by the word, for names without known letters.
OF_WORD = dict.fromkeys(("OPEN", "CLOSE", "CLOSED"), "opening")
OF_WORD |= dict.fromkeys(("PRESENT", "ABSENT"), "occupancy")
# A word that is merged with the name of the next sensor, as in ONM026.
GLUED = re.compile(rf"({'|'.join(sorted(WORDS, reverse=True))})[A-Z]{{1,2}}\d+")


class TextRow(NamedTuple):
    """A row of a log: its line in the file, time, name of the sensor, and value as text."""

    line: int
    time: datetime
    name: str
    text: str


class KeyRow(NamedTuple):
    """A row of the table of sensors: the sensor and field that a name in the log stands for.

    `initial` is the initial state as text, or "".
    """

    sensor: str
    field: str
    kind: str
    room: str
    initial: str


def word(channel: Channel, value: Value) -> str:
    """Return a value as CASAS writes it: ON, OFF, OPEN, CLOSE, or a number."""
    if channel.type is not bool:
        return format_value(value)
    words = ("CLOSE", "OPEN") if channel.quantity == "opening" else ("OFF", "ON")
    return words[bool(value)]


def to_text(log: Log, names: Mapping[Channel, str]) -> str:
    """Return the table of sensors as CSV, with a row for each channel and its name in the log.

    The column of initial states is empty if the log has none.
    """
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
    return to_csv(KEY_HEADER, rows)


def read_rows(table: Path, rows: Iterable[TextRow], has_initial: bool = False) -> ParsedLog:
    """Convert the rows of a log, which are text, to changes of sensors' fields.

    Parameters
    ----------
    table
        The file with the table of sensors. Without it, sensors and fields are guessed from the
        names in the rows.
    rows
        The rows in the order of the file.
    has_initial
        Whether the rows include the initial states. If not, they are taken from the table.
    """
    entries = _read_table(table)
    states = [entry for entry in entries.values() if entry.initial]
    found = ParsedLog([], {entry.sensor: entry.room for entry in entries.values()}, bool(states))
    numbers = {name for name, entry in entries.items() if not _is_boolean(entry)}
    booleans = entries.keys() - numbers
    mended, left_out = RowTally("word", "mended"), RowTally("row", "left out")
    for row in rows:
        line, time, name, text = row
        is_plain = name in numbers or (name in booleans and text in {"0", "1"})
        word = text if is_plain else mended_word(text)
        # In CASAS, a single letter is a damaged name.
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
    texts = [tally.text for tally in (mended, left_out) if tally.count]
    found.notes += ["; ".join(texts)] if texts else []
    return found


def _change(time: datetime, entry: KeyRow, word: str, line: int) -> Event[datetime]:
    value: Value = WORDS.get(word.upper(), word)
    return Event(time, entry.sensor, entry.field, 0.0, entry.kind, value, line)


def _is_boolean(entry: KeyRow) -> bool:
    fields = LOGGED_KINDS[entry.kind].events if entry.kind in LOGGED_KINDS else ()
    return any(field.name == entry.field and field.type is bool for field in fields)


def is_number(text: str) -> bool:
    """Return whether a text is a finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def mended_word(text: str) -> str | None:
    """Return the word in `WORDS` that a damaged text stands for; None if that is not clear.

    Examples of damaged texts are OFFc, OFcF, OF and ONM026.
    """
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
class RowTally:
    """A count of the rows of a file that were changed or left out, with the first such row.

    `noun` and `done` are words for the message, such as "row" and "left out".
    """

    noun: str
    done: str
    count: int = 0
    first: str = ""

    def add(self, line: int, what: str) -> None:
        """Count a row, and store line and content of the first one for the message."""
        self.first = self.first or f"{at_line(line)}{what}"
        self.count += 1

    @property
    def text(self) -> str:
        """A message with the number of rows and the first of them."""
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
