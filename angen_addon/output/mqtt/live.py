# SPDX-License-Identifier: GPL-3.0-or-later
"""Sending of the readings at the playhead to a broker, while Blender's window is in use."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ....sensor_logic.logs.error import AngenError
from ....sensor_logic.logs.formats.home_assistant import OFFLINE, HomeMessages
from ....sensor_logic.logs.formats.log import Change, Channel
from ....sensor_logic.logs.formats.source import channel_of
from ....sensor_logic.logs.log import Value
from ....sensor_logic.logs.wording import plural
from ....sensor_logic.parameters import is_chosen
from ....sensor_logic.recording.events import as_event
from ...process.version import extension_version
from ...runtime.playhead import Playhead
from ...scene.sensors import Sensor
from ..run_log import sensor_facts
from .address import AT_ONCE, Address
from .link import Link
from .player import SLICE_S, Player

# s: longest wait for the last messages when sending stops.
STOP_S = 2.0
Key = tuple[str, str]


class LiveSender:
    """Sends readings to a broker from a thread, until it is stopped.

    Parameters
    ----------
    address
        The address of the broker.
    sensors
        The sensors whose readings are sent.
    topic
        The first part of all topics.

    Raises
    ------
    AngenError
        If paho-mqtt is missing.
    """

    def __init__(self, address: Address, sensors: Sequence[Sensor], topic: str) -> None:
        self._address = address
        self._steps: dict[Key, float] = {}
        self._channels: dict[Key, Channel] = {}
        for sensor, published in _published(sensors):
            key = sensor.name, published.name
            self._channels[key] = channel_of(sensor_facts(sensor), published)
            self._steps[key] = getattr(sensor.parameters, published.step or "", 0.0)
        home = HomeMessages(self._channels.values(), topic, extension_version())
        self._player = Player(Link(address, home.status(OFFLINE)), home, AT_ONCE, self._check)
        self._last: dict[Key, Value] = {}
        self._changes: queue.SimpleQueue[Change] = queue.SimpleQueue()
        self._sent = 0
        self._is_connected = False
        self._stop = threading.Event()
        self._error = ""
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self, readings: Mapping[Key, Any]) -> None:
        """Connect, announce the sensors with their present readings, and send from then on."""
        for change in self._new(readings):
            self._last[change.channel.sensor.name, change.channel.field] = change.value
        self._thread.start()

    def show(self, readings: Mapping[Key, Any]) -> None:
        """Send the readings that have changed.

        `readings` has values by the names of sensor and field. A number must have changed by its
        report step, as in the event log.
        """
        for change in self._new(readings):
            self._last[change.channel.sensor.name, change.channel.field] = change.value
            self._changes.put(change)

    def stop(self) -> None:
        """Mark the sensors "unavailable" and disconnect; wait for that at most STOP_S."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(STOP_S)

    @property
    def is_alive(self) -> bool:
        """Whether it connects or sends."""
        return self._thread.is_alive()

    @property
    def error(self) -> str:
        """Why it has ended; empty if it goes on, or was stopped."""
        return self._error

    @property
    def state(self) -> str:
        """A line for the user on what it does."""
        if not self._is_connected:
            return f"Connecting to {self._address}"
        if self._player.is_lost:
            return "Connection lost, trying again"
        return f"Sent {plural(self._sent, 'reading')} to {self._address}"

    def sends_all_of(self, sensors: Sequence[Sensor]) -> bool:
        """Return whether it announced exactly these sensors' fields."""
        now = {(sensor.name, published.name) for sensor, published in _published(sensors)}
        return now == self._channels.keys()

    def _new(self, readings: Mapping[Key, Any]) -> Iterator[Change]:
        for key, value in readings.items():
            channel = self._channels.get(key)
            if channel is None or value is None:
                continue
            logged = as_event(channel.type(value), self._last.get(key), self._steps[key])
            if logged is not None:
                yield Change(0, channel, logged)

    def _check(self) -> None:
        if self._stop.is_set():
            raise InterruptedError

    def _run(self) -> None:
        try:
            states = {self._channels[key]: value for key, value in self._last.items()}
            self._player.begin(states)
            self._is_connected = True
            while True:
                try:
                    change = self._changes.get(timeout=SLICE_S)
                except queue.Empty:
                    self._player.idle()
                    continue
                self._player.play([change])
                self._sent += 1
        except InterruptedError:
            pass
        except AngenError as error:
            self._error = str(error)
        except OSError as error:
            self._error = f"the connection to {self._address} failed: {error}"
        finally:
            self._player.end()


def _published(sensors: Sequence[Sensor]) -> Iterator[tuple[Sensor, Any]]:
    """Yield each sensor with each field that it publishes."""
    for sensor in sensors:
        for published in sensor.kind.events:
            if is_chosen(sensor.parameters, published.used_when):
                yield sensor, published


def present_readings(scene: Any, sensors: Sequence[Sensor]) -> dict[Key, Any]:
    """Return the values at the playhead by the names of sensor and field.

    Values that were not measured, and readings with a problem, are left out.
    """
    playhead, found = Playhead(scene), {}
    for sensor in sensors:
        shown = playhead.of(sensor, sensor.kind.reading(sensor.parameters))
        if shown.reading is None or shown.problem:
            continue
        for published in sensor.kind.events:
            value = shown.reading.fields.get(published.name)
            if value is not None:
                found[sensor.name, published.name] = value
    return found
