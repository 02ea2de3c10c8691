# SPDX-License-Identifier: GPL-3.0-or-later
"""The intervals in which each sensor of a log was on; the log can have any format."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..error import InputError
from ..formats.log import DEFAULT_START, Log
from ..formats.reading import read_log

DAY_S = 86400.0


@dataclass
class SensorIntervals:
    """The intervals in which a sensor was on, begin and end in seconds, without intervals that
    begin before or end after the log. `starts`: all changes to on, that of an unfinished interval
    too."""

    quantity: str
    starts: list[float] = field(default_factory=list)
    intervals: list[tuple[float, float]] = field(default_factory=list)


@dataclass
class HomeIntervals:
    """A log's sensors by name; `begin` and `end` of the log in seconds since its t = 0: a folder of
    days ends at midnight, any other log with its last change. `notes`: a sentence for each thing
    that was mended or left out when the log was read."""

    name: str
    begin: float
    end: float
    sensors: dict[str, SensorIntervals]
    notes: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """How long the log is, in seconds; more than 0."""
        return self.end - self.begin


def read(path: Path) -> HomeIntervals:
    """Reads an event log, a folder of days, or a log in any of the readable formats.

    Raises InputError, which names the file and the problem, or OSError.
    """
    source = read_log(path)
    log = source.log(start=source.start or DEFAULT_START)
    home = _home(path, _log_changes(log), source.has_states)
    end = home.end if source.end is None else source.end
    if end <= home.begin:
        raise InputError(f"{path} has changes at one time only: there is nothing to compare")
    return replace(home, end=end, notes=source.notes)


Row = tuple[float, str, str, bool]


def _log_changes(log: Log) -> Iterator[Row]:
    """(seconds since the log's start, sensor, quantity, on) of each boolean."""
    for change in log.changes:
        channel = change.channel
        if isinstance(change.value, bool) and channel.quantity != "validity":
            yield change.time / 1e6, channel.sensor.name, channel.quantity, change.value


def _home(path: Path, rows: Iterable[Row], has_states: bool) -> HomeIntervals:
    sensors: dict[str, SensorIntervals] = {}
    since: dict[str, float] = {}
    states: dict[str, bool] = defaultdict(bool)
    begin, last = None, 0.0
    for time, name, quantity, on in rows:
        begin = time if begin is None else begin
        last = time
        first_of_it = name not in sensors
        sensor = sensors.setdefault(name, SensorIntervals(quantity))
        # A sensor that is on at the start of the log has been so for an unknown time.
        if first_of_it and has_states:
            states[name] = on
            continue
        # Logs of real homes repeat states.
        if on and not states[name]:
            sensor.starts.append(time)
            since[name] = time
        elif not on and name in since:
            sensor.intervals.append((since.pop(name), time))
        states[name] = on
    if begin is None:
        raise InputError(f"{path} has no sensor that is on or off")
    return HomeIntervals(path.name, begin, last, sensors)
