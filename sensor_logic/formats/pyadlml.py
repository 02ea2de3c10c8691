# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder that pyadlml reads with `load_act_assist`: devices, activities and their maps.

A device is a field of a sensor. Maps number devices and activities and tell their rooms; columns
and times are as in pyadlml's `activity_assistant.py`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path

from ..log.event_log import format_value, to_csv
from . import key
from .log import Log, titles
from .names import unique
from .read import Read
from .written import Written

TIME = "%d.%m.%Y %H:%M:%S.%f"
# Not of pyadlml: kinds, fields and units.
SENSORS = "sensors.csv"
# pyadlml wants one subject at least.
NOBODY = "R1"


def write(log: Log) -> Written:
    """Every change, the states at the start among them; text and units have no place here."""
    told = {c: title for c, title in titles(log.channels).items() if c.type is not str}
    device = {channel: str(number) for number, channel in enumerate(told)}
    names = sorted({a.activity for a in log.activities})
    activity = {name: str(number) for number, name in enumerate(names)}

    def clock(time: int) -> str:
        return log.local(time).strftime(TIME)

    files: dict[str, str | bytes] = {
        "devices.csv": to_csv(
            ("time", "device", "value"),
            (
                (clock(change.time), device[change.channel], format_value(change.value))
                for change in log.changes
                if change.channel in device
            ),
        ),
        "device_map.csv": to_csv(("id", "device"), ((device[c], told[c]) for c in told)),
        SENSORS: key.to_text(log, device),
        "device_area_map.csv": _areas("device", ((device[c], c.sensor.room) for c in told)),
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
    return Written(files, _notes(log))


def read(folder: Path) -> Read:
    """The devices' changes, of this program or of another, without the activities.

    Where no file tells of the sensors, they are taken for what their names say.
    """
    found = key.read_rows(folder / SENSORS, _rows(folder), told_at_start=True)
    found.has_activities = any(
        path.read_bytes().count(b"\n") > 1 for path in folder.glob("activities_*.csv")
    )
    return found


def _rows(folder: Path) -> Iterator[tuple[datetime, str, str]]:
    is_ours = (folder / SENSORS).is_file()
    with open(folder / "device_map.csv", newline="", encoding="utf-8-sig") as file:
        names = {row["id"]: row["device"] for row in csv.DictReader(file)}
    with open(folder / "devices.csv", newline="", encoding="utf-8-sig") as file:
        for row in csv.DictReader(file):
            name = row["device"] if is_ours else names[row["device"]]
            is_state = row["value"] in {"0", "1"} and not is_ours
            value = ("OFF", "ON")[int(row["value"])] if is_state else row["value"]
            yield datetime.strptime(row["time"], TIME), name, value


def _areas(of: str, rows: Iterable[tuple[str, str]]) -> str:
    """A map of rooms, which pyadlml reads with semicolons."""
    return "".join(f"{first};{room}\r\n" for first, room in [(of, "area"), *rows])


def _rooms(log: Log, activity: str) -> list[str]:
    return sorted({a.room for a in log.activities if a.activity == activity})


def _file_part(person: str) -> str:
    return re.sub(r"[^\w-]", "_", person) or NOBODY


def _notes(log: Log) -> tuple[str, ...]:
    texts = [f"{c.sensor.name} {c.field}" for c in log.channels if c.type is str]
    return (
        (f"pyadlml has no devices that tell text, left out: {', '.join(texts)}",) if texts else ()
    )
