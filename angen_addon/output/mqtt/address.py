# SPDX-License-Identifier: GPL-3.0-or-later
"""The options that name a broker, its user and its certificate."""

from __future__ import annotations

import argparse
import math
import os
import re
import ssl
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ....sensor_logic.logs.error import InputError, explained, replaced
from ....sensor_logic.logs.files import read_text
from ....sensor_logic.logs.formats.home_assistant import TOPIC
from ...process.parser import path

PASSWORD = "ANGEN_MQTT_PASSWORD"
PORT, TLS_PORT = 1883, 8883
# The speed at which everything is sent without waiting.
AT_ONCE = 0.0
# Options that need --mqtt, with their values where they are not given.
DEPENDENT = {
    "topic": None,
    "speed": None,
    "user": None,
    "password_file": None,
    "tls": False,
    "ca": None,
}


class Words(NamedTuple):
    """What messages call the settings of a broker, and what they tell the user to do."""

    authority: str
    tls: str
    without_tls: str
    credentials: str
    clash: str


OPTIONS = Words(
    authority="--ca FILE",
    tls="--tls",
    without_tls="leave out --tls and --ca",
    credentials=f"give --user NAME, and its password in {PASSWORD} or with --password-file",
    clash="replay is running: wait for its end, or give another --topic; if none is running, "
    "remove them with `angen replay --forget`",
)


@dataclass(frozen=True)
class Address:
    """The host, port and credentials of a broker.

    `tls` has the settings of an encrypted connection; None for an unencrypted one. `words` is for
    messages to the user who gave the address.
    """

    host: str
    port: int
    user: str | None = None
    password: str | None = field(default=None, repr=False)
    tls: ssl.SSLContext | None = None
    words: Words = OPTIONS

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def add_options(parser: argparse.ArgumentParser, required: bool) -> None:
    """Add the options for a broker to the parser of a command.

    `required` says whether the option that names the broker must be given.
    """
    group = parser.add_argument_group("to an MQTT broker, such as Home Assistant's")
    group.add_argument(
        "--mqtt",
        type=host_and_port,
        required=required,
        metavar="HOST[:PORT]",
        help=f"the broker (default port {PORT}, or {TLS_PORT} with TLS)",
    )
    group.add_argument(
        "--speed",
        type=_speed,
        metavar="N",
        help="speed in multiples of real time (default 1), or max: as fast as possible",
    )
    group.add_argument(
        "--topic",
        type=topic,
        metavar="NAME",
        help=f"first part of all topics (default {TOPIC}); a second home needs another",
    )
    group.add_argument(
        "--user",
        metavar="NAME",
        help=f"user name; its password is read from the environment variable {PASSWORD}",
    )
    group.add_argument(
        "--password-file", type=path, metavar="FILE", help="a file whose first line is the password"
    )
    group.add_argument("--tls", action="store_true", help="encrypt the connection")
    group.add_argument(
        "--ca",
        type=path,
        metavar="FILE",
        help="certificate (PEM) of the authority that signed the broker's; turns on --tls",
    )


def address_of(options: argparse.Namespace) -> Address | None:
    """Return the address of the broker that the options name; None if they name none.

    Raise InputError if the options are invalid.
    """
    if options.mqtt is None:
        for name, unset in DEPENDENT.items():
            if getattr(options, name) != unset:
                flag = f"--{name.replace('_', '-')}"
                raise InputError(f"{flag} needs --mqtt HOST")
        return None
    host, port = options.mqtt
    tls = _context(options.ca) if options.tls or options.ca else None
    return Address(host, port or (TLS_PORT if tls else PORT), options.user, _password(options), tls)


def _password(options: argparse.Namespace) -> str | None:
    if options.password_file is None:
        return os.environ.get(PASSWORD) if options.user else None
    if options.user is None:
        raise InputError("--password-file needs --user NAME")
    first = read_text(options.password_file).partition("\n")[0].rstrip("\r")
    if not first:
        raise InputError(
            f"{options.password_file}: the first line is empty: write the password there"
        )
    return first


def _context(authority: Path | None) -> ssl.SSLContext:
    with (
        explained(f"cannot read the certificate {authority}", OSError),
        replaced(f"{authority} is not a certificate in PEM format", ssl.SSLError),
    ):
        context = ssl.create_default_context(cafile=authority)
        if authority:
            # Python 3.13 refuses authorities without certain extensions, as home-made ones are.
            context.verify_flags &= ~ssl.VERIFY_X509_STRICT
        return context


def host_and_port(text: str) -> tuple[str, int | None]:
    """Return the host and the port of HOST or HOST:PORT; raise ArgumentTypeError if it is wrong."""
    if "@" in text:
        raise argparse.ArgumentTypeError(
            "the address contains a user name: give it with --user NAME instead, and the password "
            f"in {PASSWORD} or with --password-file"
        )
    # An IPv6 address stands in brackets where a port follows.
    found = re.fullmatch(r"\[([0-9a-fA-F:.%\w]+)\](?::(\d+))?|([^\s:/\[\]]+)(?::(\d+))?", text)
    if found is None and re.fullmatch(r"[0-9a-fA-F]*(:[0-9a-fA-F.]*){2,}", text):
        return text, None
    port = int(found[2] or found[4] or 0) if found else 0
    if found is None or port > 65535 or (port == 0 and (found[2] or found[4])):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not HOST or HOST:PORT, such as homeassistant.local:1883"
        )
    return found[1] or found[3], port or None


def _speed(text: str) -> float:
    if text == "max":
        return AT_ONCE
    try:
        speed = float(text)
    except ValueError:
        speed = -1.0
    if not 0.0 <= speed < math.inf:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a speed: give a number such as 10 (times real time), or max"
        )
    return speed


def topic(text: str) -> str:
    """Return the first part of topics; raise ArgumentTypeError if it cannot be one."""
    if not re.fullmatch(r"[\w-]+(/[\w-]+)*", text, re.ASCII):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a topic: use letters, digits, _, - and /, as in flat_2"
        )
    return text
