# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the commands `angen day` and `angen places`.

`angen day` simulates days of a routine in the open home and writes them into a folder. It runs in
one process or several.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable
from typing import Any, TextIO

import bpy

from ...angen_addon.commands.open_home import open_home, sensors_of
from ...angen_addon.output.output_files import Outputs, check_not_read
from ...angen_addon.process.console import DONE, FAILED, ProgressText, note
from ...angen_addon.process.parser import (
    Verb,
    add_choice,
    argument_type,
    choice_of,
    path,
    whole_number,
)
from ...angen_addon.runtime.simulation import Progress
from ...angen_addon.scene.lengths import lengths_of
from ...angen_addon.scene.sensors import Sensor, chosen, simulated
from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.formats import FORMATS
from ...sensor_logic.logs.log import parse_date
from ...sensor_logic.logs.wording import part_is, percent
from ..acting.timeline import Acted
from ..days.rows import EVENTS
from ..days.truth import DAY_S
from ..routine.timetable import check_covers
from . import reachable
from .folder import Folder, check_dates
from .run import LARGEST_SEED, HouseholdDays, Plan, moved_share, run_days
from .shared_days import WORKER, SharedDays, days_of_worker

# s between two lines of progress elsewhere than in a terminal.
LOG_S = 30.0


class DayLine:
    """The progress of a run of days, written to standard error.

    With --jobs it counts complete days only.
    """

    def __init__(self, stream: TextIO, quiet: bool, days: int, folder: Folder) -> None:
        self._text, self._days, self._folder = ProgressText(quiet, stream, LOG_S), days, folder
        self._begin = time.perf_counter()
        self._earlier = self._whole()

    def _whole(self) -> int:
        return sum(self._folder.has(number) for number in range(self._days))

    def show(self, step: Progress | None = None, acted: Acted | None = None) -> None:
        """Write the progress `step` of a day, in which residents do what `acted` says.

        Both are None if several processes simulate days.
        """
        if not self._text.is_due():
            return
        whole = self._whole()
        part = step.share if step is not None else 0.0
        moved = moved_share(acted.spans(0.0, DAY_S), part) if acted is not None else part
        made = whole - self._earlier + moved
        text = f"day {min(whole + 1, self._days)} of {self._days}"
        text += f", {percent(part)} of it" if step is not None else ""
        if made > 0.02:
            each = (time.perf_counter() - self._begin) / made
            left = each * (self._days - whole - moved)
            text += f", {60 / each:.2g} days a minute, about {_rounded(left)} left"
        if step is not None and step.doing:
            text += f", {step.doing}"
        self._text.write(text)

    def clear(self) -> None:
        self._text.clear()

    def summary(self) -> str:
        """Return a text with the number of simulated days and the time taken; "" for no days."""
        made, took = self._whole() - self._earlier, time.perf_counter() - self._begin
        return f"; {made} simulated in {_rounded(took)}" if made else ""


