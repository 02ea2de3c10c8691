# SPDX-License-Identifier: GPL-3.0-or-later
"""Read what people did and when, from the files of real homes and of simulated days.

A *log of activities* is one of

- a table with a header (CSV with commas, semicolons or tabs): columns for start, end and activity,
  and optionally the person;
- lines without quotes, as Ordonez and Kasteren have them: start, end and activity, with spaces or
  tabs between them; or start and duration in whole seconds, the start since 1970;
- CASAS text, in which an activity is marked where it begins and ends; or each row has a label;
- a folder: one of simulated days (`activities.csv`), one for pyadlml
  (`activities_subject_NAME.csv`), or one of diaries, each a table with a header.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime, timedelta
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from ..error import InputError, decoded, explained
from . import casas
from .log import LoggedActivity, since
from .source import ACTIVITY_HEADER, EPOCH, WORDS, read_activities

# The names of the columns of a table, in lower case and without spaces and underscores.
STARTS = ("start", "starttime", "begin")
ENDS = ("end", "endtime", "finish")
NAMES = ("activity", "label")
PERSONS = ("person", "subject", "resident")
# A date and time as Ordonez and Kasteren write it: 2012-11-11 21:14:00, 25-Feb-2008 00:22:46.
TIME = r"(\d{4}-\d\d-\d\d|\d\d?-[A-Za-z]{3}-\d{4})[ T](\d\d?:\d\d(?::\d\d(?:\.\d+)?)?)"
INTERVAL = re.compile(rf"\s*{TIME}\s+{TIME}\s+(\S.*?)\s*")
# A start in seconds since 1970, a duration in seconds, and a label.
LENGTH = re.compile(r"\s*(\d{9,10})\s+(\d{1,7})\s+(\S.*?)\s*")
# Lines above the data: names of columns, or a rule.
ABOVE = re.compile(r"\s*(-[-\s]*|[A-Za-z][^\d]*)?")
# The mark of an activity in CASAS text: `Sleeping begin`, `R1_Sleeping end` or `Step_Out="begin"`.
MARK = re.compile(r"([^\s,=]+)(?:\s+|=\")(begin|end)\b", re.IGNORECASE)
PERSON = re.compile(r"(R\d+|Resident\d+)_(.+)")
# The person of a log that names none.
SOMEBODY = "resident"
# Interruptions shorter than this are taken for errors of a label, s. Assumed.
FLICKER_S = 10.0
# The month of a date such as 25-Feb-2008.
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")


class DoneActivity(NamedTuple):
    """An activity of a log: local start and end, the person or "", and what was done."""

    start: datetime
    end: datetime
    person: str
    activity: str


def read(path: Path) -> tuple[list[DoneActivity], list[str]]:
    """Return the activities of a log, sorted by start, and a note for each repair.

    Raise InputError if the content is not a log of activities, or OSError if it cannot be read.
    """
    notes: list[str] = []
    if path.is_dir():
        found = list(_of_folder(path))
    else:
        not_text = decoded(path)
        with not_text:
            lines = path.read_text(encoding="utf-8-sig").splitlines()
        found = list(_of_lines(path, lines, notes))
    kept = sorted(one for one in found if one.end > one.start)
    if len(kept) < len(found):
        notes.append(f"{path}: {len(found) - len(kept)} activities without a duration left out")
    if not kept:
        raise InputError(
            f"{path} has no activities: give a table with the columns start, end and activity, "
            "CASAS text with begin and end, or a folder of days, of diaries or of pyadlml"
        )
    return kept, notes


def read_logged(
    path: Path, start: datetime, labels: Mapping[str, str] | None = None
) -> tuple[list[LoggedActivity], list[str]]:
    """Return the activities of a log in microseconds since `start`, and a note for each repair.

    `labels` has, for some activities, the names that replace them. Raise InputError or OSError.
    """
    if not path.is_dir():
        with open(path, encoding="utf-8-sig", errors="replace") as file:
            is_table = file.readline().rstrip() == ",".join(ACTIVITY_HEADER)
        if is_table:
            return read_activities(path, start, labels), []
    found, notes = read(path)
    return [
        LoggedActivity(
            since(start, one.start),
            since(start, one.end),
            one.person or SOMEBODY,
            (labels or {}).get(one.activity, one.activity),
            "",
        )
        for one in found
    ], notes


def is_activities(path: Path) -> bool:
    """Return whether a log has activities and no sensors, by its first lines.

    Of folders, only those of diaries have no sensors.
    """
    if path.is_dir():
        return bool(_diaries(path))
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        lines = [line.rstrip("\n") for _, line in zip(range(20), file, strict=False)]
    if _table(lines) is not None:
        return True
    data = next((line for line in lines if not ABOVE.fullmatch(line)), "")
    interval = INTERVAL.fullmatch(data)
    return interval is not None and len(re.split(r"\t+|\s{2,}", interval[5])) == 1


def _diaries(folder: Path) -> list[Path]:
    """Return the files of a folder that has only diaries as CSV; none for another folder."""
    found = sorted(folder.glob("*.csv"))
    if any(path.name.startswith("activities") for path in found):
        return []
    return found if all(path.is_file() and is_activities(path) for path in found) else []


def _of_diaries(paths: Iterable[Path]) -> Iterator[DoneActivity]:
    """Yield the activities of diaries; what ends one file and begins the next goes on."""
    last: dict[str, DoneActivity] = {}
    for path in paths:
        before, last = last, {}
        lines = path.read_text(encoding="utf-8-sig").splitlines()
        for one in sorted(_of_table(path, lines)):
            ended = before.pop(one.person, None)
            if ended is not None and (ended.end, ended.activity) == (one.start, one.activity):
                one = one._replace(start=ended.start)
            elif ended is not None:
                yield ended
            if one.person in last:
                yield last[one.person]
            last[one.person] = one
        yield from before.values()
    yield from last.values()


def _of_folder(folder: Path) -> Iterator[DoneActivity]:
    """Yield the activities in a folder of simulated days, for pyadlml or of diaries."""
    if diaries := _diaries(folder):
        yield from _of_diaries(diaries)
        return
    names = _names_by_number(folder)
    for path in sorted(folder.glob("activities*.csv")):
        lines = path.read_text(encoding="utf-8-sig").splitlines()
        if _table(lines) is None:
            continue
        person = path.stem.removeprefix("activities").removeprefix("_subject").removeprefix("_")
        for one in _of_table(path, lines):
            name = names.get(one.activity, one.activity)
            yield one._replace(activity=name, person=one.person or person)


def _names_by_number(folder: Path) -> dict[str, str]:
    """Return the names of pyadlml's activities by their numbers; empty if they have none."""
    path = folder / "activity_map.csv"
    if not path.is_file():
        return {}
    with open(path, newline="", encoding="utf-8-sig") as file:
        return {row["id"]: row["activity"] for row in csv.DictReader(file)}


