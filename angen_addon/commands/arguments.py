# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command line takes."""

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
from .parser import Parser, path


def parse(arguments: Sequence[str], program: str) -> argparse.Namespace:
    """The options of a command. Raises SystemExit, after telling what is wrong."""
    arguments = list(arguments)
    if "--frames" in arguments[:-1]:
        # argparse takes a negative first frame for an option of its own.
        place = arguments.index("--frames")
        arguments[place : place + 2] = [f"--frames={arguments[place + 1]}"]
    return _make_parser(program).parse_args(arguments)


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
        metavar="simulate | list | apply | check | explain | coverage | place | places | day | "
        "doctor",
    )

    every = Parser(add_help=False)
    every.add_argument(
        "--enable-autoexec",
        action="store_true",
        help="open the file as one that you trust: its drivers and scripts may run Python",
    )
    run = _of_runs(every)
    _add_simulate(verbs, run)
    listing = verbs.add_parser("list", parents=[every], help="the sensors and their parameters")
    listing.add_argument("--json", action="store_true", help="for programs")
    _add_apply(verbs, every)
    _add_check(verbs, run)
    _add_explain(verbs, every)
    doctor = verbs.add_parser(
        "doctor", parents=[every], help="what makes the home's sensors read nonsense"
    )
    doctor.add_argument("--json", action="store_true", help="for programs")
    places = verbs.add_parser(
        "places", parents=[every], help="what is marked for residents, and what they cannot reach"
    )
    places.add_argument("--json", action="store_true", help="for programs")
    add_verbs(verbs, path, every)
    days.add_verb(verbs, path, every)
    return parser


def _of_runs(every: Parser) -> Parser:
    """What all verbs take that simulate."""
    run = Parser(add_help=False, parents=[every])
    run.add_argument(
        "--frames",
        type=_frames,
        metavar="A:B",
        help="first and last frame (default: the scene's); t = 0 stays at the scene's start",
    )
    run.add_argument(
        "--sensor",
        action="append",
        default=[],
        metavar="NAME",
        help="only this sensor; may be given again",
    )
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
        help="CSV for a spreadsheet: names that it would take for formulas get a leading '",
    )
    verb.add_argument(
        "--format",
        action="append",
        default=[],
        choices=list(FORMATS),
        metavar="NAME",
        help=f"also in the format of another tool, to the --out that follows it; may be given "
        f"again: {', '.join(FORMATS)}",
    )
    verb.add_argument(
        "--out", action="append", default=[], type=path, metavar="PATH", help="of --format"
    )
    faulty.add_options(verb, path)
    address.add_options(verb, required=False)
    verb.add_argument("--bake", action="store_true", help="key the outputs; needs --save")
    verb.add_argument("--save", type=path, metavar="FILE.blend", help="save the file, as a copy")


def _add_apply(verbs: Any, every: Parser) -> None:
    verb = verbs.add_parser(
        "apply", parents=[every], help="add and change sensors as a layout file says"
    )
    verb.add_argument("layout", type=path, metavar="LAYOUT.json", help="as `list --json` prints it")
    verb.add_argument(
        "--save", type=path, required=True, metavar="FILE.blend", help="the home with the sensors"
    )
    verb.add_argument(
        "--remove", action="store_true", help="delete the sensors that the layout does not have"
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
        help="largest difference of numbers that is none (default 0)",
    )
    verb.add_argument(
        "--time-tolerance",
        type=_tolerance,
        default=0.0,
        metavar="SECONDS",
        help="largest difference of an event's time that is none (default 0)",
    )


def _add_explain(verbs: Any, every: Parser) -> None:
    verb = verbs.add_parser(
        "explain", parents=[every], help="which object made a sensor report its last event"
    )
    verb.add_argument("--sensor", required=True, metavar="NAME", help="the sensor")
    verb.add_argument(
        "--time",
        type=_tolerance,
        required=True,
        metavar="SECONDS",
        help="its last event at or before this time, as in the event log, is explained",
    )
    verb.add_argument(
        "--now",
        action="store_true",
        help="what it reads at this time instead, and what would have to change where that is "
        "nothing",
    )
    verb.add_argument(
        "--quiet", action="store_true", help="no progress, no advice on standard error"
    )
