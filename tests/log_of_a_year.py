# SPDX-License-Identifier: GPL-3.0-or-later
"""A log with every kind of sensor, awkward names, two people and a whole year."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

from angen_sensors.sensor_logic.logs.files import write_files
from angen_sensors.sensor_logic.logs.formats import FORMATS, outputs
from angen_sensors.sensor_logic.logs.formats.log import Log, LoggedActivity, SensorFacts
from angen_sensors.sensor_logic.logs.formats.source import make_log
from angen_sensors.sensor_logic.logs.log import Event

START = datetime(2026, 3, 2, 7, 0, 0)
YEAR = 365 * 86400.0
AWKWARD = 'Küche, "links"; = 2\\'
SENSORS = {
    "PIR hall": SensorFacts("PIR hall", "PIR", "hall"),
    "pir-hall": SensorFacts("pir-hall", "PIR", "hall"),
    AWKWARD: SensorFacts(AWKWARD, "PIR", "kitchen, small"),
    "Switch": SensorFacts("Switch", "OPTICAL_SWITCH", "", {"range_max": 0.4}),
    "Pad": SensorFacts("Pad", "PRESSURE", "living room"),
    "Percent": SensorFacts("Percent", "LIGHT", "hall"),
    "Lux": SensorFacts("Lux", "LIGHT", "hall"),
    "Tof": SensorFacts(
        "Tof", "DISTANCE", "hall", {"horizontal_fov": 0.5, "range_min": 0.04, "range_max": 3.6}
    ),
    "Front door": SensorFacts("Front door", "CONTACT", "hall"),
}
ROWS = [
    (0.0, "Front door", "open", "0"),
    (0.0, "Lux", "illuminance_lux", "0.1"),
    (0.0, "Lux", "lit", "0"),
    (0.0, "PIR hall", "moved", "0"),
    (0.0, "Pad", "force_n", "34.671246"),
    (0.0, "Pad", "partners", ""),
    (0.0, "Pad", "pressed", "1"),
    (0.0, "Pad", "valid", "1"),
    (0.0, "Percent", "lit", "0"),
    (0.0, "Percent", "luminance_percent", "45.88486"),
    (0.0, "Switch", "open", "0"),
    (0.0, "Tof", "distance_m", "3.6"),
    (0.0, "Tof", "near", "0"),
    (0.0, AWKWARD, "moved", "0"),
    (0.0, "pir-hall", "moved", "1"),
    (2.833333, "PIR hall", "moved", "1"),
    (3.000001, "Switch", "open", "1"),
    (3.625, "PIR hall", "moved", "0"),
    (3.75, "Tof", "distance_m", "0.8125"),
    (3.75, "Tof", "near", "1"),
    (3.8, "Front door", "open", "1"),
    (4.0, "Pad", "partners", 'Anna;Box "1"'),
    (4.0, "Pad", "force_n", "700.5"),
    (5.0, "pir-hall", "moved", "0"),
    (6.0, AWKWARD, "moved", "1"),
    (7.0, "Switch", "open", "0"),
    (8.0, "Lux", "illuminance_lux", "1445.25"),
    (8.0, "Lux", "lit", "1"),
    (YEAR - 0.000001, "PIR hall", "moved", "1"),
    (YEAR, "PIR hall", "moved", "0"),
]
ACTIVITIES = (
    LoggedActivity(2_000_000, 4_500_000, "Anna", "Enter home", "hall"),
    LoggedActivity(5_000_000, 8_000_000, "Bo", "Cook, eat", "kitchen, small"),
)
ABOUT = {"seed": "7", "versions.angen_sensors": "0.1.0", "home": "Ängen"}


def year(rows: Iterable[tuple[float, str, str, str]] = ROWS, **changed: object) -> Log:
    """Return the log; `changed` replaces arguments of `make_log` other than the events."""
    events = [
        Event(time, sensor, field, 1.0 + 24 * time, SENSORS[sensor].kind, value)
        for time, sensor, field, value in rows
    ]
    given: dict = {"start": START, "activities": ACTIVITIES, "about": ABOUT} | changed
    return make_log(events, SENSORS, **given)


def write(log: Log, name: str, out: Path) -> Path:
    """Write a log in a format into a file or folder; return its path."""
    target = FORMATS[name]
    files = outputs.output_files(target, out, target.write(log))
    if target.is_folder:
        out.mkdir()
    write_files(files)
    return out
