# SPDX-License-Identifier: GPL-3.0-or-later
"""Home Assistant's MQTT discovery and states: a line of JSON for each message, in order.

https://www.home-assistant.io/integrations/mqtt/#discovery-messages: each sensor is a device with
its room as suggested area, each field an entity. A line has `time_s`, `time` (ISO 8601), `topic`,
`payload` and `retain`. A broker stamps messages when they arrive: whoever sends them keeps time.
"""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

from ..event_log import format_value
from .log import Channel, Log, SensorFacts, Value
from .names import slug, unique
from .read import DatedChange, Read
from .written import Written

STATUS = "angen/status"
# Quantity → device class. A force in newtons has none: pressure is in pascals, weight in kilograms.
BINARY_CLASSES = {
    "motion": "motion",
    "opening": "door",
    "occupancy": "occupancy",
    "light": "light",
}
NUMBER_CLASSES = {"illuminance": "illuminance", "distance": "distance"}


def write(log: Log) -> Written:
    """Discovery, "online", then every state as it changes, and "offline" at the end."""
    topics = unique((sensor.name for sensor in log.sensors), slug)
    messages = [(0, *message) for message in discovery(log, topics)]
    messages.append((0, STATUS, "online", True))
    last = 0
    for change in log.changes:
        last = change.time
        topic = _state_topic(topics, change.channel)
        messages.append((change.time, topic, payload(change.channel, change.value), True))
    messages.append((last, STATUS, "offline", True))
    lines = []
    for time, topic, text, retain in messages:
        message = {
            "time_s": time / 1e6,
            "time": log.local(time).isoformat(timespec="microseconds"),
            "topic": topic,
            "payload": text,
            "retain": retain,
        }
        lines.append(json.dumps(message, ensure_ascii=False) + "\n")
    return Written({"": "".join(lines)})


def discovery(log: Log, topics: dict[str, str]) -> list[tuple[str, str, bool]]:
    """(topic, payload, retained) that makes each sensor a device of Home Assistant."""
    found = []
    for sensor in log.sensors:
        channels = [channel for channel in log.channels if channel.sensor is sensor]
        name = topics[sensor.name]
        config = json.dumps(_config(sensor, name, channels, log), ensure_ascii=False)
        found.append((f"homeassistant/device/angen_{name}/config", config, True))
    return found


def _config(sensor: SensorFacts, name: str, channels: list[Channel], log: Log) -> dict[str, Any]:
    device = {
        "ids": [f"angen_{name}"],
        "name": sensor.name,
        "mf": "Ängen Sensors",
        "mdl": f"simulated {sensor.kind}",
    }
    if sensor.room:
        device["sa"] = sensor.room
    return {
        "dev": device,
        "o": {"name": "angen-sensors", "sw": log.about.get("versions.angen_sensors", "unknown")},
        "cmps": {c.field: _entity(name, c, len(channels) == 1) for c in channels},
        "availability_topic": STATUS,
    }


def _entity(name: str, channel: Channel, is_only: bool) -> dict[str, Any]:
    entity: dict[str, Any] = {
        "p": "binary_sensor" if channel.type is bool else "sensor",
        "unique_id": f"angen_{name}_{channel.field}",
        "name": None if is_only else channel.field,
        "state_topic": f"angen/{name}/{channel.field}",
    }
    if channel.type is bool:
        entity |= {"payload_on": "ON", "payload_off": "OFF"}
        device_class = BINARY_CLASSES.get(channel.quantity)
    else:
        if channel.type is not str:
            entity["state_class"] = "measurement"
            if channel.unit:
                entity["unit_of_measurement"] = channel.unit
        device_class = NUMBER_CLASSES.get(channel.quantity)
    if device_class:
        entity["device_class"] = device_class
    return entity


def _state_topic(topics: dict[str, str], channel: Channel) -> str:
    return f"angen/{topics[channel.sensor.name]}/{channel.field}"


def payload(channel: Channel, value: Value) -> str:
    if channel.type is bool:
        return "ON" if value else "OFF"
    return format_value(value)


def read(path: Path) -> Read:
    """The states of sensors that messages of discovery made known."""
    found = Read([])
    known: dict[str, tuple[str, str, str]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        message = json.loads(line)
        topic, text = message["topic"], message["payload"]
        if topic.endswith("/config"):
            config = json.loads(text)
            name, kind = config["dev"]["name"], config["dev"]["mdl"].rpartition(" ")[2]
            found.rooms[name] = config["dev"].get("sa", "")
            for field, entity in config["cmps"].items():
                known[entity["state_topic"]] = name, kind, field
        elif topic in known:
            value = {"ON": "1", "OFF": "0"}.get(text, text)
            found.changes.append(
                DatedChange(datetime.fromisoformat(message["time"]), *known[topic], value)
            )
    return found
