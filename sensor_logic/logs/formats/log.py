# SPDX-License-Identifier: GPL-3.0-or-later
"""`Log`: an event log with typed values, rooms, dates and activities.

All formats are written from a `Log`. Its times are whole microseconds since its start.
"""

from __future__ import annotations

import functools
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, tzinfo
from typing import Any

from ..log import Event, Value, moment

# The start of a log without dates. Its seconds are then seconds since 1970.
DEFAULT_START = datetime(1970, 1, 1)


@dataclass(frozen=True, eq=False)
class SensorFacts:
    """A sensor of a log: its name, kind, room and parameters, which are in SI units."""

    name: str
    kind: str
    room: str = ""
    parameters: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Channel:
    """One published field of one sensor.

    `quantity` says what the field measures, such as "motion". For a field that declares no
    quantity, it is a word for the type.
    """

    sensor: SensorFacts
    field: str
    type: type
    quantity: str
    unit: str


@dataclass(frozen=True)
class Change:
    """A new value of a channel.

    Attributes
    ----------
    time
        Whole microseconds since the log's start.
    origin
        For a log with faults: the index of this row in the log without faults, or None if a fault
        added the row.
    faults
        For a log with faults: the names of the faults that changed this row.
    is_first
        For a log with faults: whether the row is the initial state of its channel.
    """

    time: int
    channel: Channel
    value: Value
    frame: float = 0.0
    origin: int | None = field(default=None, compare=False)
    faults: tuple[str, ...] = field(default=(), compare=False)
    is_first: bool = field(default=False, compare=False)

    @property
    def event(self) -> Event[float]:
        """The change as an `Event`, a row of the event log."""
        sensor, name = self.channel.sensor, self.channel.field
        return Event(self.time / 1e6, sensor.name, name, self.frame, sensor.kind, self.value)


@dataclass(frozen=True, order=True)
class LoggedActivity:
    """An activity of a person; `start` and `end` are whole microseconds since the log's start."""

    start: int
    end: int
    person: str
    activity: str
    room: str = ""


@dataclass(frozen=True, eq=False)
class LoggedSamples:
    """All updates of one sensor: the time in s and the frame of each, and its values by field."""

    sensor: str
    kind: str
    times: Sequence[float]
    frames: Sequence[float]
    columns: Mapping[str, Sequence[Any]]


@dataclass(frozen=True)
class Log:
    """All changes of sensors' fields in time order, with data about the home.

    Attributes
    ----------
    start
        Date and time of t = 0. Without a time zone, it is in local time of the home.
    activities
        The activities of all people.
    about
        Texts by name: the home, the seed and versions.
    samples
        All updates of each sensor, if the log was made from a recording.
    has_states
        Whether the first change of each channel is its initial state. If not, as in CASAS, initial
        states are unknown, and all changes are updates.
    """

    changes: tuple[Change, ...]
    start: datetime = DEFAULT_START
    activities: tuple[LoggedActivity, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)
    samples: tuple[LoggedSamples, ...] | None = None
    has_states: bool = True

    @property
    def channels(self) -> list[Channel]:
        """The channels that occur in the log, sorted by sensor and field."""
        found = {change.channel for change in self.changes}
        return sorted(found, key=lambda channel: (channel.sensor.name, channel.field))

    @property
    def sensors(self) -> list[SensorFacts]:
        """The sensors that occur in the log, sorted by name."""
        found = {change.channel.sensor for change in self.changes}
        return sorted(found, key=lambda sensor: sensor.name)

    # Cached: without the cache, each line that names an activity takes a pass over all activities.
    @functools.cached_property
    def people(self) -> frozenset[str]:
        """The names of all people who have an activity."""
        return frozenset(activity.person for activity in self.activities)

    def initial(self) -> dict[Channel, Change]:
        """Return the initial state of each channel; empty if initial states are unknown."""
        found: dict[Channel, Change] = {}
        for change in self.changes if self.has_states else ():
            found.setdefault(change.channel, change)
        return found

    def updates(self) -> list[Change]:
        """Return all changes that are not initial states."""
        first = {id(change) for change in self.initial().values()}
        return [change for change in self.changes if id(change) not in first]

    def span(self) -> tuple[int, int]:
        """Return the first and the last time of all changes and activities; (0, 0) if empty."""
        times = [change.time for change in (*self.changes[:1], *self.changes[-1:])]
        times += [time for activity in self.activities for time in (activity.start, activity.end)]
        return min(times, default=0), max(times, default=0)

    def local(self, time: int) -> datetime:
        """Convert a time in µs since the log's start to the local date and time of the home."""
        return moment(self.start, timedelta(microseconds=time))

    def epoch_us(self, time: int) -> int:
        """Convert a time in µs since the log's start to µs since 1970 in UTC.

        A start without a time zone counts as UTC.
        """
        start = self.start if self.start.tzinfo else self.start.replace(tzinfo=UTC)
        since = start - datetime(1970, 1, 1, tzinfo=UTC)
        return since // timedelta(microseconds=1) + time

    def iso(self, time: int) -> str:
        """Convert a time in µs since the log's start to a text in ISO 8601.

        The text has microseconds and the offset from UTC. A start without a time zone counts as
        UTC.
        """
        local = self.local(time)
        zoned = local if local.tzinfo else local.replace(tzinfo=UTC)
        return zoned.isoformat(timespec="microseconds")


