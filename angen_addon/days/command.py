# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen day`: days of a routine in the open home, into a folder."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from datetime import date, datetime
from functools import partial
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.days.cuts import shares
from ...sensor_logic.days.times import LEAD_S, hours_minutes
from ...sensor_logic.days.truth import DAY_S
from ...sensor_logic.files import OutputError
from ...sensor_logic.formats import FORMATS, DateError
from ..commands.console import note
from ..output.output_files import check_not_read
from ..runtime.simulation import Progress
from ..scene.sensors import Sensor, chosen, simulated
from .daylight import Daylight
from .folder import Folder
from .jobs import LOOK_EVERY, Workers
from .progress import DayLine
from .run import DayError, Household, Plan, run_days
from .stretch import DayStretch, Last, State, differing, why_whole

MOST_DAYS = 10_000
# One process makes all.
WHOLE = 0, 1


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
    verb.add_argument(
        "--sensor",
        action="append",
        default=[],
        metavar="NAME",
        help="only this sensor; may be given again",
    )
    verb.add_argument(
        "--jobs",
        type=_count,
        default=1,
        metavar="N",
        help="processes at once (default 1); they share the days, and the hours of days left over",
    )
    verb.add_argument(
        "--layout",
        type=path,
        metavar="FILE.json",
        help="the home with the sensors of this layout, as `apply` adds and changes them",
    )
    verb.add_argument("--quiet", action="store_true", help="no progress on standard error")
    # Which process this is of several that share the days, and which days are cut for them.
    verb.add_argument("--day-share", type=_part, default=WHOLE, help=argparse.SUPPRESS)
    verb.add_argument("--cut-days", type=_numbers, default=(), help=argparse.SUPPRESS)


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


def _part(text: str) -> tuple[int, int]:
    first, _, count = text.partition("/")
    return int(first), int(count)


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(map(int, text.split(",")))


def day(options: argparse.Namespace, sensors: list[Sensor]) -> bool:
    """Runs what the options ask for; whether all days are whole. Raises DayError, OutputError,
    SensorError, NoSuchSensor; KeyboardInterrupt, when the whole days were kept."""
    told = simulated(chosen(sensors, options.sensor))
    if not told:
        raise DayError("no sensor is switched on")
    _check_dates(options)
    check_not_read([options.out / "events.csv"])
    scene = bpy.context.scene
    plan = Plan.read(options.routine, options.diary)
    household = Household(scene, told, plan, options.start, options.seed)
    # What cannot be acted is told before anything is written.
    household.acted(0)
    folder = Folder(options.out, household, options.format)
    if options.day_share != WHOLE:
        # One of several processes, the first of which makes the tables.
        for _ in _made(household, folder, options, lambda *_: None):
            pass
        return True
    return _all(household, folder, options)


def _check_dates(options: argparse.Namespace) -> None:
    """Raises DayError where the days, or a format, do not hold such dates."""
    start = datetime.combine(options.start, datetime.min.time())
    try:
        for name in ("events", *options.format):
            FORMATS[name].check_dates(start, 0.0, options.days * DAY_S)
    except DateError as error:
        raise DayError(str(error)) from None


def _all(household: Household, folder: Folder, options: argparse.Namespace) -> bool:
    for number in range(options.days):
        folder.join(number)
    line = DayLine(sys.stderr, options.quiet, options.days, folder)
    left = [n for n in range(options.days) if not folder.has(n)]
    jobs, options.cut_days = _shared(household, left, options)
    options.day_share = 0, jobs
    try:
        with Workers(jobs, options.cut_days) as workers:
            for _ in _made(household, folder, options, line.show):
                pass
            for _ in workers.wait():
                options.interrupt.check()
                line.show()
                if all(folder.has(n) or folder.chain(n) for n in left):
                    break
            good = workers.good
    finally:
        line.clear()
        for number in options.cut_days:
            folder.join(number)
        whole, notes = folder.finish(options.days)
        for text in notes:
            note(text)
        kept = f"{whole} of {options.days} days are in {options.out}"
        if 0 < whole < options.days:
            note(f"{kept}; the same command goes on with the next")
    if not options.quiet:
        note(f"{kept}{line.summary()}")
    return good and whole == options.days


def _shared(
    household: Household, left: list[int], options: argparse.Namespace
) -> tuple[int, tuple[int, ...]]:
    """How many processes there is something to do for, and which of the days that are `left` are
    cut for them: each has as many of the others."""
    over = len(left) % options.jobs
    cut = tuple(left[len(left) - over :])
    why = why_whole(household.scene) if cut else ""
    if why:
        note(f"--jobs: {why}, so no day is shared by several processes")
        cut = ()
    return (options.jobs if cut else min(options.jobs, max(len(left), 1))), cut


def _cuts(household: Household, number: int, jobs: int) -> tuple[float, ...]:
    """At which times (s since midnight) a day is cut for so many processes."""
    spans = household.acted(number).spans(0.0, DAY_S)
    daylight = Daylight(household.scene, household.sensors, household.date_of(number))
    return shares(spans, DAY_S, jobs, LEAD_S, daylight.changes()) if len(spans) else ()


def _made(
    household: Household,
    folder: Folder,
    options: argparse.Namespace,
    show: Callable[..., None],
) -> Iterator[None]:
    """This process's share of the days that are not there yet, one after the other, and its stretch
    of each of those that are cut."""
    part, parts = options.day_share

    def progress(number: int, step: Progress) -> None:
        options.interrupt.check()
        show(step, household.acted(number))

    every = [n for n in range(part, options.days, parts) if n not in options.cut_days]
    left = [n for n in every if not folder.has(n)]
    for number, made in zip(left, run_days(household, left, progress), strict=False):
        folder.keep(number, made)
        yield
    for number in options.cut_days:
        cuts = _cuts(household, number, parts)
        count = len(cuts) + 1
        if part >= count or folder.has(number) or (part, count) in folder.parts(number):
            continue
        stretch = _stretch(household, folder, options, number, part, cuts)
        for made in run_days(household, [number], progress, stretch):
            folder.keep_part(number, part, stretch.until or count, count, made)
        yield


def _stretch(
    household: Household,
    folder: Folder,
    options: argparse.Namespace,
    number: int,
    part: int,
    cuts: tuple[float, ...],
) -> DayStretch:
    count, parent = len(cuts) + 1, os.getppid()

    def meets(other: int, state: State) -> bool:
        begun = folder.state(number, other, count)
        if begun is None:
            # Nobody has come so far: whoever does is late.
            return False
        names = differing(state, begun)
        if names and not options.quiet:
            when = f"{household.date_of(number)} {hours_minutes(cuts[other - 1])}"
            note(f"{when}: one process goes on, for {names[0] or 'a driver'} had not settled there")
        return not names

    def last_before() -> Last:
        while (last := folder.last(number, count, part)) is None:
            options.interrupt.check()
            if os.getppid() != parent:
                raise DayError("the process that has the first hours is gone")
            time.sleep(LOOK_EVERY)
        return last

    return DayStretch(
        part,
        cuts,
        partial(folder.keep_state, number, part, count),
        meets,
        last_before,
        partial(folder.keep_last, number, count),
    )


__all__ = ["DayError", "OutputError", "add_verb", "day"]
