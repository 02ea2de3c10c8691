# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a log, whichever of the formats it has."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from xml.etree.ElementTree import ParseError

from ..log.event_log import Event
from . import FORMATS, Format
from .log import SensorFacts
from .read import events_of
from .source import SourceError, read_log_events
from .written import FormatError

HEAD = 4096


@dataclass(frozen=True)
class Source:
    """A log that was read: events in seconds since `start` (None: nothing tells it), and what is
    known of its sensors. `has_states`: the first event of each field is its state at the start.
    `has_activities`: the file tells of activities, which are not read."""

    events: list[Event]
    start: datetime | None
    sensors: dict[str, SensorFacts]
    has_states: bool = True
    has_activities: bool = False


def read_log(path: Path, start: datetime | None = None) -> Source:
    """An event log, a folder of days, or a file or folder in any of the formats that can be read.

    `start` is the time of t = 0; else the log tells it, or it is the time of the first change.
    Raises SourceError naming the file and what is wrong; OSError.
    """
    found = _format_of(path)
    if found is None:
        return Source(*read_log_events(path / "events.csv" if path.is_dir() else path, start), {})
    try:
        assert found.read is not None
        read = found.read(path)
        events, begin = events_of(read, start)
    except KeyError as error:
        raise SourceError(f"{path} cannot be read as {found.name}: it has no {error}") from None
    except (ValueError, IndexError, TypeError, struct.error, ParseError) as error:
        raise SourceError(f"{path} cannot be read as {found.name}: {error}") from None
    except FormatError as error:
        raise SourceError(f"{path}: {error}") from None
    if not events:
        raise SourceError(f"{path} tells of no sensor that is known here")
    kinds = {event.sensor: event.kind for event in events}
    rooms = read.rooms
    sensors = {name: SensorFacts(name, kind, rooms.get(name, "")) for name, kind in kinds.items()}
    return Source(events, begin, sensors, read.has_states, read.has_activities)


def _format_of(path: Path) -> Format | None:
    """None for the event log itself, and for what is none of the others."""
    if path.is_dir():
        names = "\n".join(sorted(one.name for one in path.iterdir())).encode("utf-8", "replace")
        folders = (f for f in FORMATS.values() if f.is_folder)
        return next((f for f in folders if re.search(f.begins, names)), None)
    with open(path, "rb") as file:
        head = file.read(HEAD).removeprefix(b"\xef\xbb\xbf")
    files = (f for f in FORMATS.values() if not f.is_folder)
    return next((f for f in files if re.match(f.begins, head)), None)
