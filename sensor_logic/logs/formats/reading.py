# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a log in any format; the format is recognised by the file's content."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime, tzinfo
from pathlib import Path

from ..error import InputError, check_mark, explained
from ..log import HEADER, Event
from . import FORMATS, Format, activities, intervals
from .log import DEFAULT_START, Log, LoggedActivity, SensorFacts, count_left_out, since
from .source import ParsedLog, events_of, make_log, read_log_events, sort_rows
from .units import Units

HEAD = 4096
# The format casas covers casas-csv too; it also begins as intervals do, which are never written.
READ = {
    "intervals": Format("intervals", ".txt", "A row for each time on", None, intervals.read,
                        intervals.BEGINS),
    **{name: format for name, format in FORMATS.items() if format.begins},
}  # fmt: skip


@dataclass(frozen=True)
class LoadedLog:
    """A log from a file, in any format.

    Attributes
    ----------
    events
        The events, in seconds since `start`.
    start
        Date and time of t = 0; None if unknown.
    sensors
        The sensors by name, as far as the file describes them.
    has_states
        Whether the first event of each field is its initial state.
    has_activities
        Whether the file has activities; they were not read.
    left_out
        The number of changes at local times that do not exist, because clocks skipped them in
        spring. Such a change has the time at which the clocks went forward.
    notes
        A sentence for each repair or omission.
    end
        The time in seconds until which the sensors were observed; None if unknown.
    """

    path: Path
    events: list[Event[float]]
    start: datetime | None
    sensors: dict[str, SensorFacts]
    has_states: bool = True
    has_activities: bool = False
    left_out: int = 0
    notes: tuple[str, ...] = ()
    end: float | None = None

    def log(
        self,
        sensors: Mapping[str, SensorFacts] | None = None,
        start: datetime = DEFAULT_START,
        activities: Iterable[LoggedActivity] = (),
        about: Mapping[str, str] | None = None,
    ) -> Log:
        """Return the events as a `Log`, with more data about the sensors and the home.

        `sensors` replace sensors of the file with the same name. `about` has texts about the home,
        by name. Raise InputError, which names the file, if the events are invalid.
        """
        facts = self.sensors | dict(sensors or {})
        states = self.has_states
        with explained(str(self.path), InputError):
            return make_log(self.events, facts, start, activities, about, has_states=states)


def read_log(
    path: Path,
    start: datetime | None = None,
    zone: tzinfo | None = None,
    sort: bool = False,
    units: Units | None = None,
) -> LoadedLog:
    """Read an event log, a folder of days, or a file or folder in any of the readable formats.

    Parameters
    ----------
    start
        The date and time of t = 0. With None, it is the start in the log; if the log has none, the
        time of the first change.
    zone
        The time zone of the home, if known.
    sort
        Sort the rows by time, and keep only one of several equal rows.
    units
        The units of numbers whose units are not in the file.

    Raises
    ------
    InputError
        If the file cannot be read as a log; the text names the file and the problem.
    OSError
        If the file cannot be opened.
    """
    if not path.is_dir():
        with open(path, "rb") as file:
            check_mark(path, file.read(2))
    if activities.is_activities(path):
        raise InputError(
            f"{path} has activities and no sensors: give the log of the sensors, and these with "
            "--activities"
        )
    found = _format_of(path)
    if found is None and not path.is_dir() and not path.stat().st_size:
        raise InputError(f"{path} is empty: no sensor changed, or it was not written")
    if found is None:
        raise InputError(
            f"{path}: its format is not recognised from line 1; those that are read are "
            f"{', '.join(READ)}; an event log begins with {','.join(HEADER)}"
        )
    if found.read is not None:
        return _loaded(path, found.name, found.read, start, zone, sort, units)
    read = read_log_events(path / "events.csv" if path.is_dir() else path, start)
    if isinstance(read, ParsedLog):
        return _loaded(path, found.name, lambda _: read, start, zone, sort, units)
    events, start = read
    _convert(path, ParsedLog([]), units)
    if not sort:
        return LoadedLog(path, events, start, {})
    events, note = sort_rows(events)
    return LoadedLog(path, events, start, {}, notes=(f"{path}: {note}",))


def _loaded(
    path: Path,
    name: str,
    reader: Callable[[Path], ParsedLog],
    start: datetime | None,
    zone: tzinfo | None,
    sort: bool,
    units: Units | None,
) -> LoadedLog:
    try:
        read = reader(path)
        _convert(path, read, units)
        if sort:
            read.sort()
        events, begin = events_of(read, start, zone)
        left_out = 0 if read.in_utc else count_left_out([c.time for c in read.changes], zone)
    except KeyError as error:
        raise InputError(f"{path} cannot be read as {name}: it has no {error}") from None
    except (ValueError, IndexError, TypeError, OverflowError) as error:
        raise InputError(f"{path} cannot be read as {name}: {error}") from None
    notes = tuple(f"{path}: {text}" for text in read.notes)
    if not events and name != "events":
        raise InputError("; ".join([f"{path} has no sensor of a known kind", *read.notes]))
    kinds = {event.sensor: event.kind for event in events}
    rooms = read.rooms
    sensors = {s: SensorFacts(s, kind, rooms.get(s, "")) for s, kind in kinds.items()}
    end = since(begin, read.end) / 1e6 if begin and read.end else None
    has = read.has_states, read.has_activities
    return LoadedLog(path, events, begin, sensors, *has, left_out, notes, end)


def _convert(path: Path, read: ParsedLog, units: Units | None) -> None:
    """Convert the changes of a parsed log to the units of their fields."""
    units = units or Units()
    if units.given and not read.units:
        raise InputError(
            f"{path}: --unit is for a file without units, such as Home Assistant's history; "
            "this log has no such numbers"
        )
    with explained(str(path), InputError):
        read.changes, notes = units.convert(read.changes, read.units)
    read.notes += notes


def _format_of(path: Path) -> Format | None:
    """Return the format of a file or folder; None for a file of unknown content.

    A folder in no other format counts as a folder of simulated days, with the format `events`.
    """
    if path.is_dir():
        names = "\n".join(sorted(one.name for one in path.iterdir())).encode("utf-8", "replace")
        folders = (f for f in READ.values() if f.is_folder)
        return next((f for f in folders if re.search(f.begins, names)), FORMATS["events"])
    with open(path, "rb") as file:
        head = file.read(HEAD).removeprefix(b"\xef\xbb\xbf")
    files = (f for f in READ.values() if not f.is_folder)
    return next((f for f in files if re.match(f.begins, head)), None)
