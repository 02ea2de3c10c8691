# SPDX-License-Identifier: GPL-3.0-or-later
"""An event log with typed values, rooms, dates and activities, as other formats need them."""

from __future__ import annotations

import functools
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, tzinfo

from ..log import Event, Value, moment
from ..recording.tracks import Recording

# The start of a log without dates, so that its seconds are seconds since 1970.
DEFAULT_START = datetime(1970, 1, 1)


@dataclass(frozen=True, eq=False)
class SensorFacts:
    """The facts about a sensor besides its events; `parameters` in SI units."""

    name: str
    kind: str
    room: str = ""
    parameters: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Channel:
    """One published field of one sensor; `quantity` as in `kind.Field`, never empty."""

    sensor: SensorFacts
    field: str
    type: type
    quantity: str
    unit: str


@dataclass(frozen=True)
class Change:
    """A channel's new value; `time` in whole microseconds since the log's start. In a faulty log:
    the `faults` that changed it; its index in the log without faults, `origin` (None: it was
    added); `is_first`: it is the initial state of its channel."""

    time: int
    channel: Channel
    value: Value
    frame: float = 0.0
    origin: int | None = field(default=None, compare=False)
    faults: tuple[str, ...] = field(default=(), compare=False)
    is_first: bool = field(default=False, compare=False)

    @property
    def event(self) -> Event[float]:
        """The change as an event of the event log."""
        sensor, name = self.channel.sensor, self.channel.field
        return Event(self.time / 1e6, sensor.name, name, self.frame, sensor.kind, self.value)


@dataclass(frozen=True, order=True)
class LoggedActivity:
    """An activity of a person; times in whole microseconds since the log's start."""

    start: int
    end: int
    person: str
    activity: str
    room: str = ""


@dataclass(frozen=True)
class Log:
    """Changes in time order. The first change of each channel is its initial state, if the log
    `has_states`.

    `start`: date and time of t = 0; without a time zone it is the local time of the home.
    `about`: home, seed, versions, as text. `samples`: all updates, where the log has them.
    `has_states` off: initial states are unknown, as in CASAS, and all changes are updates.
    """

    changes: tuple[Change, ...]
    start: datetime = DEFAULT_START
    activities: tuple[LoggedActivity, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)
    samples: Recording | None = None
    has_states: bool = True

    @property
    def channels(self) -> list[Channel]:
        """The channels that have a value, by sensor and field."""
        found = {change.channel for change in self.changes}
        return sorted(found, key=lambda channel: (channel.sensor.name, channel.field))

    @property
    def sensors(self) -> list[SensorFacts]:
        """The sensors that have a value, by name."""
        found = {change.channel.sensor for change in self.changes}
        return sorted(found, key=lambda sensor: sensor.name)

    # Once a log; without it all activities are gone through for each line that names one.
    @functools.cached_property
    def people(self) -> frozenset[str]:
        """The persons of all activities."""
        return frozenset(activity.person for activity in self.activities)

    def initial(self) -> dict[Channel, Change]:
        """Each channel's initial state."""
        found: dict[Channel, Change] = {}
        for change in self.changes if self.has_states else ():
            found.setdefault(change.channel, change)
        return found

    def updates(self) -> list[Change]:
        """The changes without the initial states."""
        first = {id(change) for change in self.initial().values()}
        return [change for change in self.changes if id(change) not in first]

    def span(self) -> tuple[int, int]:
        """The times of the first and the last change or activity; those of t = 0 if it is empty."""
        times = [change.time for change in (*self.changes[:1], *self.changes[-1:])]
        times += [time for activity in self.activities for time in (activity.start, activity.end)]
        return min(times, default=0), max(times, default=0)

    def local(self, time: int) -> datetime:
        """The local time of the home `time` microseconds after the start."""
        return moment(self.start, timedelta(microseconds=time))

    def epoch_us(self, time: int) -> int:
        """Microseconds since 1970 in UTC; a start without a time zone counts as UTC."""
        start = self.start if self.start.tzinfo else self.start.replace(tzinfo=UTC)
        since = start - datetime(1970, 1, 1, tzinfo=UTC)
        return since // timedelta(microseconds=1) + time

    def iso(self, time: int) -> str:
        """ISO 8601 with microseconds and offset; a start without a time zone counts as UTC."""
        local = self.local(time)
        zoned = local if local.tzinfo else local.replace(tzinfo=UTC)
        return zoned.isoformat(timespec="microseconds")


def titles(channels: list[Channel]) -> dict[Channel, str]:
    """Channel → a unique name: the sensor's name for its first boolean field, else sensor and
    field."""
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
            while title in taken:  # a sensor may have the name of another's field
                title += "_"
        taken.add(title)
        found[channel] = title
    return found


# Spellings of names for other formats, without duplicates.


def unique(names: Iterable[str], spell: Callable[[str], str]) -> dict[str, str]:
    """Name → its spelling; of two equal spellings the one of the later name gets a number."""
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
    """Lower-case ASCII letters, digits and single underscores, a letter first: `pir_hall`."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    words = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")
    return words if words[:1].isalpha() else f"sensor_{words}".rstrip("_")


def camel(name: str) -> str:
    """One word in camel case, of ASCII letters and digits: `PIR hall` → `PIRHall`."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    words = re.findall(r"[A-Za-z0-9]+", plain)
    return "".join(word[0].upper() + word[1:] for word in words) or "Sensor"


def label(activity: str) -> str:
    """An activity as a CASAS label, one word: `Bed to toilet` → `Bed_to_toilet`."""
    return re.sub(r"\W+", "_", activity).strip("_") or "Activity"


# Local times in a home's time zone, where clocks go forward in spring and back in autumn.

MICROSECOND = timedelta(microseconds=1)


def is_left_out(time: datetime, zone: tzinfo) -> bool:
    """Whether clocks went forward past this local time."""
    return time.tzinfo is None and _utc(time, zone).astimezone(zone).replace(tzinfo=None) != time


def localised(time: datetime, zone: tzinfo) -> datetime:
    """A local time in its zone. One that clocks left out becomes the moment at which they went
    forward, so that times stay in order."""
    if time.tzinfo is not None or not is_left_out(time, zone):
        return time if time.tzinfo else time.replace(tzinfo=zone)
    # With the offset of after, the time lies before that moment; with that of before, after it.
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
    """The same moments in a zone; those without a zone are UTC if `in_utc`, or else local. In the
    hour that local clocks repeat, times that would go back are of the second time."""
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
    """How many of these local times clocks went past."""
    return 0 if zone is None else sum(is_left_out(time, zone) for time in times)


def since(start: datetime, time: datetime) -> int:
    """Microseconds from the start; a time without a zone is a local one in the start's zone.
    Raises TypeError for a time with a zone where the start has none."""
    zone = start.tzinfo
    if zone is not None:
        # Python subtracts times of one zone as if daylight saving did not exist.
        start, time = start.astimezone(UTC), localised(time, zone).astimezone(UTC)
    return (time - start) // MICROSECOND


def _utc(time: datetime, zone: tzinfo) -> datetime:
    return time.replace(tzinfo=zone).astimezone(UTC)


# The result of the formats' writers.


@dataclass(frozen=True)
class FormatFiles:
    """The contents of a format's files, and notes, a sentence each, about what was left out.

    A format of one file has it under the key "", and files beside it under suffixes of its name
    (".sensors.csv"); a format that is a folder has its files' names as keys.
    """

    files: Mapping[str, str | bytes]
    notes: tuple[str, ...] = ()
