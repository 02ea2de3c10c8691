# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen compare LOG LOG`: compares two event logs; needs no Blender."""

from __future__ import annotations

import json
import sys

from ...sensor_logic.logs.comparison import compare
from ...sensor_logic.logs.comparison.compare import measures, read_both
from ...sensor_logic.logs.files import write_files
from ...sensor_logic.logs.formats.label_map import read_map
from ...sensor_logic.logs.formats.outputs import check_apart
from ...sensor_logic.report import comparison
from ..process.console import DONE, FAILED, note
from ..process.parser import Parser, path, tells_errors


@tells_errors
def main(arguments: list[str], program: str) -> int:
    """Compare two logs, and return the exit status.

    `arguments` are those after `compare`. `program` is the text before `compare` in the help. Raise
    SystemExit if the arguments are wrong.
    """
    options = make_parser(program).parse_args(arguments)
    labels = read_map(options.labels).labels if options.labels else {}
    first, second = read_both(options.log, options.other, labels)
    for text in dict.fromkeys((*first.notes, *second.notes)):
        note(text)
    found = measures(first, second)
    if options.picture:
        check_apart("--picture", options.picture, [options.log, options.other])
        write_files({options.picture: comparison.svg(first, second, found)})
    if options.json:
        return _write_output(
            json.dumps(compare.data(first, second, found), indent=1, ensure_ascii=False) + "\n"
        )
    return _write_output(compare.text(first, second, found))


def _write_output(text: str) -> int:
    if sys.stdout is None:
        return _fail("standard output is closed: redirect it to a file", FAILED)
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        # Without it, Python does not try to write the rest at exit.
        sys.stdout = None  # type: ignore[assignment]
        if isinstance(error, BrokenPipeError):
            # The reader of the output has closed it, as `head` does.
            return FAILED
        return _fail(f"cannot write to standard output: {error.strerror}", FAILED)
    return DONE


def _fail(text: str, status: int) -> int:
    note(text)
    return status


def make_parser(program: str) -> Parser:
    """Return the argument parser of `angen compare`."""
    parser = Parser(
        prog=f"{program} compare",
        description="Compare how long and how often sensors are on, or things done, in two logs.",
    )
    about = (
        "an event log, a folder of days, or a log in another format; or a log of activities, as "
    )
    about += "`learn` reads them, to compare what people did"
    parser.add_argument("log", type=path, metavar="LOG", help=about)
    parser.add_argument("other", type=path, metavar="LOG", help=about)
    parser.add_argument(
        "--labels",
        type=path,
        metavar="FILE.toml",
        help="table [labels] with other names for activities",
    )
    parser.add_argument("--json", action="store_true", help="print JSON, for programs")
    parser.add_argument(
        "--picture",
        type=path,
        metavar="FILE.svg",
        help="draw both logs' distributions, one panel for each measured figure",
    )
    return parser