def _of_lines(path: Path, lines: Sequence[str], notes: list[str]) -> Iterator[DoneActivity]:
    if _table(lines) is not None:
        yield from _of_table(path, lines)
    elif any(INTERVAL.fullmatch(line) or LENGTH.fullmatch(line) for line in lines[:20]):
        yield from _of_intervals(path, lines)
    elif any(casas.LINE.match(line) for line in lines[:20]):
        if any(MARK.search(line) for line in lines):
            yield from _of_marks(path, lines, notes)
        else:
            yield from _of_labels(path, lines)


def _table(lines: Sequence[str]) -> tuple[str, dict[str, int]] | None:
    """Return the separator of a table and the places of its columns; None without a header."""
    if not lines:
        return None
    for separator in (",", ";", "\t"):
        header = [plain(name) for name in lines[0].split(separator)]
        places = {
            role: next((header.index(name) for name in names if name in header), -1)
            for role, names in (
                ("start", STARTS), ("end", ENDS), ("activity", NAMES), ("person", PERSONS)
            )
        }  # fmt: skip
        has_all = min(places["start"], places["end"], places["activity"]) >= 0
        # Ordonez has a header with tabs above columns that several tabs separate.
        if has_all and (separator != "\t" or not all(map(ABOVE.fullmatch, lines[1:2]))):
            return separator, places
    return None


def plain(name: str) -> str:
    """Return the name of a column in lower case, without spaces, underscores and quotes."""
    return re.sub(r"[\s_\"]", "", name).lower()


def _of_table(path: Path, lines: Sequence[str]) -> Iterator[DoneActivity]:
    table = _table(lines)
    assert table is not None
    separator, places = table
    rows = csv.reader(lines, delimiter=separator)
    next(rows)
    for row in rows:
        if not any(row):
            continue
        where = f"{path}, line {rows.line_num}"
        with explained(where, ValueError, IndexError):
            start, end = (parsed_time(row[places[key]]) for key in ("start", "end"))
            activity = row[places["activity"]].strip()
            person = row[places["person"]].strip() if places["person"] >= 0 else ""
        if not activity:
            raise InputError(f"{where}: the activity has no name")
        yield DoneActivity(start, end, person, activity)


def _of_intervals(path: Path, lines: Iterable[str]) -> Iterator[DoneActivity]:
    for number, line in enumerate(lines, start=1):
        if found := INTERVAL.fullmatch(line):
            with explained(f"{path}, line {number}", ValueError):
                start, end = (
                    parsed_time(f"{found[1]} {found[2]}"),
                    parsed_time(f"{found[3]} {found[4]}"),
                )
            yield DoneActivity(start, end, "", found[5])
        elif found := LENGTH.fullmatch(line):
            start = EPOCH + timedelta(seconds=int(found[1]))
            yield DoneActivity(start, start + timedelta(seconds=int(found[2])), "", found[3])
        elif not ABOVE.fullmatch(line):
            raise InputError(f"{path}, line {number} is not start, end and activity")