def titles(channels: list[Channel]) -> dict[Channel, str]:
    """Return a unique name for each channel.

    The first boolean field of a sensor gets the sensor's name. Any other field gets the sensor's
    name, followed by the field's name.
    """
    main: dict[SensorFacts, Channel] = {}
    for channel in channels:
        if channel.type is bool and channel.quantity != "validity":
            main.setdefault(channel.sensor, channel)
    found: dict[Channel, str] = {}
    taken = {sensor.name for sensor in main}
    for channel in channels:
        title = channel.sensor.name
        if main.get(channel.sensor) is not channel:
            title = f"{title} {channel.field}"
            while title in taken:  # a sensor can have the name of another sensor's field
                title += "_"
        taken.add(title)
        found[channel] = title
    return found


# Names spelled for other formats, without duplicates.


def unique(names: Iterable[str], spell: Callable[[str], str]) -> dict[str, str]:
    """Return a unique spelling for each name.

    `spell` makes a spelling from a name. If another name has the same spelling, a number is added.
    """
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in sorted(set(names)):
        stem, number = spell(name), 1
        spelling = stem
        while spelling.casefold() in taken:
            number += 1
            spelling = f"{stem}_{number}"
        taken.add(spelling.casefold())
        found[name] = spelling
    return found


def slug(name: str) -> str:
    """Return a name in lower-case ASCII letters, digits and single underscores: `pir_hall`.

    The first character is a letter.
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    words = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")
    return words if words[:1].isalpha() else f"sensor_{words}".rstrip("_")


def camel(name: str) -> str:
    """Return a name as one word of ASCII letters and digits in camel case.

    For example, `PIR hall` becomes `PIRHall`.
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    words = re.findall(r"[A-Za-z0-9]+", plain)
    return "".join(word[0].upper() + word[1:] for word in words) or "Sensor"


def label(activity: str) -> str:
    """Return an activity as a CASAS label, one word: `Bed to toilet` → `Bed_to_toilet`."""
    return re.sub(r"\W+", "_", activity).strip("_") or "Activity"


# Local times in a time zone whose clocks go forward in spring and back in autumn.

MICROSECOND = timedelta(microseconds=1)


def is_left_out(time: datetime, zone: tzinfo) -> bool:
    """Return whether this local time does not exist because clocks went forward and skipped it."""
    return time.tzinfo is None and _utc(time, zone).astimezone(zone).replace(tzinfo=None) != time


def localised(time: datetime, zone: tzinfo) -> datetime:
    """Return a local time with its zone.

    In spring, clocks go forward and skip some times. For such a time, return the time at which they
    went forward, so that times stay in order.
    """
    if time.tzinfo is not None or not is_left_out(time, zone):
        return time if time.tzinfo else time.replace(tzinfo=zone)
    # `early` uses the later offset and lies before the clock change; `late` lies after the change.
    early, late = (_utc(time.replace(fold=fold), zone) for fold in (1, 0))
    offset = early.astimezone(zone).utcoffset()
    while late - early > MICROSECOND:
        middle = early + (late - early) // 2
        if middle.astimezone(zone).utcoffset() == offset:
            early = middle
        else:
            late = middle
    return late.astimezone(zone)


def in_zone(times: Iterable[datetime], zone: tzinfo, in_utc: bool) -> list[datetime]:
    """Convert times to a time zone.

    Times without a zone are in UTC if `in_utc`, else in local time. In autumn, clocks go back, and
    an hour of local time occurs twice. A time in that hour belongs to the second occurrence if it
    would otherwise be earlier than the previous time.
    """
    found: list[datetime] = []
    for time in times:
        if time.tzinfo is not None or in_utc:
            time = (time if time.tzinfo else time.replace(tzinfo=UTC)).astimezone(zone)
        else:
            time = localised(time, zone)
            if found and time.astimezone(UTC) < found[-1].astimezone(UTC):
                time = time.replace(fold=1)
        found.append(time)
    return found


def count_left_out(times: Sequence[datetime], zone: tzinfo | None) -> int:
    """Return how many of the local times do not exist in the zone, because clocks skipped them."""
    return 0 if zone is None else sum(is_left_out(time, zone) for time in times)


def since(start: datetime, time: datetime) -> int:
    """Return the microseconds from `start` to `time`.

    If only `start` has a zone, `time` is a local time in that zone. Raise TypeError if only `time`
    has a zone.
    """
    zone = start.tzinfo
    if zone is not None:
        # Python ignores daylight saving when it subtracts times in the same zone.
        start, time = start.astimezone(UTC), localised(time, zone).astimezone(UTC)
    return (time - start) // MICROSECOND


def _utc(time: datetime, zone: tzinfo) -> datetime:
    return time.replace(tzinfo=zone).astimezone(UTC)


# The result of a writer.


@dataclass(frozen=True)
class FormatFiles:
    """The contents of a format's files, and notes about what was left out.

    Attributes
    ----------
    files
        The contents by key. For a format that is a folder, the keys are the names of its files. For
        others, the key "" stands for the main file, and a suffix such as ".sensors.csv" for a file
        beside it.
    notes
        A sentence for each omission.
    """

    files: Mapping[str, str | bytes]
    notes: tuple[str, ...] = ()
