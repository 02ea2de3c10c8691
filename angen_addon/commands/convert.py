# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen convert EVENTS.csv --format NAME --out PATH`: converts an event log; needs no Blender."""

from __future__ import annotations

import argparse
from dataclasses import replace
from datetime import datetime
from zoneinfo import ZoneInfo, available_timezones

from ...sensor_logic.logs.error import replaced
from ...sensor_logic.logs.faults import undo
from ...sensor_logic.logs.files import write_files
from ...sensor_logic.logs.formats import FORMATS, Log
from ...sensor_logic.logs.formats.activities import read_logged
from ...sensor_logic.logs.formats.log import DEFAULT_START, LoggedActivity
from ...sensor_logic.logs.formats.outputs import check_apart, check_out, output_files
from ...sensor_logic.logs.formats.reading import read_log
from ...sensor_logic.logs.formats.source import DescribedHome, format_labels, home_beside, read_home
from ...sensor_logic.logs.formats.units import UNIT_HELP, Units
from ...sensor_logic.logs.log import parse_start
from ...sensor_logic.logs.wording import plural
from ..output.faulty import Faults, add_options
from ..process.console import BAD_INPUT, DONE, note
from ..process.parser import Parser, path, tells_errors


@tells_errors
def main(arguments: list[str], program: str) -> int:
    """Convert an event log, and return the exit status.

    `arguments` are those after `convert`. `program` is the text before `convert` in the help. Raise
    SystemExit if the arguments are wrong.
    """
    options = make_parser(program).parse_args(arguments)
    target = FORMATS[options.format]
    try:
        faults = Faults(options.faults, options.truth, options.out)
        given = (options.events, options.home, options.activities, faults.file, options.undo_faults)
        sources = [source for source in given if source]
        check_out(target, options.out, sources)
        log, sensors = _read(options)
        faults.check_names(sensors)
        log, truth = faults.of(log)
        written = target.write(log)
        files = output_files(target, options.out, written)
        for path in truth:
            check_apart("--truth", path, [*sources, *files])
        files |= truth
        if target.is_folder:
            options.out.mkdir(exist_ok=True)
        write_files(files)
    except OverflowError as error:
        note(f"a time or a number in {options.events} is too large: {error}")
        return BAD_INPUT
    for text in written.notes:
        note(text)
    return DONE


def _read(options: argparse.Namespace) -> tuple[Log, set[str]]:
    """Return the log that the options name, and the names of all sensors in the log or the home.

    Raise InputError if a file is wrong, and OSError if it cannot be read.
    """
    home = read_home(options.home) if options.home else home_beside(options.events)
    sensors = home.sensors
    start = parse_start(options.start) if options.start else home.start
    zone = _zone(options.timezone) if options.timezone else None
    if start and zone:
        start = start.replace(tzinfo=zone)
    source = read_log(options.events, start, zone, options.sort, Units.parse(options.unit))
    start = source.start
    for text in source.notes:
        note(text)
    if source.has_activities and not options.activities:
        note(
            f"the activities in {options.events} are not converted: to add them, give "
            f"--activities {options.events}"
        )
    if source.left_out:
        note(
            f"{plural(source.left_out, 'change')} in {options.events} at local times that clocks "
            f"in {options.timezone} skip in spring: moved to the end of the skipped time"
        )
    if options.undo_faults:
        source = replace(source, events=undo(source.events, options.undo_faults))
    if start is None:
        start = DEFAULT_START
        note(
            f"the log has no dates, so its start is taken as {start.isoformat()}: give another "
            "start with --start"
        )
    if zone:
        start = start.astimezone(zone) if start.tzinfo else start.replace(tzinfo=zone)
    activities = _activities(options, start, home)
    log = source.log(sensors, start, activities, home.about)
    return log, sensors.keys() | {sensor.name for sensor in log.sensors}


def _activities(
    options: argparse.Namespace, start: datetime, home: DescribedHome
) -> list[LoggedActivity]:
    """Return the activities to write into the log, with the labels that the format uses.

    They come from the file in the options, or else from simulated days beside the log.
    """
    beside = options.events / "activities.csv"
    found = options.activities or (beside if home.days and beside.is_file() else None)
    if found is None:
        return []
    activities, notes = read_logged(found, start, format_labels(options.format, home.labels))
    for text in notes:
        note(text)
    return activities


def _zone(name: str) -> ZoneInfo:
    hint = "give one such as Europe/Stockholm"
    if not available_timezones():
        # As on Windows without the package.
        hint = "this Python has no list of time zones: pip install tzdata"
    with replaced(f"time zone '{name}' is unknown: {hint}", ValueError, OSError, KeyError):
        return ZoneInfo(name)


def make_parser(program: str) -> Parser:
    """Return the argument parser of `angen convert`."""
    parser = Parser(
        prog=f"{program} convert",
        description="Write an event log in the format of another tool; needs no Blender.",
    )
    parser.add_argument(
        "events",
        type=path,
        metavar="LOG",
        help="an event log, a folder of days, or a log in another format",
    )
    parser.add_argument(
        "--format",
        required=True,
        choices=list(FORMATS),
        metavar="NAME",
        help=", ".join(FORMATS),
    )
    parser.add_argument(
        "--out",
        required=True,
        type=path,
        metavar="PATH",
        help="the output file; for pyadlml, a folder",
    )
    parser.add_argument(
        "--sort",
        action="store_true",
        help="sort the log by time first, and drop rows that repeat another exactly",
    )
    parser.add_argument("--unit", **UNIT_HELP)
    parser.add_argument(
        "--home",
        type=path,
        metavar="HOME.toml",
        help="file with rooms, start and versions, such as `day` writes; or HOME.json, the saved "
        "output of `list --json`",
    )
    parser.add_argument(
        "--activities",
        type=path,
        metavar="FILE.csv",
        help="what people did: activities.csv of simulated days, or another log of activities, as "
        "`learn` reads them",
    )
    parser.add_argument(
        "--start", metavar="TIME", help="date and time of t = 0, such as 2026-03-02T07:00:00"
    )
    parser.add_argument(
        "--timezone",
        metavar="NAME",
        help="time zone of the home, such as Europe/Stockholm (default: none)",
    )
    add_options(parser, path)
    parser.add_argument(
        "--undo-faults",
        type=path,
        metavar="TRUTH.csv",
        help="undo the faults listed in this file, which --truth wrote",
    )
    return parser
