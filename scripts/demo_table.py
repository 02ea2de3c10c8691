# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of `make demo`: a summary of each sensor's readings, from the files of one run."""

import csv
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from sensor_logic.kinds import KINDS
from sensor_logic.logs.wording import aligned, short

HEADER = ("room", "sensor", "kind", "events", "first s", "last s", "active", "max")
NAME_COLUMNS = 3


@dataclass(frozen=True)
class Report:
    """The summary of one sensor.

    The times of its changes (s), the share of time in which it was active (0..1), and the greatest
    value with its unit, if its kind reports a number.
    """

    changes: list[float]
    active: float
    greatest: str = ""


def change_times(event_log: Iterable[str]) -> dict[str, list[float]]:
    """Return each sensor's times of change (s) in an event log, without its first update."""
    times: dict[str, list[float]] = {}
    first: dict[str, str] = {}
    for row in csv.DictReader(event_log):
        changes = times.setdefault(row["sensor"], [])
        if first.setdefault(row["sensor"], row["time_s"]) != row["time_s"]:
            changes.append(float(row["time_s"]))
    return times


def active_share(samples: Iterable[str], kind: str) -> float:
    """Return the share (0..1) of a sensor's samples in which it was active; 0 without samples."""
    field = next(f.name for f in KINDS[kind].events if f.type is bool)
    states = [line[field] for line in csv.DictReader(samples)]
    return states.count("1") / max(len(states), 1)


def greatest(samples: Iterable[str], units: Mapping[str, str]) -> str:
    """Return the greatest valid value of the first field that has a unit.

    `units` are the units of the sensor's fields.
    """
    lines = [line for line in csv.DictReader(samples) if line.get("valid", "1") == "1"]
    for field, unit in units.items():
        values = [float(line[field]) for line in lines if unit and line.get(field)]
        if values:
            return short(max(values), unit)
    return ""


def last_time(samples: Iterable[str]) -> float:
    """Return the time (s) of a sensor's last sample; 0 without samples."""
    return max((float(line["time_s"]) for line in csv.DictReader(samples)), default=0.0)


def row(sensor: Mapping[str, Any], report: Report) -> tuple[str, ...]:
    """Return a line of the table for a sensor as `list --json` describes it."""
    kind = sensor["kind"].lower().replace("_", " ")
    start = (sensor["room"] or "-", sensor["name"], kind)
    changes = [f"{time:.1f}" for time in report.changes] or ["-"]
    count = str(len(report.changes))
    return (*start, count, changes[0], changes[-1], f"{report.active:.1%}", report.greatest)


def table(rows: Sequence[tuple[str, ...]]) -> str:
    """Return rows under the header in columns: names to the left, figures to the right."""
    text = aligned([HEADER, *rows], NAME_COLUMNS)
    return "\n".join([text[0], "-" * len(text[0]), *text[1:]])