def _rounded(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


# Type of the options --days and --jobs.
_COUNT = whole_number(1, 10_000)


def _add_day(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "day", parents=[every], help="simulate whole days of residents who follow a routine"
    )
    verb.add_argument(
        "--routine",
        type=path,
        required=True,
        metavar="FILE.toml",
        help="routine: what residents do, and when",
    )
    verb.add_argument(
        "--diary",
        type=path,
        metavar="FILE.csv",
        help="table of activities that replaces the plans of the routine; or a folder of them",
    )
    verb.add_argument(
        "--start",
        type=argument_type(parse_date),
        required=True,
        metavar="DATE",
        help="date of the first day",
    )
    verb.add_argument(
        "--days", type=_COUNT, default=1, metavar="N", help="number of days (default 1)"
    )
    seed = whole_number(0, LARGEST_SEED)
    tools = [name for name in FORMATS if name != "events"]
    verb.add_argument(
        "--seed", type=seed, default=0, metavar="S", help="seed of all random draws (default 0)"
    )
    verb.add_argument(
        "--out",
        type=path,
        required=True,
        metavar="DIR",
        help="new folder for the days; or the folder of the same command, to continue it",
    )
    verb.add_argument(
        "--format",
        action="append",
        default=[],
        choices=tools,
        metavar="NAME",
        help=f"also write a log for another tool into DIR; can be repeated: {', '.join(tools)}",
    )
    verb.add_argument(
        "--samples",
        action="store_true",
        help="also keep all updates, with the frames of arrays: DIR/samples/SENSOR/DATE.csv.gz",
    )
    add_choice(verb)
    verb.add_argument(
        "--jobs",
        type=_COUNT,
        default=1,
        metavar="N",
        help="number of processes (default 1); each simulates whole days",
    )
    verb.add_argument(
        "--layout",
        type=path,
        metavar="FILE.json",
        help="first add and change sensors to match this layout, as `apply` does",
    )
    verb.add_argument("--quiet", action="store_true", help="print no progress")
    # Set in the processes that --jobs starts.
    verb.add_argument(WORKER, action="store_true", help=argparse.SUPPRESS)


def _day(options: argparse.Namespace, _outputs: Outputs) -> int:
    sensors = sensors_of(options, options.layout)
    try:
        return DONE if _run(options, sensors) else FAILED
    except KeyboardInterrupt:
        # The whole days are written, and their number was printed.
        options.interrupt.came = False
        return FAILED


def _run(options: argparse.Namespace, sensors: list[Sensor]) -> bool:
    """Simulate the days, and return whether all of them are complete.

    Raise `AngenError` if an option is invalid. After an interrupt, write the complete days and
    raise `KeyboardInterrupt`.
    """
    chosen_sensors = simulated(chosen(sensors, choice_of(options)))
    if not chosen_sensors:
        raise InputError("no sensor is switched on: choose others, or enable some in the home")
    check_dates(options.start, options.days, options.format)
    check_not_read([options.out / EVENTS])
    scene = bpy.context.scene
    plan = Plan.read(options.routine, options.diary)
    days = options.start, options.days, str(options.diary)
    told = check_covers(plan.diary, plan.first, plan.routine.persons, *days)
    household = HouseholdDays(scene, chosen_sensors, plan, options.start, options.seed)
    if options.worker:
        # This never returns: the process that started this one ends it, and writes the tables.
        folder = Folder(options.out, household, options.format, options.samples)
        _make(household, folder, days_of_worker(), lambda *_: None)
    # Act the first day now: errors come before anything is written.
    household.acted(0)
    for text in told:
        note(text)
    _note_new(household)
    folder = Folder(options.out, household, options.format, options.samples)
    return _all(household, folder, options)


def _all(household: HouseholdDays, folder: Folder, options: argparse.Namespace) -> bool:
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
                shared.poll_workers()
                line.show(step, household.acted(number))

            _make(household, folder, shared.own_days(waiting), progress, options.days)
    finally:
        line.clear()
        whole, notes = folder.finish(options.days)
        for text in notes:
            note(text)
        kept = f"{part_is(whole, options.days, 'day')} in {options.out}"
        if whole < options.days and (whole or options.interrupt.came):
            note(
                f"{kept}; give the same command again to continue with the "
                f"{'next' if whole else 'first'}"
            )
    if whole == options.days and not options.quiet:
        note(f"{kept}{line.summary()}")
    return whole == options.days


def _make(
    household: HouseholdDays,
    folder: Folder,
    numbers: Iterable[int],
    progress: Callable[[int, Progress], object],
    days: int = 0,
) -> None:
    """Simulate days into the folder, whose `events.csv` grows to at most `days` days.

    `days` is 0 in a worker, which leaves tables and what is to be told to the first process.
    """
    if days:
        folder.grow(days)
    for day in run_days(household, numbers, progress):
        folder.keep(day)
        if days:
            folder.grow(days)
            _note_new(household)


def _note_new(household: HouseholdDays) -> None:
    for text in household.take_notes():
        note(text)


def _add_places(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "places",
        parents=[every],
        help="list the places marked for residents, and those that they cannot reach",
    )
    verb.add_argument("--json", action="store_true", help="print JSON instead of a table")


def _places(options: argparse.Namespace, outputs: Outputs) -> int:
    open_home(options)
    found = reachable.check_places(bpy.context.evaluated_depsgraph_get())
    as_text = reachable.as_text(found, lengths_of(bpy.context.scene))
    outputs.printed = reachable.as_json(found) if options.json else as_text
    note(found.count)
    return FAILED if found.lost or found.places.problems or found.unable else DONE


VERBS = {"day": Verb(_add_day, _day), "places": Verb(_add_places, _places)}
