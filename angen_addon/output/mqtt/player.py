# SPDX-License-Identifier: GPL-3.0-or-later
"""Publishing of a log's events to a broker, each when it is due, at any speed.

The player first announces the sensors, and marks them unavailable at the end.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress

from ....sensor_logic.logs.error import AngenError
from ....sensor_logic.logs.formats.home_assistant import (
    CONFIGS,
    OFFLINE,
    ONLINE,
    HomeMessages,
    Message,
    is_config_of,
)
from ....sensor_logic.logs.formats.log import Change, Channel
from ....sensor_logic.logs.log import Value
from ...process.console import note
from .link import PARTING_S, Link

# Waiting until the events of a log are due, at any speed.

# s: interval between calls of `idle` while waiting.
SLICE_S = 0.2


class Pace:
    """A timer that waits until the events of a log are due.

    Each waiting time is computed from the start, not from the event before. So a late event does
    not delay later ones.

    Parameters
    ----------
    speed
        How many times faster than real time the log is played; 0 to play it without waiting.
    idle
        A function that is called repeatedly while waiting.
    clock
        A function that returns the present time in s, from a monotonic clock.
    sleep
        A function that sleeps for a number of seconds.
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
        """Set the present time of the log to `at`, in microseconds."""
        self._begin, self._at = self._clock(), at

    def wait(self, until: int) -> float:
        """Wait until the time `until` of the log, in microseconds; return the lateness in s.

        Call `idle` at least once; an exception from `idle` ends the wait.
        """
        self._idle()
        if self.is_at_once:
            return 0.0
        due = self._begin + (until - self._at) / 1e6 / self._speed
        while (left := due - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()
        return self._clock() - due

    def rest(self, seconds: float) -> None:
        """Wait for a number of seconds of real time, which the speed does not change."""
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0.0:
            self._sleep(min(left, SLICE_S))
            self._idle()


# s: Home Assistant subscribes to the readings of new devices only a moment after their discovery.
SETTLE_S = 2.0


class Player:
    """Announces the sensors of a home to a broker, and publishes the changes of their fields.

    Parameters
    ----------
    link
        The connection to the broker.
    home
        The messages for the sensors of the home.
    speed
        How many times faster than real time changes are published; 0 to publish without waiting.
    check
        A function that is called repeatedly. To stop the player, it raises an exception.
    """

    def __init__(
        self, link: Link, home: HomeMessages, speed: float, check: Callable[[], None]
    ) -> None:
        self.pace = Pace(speed, self.idle)
        self.late_s = 0.0
        self._link, self._home, self._check = link, home, check
        self._states: dict[str, str] = {}
        # Topics that were removed while playing; removed again after a lost connection.
        self._gone: set[str] = set()
        self._played = self._missed = 0
        self._missed_now = 0
        self._lost_at: float | None = None
        self._is_open = False

    @property
    def is_lost(self) -> bool:
        """Whether the connection is lost, and is being made again."""
        return self._is_open and self._link.is_lost

    def begin(self, states: Mapping[Channel, Value]) -> None:
        """Connect to the broker and announce the sensors.

        `states` has the present value of each channel; a channel without a value is announced as
        unknown. Raise AngenError if the broker cannot be used.
        """
        self._link.connect()
        self._check()
        retained = dict(retained_messages(self._link, self._home.topic))
        self._refuse_clash(retained.get(self._home.status("").topic))
        self._is_open = True
        # Listeners of now get all states, also those that the broker retains of an earlier replay.
        begin = f"{self._home.topic}/"
        known = {topic: text for topic, text in retained.items() if not topic.startswith(begin)}
        # Comes first: a broker that refuses this topic gets no other message either.
        is_whole = self._send_all([self._home.status(OFFLINE)])
        if not (is_whole and self._announce(states, retained, known)):
            raise AngenError(
                "the connection to the broker was lost before the first reading: check the broker, "
                "and try again"
            )

    def change_home(self, home: HomeMessages, states: Mapping[Channel, Value]) -> None:
        """Announce the sensors of a home that has changed since `begin`; remove those that it lost.

        `states` is that of `begin`.
        """
        before = dict([*self._home.discovery(), *self._now()])
        self._home = home
        self._announce(states, before, before)

    def play(self, changes: Iterable[Change], after: int = 0) -> None:
        """Publish each change when its own time plus `after`, in microseconds, is due."""
        for change in changes:
            late = self.pace.wait(after + change.time)
            self.late_s = max(self.late_s, late)
            message = self._home.state(change.channel, change.value)
            self._states[message.topic] = message.payload
            self._played += 1
            self._missed_now += not self._link.send(message, self.idle)

    @property
    def sent(self) -> int:
        """Number of the changes that the broker got."""
        return self._played - self._missed - self._missed_now

    def end(self) -> bool:
        """Mark the sensors "unavailable", and return whether all changes were sent."""
        if self._is_open:
            self._is_open = False
            with suppress(AngenError):
                self._link.flush(PARTING_S)
                self._missed += self._missed_now + self._link.take_unacknowledged()
                self._missed_now = 0
                if not self._link.is_lost:
                    self._link.send(self._home.status(OFFLINE))
                    self._link.flush(PARTING_S)
            self._link.close()
        return not self._missed

    def summary(self) -> str:
        """Return a line for the user on how many changes were sent, and how late."""
        sensors = len({channel.sensor.name for channel in self._home.channels})
        text = f"sent {self.sent} readings of {sensors} sensors"
        if not self.pace.is_at_once:
            text += f", at most {self.late_s:.3f} s late"
        if self._missed:
            text += f"; {self._missed} were missed while the connection was lost"
        return text

    def _now(self) -> list[Message]:
        """Return messages with the present states of all sensors, and that they are online."""
        states = [Message(topic, payload) for topic, payload in self._states.items()]
        return [*states, self._home.status(ONLINE)]

    def _announce(
        self,
        states: Mapping[Channel, Value],
        retained: Mapping[str, str],
        known: Mapping[str, str],
    ) -> bool:
        """Announce the sensors with their states, and remove others that the broker retains.

        `retained` and `known` have payloads by topic. A message that is in `known` is not sent.
        Return False if the connection is lost meanwhile.
        """
        configs = self._home.discovery()
        channels = self._home.channels
        self._states = dict(self._home.state(channel, states.get(channel)) for channel in channels)
        topics = {*dict(configs), *self._states, self._home.status("").topic}
        gone = [Message(*message) for message in retained.items() if message[0] not in topics]
        self._gone = (self._gone | {message.topic for message in gone}) - topics
        names = remove_messages(self._link, gone)
        if names:
            note(f"removed from the broker, since this home does not have them: {', '.join(names)}")
        new = [config for config in configs if known.get(config.topic) != config.payload]
        now = [message for message in self._now() if known.get(message.topic) != message.payload]
        is_whole = self._send_all([*new, *now])
        if new and is_whole:
            self.pace.rest(SETTLE_S)
        return is_whole

    def _send_all(self, messages: Iterable[Message]) -> bool:
        """Send messages; return whether the broker has acknowledged all of them."""
        for message in messages:
            self._link.send(message, self._check)
        return self._link.flush()

    def _refuse_clash(self, status: str | None) -> None:
        if status == ONLINE:
            self._link.close()
            raise AngenError(
                f"sensors below '{self._home.topic}' are online at this broker, so another "
                f"{self._link.words.clash}"
            )

    def idle(self) -> None:
        """Report to the user if the connection is lost, and try to reconnect.

        Call this method repeatedly between messages.
        """
        self._check()
        if not self._is_open or not self._link.is_lost:
            return
        if self._lost_at is None:
            self._lost_at = time.monotonic()
            self._missed_now += self._link.take_unacknowledged()
            note("the connection to the broker is lost; trying to reconnect")
        if self._link.revive():
            lasted = time.monotonic() - self._lost_at
            note(
                f"reconnected after {lasted:.1f} s: {self._missed_now} readings were missed; "
                f"the sensors' present readings were sent"
            )
            self._missed += self._missed_now
            self._missed_now, self._lost_at = 0, None
            gone = [Message(topic, "") for topic in self._gone]
            for message in (*gone, *self._home.discovery(), *self._now()):
                self._link.send(message, self._check)


def retained_messages(link: Link, topic: str) -> list[Message]:
    """Return the messages of a home that the broker retains.

    These are the announcements of its devices, and all messages on topics below `topic`.
    """
    messages = link.retained([f"{topic}/#", CONFIGS.replace("*", "+")])
    return [m for m in messages if m.topic.startswith(f"{topic}/") or is_config_of(topic, m)]


def remove_messages(link: Link, messages: Iterable[Message]) -> list[str]:
    """Remove retained messages from the broker, and return the names of their sensors.

    Announcements of devices are removed first.
    """
    prefix = CONFIGS.partition("*")[0]
    names = []
    for message in sorted(messages, key=lambda message: not message.topic.startswith(prefix)):
        if message.topic.startswith(prefix):
            names.append(json.loads(message.payload)["dev"]["name"])
        link.send(Message(message.topic, ""))
    link.flush()
    return sorted(names)


def forget(link: Link, topic: str) -> list[str]:
    """Remove the sensors of a home from a broker, and return their names.

    Raise AngenError if the broker cannot be used.
    """
    link.connect()
    try:
        return remove_messages(link, retained_messages(link, topic))
    finally:
        link.close()
