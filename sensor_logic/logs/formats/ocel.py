# SPDX-License-Identifier: GPL-3.0-or-later
"""OCEL 2.0 as JSON: object-centric event logs (https://www.ocel-standard.org/2.0/).

The objects are sensors, rooms and people. The events are changes of sensors' fields, and the begin
and end of each activity. An event refers to the objects that it involves.
"""

from __future__ import annotations

import json
from typing import Any

from ..log import format_value
from .log import Change, FormatFiles, Log, LoggedActivity, SensorFacts

TYPES = {bool: "boolean", float: "float", int: "integer", str: "string"}
ACTIVITY_TYPES = ("activity begins", "activity ends")


def write(log: Log) -> FormatFiles:
    """Return the log as OCEL: all changes, including initial states, and all activities."""
    timed = [(c.time, _change(log, number, c)) for number, c in enumerate(log.changes)]
    timed += _activities(log, len(timed))
    # Sorted by elapsed time, because local times are out of order when daylight saving ends.
    events = [event for _, event in sorted(timed, key=lambda pair: pair[0])]
    found = {
        "objectTypes": _object_types(),
        "eventTypes": _event_types(log),
        "objects": _objects(log),
        "events": events,
    }
    return FormatFiles({"": json.dumps(found, ensure_ascii=False, indent=1) + "\n"})


def _object_types() -> list[dict[str, Any]]:
    sensor = [{"name": name, "type": "string"} for name in ("name", "kind")]
    name = [{"name": "name", "type": "string"}]
    return [
        {"name": "sensor", "attributes": sensor},
        {"name": "room", "attributes": name},
        {"name": "person", "attributes": name},
    ]


def _event_types(log: Log) -> list[dict[str, Any]]:
    found = {
        channel.field: [
            {"name": "value", "type": TYPES[channel.type]},
            {"name": "unit", "type": "string"},
        ]
        for channel in log.channels
    }
    if log.activities:
        found |= {name: [{"name": "activity", "type": "string"}] for name in ACTIVITY_TYPES}
    return [{"name": name, "attributes": attributes} for name, attributes in found.items()]


def _objects(log: Log) -> list[dict[str, Any]]:
    begin = log.iso(0)
    rooms = {s.room for s in log.sensors} | {a.room for a in log.activities}
    people = {a.person for a in log.activities}
    found = [_sensor(sensor, begin) for sensor in log.sensors]
    for what, names in (("room", rooms - {""}), ("person", people - {""})):
        found += [
            {
                "id": f"{what}:{name}",
                "type": what,
                "attributes": [{"name": "name", "time": begin, "value": name}],
            }
            for name in sorted(names)
        ]
    return found


def _sensor(sensor: SensorFacts, begin: str) -> dict[str, Any]:
    found: dict[str, Any] = {
        "id": f"sensor:{sensor.name}",
        "type": "sensor",
        "attributes": [
            {"name": "name", "time": begin, "value": sensor.name},
            {"name": "kind", "time": begin, "value": sensor.kind},
        ],
    }
    if sensor.room:
        found["relationships"] = [{"objectId": f"room:{sensor.room}", "qualifier": "hangs in"}]
    return found


def _change(log: Log, number: int, change: Change) -> dict[str, Any]:
    channel, value = change.channel, change.value
    written = value if isinstance(value, (bool, str)) else float(format_value(value))
    attributes: list[dict[str, Any]] = [{"name": "value", "value": written}]
    if channel.unit:
        attributes.append({"name": "unit", "value": channel.unit})
    related = [_relation(f"sensor:{channel.sensor.name}", "reported by")]
    if channel.sensor.room:
        related.append(_relation(f"room:{channel.sensor.room}", "in"))
    return {
        "id": f"e{number}",
        "type": channel.field,
        "time": log.iso(change.time),
        "attributes": attributes,
        "relationships": related,
    }


def _activities(log: Log, number: int) -> list[tuple[int, dict[str, Any]]]:
    found: list[tuple[int, dict[str, Any]]] = []
    for activity in log.activities:
        for kind, time in zip(ACTIVITY_TYPES, (activity.start, activity.end), strict=True):
            event = {
                "id": f"e{number + len(found)}",
                "type": kind,
                "time": log.iso(time),
                "attributes": [{"name": "activity", "value": activity.activity}],
                "relationships": _who_and_where(activity),
            }
            found.append((time, event))
    return found


def _who_and_where(activity: LoggedActivity) -> list[dict[str, str]]:
    found = []
    if activity.person:
        found.append(_relation(f"person:{activity.person}", "done by"))
    if activity.room:
        found.append(_relation(f"room:{activity.room}", "in"))
    return found


def _relation(identifier: str, qualifier: str) -> dict[str, str]:
    return {"objectId": identifier, "qualifier": qualifier}
