# SPDX-License-Identifier: GPL-3.0-or-later
"""An argument parser that prints its errors in one line, as all other errors are."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NoReturn

from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.spelling import hint

VERBS = (
    *("simulate", "list", "apply", "check", "explain", "coverage", "place", "places", "day"),
    "doctor",
)
# Verbs that need no blend file, each in the module of its name.
WITHOUT_BLENDER = ("convert", "compare", "replay", "study")


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"angen: {message} (see --help)\n")


def wrong_verb(name: str) -> str:
    """What to tell where `name` is no verb on a blend file."""
    if name in WITHOUT_BLENDER:
        return f"{name} runs without Blender: python -m angen_addon {name}"
    every = (*VERBS, *WITHOUT_BLENDER)
    return f"there is no verb '{name}'; {hint(name, every, len(every))}"


def add_names(parser: argparse.ArgumentParser, what: str = "sensor") -> None:
    """Adds `--sensor`."""
    parser.add_argument(
        "--sensor",
        action="append",
        default=[],
        metavar="NAME",
        help=f"only this {what}, or those that fit a pattern such as 'PIR*'; may be given again",
    )


def add_choice(parser: argparse.ArgumentParser) -> None:
    """Adds the options that choose sensors, of all verbs that simulate."""
    add_names(parser)
    parser.add_argument(
        "--kind",
        action="append",
        default=[],
        type=str.upper,
        choices=list(KINDS),
        metavar="KIND",
        help="only sensors of this kind, such as PIR; may be given again",
    )
    parser.add_argument(
        "--no-light", action="store_true", help="no light sensors, which take the longest"
    )


def choice_of(options: argparse.Namespace) -> SensorChoice:
    """The sensors that these options choose."""
    return SensorChoice(tuple(options.sensor), tuple(options.kind), not options.no_light)


def path(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("the name of a file or folder is empty")
    return Path(text)
