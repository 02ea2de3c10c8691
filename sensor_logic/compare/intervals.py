# SPDX-License-Identifier: GPL-3.0-or-later
"""When each sensor of a log was on, whatever format the log has."""

from __future__ import annotations

import csv
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from ..formats.log import DEFAULT_START, Log
from ..formats.source import SourceError, make_log, read_log_events
from ..kinds import KINDS

DAY_S = 86400.0
WORDS = {"ON": True, "OFF": False, "OPEN": True, "CLOSE": False, "CLOSED": False}
# CASAS names sensors by a letter and a number, or, since 2025, by their places.
NUMBERED = {"M": "motion", "MA": "motion", "D": "opening", "I": "occupancy", "L": "light"}
_LINE = re.compile(
    r"(\d{4}-\d\d-\d\d)[\s,]+(\d\d:\d\d:\d\d(?:\.\d+)?)[\s,]+([^\s,]+)[\s,]+([^\s,]+)"
)


@dataclass
class Sensor:
    """When a sensor was on: begins and ends in seconds, without a first or last that is cut off.

    `starts`: every change to on, that of an unfinished last interval too.
    """

    quantity: str
    starts: list[float] = field(default_factory=list)
    intervals: list[tuple[float, float]] = field(default_factory=list)


@dataclass
class Home:
    """A log's sensors by name; `begin` and `end` of the log in seconds since its first midnight."""

    name: str
    begin: float
    end: float
    sensors: dict[str, Sensor]


def read(path: Path) -> Home:
    """An event log, a folder of days, its `events.csv`, or a CASAS file.

    Raises SourceError naming the file and what it should be; OSError.
    """
    if path.is_dir():
        path = path / "events.csv"
    if _is_casas(path):
        known = _known_sensors(path)
        home = _home(path, _casas_changes(path, known))
        for name, quantity in known.items():
            home.sensors.setdefault(name, Sensor(quantity))
        return home
    events, start = read_log_events(path, None)
    try:
        log = make_log(events, start=start or DEFAULT_START)
        return _home(path, _log_changes(log), has_states_at_start=True)
    except SourceError as error:
        raise SourceError(f"{path}: {error}") from None


Row = tuple[float, str, str, bool]


def _log_changes(log: Log) -> Iterator[Row]:
    """(seconds since midnight of the first day, sensor, quantity, on) of each boolean."""
    if not log.changes:
        return
    midnight = log.local(log.changes[0].time).replace(hour=0, minute=0, second=0, microsecond=0)
    midnight = midnight.replace(tzinfo=None)
    for change in log.changes:
        channel = change.channel
        if isinstance(change.value, bool) and channel.quantity != "validity":
            clock = log.local(change.time).replace(tzinfo=None)
            seconds = (clock - midnight).total_seconds()
            yield seconds, channel.sensor.name, channel.quantity, change.value


def _is_casas(path: Path) -> bool:
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        return _LINE.match(file.readline()) is not None


def _casas_changes(path: Path, known: dict[str, str]) -> Iterator[Row]:
    midnight: datetime | None = None
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            found = _LINE.match(line)
            try:
                if found is None:
                    raise ValueError
                time = datetime.fromisoformat(f"{found[1]} {found[2]}")
            except ValueError:
                if line.strip():
                    raise SourceError(f"{path}: line {number} is not one of CASAS") from None
                continue
            midnight = midnight or time.replace(hour=0, minute=0, second=0, microsecond=0)
            value = WORDS.get(found[4].upper())
            if value is not None:
                quantity = known.get(found[3]) or _quantity(found[3], found[4])
                yield (time - midnight).total_seconds(), found[3], quantity, value


def _known_sensors(path: Path) -> dict[str, str]:
    """Name → quantity, by the file that `convert --format casas` writes beside its own."""
    beside = path.with_name(f"{path.name}.sensors.csv")
    if not beside.is_file():
        return {}
    quantities = {
        (kind.identifier, field.name): field.quantity
        for kind in KINDS.values()
        for field in kind.events
        if field.type is bool and field.quantity != "validity"
    }
    with open(beside, newline="", encoding="utf-8-sig") as file:
        return {
            row["id"]: quantities[row["kind"], row["field"]]
            for row in csv.DictReader(file)
            if {"id", "kind", "field"} <= row.keys() and (row["kind"], row["field"]) in quantities
        }


def _quantity(name: str, word: str) -> str:
    letters = re.fullmatch(r"([A-Z]+)\d+", name)
    if letters and letters[1] in NUMBERED:
        return NUMBERED[letters[1]]
    is_door = word.upper() not in {"ON", "OFF"} or name.lower().endswith("door")
    return "opening" if is_door else "motion"


def _home(path: Path, rows: Iterable[Row], has_states_at_start: bool = False) -> Home:
    sensors: dict[str, Sensor] = {}
    since: dict[str, float] = {}
    states: dict[str, bool] = defaultdict(bool)
    begin, last = None, 0.0
    for time, name, quantity, on in rows:
        begin = time if begin is None else begin
        if time < last:
            raise SourceError(f"{path}: the rows are out of order; sort them by time")
        last = time
        first_of_it = name not in sensors
        sensor = sensors.setdefault(name, Sensor(quantity))
        # Who is on at the start of the log has been so for an unknown time.
        if first_of_it and has_states_at_start:
            states[name] = on
            continue
        # Logs of real homes repeat themselves.
        if on and not states[name]:
            sensor.starts.append(time)
            since[name] = time
        elif not on and name in since:
            sensor.intervals.append((since.pop(name), time))
        states[name] = on
    if begin is None:
        raise SourceError(f"{path} has no sensor that is on or off")
    return Home(path.name, begin, last, sensors)
