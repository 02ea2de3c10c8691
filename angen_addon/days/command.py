# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen day`: days of a routine in the open home, into a folder."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from datetime import date, datetime
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.days.truth import DAY_S
from ...sensor_logic.error import AngenError, InputError
from ...sensor_logic.formats import FORMATS
from ...sensor_logic.wording import part_is
from ..commands.console import note
from ..commands.parser import add_choice, choice_of
from ..output.output_files import check_not_read
from ..runtime.simulation import Progress
from ..scene.sensors import Sensor, chosen, simulated
from .folder import Folder
from .jobs import WORKER, SharedDays, days_of_worker
from .progress import DayLine
from .run import Household, Plan, run_days

MOST_DAYS = 10_000


def add_verb(verbs: Any, path: Callable[[str], Path], every: argparse.ArgumentParser) -> None:
    """Adds it to the subparsers of the command line, as `coverage.arguments.add_verbs` does."""
    verb = verbs.add_parser(
        "day", parents=[every], help="run days that residents live by a routine"
    )
    verb.add_argument("--routine", type=path, required=True, metavar="FILE.toml")
    verb.add_argument(
        "--diary", type=path, metavar="FILE.csv", help="what is done, instead of the routine's plan"
    )
    verb.add_argument("--start", type=_date, required=True, metavar="DATE", help="the first day")
    verb.add_argument("--days", type=_count, default=1, metavar="N", help="how many (default 1)")
    verb.add_argument("--seed", type=_seed, default=0, metavar="S", help="of chance (default 0)")
    verb.add_argument(
        "--out", type=path, required=True, metavar="DIR", help="a new folder, or one to go on with"
    )
    verb.add_argument(
        "--format",
        action="append",
        default=[],
        choices=[name for name in FORMATS if name != "events"],
        metavar="NAME",
        help=f"also for another tool, in DIR; may be given again: {', '.join(FORMATS)}",
    )
    add_choice(verb)
    verb.add_argument(
        "--jobs",
        type=_count,
        default=1,
        metavar="N",
        help="processes at once (default 1), each of which runs whole days",
    )
    verb.add_argument(
        "--layout",
        type=path,
        metavar="FILE.json",
        help="the home with the sensors of this layout, as `apply` adds and changes them",
    )
    verb.add_argument("--quiet", action="store_true", help="no progress on standard error")
    # The process is one of those that `--jobs` started.
    verb.add_argument(WORKER, action="store_true", help=argparse.SUPPRESS)


def _date(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a date such as 2026-03-02") from None


def _whole(text: str, least: int, most: int) -> int:
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f"'{text}' is no whole number from {least} to {most}")
    return number


def _count(text: str) -> int:
    return _whole(text, 1, MOST_DAYS)


def _seed(text: str) -> int:
    return _whole(text, 0, 0x7FFFFFFF)


def day(options: argparse.Namespace, sensors: list[Sensor]) -> bool:
    """Runs what the options ask for; whether all days are whole. Raises AngenError,
    AngenError; KeyboardInterrupt, when the whole days were kept."""
    told = simulated(chosen(sensors, choice_of(options)))
    if not told:
        raise InputError("no sensor is switched on")
    _check_dates(options)
    check_not_read([options.out / "events.csv"])
    scene = bpy.context.scene
    plan = Plan.read(options.routine, options.diary)
    household = Household(scene, told, plan, options.start, options.seed)
    if options.worker:
        # Never returns: the process ends with the one that started it, which makes the tables.
        folder = Folder(options.out, household, options.format)
        _make(household, folder, days_of_worker(), lambda *_: None)
    # What cannot be acted is told before anything is written.
    household.acted(0)
    return _all(household, Folder(options.out, household, options.format), options)


def _check_dates(options: argparse.Namespace) -> None:
    """Raises InputError where the days, or a format, do not hold such dates."""
    start = datetime.combine(options.start, datetime.min.time())
    for name in ("events", *options.format):
        FORMATS[name].check_dates(start, 0.0, options.days * DAY_S)


def _all(household: Household, folder: Folder, options: argparse.Namespace) -> bool:
    line = DayLine(sys.stderr, options.quiet, options.days, folder)
    left = [n for n in range(options.days) if not folder.has(n)]
    workers = max(min(options.jobs, len(left)) - 1, 0)

    def waiting() -> None:
        options.interrupt.check()
        line.show()

    try:
        with SharedDays(folder, left, workers) as shared:

            def progress(number: int, step: Progress) -> None:
                options.interrupt.check()
                shared.look()
                line.show(step, household.acted(number))

            _make(household, folder, shared.own(waiting), progress)
    finally:
        line.clear()
        whole, notes = folder.finish(options.days)
        for text in notes:
            note(text)
        kept = f"{part_is(whole, options.days, 'day')} in {options.out}"
        if whole < options.days and (whole or options.interrupt.came):
            note(f"{kept}; the same command goes on with the {'next' if whole else 'first'}")
    if whole == options.days and not options.quiet:
        note(f"{kept}{line.summary()}")
    return whole == options.days


def _make(
    household: Household,
    folder: Folder,
    numbers: Iterable[int],
    progress: Callable[[int, Progress], object],
) -> None:
    for day in run_days(household, numbers, progress):
        folder.keep(day)


__all__ = ["AngenError", "InputError", "add_verb", "day"]