def _of_marks(path: Path, lines: Iterable[str], notes: list[str]) -> Iterator[DoneActivity]:
    """Yield the activities that are marked in CASAS text."""
    begun: dict[str, datetime] = {}
    lost = 0
    for number, line in enumerate(lines, start=1):
        row = casas.LINE.match(line)
        mark = MARK.search(line[row.end() :]) if row else None
        if row is None or mark is None:
            continue
        with explained(f"{path}, line {number}", ValueError):
            time = parsed_time(f"{row[1]} {row[2]}")
        label, word = mark[1], mark[2].lower()
        if word == "begin":
            lost += label in begun
            begun[label] = time
        elif label in begun:
            start, person = begun.pop(label), PERSON.fullmatch(label)
            yield DoneActivity(start, time, *(person.groups() if person else ("", label)))
        else:
            lost += 1
    if lost + len(begun):
        notes.append(f"{path}: {lost + len(begun)} marks without their begin or end left out")


def _of_labels(path: Path, lines: Iterable[str]) -> Iterator[DoneActivity]:
    """Yield the activities of CASAS text whose rows have a label: until the next row of another."""
    start, under_way = datetime.min, ""
    for number, line in enumerate(lines, start=1):
        row = casas.LINE.match(line)
        if row is None:
            continue
        with explained(f"{path}, line {number}", ValueError):
            time = parsed_time(f"{row[1]} {row[2]}")
        words = line[row.end() :].replace(",", " ").split()
        label = words[-1] if words and words[-1].upper() not in WORDS else ""
        if label != under_way:
            if under_way:
                yield DoneActivity(start, time, "", under_way)
            start, under_way = time, label


def parsed_time(text: str) -> datetime:
    """Return a date and time as one of the formats writes it; raise ValueError for another text."""
    text = text.strip()
    day, _, clock = text.replace("T", " ").partition(" ")
    if found := re.fullmatch(r"(\d\d?)-([A-Za-z]{3})-(\d{4})", day):
        if found[2].lower() not in MONTHS:
            raise ValueError(f"{text!r} is not a date and time")
        day = f"{found[3]}-{MONTHS.index(found[2].lower()) + 1:02d}-{int(found[1]):02d}"
    elif found := re.fullmatch(r"(\d\d?)\.(\d\d?)\.(\d{4})", day):
        day = f"{found[3]}-{int(found[2]):02d}-{int(found[1]):02d}"
    parts = clock.strip().split(":")
    clock = ":".join(part.zfill(2) if "." not in part else part for part in parts)
    time = datetime.fromisoformat(f"{day} {clock}" if clock else day)
    return time.replace(tzinfo=None)


def without_overlaps(
    activities: Iterable[DoneActivity], shortest: float = 60.0
) -> list[DoneActivity]:
    """Return the activities of one person so that none overlaps another.

    What begins later interrupts what is under way, which goes on afterwards. Stretches of the same
    activity less than `shortest` (s) apart are one, and so is what is shorter than `FLICKER_S`
    between them.
    """
    cut: list[DoneActivity] = []
    for one in sorted(activities, key=lambda one: (one.start, one.start - one.end)):
        rest: DoneActivity | None = None
        if cut and cut[-1].end > one.start:
            under_way = cut.pop()
            if under_way.start < one.start:
                cut.append(under_way._replace(end=one.start))
            if under_way.end > one.end:
                rest = under_way._replace(start=one.end)
        cut.append(one)
        if rest is not None:
            cut.append(rest)
            cut.sort()
    found: list[DoneActivity] = []
    for one in sorted(cut):
        start = max(one.start, found[-1].end) if found else one.start
        if one.end <= start:
            continue
        # What flickers for a moment between two stretches of an activity is part of it.
        flicker = found[-1] if len(found) > 1 else None
        if (
            flicker is not None
            and found[-2].activity == one.activity != flicker.activity
            and (flicker.end - flicker.start).total_seconds() < FLICKER_S
            and (start - found[-2].end).total_seconds() < shortest
        ):
            found.pop()
        last = found[-1] if found else None
        near = last is not None and (start - last.end).total_seconds() < shortest
        if last is not None and near and last.activity == one.activity:
            found[-1] = last._replace(end=one.end)
        else:
            found.append(one._replace(start=start))
    return found


def gaps(activities: Sequence[DoneActivity], shortest: float = 60.0) -> list[DoneActivity]:
    """Return the gaps of at least `shortest` (s) between activities, without a name."""
    return [
        DoneActivity(before.end, after.start, before.person, "")
        for before, after in pairwise(activities)
        if (after.start - before.end).total_seconds() >= shortest
    ]
