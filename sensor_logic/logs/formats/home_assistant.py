# SPDX-License-Identifier: GPL-3.0-or-later
"""MQTT messages for Home Assistant, and a file of these messages.

Discovery messages describe the sensors, state messages have their values:
https://www.home-assistant.io/integrations/mqtt/#discovery-messages. Each sensor is a device with
its room as suggested area, and each field is an entity. A line of the file has `time_s`, `time`
(ISO 8601), `topic`, `payload` and `retain`. Home Assistant stamps a message with the time at which
it arrives. So the messages must be sent at their times, as `angen replay` does.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

from ..log import Event, Value, format_value
from .log import Channel, FormatFiles, Log, SensorFacts, slug, unique
from .source import ParsedLog

TOPIC = "angen"
# The discovery topics, with `*` for a sensor's identifier.
CONFIGS = "homeassistant/device/*/config"
PROGRAM = "angen-sensors"
ONLINE, OFFLINE = "online", "offline"
# Home Assistant's payload for an unknown state.
UNKNOWN = "None"
# The payload for an empty text. An empty payload would delete the state that the broker retains.
NO_TEXT = "–"
VALUES: dict[str, Value] = {"ON": True, "OFF": False, NO_TEXT: ""}
# Home Assistant rejects a longer state.
LONGEST = 255
# The device class of a quantity. A force in newtons has none: pressure is in Pa, weight in kg.
BINARY_CLASSES = {
    "motion": "motion",
    "opening": "door",
    "occupancy": "occupancy",
    "proximity": "occupancy",
    "light": "light",
    "operation": "running",
    "flow": "running",
}
NUMBER_CLASSES = {q: q for q in ("illuminance", "distance", "temperature", "power")}


class Message(NamedTuple):
    """An MQTT message, which the broker retains for later subscribers."""

    topic: str
    payload: str


class HomeMessages:
    """Makes the MQTT messages of a home's sensors.

    All topics begin with `topic`, except the topics of discovery messages.
    """

    def __init__(
        self, channels: Iterable[Channel], topic: str = TOPIC, version: str = "unknown"
    ) -> None:
        self.topic, self.channels = topic, list(channels)
        self._version = version
        self._names = unique((channel.sensor.name for channel in self.channels), slug)

    def status(self, payload: str) -> Message:
        """Return the message that all sensors are available or not.

        `payload` is ONLINE, or OFFLINE, for which Home Assistant shows sensors as "unavailable".
        """
        return Message(f"{self.topic}/status", payload)

    def discovery(self) -> list[Message]:
        """Return the discovery messages, one for each sensor."""
        channels: dict[str, list[Channel]] = {name: [] for name in self._names}
        for channel in self.channels:
            channels[channel.sensor.name].append(channel)
        return [
            Message(
                CONFIGS.replace("*", self._identifier(name)),
                json.dumps(self._config(found[0].sensor, found), ensure_ascii=False),
            )
            for name, found in channels.items()
        ]

    def state(self, channel: Channel, value: Value | None) -> Message:
        """Return the message with a new value of a channel; None is an unknown value."""
        return Message(
            f"{self.topic}/{self._names[channel.sensor.name]}/{channel.field}",
            UNKNOWN if value is None else payload(channel, value),
        )

    def _identifier(self, sensor: str) -> str:
        return f"{slug(self.topic)}_{self._names[sensor]}"

    def _config(self, sensor: SensorFacts, channels: list[Channel]) -> dict[str, Any]:
        device = {
            "ids": [self._identifier(sensor.name)],
            "name": sensor.name,
            "mf": "Ängen Sensors",
            "mdl": f"simulated {sensor.kind}",
        }
        if sensor.room:
            device["sa"] = sensor.room
        return {
            "dev": device,
            "o": {"name": PROGRAM, "sw": self._version},
            "cmps": {c.field: self._entity(c, len(channels) == 1) for c in channels},
            "availability_topic": self.status(ONLINE).topic,
        }

    def _entity(self, channel: Channel, is_only: bool) -> dict[str, Any]:
        entity: dict[str, Any] = {
            "p": "binary_sensor" if channel.type is bool else "sensor",
            "unique_id": f"{self._identifier(channel.sensor.name)}_{channel.field}",
            "name": None if is_only else channel.field,
            "state_topic": self.state(channel, None).topic,
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


def payload(channel: Channel, value: Value) -> str:
    """Return the payload of the message with a channel's value; it is never empty."""
    if channel.type is bool:
        return "ON" if value else "OFF"
    if isinstance(value, float) and not math.isfinite(value):
        return UNKNOWN
    text = format_value(value) or NO_TEXT
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


def is_config_of(topic: str, message: Message) -> bool:
    """Return whether a discovery message is from this program, with `topic` as the home's topic."""
    try:
        config = json.loads(message.payload)
        return bool(
            config["o"]["name"] == PROGRAM and config["availability_topic"] == f"{topic}/status"
        )
    except (ValueError, TypeError, KeyError):
        return False


def write(log: Log) -> FormatFiles:
    """Return the log as MQTT messages, one a line.

    The discovery messages and "online" come first, then every change of a state, then "offline".
    """
    home = HomeMessages(log.channels, version=log.about.get("versions.angen_sensors", "unknown"))
    messages = [(0, message) for message in (*home.discovery(), home.status(ONLINE))]
    for change in log.changes:
        messages.append((change.time, home.state(change.channel, change.value)))
    messages.append((log.changes[-1].time if log.changes else 0, home.status(OFFLINE)))
    lines = []
    for time, (topic, text) in messages:
        message = {
            "time_s": time / 1e6,
            "time": log.local(time).isoformat(timespec="microseconds"),
            "topic": topic,
            "payload": text,
            "retain": True,
        }
        lines.append(json.dumps(message, ensure_ascii=False) + "\n")
    return FormatFiles({"": "".join(lines)})


def read(path: Path) -> ParsedLog:
    """Read the changes from a file of messages, for sensors that have a discovery message in it."""
    found = ParsedLog([])
    known: dict[str, tuple[str, str, str]] = {}
    # Not `splitlines`: names can contain U+2028, which JSON does not escape.
    lines = path.read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            message = json.loads(line)
            topic, text = message["topic"], message["payload"]
        except KeyError as error:
            raise ValueError(f"line {number} has no {error}") from None
        except ValueError:
            raise ValueError(f"line {number} is not JSON") from None
        if topic.endswith("/config"):
            config = json.loads(text)
            name, kind = config["dev"]["name"], config["dev"]["mdl"].rpartition(" ")[2]
            found.rooms[name] = config["dev"].get("sa", "")
            for field, entity in config["cmps"].items():
                known[entity["state_topic"]] = name, kind, field
        elif topic in known:
            value = VALUES.get(text, text)
            time = datetime.fromisoformat(message["time"])
            name, kind, field = known[topic]
            found.changes.append(Event(time, name, field, 0.0, kind, value, number))
    return found
