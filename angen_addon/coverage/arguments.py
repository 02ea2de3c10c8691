# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of `angen coverage` and `angen place`."""

from __future__ import annotations

import argparse
from typing import Any

from ...sensor_logic.coverage.motions import MOTIONS
from ..commands.parser import add_names, path
from .candidates import MOUNTINGS


def add_coverage(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "coverage", parents=[_common(every)], help="where motion detectors notice what moves"
    )
    add_names(verb, "motion detector")


def _common(every: argparse.ArgumentParser) -> argparse.ArgumentParser:
    common = argparse.ArgumentParser(add_help=False, parents=[every])
    common.add_argument(
        "--motion",
        choices=tuple(MOTIONS),
        default="STEP",
        metavar="|".join(MOTIONS),
        help="what moves in each cell (default STEP)",
    )
    common.add_argument(
        "--height",
        type=_positive,
        default=0.0,
        metavar="M",
        help="above the floor: the top of what walks, the middle of a chest or an arm",
    )
    common.add_argument(
        "--cell", type=_positive, default=0.25, metavar="M", help="side of a cell (default 0.25)"
    )
    common.add_argument(
        "--room",
        action="append",
        default=[],
        metavar="NAME",
        help="only this room; may be given again",
    )
    common.add_argument("--csv", type=path, metavar="FILE.csv", help="a row for each cell or place")
    common.add_argument(
        "--picture", type=path, metavar="FILE.svg", help="the map on the plan of the home"
    )
    common.add_argument("--save", type=path, metavar="FILE.blend", help="save the file, as a copy")
    common.add_argument("--quiet", action="store_true", help="no progress on standard error")
    return common


def add_place(verbs: Any, every: argparse.ArgumentParser) -> None:
    place = verbs.add_parser(
        "place",
        parents=[_common(every)],
        help="propose places of motion detectors; --save places them",
    )
    place.add_argument("--count", type=_whole, default=1, metavar="N", help="how many (default 1)")
    place.add_argument(
        "--mounting",
        choices=MOUNTINGS,
        default="WALL",
        metavar="|".join(MOUNTINGS),
        help="where they may hang (default WALL)",
    )
    place.add_argument(
        "--mounting-height",
        type=_positive,
        default=2.3,
        metavar="M",
        help="above the floor, on walls (default 2.3)",
    )
    place.add_argument(
        "--spacing",
        type=_positive,
        default=0.5,
        metavar="M",
        help="between places that are tried (default 0.5)",
    )
    place.add_argument("--like", metavar="SENSOR", help="with the parameters of this detector")
    place.add_argument("--preset", metavar="PRESET", help="with the parameters of this preset")
    place.add_argument(
        "--beside", action="store_true", help="count only what the detectors there do not cover"
    )
    place.add_argument(
        "--seed",
        type=_seed,
        default=0,
        metavar="N",
        help="which of equally good places is taken (default 0)",
    )


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a length above 0 in m, such as 0.25")
    return value


def _whole(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of 1 or more")
    return int(text)


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of 0 or more")
    return int(text)
