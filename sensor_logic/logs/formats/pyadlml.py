# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder that pyadlml reads with `load_act_assist`.

It has files of devices and of activities, and files that map numbers to their names and rooms. A
device is a field of a sensor. Columns and times are as in pyadlml's `activity_assistant.py`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path

from ..log import format_value, to_csv
from . import source
from .log import FormatFiles, Log, titles, unique
from .source import ParsedLog

TIME = "%d.%m.%Y %H:%M:%S.%f"
DEVICES = "devices.csv"
# The file with the names of the devices; older folders have the second one.
MAPS = ("device_map.csv", "device_mapping.csv")
# The file with kinds, fields and units, which pyadlml does not read.
SENSORS = "sensors.csv"
# The subject of a log without activities, because pyadlml needs at least one.
NOBODY = "R1"


def write(log: Log) -> FormatFiles:
    """Return the log as a folder: all changes, including initial states, and all activities.

    Fields with text values are left out.
    """
    named = {c: title for c, title in titles(log.channels).items() if c.type is not str}
    device = {channel: str(number) for number, channel in enumerate(named)}
    names = sorted({a.activity for a in log.activities})
    activity = {name: str(number) for number, name in enumerate(names)}

    def clock(time: int) -> str:
        local = log.local(time)
        # `%Y` would write years before 1000 with fewer digits.
        return local.strftime(TIME.replace("%Y", f"{local.year:04}"))

    files: dict[str, str | bytes] = {
        DEVICES: to_csv(
            ("time", "device", "value"),
            (
                (clock(change.time), device[change.channel], format_value(change.value))
                for change in log.changes
                if change.channel in device
            ),
        ),
        MAPS[0]: to_csv(("id", "device"), ((device[c], named[c]) for c in named)),
        SENSORS: source.to_text(log, device),
        "device_area_map.csv": _areas("device", ((device[c], c.sensor.room) for c in named)),
        "activity_map.csv": to_csv(("id", "activity"), ((activity[n], n) for n in names)),
        "activity_area_map.csv": _areas(
            "activity", ((activity[n], f"[{','.join(_rooms(log, n))}]") for n in names)
        ),
    }
    people = unique({a.person for a in log.activities} or {NOBODY}, _file_part)
    for person, part in people.items():
        files[f"activities_subject_{part}.csv"] = to_csv(
            ("start_time", "end_time", "activity"),
            (
                (clock(a.start), clock(a.end), activity[a.activity])
                for a in log.activities
                if a.person == person
            ),
        )
    return FormatFiles(files, _notes(log))


def read(folder: Path) -> ParsedLog:
    """Read the devices' changes from a folder that any program wrote; activities are not read.

    Without the file `sensors.csv`, the devices' kinds are guessed from their names.
    """
    found = source.read_rows(folder / SENSORS, _rows(folder), has_initial=True)
    found.has_activities = any(
        path.read_bytes().count(b"\n") > 1 for path in folder.glob("activities_*.csv")
    )
    return found


def _rows(folder: Path) -> Iterator[source.TextRow]:
    is_ours = (folder / SENSORS).is_file()
    names = {} if is_ours else _names(folder)
    with open(folder / DEVICES, newline="", encoding="utf-8-sig") as file:
        rows = csv.DictReader(file)
        if missing := {"time", "device", "value"} - set(rows.fieldnames or ()):
            raise ValueError(f"{DEVICES} line 1 has no column {', '.join(sorted(missing))}")
        for row in rows:
            device, value = row["device"], row["value"] or ""
            if value in {"0", "1"}:
                value = value if is_ours else ("OFF", "ON")[int(value)]
            time = _time(rows.line_num, row["time"])
            yield source.TextRow(rows.line_num, time, names.get(device, device), value)


def _names(folder: Path) -> dict[str, str]:
    """Return the name of each device by its number; empty if no file maps the numbers."""
    path = next((folder / name for name in MAPS if (folder / name).is_file()), None)
    if path is None:
        return {}
    with open(path, newline="", encoding="utf-8-sig") as file:
        rows = csv.DictReader(file)
        columns = rows.fieldnames or ()
        names = [column for column in columns if column.startswith("device")]
        if "id" not in columns or not names:
            raise ValueError(f"{path.name} line 1 is not id,device")
        return {row["id"]: row[names[0]] for row in rows}


def _time(line: int, text: str | None) -> datetime:
    for pattern in (TIME, TIME.removesuffix(".%f")):
        try:
            return datetime.strptime(text or "", pattern)
        except ValueError:
            pass
    try:
        return datetime.fromisoformat(text or "")
    except ValueError:
        raise ValueError(
            f"{DEVICES} line {line}: '{text}' is not a time such as 05.11.2010 00:00:09.500000 or "
            "2010-11-05 00:00:09.5"
        ) from None


def _areas(header: str, rows: Iterable[tuple[str, str]]) -> str:
    """Return the file that maps devices or activities to rooms, separated by semicolons."""
    return "".join(f"{first};{room}\r\n" for first, room in [(header, "area"), *rows])


def _rooms(log: Log, activity: str) -> list[str]:
    return sorted({a.room for a in log.activities if a.activity == activity})


def _file_part(person: str) -> str:
    return re.sub(r"[^\w-]", "_", person) or NOBODY


def _notes(log: Log) -> tuple[str, ...]:
    texts = [f"{c.sensor.name} {c.field}" for c in log.channels if c.type is str]
    return (
        (f"pyadlml has no devices with text values, so these were left out: {', '.join(texts)}",)
        if texts
        else ()
    )
