# SPDX-License-Identifier: GPL-3.0-or-later
"""The text format of the CASAS data sets, which record the sensors of real homes.

Each line is a change of a sensor. An activity is marked on the lines where it begins and ends.
`casas` is the format of the homes Aruba, Milan, Cairo and Kyoto: `2010-11-04 00:03:50.209589 M003
ON Sleeping begin`. `casas-csv` is the format of the release of 2025 (doi 10.5281/zenodo.15708568):
`2012-07-20,10:38:54.512364,OutsideDoor,ON,Step_Out="begin"`.

Neither format has a header, rooms, units or initial states. A second file holds them.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ..wording import listed
from . import source
from .log import Change, Channel, FormatFiles, Log, LoggedActivity, camel, label, titles, unique
from .source import ParsedLog

# The suffix of the second file, which describes the sensors.
SUFFIX = ".sensors.csv"
BEGINS = rb"\d{4}-\d\d-\d\d[\s,]+\d\d:\d\d:\d\d"
LINE = re.compile(
    r"(\d{4}-\d\d-\d\d)[\s,]+(\d\d:\d\d:\d\d(?:\.\d+)?)[\s,]+([^\s,]+)[\s,]+([^\s,]+)"
)

# The first letters of sensor names: motion, door, item, light switch, light level, temperature.
PREFIXES = {
    "motion": "M",
    "opening": "D",
    "occupancy": "I",
    "light": "L",
    "illuminance": "LS",
    "luminance": "LS",
    "temperature": "T",
}
# The prefix of any other boolean field: an item that is in use or not.
ITEM = "I"


@dataclass
class _Mark:
    """The mark of an activity at the end of a line: a label, and the word "begin" or "end"."""

    activity: str
    word: str


def write_text(log: Log) -> FormatFiles:
    """Return the changes in the format `casas`, with spaces between columns.

    Sensors are numbered by kind, such as `M003`. Initial states are left out.
    """
    names = _numbered(log.channels)
    lines = []
    marks, notes = _marks(log, names)
    for change in log.updates():
        if change.channel in names:
            mark = marks.get(id(change))
            text = f" {mark.activity} {mark.word}" if mark else ""
            word = source.word(change.channel, change.value)
            lines.append(f"{_stamp(log, change, ' ')} {names[change.channel]} {word}{text}\n")
    return _written(log, names, lines, notes)


def write_csv(log: Log) -> FormatFiles:
    """Return the changes in the format `casas-csv`, with commas between columns.

    Sensors have their names as one word, such as `PIRHall`. Initial states are left out.
    """
    names = _named(log.channels)
    lines = []
    marks, notes = _marks(log, names)
    inside = _PresentActivity(log)
    for change in log.updates():
        if change.channel in names:
            mark = marks.get(id(change))
            text = f'{mark.activity}="{mark.word}"' if mark else inside.at(change.time)
            word = source.word(change.channel, change.value)
            row = f"{_stamp(log, change, ',')},{names[change.channel]},{word},{text}"
            lines.append(f"{row.rstrip(',')}\n")
    return _written(log, names, lines, notes)


def _written(
    log: Log, names: dict[Channel, str], lines: list[str], notes: list[str]
) -> FormatFiles:
    left_out = [f"{c.sensor.name} {c.field}" for c in log.channels if c not in names]
    if left_out:
        notes.append(
            f"CASAS has no sensors for these fields, which were left out: {', '.join(left_out)}"
        )
    if log.channels and not lines:
        notes.append("the file is empty, since CASAS lists only changes, and no sensor changed")
    renamed = [f"{c.sensor.name} is {name}" for c, name in names.items() if c.sensor.name != name]
    if renamed and not log.has_states:
        # For a log that came from CASAS. Other logs have these names in the second file.
        notes.append(
            f"sensors whose names do not fit CASAS were renamed, as the file OUT{SUFFIX} lists: "
            f"{listed(renamed)}"
        )
    return FormatFiles({"": "".join(lines), SUFFIX: source.to_text(log, names)}, tuple(notes))


def _numbered(channels: list[Channel]) -> dict[Channel, str]:
    """Return a CASAS name, such as `M003`, for each channel that has a counterpart in CASAS.

    A channel that already has a CASAS name keeps it.
    """
    kept = {c: title for c, title in titles(channels).items() if _has_casas_name(c, title)}
    taken = set(kept.values())
    counts: dict[str, int] = {}
    found = {}
    for channel in channels:
        prefix = PREFIXES.get(channel.quantity, ITEM if channel.type is bool else "")
        if channel in kept:
            found[channel] = kept[channel]
        elif prefix and channel.quantity != "validity":
            while (name := _next(prefix, counts)) in taken:
                pass
            found[channel] = name
    return found


def _has_casas_name(channel: Channel, name: str) -> bool:
    """Return whether `name` is a CASAS name, such as `M003`, that fits the channel's quantity."""
    # Letters without a known quantity fit any quantity.
    letters = re.fullmatch(r"([A-Z]{1,2})\d+", name)
    quantity = letters and source.NUMBERED.get(letters[1], channel.quantity)
    return channel.type is bool and quantity == channel.quantity


