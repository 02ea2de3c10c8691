# SPDX-License-Identifier: GPL-3.0-or-later
"""Sending of readings to a broker during a run, for `angen simulate --mqtt HOST`."""

from __future__ import annotations

import argparse
import queue
import threading
from collections.abc import Iterator, Sequence

from ....sensor_logic.logs.formats.home_assistant import OFFLINE, TOPIC, HomeMessages
from ....sensor_logic.logs.formats.log import Change
from ....sensor_logic.logs.formats.source import channel_of, make_log
from ....sensor_logic.parameters import is_chosen
from ....sensor_logic.recording.events import NewEvents
from ....sensor_logic.recording.tracks import Recording
from ...process.console import note
from ...process.version import extension_version
from ...scene.sensors import Sensor
from ..run_log import sensor_facts
from .address import Address
from .link import Link
from .player import SLICE_S, Player


class Sending:
    """Context manager: send the readings of a run to a broker.

    A thread sends each reading when it is due, while the run can already simulate later times. On
    exit, the sensors are marked "unavailable".

    Parameters
    ----------
    address
        The address of the broker; None to send nothing.
    sensors
        The sensors of the run.
    options
        The options of the command.

    Raises
    ------
    AngenError
        If paho-mqtt is missing.
    """

    def __init__(
        self, address: Address | None, sensors: Sequence[Sensor], options: argparse.Namespace
    ) -> None:
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
        """Connect and announce the sensors; raise AngenError if the broker cannot be used."""
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
        """Queue the readings that were added to the recording since the last call.

        If an error has ended the thread, raise this error.
        """
        if self._player is None:
            return
        if self._error:
            raise self._error
        self._events = self._events or NewEvents(recording)
        for change in make_log(self._events.take(), self._facts).changes:
            self._changes.put(change)

    def finish(self) -> bool:
        """Wait until all queued readings are sent, and return whether all of them arrived."""
        if self._player is None:
            return True
        self._changes.put(None)
        self._thread.join(SLICE_S)
        if self._thread.is_alive() and not self._quiet:
            note("the run has ended, and its last readings are being sent; Ctrl-C stops this")
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
        """Yield the changes in the order in which the run queues them, until the run has ended."""
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
