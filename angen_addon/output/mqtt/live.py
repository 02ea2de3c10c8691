# SPDX-License-Identifier: GPL-3.0-or-later
"""Sending of the readings at the playhead to a broker, while Blender's window is in use."""

from __future__ import annotations

import queue
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ....sensor_logic.logs.error import AngenError
from ....sensor_logic.logs.fields import Field
from ....sensor_logic.logs.formats.home_assistant import OFFLINE, HomeMessages, Message
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
from .address import AT_ONCE, Address, Words
from .link import Link
from .player import SLICE_S, Player, forget

# s: longest wait for the last messages when sending stops.
STOP_S = 2.0
Key = tuple[str, str]
WORDS = Words(
    authority="Authority",
    tls="TLS",
    without_tls="switch TLS off",
    credentials="give User and Password",
    clash="Blender or replay sends them: end that, or give another Topic; if there is none, press "
    "Remove",
)


class BrokerThread(ABC):
    """Work at a broker in a thread, until it has ended or is stopped."""

    def __init__(self, address: Address) -> None:
        self._address = address
        self._stop = threading.Event()
        self._error = ""
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the work; wait for its end at most STOP_S."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(STOP_S)

    @property
    def is_alive(self) -> bool:
        """Whether it works."""
        return self._thread.is_alive()

    @property
    def is_stopped(self) -> bool:
        """Whether `stop` was called; its work may still wait for the broker to answer."""
        return self._stop.is_set()

    @property
    def error(self) -> str:
        """Why it has failed; empty if it goes on, was stopped or has done its work."""
        return self._error

    @property
    def state(self) -> str:
        """A line for the user on what it does, or has done."""
        if self.is_stopped:
            return f"Stopping, waiting for {self._address}"
        return f"Connecting to {self._address}"

    @abstractmethod
    def _work(self) -> None:
        """Do the work; it ends with `InterruptedError` if `_check`, called meanwhile, raises it."""

    def _check(self) -> None:
        if self._stop.is_set():
            raise InterruptedError

    def _run(self) -> None:
        try:
            self._work()
        except InterruptedError:
            pass
        except AngenError as error:
            self._error = str(error)
        except OSError as error:
            self._error = f"the connection to {self._address} failed: {error}"


class LiveSender(BrokerThread):
    """Sends readings to a broker.

    Parameters
    ----------
    address
        The address of the broker.
    topic
        The first part of all topics.
    sensors
        The sensors whose readings are sent, until `show` gets others.
    readings
        The present values by the names of sensor and field.

    Raises
    ------
    AngenError
        If paho-mqtt is missing.
    """

    def __init__(
        self, address: Address, topic: str, sensors: Sequence[Sensor], readings: Mapping[Key, Any]
    ) -> None:
        super().__init__(address)
        self._topic = topic
        self._last: dict[Key, Value] = {}
        self._channels: dict[Key, Channel] = {}
        self._announced: list[Any] | None = None
        self._due: queue.SimpleQueue[Change | _Home] = queue.SimpleQueue()
        self._is_connected = False
        self.show(sensors, readings)
        first = self._due.get_nowait()
        assert isinstance(first, _Home)
        self._first, home = first, first.messages
        self._player = Player(Link(address, home.status(OFFLINE)), home, AT_ONCE, self._check)

    def show(self, sensors: Sequence[Sensor], readings: Mapping[Key, Any]) -> None:
        """Send the readings that have changed; announce the sensors if they have changed.

        A number must have changed by its report step, as in the event log.
        """
        published = {(s.name, field.name): (s, field) for s, field in _published(sensors)}
        facts = [(s.name, s.kind, s.room, field) for s, field in published.values()]
        is_new = facts != self._announced
        if is_new:
            self._announced = facts
            self._channels = {
                key: channel_of(sensor_facts(sensor), field)
                for key, (sensor, field) in published.items()
            }
            self._last = {key: last for key, last in self._last.items() if key in published}
        changes = []
        for key, (sensor, field) in published.items():
            if readings.get(key) is None:
                continue
            step = getattr(sensor.parameters, field.step or "", 0.0)
            value = as_event(field.type(readings[key]), self._last.get(key), step)
            if value is not None:
                self._last[key] = value
                changes.append(Change(0, self._channels[key], value))
        if is_new:
            states = {self._channels[key]: value for key, value in self._last.items()}
            messages = HomeMessages(self._channels.values(), self._topic, extension_version())
            self._due.put(_Home(messages, states))
        else:
            for change in changes:
                self._due.put(change)

    @property
    def state(self) -> str:
        """A line for the user on what it does."""
        if self.is_stopped or not self._is_connected:
            return super().state
        if self._player.is_lost:
            return "Connection lost, trying again"
        return f"Connected to {self._address}: sent {plural(self._player.sent, 'change')}"

    def _work(self) -> None:
        player = self._player
        try:
            player.begin(self._first.states)
            self._is_connected = True
            while True:
                try:
                    due = self._due.get(timeout=SLICE_S)
                except queue.Empty:
                    player.idle()
                    continue
                if isinstance(due, _Home):
                    player.change_home(due.messages, due.states)
                else:
                    player.play([due])
        finally:
            player.end()


class Remover(BrokerThread):
    """Removes the sensors below a topic from a broker."""

    def __init__(self, address: Address, topic: str) -> None:
        super().__init__(address)
        self._link, self._topic = Link(address, Message(f"{topic}/status", OFFLINE)), topic
        self._removed: int | None = None

    @property
    def state(self) -> str:
        """A line for the user on what it does, or has done."""
        if self._removed is None:
            return super().state
        return f"Removed {plural(self._removed, 'sensor')} from {self._address}"

    def _work(self) -> None:
        self._removed = len(forget(self._link, self._topic))


class _Home(NamedTuple):
    """The messages of a home, and the present values of its channels."""

    messages: HomeMessages
    states: dict[Channel, Value]


def _published(sensors: Sequence[Sensor]) -> Iterator[tuple[Sensor, Field]]:
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