def _next(prefix: str, counts: dict[str, int]) -> str:
    counts[prefix] = counts.get(prefix, 0) + 1
    return f"{prefix}{counts[prefix]:03d}"


def _named(channels: list[Channel]) -> dict[Channel, str]:
    """Return the name of each channel as one word; channels with text values are left out."""
    named = {c: title for c, title in titles(channels).items() if c.type is not str}
    spelling = unique(named.values(), camel)
    return {channel: spelling[title] for channel, title in named.items()}


def _stamp(log: Log, change: Change, separator: str) -> str:
    # `strftime` would write years before 1000 with fewer digits.
    return log.local(change.time).replace(tzinfo=None).isoformat(separator, "microseconds")


def _marks(log: Log, names: dict[Channel, str]) -> tuple[dict[int, _Mark], list[str]]:
    """Return the marks of activities, by the `id` of the change on whose line they are, and notes.

    An activity is marked on the first and on the last change while it lasts. A line holds only one
    mark. An activity without two free lines is left out, and a note says so.
    """
    changes = [change for change in log.updates() if change.channel in names]
    times = [change.time for change in changes]
    found: dict[int, _Mark] = {}
    lost = []
    for activity in log.activities:
        within = range(bisect_left(times, activity.start), bisect_right(times, activity.end))
        first = next((i for i in within if id(changes[i]) not in found), None)
        last = next((i for i in reversed(within) if id(changes[i]) not in found), None)
        if first is None or last is None or first == last:
            lost.append(activity.activity)
            continue
        name = _label(log, activity)
        found[id(changes[first])] = _Mark(name, "begin")
        found[id(changes[last])] = _Mark(name, "end")
    notes = []
    if lost:
        names_lost = ", ".join(sorted(set(lost)))
        notes.append(
            f"{len(lost)} of {len(log.activities)} activities were left out, since fewer than two "
            f"sensor changes, on which CASAS marks begin and end, fall into them: {names_lost}"
        )
    return found, notes


def _label(log: Log, activity: LoggedActivity) -> str:
    """Return an activity's label; with several people it begins with a name, as `R1_Sleeping`."""
    name = label(activity.activity)
    return f"{label(activity.person)}_{name}" if len(log.people) > 1 else name


class _PresentActivity:
    """Finds the activity at a time; calls of `at` must be in ascending order of time."""

    def __init__(self, log: Log) -> None:
        self.log = log
        self.coming = sorted(log.activities, key=lambda activity: activity.start, reverse=True)
        self.present: list[LoggedActivity] = []

    def at(self, time: int) -> str:
        """Return the label of the activity at `time`; "" if there is none."""
        while self.coming and self.coming[-1].start <= time:
            self.present.append(self.coming.pop())
        self.present = [activity for activity in self.present if time <= activity.end]
        return _label(self.log, self.present[-1]) if self.present else ""


def read(path: Path) -> ParsedLog:
    """Read a file in either format, written by this program or recorded in a real home.

    The activities are not read. Without the second file, the sensors' kinds are guessed from their
    names, and rows with numbers are left out. Raise ValueError for an invalid line; the text names
    it.
    """
    labels: set[str] = set()
    found = source.read_rows(path.with_name(f"{path.name}{SUFFIX}"), _rows(path, labels))
    found.has_activities = bool(labels)
    return found


def _rows(path: Path, labels: set[str]) -> Iterator[source.TextRow]:
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            found = LINE.match(line)
            if found:
                labels.update(line[found.end() :].split())
                time = _time(number, f"{found[1]} {found[2]}")
                yield source.TextRow(number, time, found[3], found[4])
            elif line.strip():
                raise ValueError(f"line {number} is not in the format of CASAS")


def _time(number: int, text: str) -> datetime:
    try:
        return datetime.fromisoformat(text)
    except ValueError:
        raise ValueError(f"line {number} has no date and time") from None
