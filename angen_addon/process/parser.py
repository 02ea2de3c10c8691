# SPDX-License-Identifier: GPL-3.0-or-later
"""The subcommands of `angen` (called verbs here), and the options that several of them have."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, ParamSpec, TypeVar

from ...parts import VERBS, WITHOUT_BLENDER, installation, installed, part
from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.logs.error import AngenError, InputError, replaced
from ...sensor_logic.logs.wording import hint
from .console import BAD_INPUT, note

T = TypeVar("T")
P = ParamSpec("P")


class Verb(NamedTuple):
    """A subcommand of `angen`, such as `simulate`, that works on a blend file.

    Attributes
    ----------
    add
        A function that adds the subcommand's parser. Its arguments are argparse's subparsers, and
        a parser with the options that all subcommands have.
    run
        A function that does the work and returns the exit status. Its arguments are the options,
        and an `Outputs`, to which it adds the files to write.
    """

    add: Callable[[Any, argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Any], int]


def verbs_here() -> list[str]:
    """Return the names of the installed subcommands that work on a blend file."""
    return [name for name, module in VERBS.items() if installed(module)]


def verb_of(name: str) -> Verb:
    """Import and return the subcommand with this name."""
    found: Verb = part(VERBS[name]).VERBS[name]
    return found


class Parser(argparse.ArgumentParser):
    """An argument parser that prints its errors in one line."""

    def error(self, message: str) -> NoReturn:
        """Print an error message in one line, and exit with status 2."""
        self.exit(2, f"angen: {message} (see --help)\n")


def parse(arguments: Sequence[str], program: str) -> argparse.Namespace:
    """Parse the arguments of the command line; return the subcommand and its options.

    If they are wrong, print the error and raise SystemExit. `program` is the text before the
    arguments in the help.
    """
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
    """Return the parser of all subcommands that work on a blend file.

    `program` is the program's name in the help.
    """
    parser = Parser(
        prog=program, description="Simulate the ambient sensors of a home in a blend file."
    )
    names = verbs_here()
    verbs = parser.add_subparsers(dest="verb", required=True, metavar=" | ".join(names))
    common = Parser(add_help=False)
    common.add_argument(
        "--enable-autoexec",
        action="store_true",
        help="trust the file: its drivers and scripts may run Python",
    )
    for name in names:
        verb_of(name).add(verbs, common)
    if "--command" not in program:  # else Blender has opened the home
        for name, verb in verbs.choices.items():
            verb.prog += " LAYOUT.json HOME.blend" if name == "apply" else " HOME.blend"
        verbs.choices["apply"].usage = "%(prog)s --save FILE.blend [options]"
    return parser


def lacking(name: str) -> str:
    """Return a text that tells the user how to install the subcommand `name`.

    The text is empty if the subcommand is installed or does not exist.
    """
    folder = WITHOUT_BLENDER.get(name, "").partition(".")[0]
    if not folder or installed(folder):
        return ""
    return f"{name} is in the Python package, not in the extension: {installation(folder)}"


def wrong_verb(name: str) -> str:
    """Return the error text for a `name` that is no subcommand that works on a blend file."""
    if lacking(name):
        return lacking(name)
    if name in WITHOUT_BLENDER:
        return (
            f"{name} runs without Blender: use angen {name}, from the Python package, or "
            f"python -m angen_addon {name} in the project's folder"
        )
    verbs = (*verbs_here(), *WITHOUT_BLENDER)
    return f"there is no verb '{name}'; {hint(name, verbs, len(verbs))}"


def add_names(parser: argparse.ArgumentParser, what: str = "sensor", text: str = "") -> None:
    """Add the option `--sensor`; its help is `text`, or else calls the selected objects `what`."""
    parser.add_argument(
        "--sensor",
        action="append",
        default=[],
        metavar="NAME",
        help=text
        or f'only this {what}, or all that match a pattern such as "PIR*"; can be repeated',
    )


def add_choice(parser: argparse.ArgumentParser, is_one: bool = False) -> None:
    """Add the options that select sensors, such as `--kind`, to a parser.

    If `is_one` is True, the help says that exactly one sensor must be selected.
    """
    if is_one:
        add_names(parser, text="the sensor to explain, or a pattern that matches its name alone")
    else:
        add_names(parser)
    parser.add_argument(
        "--kind",
        action="append",
        default=[],
        type=str.upper,
        choices=list(KINDS),
        metavar="KIND",
        help="select among sensors of this kind, such as PIR"
        if is_one
        else "only sensors of this kind, such as PIR; can be repeated",
    )
    parser.add_argument(
        "--no-light",
        action="store_true",
        help="select among the sensors that are not light sensors"
        if is_one
        else "leave out light sensors, which take most of the time",
    )


def choice_of(options: argparse.Namespace) -> SensorChoice:
    """Return the sensor selection that the options of `add_choice` describe."""
    return SensorChoice(tuple(options.sensor), tuple(options.kind), not options.no_light)


def argument_type(read: Callable[[str], T]) -> Callable[[str], T]:
    """Return a function for the parameter `type` of argparse, which converts a text by `read`.

    An InputError of `read` becomes the ArgumentTypeError that argparse expects.
    """

    def convert(text: str) -> T:
        try:
            return read(text)
        except InputError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return convert


def path(text: str) -> Path:
    """Return the argument as a path; an empty argument is an error."""
    if not text:
        raise argparse.ArgumentTypeError("the name of a file or folder is empty")
    return Path(text)


def frames(text: str) -> tuple[int, int]:
    """Return the first and the last frame of an argument FIRST:LAST."""
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


def whole_number(least: int, most: int) -> Callable[[str], int]:
    """Return a function for the parameter `type` of argparse, which converts a text to an integer.

    An integer that is not from `least` to `most` is an error.
    """

    def convert(text: str) -> int:
        wrong = f"'{text}' is not a whole number from {least} to {most}"
        with replaced(wrong, ValueError, raised=argparse.ArgumentTypeError):
            number = int(text)
        if not least <= number <= most:
            raise argparse.ArgumentTypeError(wrong)
        return number

    return convert


def tolerance(text: str) -> float:
    """Return the argument as a float; a negative number is an error."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of 0 or more")
    return value


def run_options(every: argparse.ArgumentParser) -> Parser:
    """Return a parser with the options of all subcommands that simulate.

    `every` is a parser with the options of all subcommands, which are included.
    """
    run = Parser(add_help=False, parents=[every])
    run.add_argument(
        "--frames",
        type=frames,
        metavar="A:B",
        help="first and last frame (default: the scene's); t = 0 stays at the scene's start, and "
        "frames after the scene's end are simulated too",
    )
    add_choice(run)
    run.add_argument("--quiet", action="store_true", help="print no progress and no advice")
    return run


def tells_errors(main: Callable[P, int]) -> Callable[P, int]:
    """Make a verb's `main` print its errors on one line, and return their exit status.

    These are errors of the extension, and files that cannot be read.
    """

    @functools.wraps(main)
    def run(*arguments: P.args, **options: P.kwargs) -> int:
        try:
            return main(*arguments, **options)
        except AngenError as error:
            note(str(error))
            return error.status
        except OSError as error:
            note(f"cannot read {error.filename}: {error.strerror}")
            return BAD_INPUT

    return run
