# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays a home's readings to a broker: announces its sensors, publishes their readings, and marks
them unavailable at the end.
"""

from __future__ import annotations

import argparse
import json
import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress

from ....sensor_logic.error import AngenError
from ....sensor_logic.formats.home_assistant import (
    CONFIGS,
    OFFLINE,
    ONLINE,
    TOPIC,
    HomeMessages,
    Message,
    is_config_of,
)
from ....sensor_logic.formats.log import Change, Channel
from ....sensor_logic.formats.source import channel_of, make_log
from ....sensor_logic.log import NewEvents, Value
from ....sensor_logic.parameters import is_chosen
from ....sensor_logic.recording.tracks import Recording
from ...commands.console import note
from ...scene.sensors import Sensor
from ..run_log import extension_version, sensor_facts
from .address import Address
from .link import PARTING_S, Link

# Waits until the events of a log are due, at any speed.

# s: `idle` is called this often while waiting.
SLICE_S = 0.2


class Pace:
    """Plays a log at `speed` times real time (0: without waiting).

    Each time is measured from the start, on a clock that never jumps, so that one late event does
    not delay those after it.
    """

    def __init__(
        self,
        speed: float,
        idle: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.is_at_once = speed == 0.0
        self._speed, self._idle = speed, idle
        self._clock, self._sleep = clock, sleep
        self._begin = 0.0
        self._at = 0

    def start(self, at: int) -> None:
        """Starts the clock: `at` (microseconds of the log) is now."""
        self._begin, self._at = self._clock(), at

    def wait(self, until: int) -> float:
        """Waits until a time of the log (microseconds) is due; returns by how many seconds it is
        late. Calls `idle` at least once, which may raise."""
        self._idle()
        if self.is_at_once:
            return 0.0
        due = self._begin + (until - self._at) / 1e6 / self._speed
        while (left := due - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()
        return self._clock() - due

    def rest(self, seconds: float) -> None:
        """Waits for this many real seconds, whatever the speed."""
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()


# s: Home Assistant subscribes to the readings of new devices only a moment after their discovery.
SETTLE_S = 2.0


class Player:
    """Announces the sensors of `home` to the broker, publishes their changes and leaves them
    "unavailable". Calls `check` often, which may raise to end it."""

    def __init__(
        self, link: Link, home: HomeMessages, speed: float, check: Callable[[], None]
    ) -> None:
        self.pace = Pace(speed, self.idle)
        self.late_s = 0.0
        self._link, self._home, self._check = link, home, check
        self._states: dict[str, str] = {}
        self._played = self._missed = 0
        self._missed_now = 0
        self._lost_at: float | None = None
        self._is_open = False

    def begin(self, states: Mapping[Channel, Value]) -> None:
        """Connects and announces the sensors, with these states or without any. Raises
        AngenError."""
        self._link.connect()
        retained = dict(found(self._link, self._home.topic))
        self._refuse_clash(retained.get(self._home.status("").topic))
        self._is_open = True
        # Comes first: a broker that refuses this topic gets no other message either.
        self._send_all([self._home.status(OFFLINE)])
        configs = self._home.discovery()
        for channel in self._home.channels:
            message = self._home.state(channel, states.get(channel))
            self._states[message.topic] = message.payload
        self._remove(retained, {config.topic for config in configs})
        new = [config for config in configs if retained.get(config.topic) != config.payload]
        self._send_all([*new, *self._now()])
        if new:
            self.pace.rest(SETTLE_S)

    def play(self, changes: Iterable[Change], after: int = 0) -> None:
        """Publishes each change when it is due, `after` microseconds later than it says."""
        for change in changes:
            late = self.pace.wait(after + change.time)
            self.late_s = max(self.late_s, late)
            message = self._home.state(change.channel, change.value)
            self._states[message.topic] = message.payload
            self._played += 1
            self._missed_now += not self._link.send(message, self.idle)

    def end(self) -> bool:
        """Leaves the sensors "unavailable"; returns whether all readings were sent."""
        if self._is_open:
            self._is_open = False
            with suppress(AngenError):
                self._link.flush(PARTING_S)
                self._missed += self._missed_now + self._link.take_unacknowledged()
                if not self._link.is_lost:
                    self._link.send(self._home.status(OFFLINE))
                    self._link.flush(PARTING_S)
            self._link.close()
        return not self._missed

    def summary(self) -> str:
        sensors = len({channel.sensor.name for channel in self._home.channels})
        text = f"sent {self._played - self._missed} readings of {sensors} sensors"
        if not self.pace.is_at_once:
            text += f", at most {self.late_s:.3f} s late"
        if self._missed:
            text += f"; {self._missed} were missed while the connection was lost"
        return text

    def _now(self) -> list[Message]:
        """The messages with the present states of all sensors, and that they are online."""
        states = [Message(topic, payload) for topic, payload in self._states.items()]
        return [*states, self._home.status(ONLINE)]

    def _send_all(self, messages: Iterable[Message]) -> None:
        for message in messages:
            self._link.send(message, self._check)
        if not self._link.flush():
            raise AngenError("the connection to the broker is lost before the first reading")

    def _refuse_clash(self, status: str | None) -> None:
        if status == ONLINE:
            self._link.close()
            raise AngenError(
                f"sensors below '{self._home.topic}' are online at this broker: another replay "
                f"is under way; wait for its end, or give this home a --topic of its own "
                f"(where none is: `angen replay --forget`)"
            )

    def _remove(self, retained: Mapping[str, str], configs: set[str]) -> None:
        """Removes the sensors of an earlier replay that this home does not have."""
        own = {*configs, *self._states, self._home.status("").topic}
        gone = [Message(*message) for message in retained.items() if message[0] not in own]
        names = clear(self._link, gone)
        if names:
            note(f"removed from the broker, as this home lacks them: {', '.join(names)}")

    def idle(self) -> None:
        """Reports a lost connection and tries to reconnect; to be called between messages."""
        self._check()
        if not self._is_open or not self._link.is_lost:
            return
        if self._lost_at is None:
            self._lost_at = time.monotonic()
            self._missed_now += self._link.take_unacknowledged()
            note("the connection to the broker is lost; trying to come back")
        if self._link.revive():
            lasted = time.monotonic() - self._lost_at
            note(
                f"connected again after {lasted:.1f} s: {self._missed_now} readings were missed; "
                f"the sensors' present readings were sent"
            )
            self._missed += self._missed_now
            self._missed_now, self._lost_at = 0, None
            for message in (*self._home.discovery(), *self._now()):
                self._link.send(message, self._check)


def found(link: Link, topic: str) -> list[Message]:
    """The retained messages of a home: its devices, and all below its topic."""
    messages = link.retained([f"{topic}/#", CONFIGS.replace("*", "+")])
    return [m for m in messages if m.topic.startswith(f"{topic}/") or is_config_of(topic, m)]


def clear(link: Link, messages: Iterable[Message]) -> list[str]:
    """Removes retained messages from the broker, devices first; returns their sensors' names."""
    prefix = CONFIGS.partition("*")[0]
    names = []
    for message in sorted(messages, key=lambda message: not message.topic.startswith(prefix)):
        if message.topic.startswith(prefix):
            names.append(json.loads(message.payload)["dev"]["name"])
        link.send(Message(message.topic, ""))
    link.flush()
    return sorted(names)


