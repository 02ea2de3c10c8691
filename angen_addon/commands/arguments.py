# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from datetime import datetime
from typing import Any

import bpy

from ...sensor_logic.formats import FORMATS
from ...sensor_logic.log.start import parse_start
from ..coverage.arguments import add_verbs
from ..days import command as days
from ..output import faulty
from ..output.mqtt import address
from .parser import VERBS, Parser, add_choice, path, wrong_verb


def parse(arguments: Sequence[str], program: str) -> argparse.Namespace:
    """The options of a command. On an error, prints it and raises SystemExit."""
    arguments = list(arguments)
    if "--frames" in arguments[:-1]:
        # argparse would read a negative first frame as an option.
        place = arguments.index("--frames")
        arguments[place : place + 2] = [f"--frames={arguments[place + 1]}"]
    parser = _make_parser(program)
    if arguments and not arguments[0].startswith("-") and arguments[0] not in VERBS:
        parser.error(wrong_verb(arguments[0]))
    return parser.parse_args(arguments)


def _frames(text: str) -> tuple[int, int]:
    try:
        first, _, last = text.partition(":")
        frames = int(first), int(last)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not FIRST:LAST, two whole frame numbers such as 1:240"
        ) from None
    if frames[0] > frames[1]:
        raise argparse.ArgumentTypeError(
            f"{text}: the first frame is after the last; did you mean {frames[1]}:{frames[0]}?"
        )
    limits = bpy.types.Scene.bl_rna.properties["frame_current"]
    if frames[0] < limits.hard_min or frames[1] > limits.hard_max:
        raise argparse.ArgumentTypeError(
            f"{text}: Blender's frames are {limits.hard_min} to {limits.hard_max}"
        )
    return frames


def _start(text: str) -> datetime | None:
    try:
        return parse_start(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _tolerance(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of 0 or more")
    return value


def _make_parser(program: str) -> argparse.ArgumentParser:
    parser = Parser(
        prog=program, description="Simulates the ambient sensors of a home in a blend file."
    )
    verbs = parser.add_subparsers(
        dest="verb",
        required=True,
        metavar=" | ".join(VERBS),
    )

    every = Parser(add_help=False)
    every.add_argument(
        "--enable-autoexec",
        action="store_true",
        help="open the file as one that you trust: its drivers and scripts may run Python",
    )
    run = _of_runs(every)
    _add_simulate(verbs, run)
    listing = verbs.add_parser(
        "list", parents=[every], help="list the sensors and their parameters"
    )
    listing.add_argument("--json", action="store_true", help="for programs")
    _add_apply(verbs, every)
    _add_check(verbs, run)
    _add_explain(verbs, every)
    doctor = verbs.add_parser(
        "doctor", parents=[every], help="find what makes the home's sensors read nonsense"
    )
    doctor.add_argument("--json", action="store_true", help="for programs")
    places = verbs.add_parser(
        "places",
        parents=[every],
        help="list the places marked for residents, and those that they cannot reach",
    )
    places.add_argument("--json", action="store_true", help="for programs")
    add_verbs(verbs, path, every)
    days.add_verb(verbs, path, every)
    if "--command" not in program:  # else Blender has opened the home
        for name, verb in verbs.choices.items():
            verb.prog += " LAYOUT.json HOME.blend" if name == "apply" else " HOME.blend"
        verbs.choices["apply"].usage = "%(prog)s --save FILE.blend [options]"
    return parser


def _of_runs(every: Parser) -> Parser:
    """The options of all verbs that simulate."""
    run = Parser(add_help=False, parents=[every])
    run.add_argument(
        "--frames",
        type=_frames,
        metavar="A:B",
        help="first and last frame (default: the scene's); t = 0 stays at the scene's start, and "
        "frames after the scene's end are run too",
    )
    add_choice(run)
    run.add_argument(
        "--quiet", action="store_true", help="no progress, no advice on standard error"
    )
    return run


def _add_simulate(verbs: Any, run: Parser) -> None:
    verb = verbs.add_parser("simulate", parents=[run], help="write what the sensors report")
    verb.add_argument(
        "--events", type=path, metavar="FILE.csv", help="event log (default: standard output)"
    )
    verb.add_argument(
        "--report",
        type=path,
        metavar="FILE.html",
        help="timeline, floor plan and figures to read and print; FILE.svg: the pictures alone",
    )
    verb.add_argument(
        "--samples", type=path, metavar="DIR", help="every update, a CSV file a sensor"
    )
    verb.add_argument(
        "--start",
        type=_start,
        metavar="ISO-TIME",
        help="date and time of t = 0, such as 2026-03-01T08:00; logs get a column 'time'",
    )
    verb.add_argument(
        "--spreadsheet",
        action="store_true",
        help="CSV for a spreadsheet: names that it would read as formulas get a leading '",
    )
    verb.add_argument(
        "--format",
        action="append",
        default=[],
        choices=list(FORMATS),
        metavar="NAME",
        help=f"also write the log for another tool, to the --out after it; may be given again: "
        f"{', '.join(FORMATS)}",
    )
    verb.add_argument(
        "--out",
        action="append",
        default=[],
        type=path,
        metavar="PATH",
        help="file or folder of the --format before it",
    )
    faulty.add_options(verb, path)
    address.add_options(verb, required=False)
    verb.add_argument(
        "--bake", action="store_true", help="bake the outputs to keyframes; needs --save"
    )
    verb.add_argument("--save", type=path, metavar="FILE.blend", help="save the file as a copy")


def _add_apply(verbs: Any, every: Parser) -> None:
    verb = verbs.add_parser(
        "apply", parents=[every], help="add and change sensors to match a layout file"
    )
    verb.add_argument("layout", type=path, metavar="LAYOUT.json", help="as `list --json` prints it")
    verb.add_argument(
        "--save", type=path, metavar="FILE.blend", help="the home with the sensors; needed"
    )
    verb.add_argument(
        "--remove", action="store_true", help="delete the sensors that the layout lacks"
    )
    verb.add_argument("--quiet", action="store_true", help="do not say what was done")


def _add_check(verbs: Any, run: Parser) -> None:
    verb = verbs.add_parser("check", parents=[run], help="simulate and compare with an event log")
    verb.add_argument("expected", type=path, metavar="EXPECTED.csv")
    verb.add_argument(
        "--tolerance",
        type=_tolerance,
        default=0.0,
        metavar="X",
        help="numbers that differ by at most this count as equal (default 0)",
    )
    verb.add_argument(
        "--time-tolerance",
        type=_tolerance,
        default=0.0,
        metavar="SECONDS",
        help="times that differ by at most this count as equal (default 0)",
    )


def _add_explain(verbs: Any, every: Parser) -> None:
    verb = verbs.add_parser(
        "explain", parents=[every], help="name the object that made a sensor report its last event"
    )
    add_choice(verb)
    verb.add_argument(
        "--time",
        type=_tolerance,
        required=True,
        metavar="SECONDS",
        help="explain its last event at or before this time of the event log",
    )
    verb.add_argument(
        "--now",
        action="store_true",
        help="explain its reading at this time instead, or what would have to change for one",
    )
    verb.add_argument(
        "--quiet", action="store_true", help="no progress, no advice on standard error"
    )
