# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a log in any format, which it recognises by the content."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from datetime import datetime, tzinfo
from pathlib import Path
from xml.etree.ElementTree import ParseError

from ..log.event_log import HEADER, Event
from . import FORMATS, Format
from .local_time import count_left_out
from .log import SensorFacts
from .read import events_of
from .source import SourceError, read_log_events
from .written import FormatError

HEAD = 4096


@dataclass(frozen=True)
class LoadedLog:
    """A log from a file: events in seconds since `start` (None: unknown), and the facts about its
    sensors. `has_states`: the first event of each field is its initial state. `has_activities`: the
    file has activities, which were not read. `left_out`: how many changes have a local time that
    the home's clocks went past in spring; they count as at the moment at which these did."""

    events: list[Event]
    start: datetime | None
    sensors: dict[str, SensorFacts]
    has_states: bool = True
    has_activities: bool = False
    left_out: int = 0


def read_log(path: Path, start: datetime | None = None, zone: tzinfo | None = None) -> LoadedLog:
    """Reads an event log, a folder of days, or a file or folder in any of the readable formats.

    `start` is the time of t = 0; None: the time in the log, or that of the first change; `zone`:
    the home's, if known. Raises SourceError, which names the file and the problem, or OSError.
    """
    found = _format_of(path)
    if found is None:
        raise SourceError(
            f"{path}: its format is not recognised by line 1; known are {', '.join(FORMATS)}; an "
            f"event log begins with {','.join(HEADER)}"
        )
    if found.read is None:
        log_path = path / "events.csv" if path.is_dir() else path
        events, begin, left_out = read_log_events(log_path, start, zone)
        return LoadedLog(events, begin, {}, left_out=left_out)
    try:
        read = found.read(path)
        events, begin = events_of(read, start, zone)
        left_out = 0 if read.in_utc else count_left_out([c.time for c in read.changes], zone)
    except KeyError as error:
        raise SourceError(f"{path} cannot be read as {found.name}: it has no {error}") from None
    except (ValueError, IndexError, TypeError, struct.error, ParseError) as error:
        raise SourceError(f"{path} cannot be read as {found.name}: {error}") from None
    except FormatError as error:
        raise SourceError(f"{path}: {error}") from None
    if not events:
        raise SourceError(f"{path} has no sensor of a known kind")
    kinds = {event.sensor: event.kind for event in events}
    rooms = read.rooms
    sensors = {name: SensorFacts(name, kind, rooms.get(name, "")) for name, kind in kinds.items()}
    return LoadedLog(events, begin, sensors, read.has_states, read.has_activities, left_out)


def _format_of(path: Path) -> Format | None:
    """The format of a file or folder, that of any other folder being `events`; None for unknown
    content."""
    if path.is_dir():
        names = "\n".join(sorted(one.name for one in path.iterdir())).encode("utf-8", "replace")
        folders = (f for f in FORMATS.values() if f.is_folder)
        return next((f for f in folders if re.search(f.begins, names)), FORMATS["events"])
    with open(path, "rb") as file:
        head = file.read(HEAD).removeprefix(b"\xef\xbb\xbf")
    files = (f for f in FORMATS.values() if not f.is_folder)
    return next((f for f in files if re.match(f.begins, head)), None)