# `angen simulate --mqtt HOST`: sends readings during the run.


class Sending:
    """Sends the readings of a run in a thread of its own, each when it is due, while the run may be
    ahead. A context manager, which leaves the sensors "unavailable"; without an address it does
    nothing."""

    def __init__(
        self, address: Address | None, sensors: Sequence[Sensor], options: argparse.Namespace
    ) -> None:
        """Raises AngenError where paho-mqtt is missing."""
        self._player: Player | None = None
        self._interrupt, self._quiet = options.interrupt, options.quiet
        self._changes: queue.SimpleQueue[Change | None] = queue.SimpleQueue()
        self._events: NewEvents | None = None
        self._stop = threading.Event()
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._play, daemon=True)
        if address is None:
            return
        self._facts = {sensor.name: sensor_facts(sensor) for sensor in sensors}
        channels = [
            channel_of(self._facts[sensor.name], published)
            for sensor in sensors
            for published in sensor.kind.events
            if is_chosen(sensor.parameters, published.used_when)
        ]
        home = HomeMessages(channels, options.topic or TOPIC, extension_version())
        speed = 1.0 if options.speed is None else options.speed
        self._player = Player(Link(address, home.status(OFFLINE)), home, speed, self._check)

    def __enter__(self) -> Sending:
        """Raises AngenError where the broker cannot be used."""
        if self._player:
            try:
                with self._interrupt.watched():
                    self._player.begin({})
            except BaseException:
                self._player.end()
                raise
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._player and self._thread.is_alive():
            self._stop.set()
            self._thread.join(2 * SLICE_S)
        if self._player:
            self._player.end()

    def take(self, recording: Recording) -> None:
        """Queues the new readings of a recording. Raises the error that ended the thread, if
        any."""
        if self._player is None:
            return
        if self._error:
            raise self._error
        self._events = self._events or NewEvents(recording)
        for change in make_log(self._events.take(), self._facts).changes:
            self._changes.put(change)

    def finish(self) -> bool:
        """Waits until all is sent; returns whether all readings arrived."""
        if self._player is None:
            return True
        self._changes.put(None)
        self._thread.join(SLICE_S)
        if self._thread.is_alive() and not self._quiet:
            note("the run is ahead of what it sends; Ctrl-C ends both")
        while self._thread.is_alive():
            self._interrupt.check()
            self._thread.join(SLICE_S)
        if self._error:
            raise self._error
        is_whole = self._player.end()
        if not (is_whole and self._quiet):
            note(self._player.summary())
        return is_whole

    def _check(self) -> None:
        if self._stop.is_set():
            raise InterruptedError
        self._interrupt.check()

    def _play(self) -> None:
        assert self._player is not None
        try:
            self._player.play(self._as_they_come(self._player))
        except BaseException as error:
            self._error = error

    def _as_they_come(self, player: Player) -> Iterator[Change]:
        """The changes as the run queues them, until its end; the first one starts the clock."""
        is_first = True
        while True:
            try:
                change = self._changes.get(timeout=SLICE_S)
            except queue.Empty:
                player.idle()
                continue
            if change is None:
                return
            if is_first:
                player.pace.start(change.time)
                is_first = False
            yield change
