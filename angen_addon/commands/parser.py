# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: its verbs, and the options that several of them have."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, TypeVar

from ...parts import VERBS, WITHOUT_BLENDER, installation, installed, part
from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.error import InputError, replaced
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.wording import hint

T = TypeVar("T")


class Verb(NamedTuple):
    """A verb on a blend file. `add(verbs, every)` adds its parser to the subparsers `verbs`, with
    the options of the parser `every`, which all verbs have; `run(options, outputs)` returns the
    exit status."""

    add: Callable[[Any, argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Any], int]


def verbs_here() -> list[str]:
    """The names of the verbs on a blend file."""
    return [name for name, module in VERBS.items() if installed(module)]


def verb_of(name: str) -> Verb:
    found: Verb = part(VERBS[name]).VERBS[name]
    return found


class Parser(argparse.ArgumentParser):
    """Prints its errors in one line, as all other errors are."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"angen: {message} (see --help)\n")


def parse(arguments: Sequence[str], program: str) -> argparse.Namespace:
    """The options of a command. On an error, prints it and raises SystemExit."""
    arguments = list(arguments)
    if "--frames" in arguments[:-1]:
        # argparse would read a negative first frame as an option.
        place = arguments.index("--frames")
        arguments[place : place + 2] = [f"--frames={arguments[place + 1]}"]
    parser = make_parser(program)
    if arguments and not arguments[0].startswith("-") and arguments[0] not in verbs_here():
        parser.error(wrong_verb(arguments[0]))
    return parser.parse_args(arguments)


def make_parser(program: str) -> argparse.ArgumentParser:
    parser = Parser(
        prog=program, description="Simulates the ambient sensors of a home in a blend file."
    )
    names = verbs_here()
    verbs = parser.add_subparsers(dest="verb", required=True, metavar=" | ".join(names))
    every = Parser(add_help=False)
    every.add_argument(
        "--enable-autoexec",
        action="store_true",
        help="open the file as one that you trust: its drivers and scripts may run Python",
    )
    for name in names:
        verb_of(name).add(verbs, every)
    if "--command" not in program:  # else Blender has opened the home
        for name, verb in verbs.choices.items():
            verb.prog += " LAYOUT.json HOME.blend" if name == "apply" else " HOME.blend"
        verbs.choices["apply"].usage = "%(prog)s --save FILE.blend [options]"
    return parser


def lacking(name: str) -> str:
    """The line that says how to get a verb whose house is not installed; empty where it is, and
    for words that are no verb."""
    house = WITHOUT_BLENDER.get(name, "").partition(".")[0]
    if not house or installed(house):
        return ""
    return f"{name} is in the Python package, not in the extension: {installation(house)}"


def wrong_verb(name: str) -> str:
    """What to tell where `name` is no verb on a blend file."""
    if lacking(name):
        return lacking(name)
    if name in WITHOUT_BLENDER:
        return f"{name} runs without Blender: python -m angen_addon {name}"
    every = (*verbs_here(), *WITHOUT_BLENDER)
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


def typed(read: Callable[[str], T]) -> Callable[[str], T]:
    """A type of arguments, which says as other types do what `read` raises as InputError."""

    def convert(text: str) -> T:
        try:
            return read(text)
        except InputError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return convert


def path(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("the name of a file or folder is empty")
    return Path(text)


def frames(text: str) -> tuple[int, int]:
    wrong = f"'{text}' is not FIRST:LAST, two whole frame numbers such as 1:240"
    with replaced(wrong, ValueError, raised=argparse.ArgumentTypeError):
        first, _, last = text.partition(":")
        found = int(first), int(last)
    if found[0] > found[1]:
        raise argparse.ArgumentTypeError(
            f"{text}: the first frame is after the last; did you mean {found[1]}:{found[0]}?"
        )
    import bpy

    limits = bpy.types.Scene.bl_rna.properties["frame_current"]
    if found[0] < limits.hard_min or found[1] > limits.hard_max:
        raise argparse.ArgumentTypeError(
            f"{text}: Blender's frames are {limits.hard_min} to {limits.hard_max}"
        )
    return found


def whole(least: int, most: int) -> Callable[[str], int]:
    """A type of arguments: whole numbers from `least` to `most`."""

    def convert(text: str) -> int:
        wrong = f"'{text}' is no whole number from {least} to {most}"
        with replaced(wrong, ValueError, raised=argparse.ArgumentTypeError):
            number = int(text)
        if not least <= number <= most:
            raise argparse.ArgumentTypeError(wrong)
        return number

    return convert


def tolerance(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of 0 or more")
    return value


def of_runs(every: argparse.ArgumentParser) -> Parser:
    """The options of all verbs that simulate."""
    run = Parser(add_help=False, parents=[every])
    run.add_argument(
        "--frames",
        type=frames,
        metavar="A:B",
        help="first and last frame (default: the scene's); t = 0 stays at the scene's start, and "
        "frames after the scene's end are run too",
    )
    add_choice(run)
    run.add_argument(
        "--quiet", action="store_true", help="no progress, no advice on standard error"
    )
    return run
