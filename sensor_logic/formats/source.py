# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a `Log` from an event log, the facts about its home, and its activities."""

from __future__ import annotations

import csv
import json
import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from ..error import InputError
from ..kind import Field
from ..kinds import KINDS
from ..log.event_log import HEADER, Event, Value, format_value, read_events
from ..log.start import COLUMN, parse_start
from ..recording.tracks import Recording
from .local_time import since
from .log import DEFAULT_START, Change, Channel, Log, LoggedActivity, SensorFacts
from .read import ParsedLog

DAY_HEADER = ("time", "sensor", "kind", "field", "value", "person", "because")
# The quantity of a field that names none, by type.
ANY_QUANTITY = {bool: "state", str: "text", float: "number", int: "number"}
ACTIVITY_HEADER = ("start", "end", "person", "activity", "room")


def make_log(
    events: Iterable[Event[float]],
    sensors: Mapping[str, SensorFacts] | None = None,
    start: datetime = DEFAULT_START,
    activities: Iterable[LoggedActivity] = (),
    about: Mapping[str, str] | None = None,
    samples: Recording | None = None,
    has_states: bool = True,
) -> Log:
    """A log of events; a sensor that is not in `sensors` has no room.

    `has_states`: the first event of each field is its initial state. Raises InputError for an
    unknown kind or field, an invalid value, and decreasing times.
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
                f"{where}: '{event.sensor}' is of kind {event.kind} here and of kind "
                f"{channel.sensor.kind} elsewhere"
            )
        value = _value(where, event, published.type)
        changes.append(Change(round(event.time * 1e6), channel, value, event.frame))
    activities, about = tuple(sorted(activities)), dict(about or {})
    return Log(tuple(changes), start, activities, about, samples, has_states)


def channel_of(sensor: SensorFacts, published: Field) -> Channel:
    quantity = published.quantity or ANY_QUANTITY[published.type]
    return Channel(sensor, published.name, published.type, quantity, published.unit)


def _field(where: str, event: Event[float]) -> Field:
    kind = KINDS.get(event.kind)
    if kind is None:
        raise InputError(f"{where}: kind '{event.kind}' is unknown; known are {', '.join(KINDS)}")
    for published in kind.events:
        if published.name == event.field:
            return published
    names = ", ".join(f.name for f in kind.events)
    raise InputError(f"{where}: {event.kind} has no field '{event.field}', but {names}")


def _value(where: str, event: Event[float], of: type) -> Value:
    """The value, which from a file may still be text."""
    text = format_value(event.value)
    if of is str:
        return text
    if of is bool and text in {"0", "1"}:
        return text == "1"
    try:
        if of is not bool and math.isfinite(number := float(event.value)):
            return number
    except (ValueError, TypeError):
        pass
    wanted = "0 or 1" if of is bool else "a number, which is finite"
    raise InputError(f"{where}: '{event.field}' is '{text}', not {wanted}")


def read_log_events(
    path: Path, start: datetime | None
) -> tuple[list[Event[float]], datetime | None] | ParsedLog:
    """The events of an event log and their start; of the `events.csv` of a folder of days, which
    has dates instead of seconds, the changes.

    `start` None: the dates in the file give the start. Raises InputError, OSError.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = csv.reader(file)
            header = tuple(next(rows, ()))
            if header == DAY_HEADER:
                return ParsedLog(list(_dated_changes(path, rows)), end=_end_of_days(path.parent))
            if header == (*HEADER, COLUMN) and start is None:
                start = _start_by_row(next(rows, []))
            return read_events(path), start
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text file in UTF-8") from None
    except ValueError as error:
        raise InputError(f"{error}; {','.join(HEADER)} is what `angen simulate` writes") from None


def _end_of_days(folder: Path) -> datetime | None:
    """The midnight at which a folder of days ends; None if it does not say so."""
    home = home_beside(folder)
    return home.start + timedelta(days=home.days) if home.start and home.days else None


def _start_by_row(row: Sequence[str]) -> datetime | None:
    """The date and time of t = 0, from an event's seconds and date; None for an invalid row, which
    `read_events` reports."""
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
class HomeFile:
    """The facts in a `home.toml`. `days`: how many the folder beside it has; 0: unknown. `labels`:
    what other vocabularies call activities, by vocabulary and activity."""

    sensors: dict[str, SensorFacts] = field(default_factory=dict)
    start: datetime | None = None
    about: dict[str, str] = field(default_factory=dict)
    days: int = 0
    labels: dict[str, dict[str, str]] = field(default_factory=dict)


def format_labels(name: str, labels: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """What the format `name` calls activities, where `labels` say so by vocabulary and activity:
    `casas-csv` is of the vocabulary `casas` too."""
    return {**labels.get(name.partition("-")[0], {}), **labels.get(name, {})}


def read_home(path: Path) -> HomeFile:
    """Reads a `home.toml`, or the sensors that `angen list --json` printed.

    Raises InputError, OSError.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        found: Any = json.loads(text) if path.suffix.lower() == ".json" else tomllib.loads(text)
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text file in UTF-8") from None
    except RecursionError:
        raise InputError(f"{path} is nested too deeply") from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    home = {"sensors": found} if isinstance(found, list) else found
    entries = home.get("sensors") if isinstance(home, dict) else None
    if not isinstance(entries, list):
        raise InputError(f"{path} has no list of sensors, as home.toml and `list --json` have")
    sensors: dict[str, SensorFacts] = {}
    for entry in entries:
        facts = _sensor_facts(path, entry)
        if facts.name in sensors:
            raise InputError(f"{path}: two sensors are called '{facts.name}'")
        sensors[facts.name] = facts
    start = home.get("start")
    if start is not None and not isinstance(start, datetime):
        start = start_of(str(start))
    days = home.get("days")
    count = days if isinstance(days, int) and days > 0 else 0
    return HomeFile(sensors, start, _about(home), count, _labels(home.get("labels")))


def home_beside(events: Path) -> HomeFile:
    """The facts in a folder of days; none of any other log. Raises InputError, OSError."""
    path = events / "home.toml"
    return read_home(path) if path.is_file() else HomeFile()


def _labels(found: Any) -> dict[str, dict[str, str]]:
    """The tables of labels; without what is no such table."""
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
    """The facts about the home itself, those in tables as `table.name`."""
    found: dict[str, str] = {}
    for key, value in home.items():
        if key == "labels":
            continue
        if isinstance(value, Mapping):
            found |= {f"{key}.{name}": str(text) for name, text in value.items()}
        elif key not in {"sensors", "start"}:
            found[key] = str(value)
    return found


def start_of(text: str) -> datetime | None:
    """A date and time such as 2026-03-02T07:00:00. Raises InputError."""
    try:
        return parse_start(text)
    except ValueError as error:
        raise InputError(str(error)) from None


def read_activities(
    path: Path, start: datetime, labels: Mapping[str, str] | None = None
) -> list[LoggedActivity]:
    """The rows of an `activities.csv`: start, end, person, activity, room; `labels`: the names that
    activities get instead.

    Raises InputError, OSError.
    """
    found = []
    with open(path, newline="", encoding="utf-8-sig") as file:
        try:
            rows = csv.reader(file)
            if tuple(next(rows, ())) != ACTIVITY_HEADER:
                raise InputError(f"{path}: line 1 is not {','.join(ACTIVITY_HEADER)}")
            found = [
                _activity(path, number, row, start, labels or {})
                for number, row in enumerate(rows, 2)
            ]
        except UnicodeDecodeError:
            raise InputError(f"{path} is not a text file in UTF-8") from None
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
