# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen replay EVENTS.csv --mqtt HOST`: publishes the readings of a log; needs no Blender."""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.formats.home_assistant import OFFLINE, TOPIC, HomeMessages, Message
from ...sensor_logic.logs.formats.log import DEFAULT_START, Change, Channel, Log, since
from ...sensor_logic.logs.formats.reading import read_log
from ...sensor_logic.logs.formats.source import home_beside, read_home
from ...sensor_logic.logs.formats.units import UNIT_HELP, Units
from ...sensor_logic.logs.log import Value, parse_start
from ..output.mqtt.address import AT_ONCE, Address, add_options, address_of
from ..output.mqtt.link import Link
from ..output.mqtt.player import Player, forget
from ..process.console import DONE, FAILED, Interrupt, leave_hard, note
from ..process.parser import Parser, path, tells_errors
from ..process.version import extension_version

INTERRUPTED = "interrupted: the broker now shows the sensors as unavailable"


@tells_errors
def main(arguments: list[str], program: str) -> int:
    """Replay an event log, and return the exit status.

    `arguments` are those after `replay`. `program` is the text before `replay` in the help. Raise
    SystemExit if the arguments are wrong.
    """
    options = make_parser(program).parse_args(arguments)
    try:
        work = _forget if options.forget else _replay
        address = address_of(options)
        assert address is not None
        # Ctrl-C is the normal end of a loop.
        interrupted = DONE if options.loop else FAILED
        with Interrupt(lambda: _give_up(interrupted)) as interrupt, interrupt.watched():
            return work(options, address, interrupt.check)
    except KeyboardInterrupt:
        note(INTERRUPTED)
        return interrupted


def _give_up(status: int) -> None:
    # The broker then publishes the will: the sensors are offline.
    note(INTERRUPTED)
    leave_hard(status)


def _replay(options: argparse.Namespace, address: Address, check: Callable[[], None]) -> int:
    if options.events is None:
        raise InputError("no log to replay: give EVENTS.csv, or --forget")
    log, start = _read(options.events, options.home, Units.parse(options.unit))
    if not log.changes:
        raise InputError(f"{options.events} has no events to replay")
    played = LogRange(log, _time_of(options.since, start), _time_of(options.until, start))
    speed = 1.0 if options.speed is None else options.speed
    if options.loop and (speed == AT_ONCE or played.length <= 0):
        raise InputError(
            "--loop would repeat without a pause: give a --speed, or an earlier --from"
        )
    home = HomeMessages(log.channels, options.topic or TOPIC, extension_version())
    link = Link(address, home.status(OFFLINE))
    player = Player(link, home, speed, check)
    try:
        player.begin(played.states)
        player.pace.start(played.begin)
        for number in itertools.count():
            after = number * played.length
            if number:
                player.play(played.again, after)
            player.play(played.changes, after)
            player.pace.wait(played.end + after)
            if not options.loop:
                break
    finally:
        whole = player.end()
    note(player.summary())
    return DONE if whole else FAILED


def _read(
    events: Path, home: Path | None, units: Units | None = None
) -> tuple[Log, datetime | None]:
    """Return a log with the rooms of its sensors, and the date and time of its start.

    The start is None if the log has no dates. `home` is a file with the rooms; by default the one
    beside the log. `units` are the units of numbers that the log gives without one. Raise
    InputError if a file is wrong, and OSError if it cannot be read.
    """
    about = read_home(home) if home else home_beside(events)
    source = read_log(events, about.start, units=units)
    for text in source.notes:
        note(text)
    return source.log(about.sensors, source.start or DEFAULT_START), source.start


class LogRange:
    """The part of a log to replay. All times are in microseconds, as in the log.

    Attributes
    ----------
    begin, end
        The first and the last time of the part.
    states
        The value of each channel (a field of a sensor) at `begin`.
    again
        The same values, as changes at `begin`. They are published when the part is repeated.
    changes
        The changes after `begin`, up to `end`.
    """

    def __init__(self, log: Log, begin: int | None, end: int | None) -> None:
        last = log.changes[-1].time
        self.begin = log.changes[0].time if begin is None else begin
        self.end = last if end is None else end
        if not 0 <= self.begin <= self.end:
            raise InputError(
                f"--from {self.begin / 1e6:g} s and --until {self.end / 1e6:g} s: the log has no "
                f"events between them; it ends at {last / 1e6:g} s"
            )
        self.states: dict[Channel, Value] = {
            c.channel: c.value for c in log.changes if c.time <= self.begin
        }
        self.again = [Change(self.begin, *state) for state in self.states.items()]
        self.changes = [c for c in log.changes if self.begin < c.time <= self.end]

    @property
    def length(self) -> int:
        """The length of the range in microseconds."""
        return self.end - self.begin


def _time_of(text: str | None, start: datetime | None) -> int | None:
    """Convert an argument of `--from` or `--until` to µs since the log's start.

    Return None if `text` is None. `start` is the date and time of the log's start, or None if the
    log has no dates. Raise InputError if the argument is wrong.
    """
    if text is None:
        return None
    try:
        seconds = float(text)
        if math.isfinite(seconds):
            return round(seconds * 1e6)
    except ValueError:
        pass
    if start is None:
        raise InputError(f"'{text}' is not in seconds, and the log has no dates: give seconds")
    time = parse_start(text) or start
    try:
        return since(start, time)
    except TypeError:
        raise InputError(
            f"'{text}' has a time zone, and the log's times have none: leave it out"
        ) from None


def _forget(options: argparse.Namespace, address: Address, check: Callable[[], None]) -> int:
    if options.events is not None:
        raise InputError("--forget removes sensors and replays nothing: leave out EVENTS.csv")
    topic = options.topic or TOPIC
    link = Link(address, Message(f"{topic}/status", OFFLINE))
    names = forget(link, topic)
    check()
    note(f"removed {len(names)} sensors below '{topic}' from {address}")
    return DONE


def make_parser(program: str) -> Parser:
    """Return the argument parser of `angen replay`."""
    parser = Parser(
        prog=f"{program} replay",
        description="Announce the sensors of an event log to an MQTT broker, such as Home "
        "Assistant's, and replay their readings.",
    )
    parser.add_argument(
        "events",
        type=path,
        nargs="?",
        metavar="EVENTS.csv",
        help="a log in any format that convert reads, or a folder of days",
    )
    add_options(parser, required=True)
    parser.add_argument("--unit", **UNIT_HELP)
    parser.add_argument(
        "--home",
        type=path,
        metavar="HOME.toml",
        help="file with the rooms, which `day` writes; or HOME.json, the saved output of `list "
        "--json`",
    )
    parser.add_argument(
        "--from",
        dest="since",
        metavar="TIME",
        help="begin at this time, in seconds of the log, or as 2026-03-02T12:00 if it has dates",
    )
    parser.add_argument(
        "--until", metavar="TIME", help="end at this time (default: the last event)"
    )
    parser.add_argument("--loop", action="store_true", help="repeat until Ctrl-C")
    parser.add_argument(
        "--forget",
        action="store_true",
        help="remove the sensors from the broker, and replay nothing",
    )
    return parser
