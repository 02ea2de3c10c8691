# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen simulate`: simulates the home and writes what its sensors publish."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import Any

import bpy

from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.files import file_names, is_same_file
from ...sensor_logic.logs.formats import FORMATS
from ...sensor_logic.logs.log import for_spreadsheets, parse_start, rows_csv
from ...sensor_logic.recording.events import samples_csv
from ...sensor_logic.recording.validity import not_valid, often_not_valid
from ..output import faulty
from ..output.faulty import Faults
from ..output.mqtt import address as mqtt
from ..output.mqtt.address import address_of
from ..output.mqtt.sending import Sending
from ..output.output_files import Exports, Outputs, check_outputs
from ..output.report import check_name, report_text
from ..output.run_log import log_of_run
from ..process.console import DONE, FAILED, note
from ..process.parser import Verb, argument_type, choice_of, path, run_options
from ..recording import bake
from ..recording.results import RESULTS
from ..recording.stored_recording import stored_run
from ..scene.sensors import Sensor, all_sensors, chosen, simulated
from .open_home import run_home, seconds_to_run, sensors_of


def simulate(options: argparse.Namespace, outputs: Outputs) -> int:
    """Simulate the home, add all files to `outputs`, and return the exit status.

    Raise AngenError if an option is wrong or the home cannot be simulated.
    """
    if options.bake and not options.save:
        raise InputError("--bake needs --save FILE.blend, or the keyframes would be lost")
    if not options.events and sys.stdout is None:
        raise InputError("standard output is closed: give --events FILE.csv")
    faults = _faults(options)
    address = address_of(options)
    if address and faults.plan:
        raise InputError(
            "--mqtt sends readings during the run, and --faults changes the log after it: simulate "
            "with --faults, then send the log with `angen replay`"
        )
    sensors = sensors_of(options)
    selected = chosen(sensors, choice_of(options))
    exports = _exports(options, sensors, selected, faults)
    with Sending(address, simulated(selected), options) as sending:
        recording = run_home(options, selected, sending.take)
        is_whole = sending.finish()
    for line in often_not_valid(not_valid(recording.tracks.values())):
        note(line)

    def shown(pieces: Iterable[str]) -> Iterable[str]:
        comma = options.spreadsheet == "comma"
        return for_spreadsheets(pieces, comma) if options.spreadsheet else pieces

    log, truth = faults.of(log_of_run(recording, bpy.context.scene, selected, options.start))
    outputs.texts |= {name: shown([text]) for name, text in truth.items()}
    text = shown([rows_csv((change.event for change in log.changes), options.start)])
    if options.events:
        outputs.texts[options.events] = text
    else:
        outputs.printed = "".join(text)
    if options.samples is not None:
        outputs.folders.append(options.samples)
        for sensor, name in file_names(recording.tracks).items():
            rows = samples_csv(recording.tracks[sensor], options.start)
            outputs.texts[options.samples / name] = shown(rows)
    for text in exports.add_to(outputs, log):
        note(text)
    if options.report:
        outputs.texts[options.report] = report_text(
            options.report, bpy.context.scene, selected, recording, options.start
        )
    if options.bake:
        keyed = simulated(all_sensors(bpy.context.view_layer))
        baked = bake.bake(keyed, recording, bpy.context.scene)
        for text in baked.notes:
            note(text)
    if options.save:
        # So that whoever opens the copy can scrub through the recording.
        scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
        RESULTS.keep(scene, stored_run(recording, scene, depsgraph))
        outputs.save_blend(options.save)
    return DONE if is_whole else FAILED


def _exports(
    options: argparse.Namespace, sensors: list[Sensor], selected: list[Sensor], faults: Faults
) -> Exports:
    """Check all output files, and return the logs to write in formats of other tools.

    Raise InputError if a file cannot be written, or would overwrite a file in use.
    """
    files = {"--events": options.events, "--save": options.save, "--report": options.report}
    faults.check_names(sensor.name for sensor in sensors)
    exports = Exports(options.format, options.out)
    exports.check_dates(options.start, seconds_to_run(options))
    files |= {**exports.files, "--truth": faults.truth}
    for flag, file in files.items():
        if file and faults.file and is_same_file(file, faults.file):
            raise InputError(f"{flag}: {file} is the faults file: give another name")
    check_outputs(files, options.samples, file_names(s.name for s in simulated(selected)).values())
    if options.report:
        check_name(options.report, "--report")
    return exports


def _faults(options: argparse.Namespace) -> Faults:
    """Return the faults, such as lost messages, that the options add to the logs."""
    log = options.events or (options.out[0] if options.out else None)
    return Faults(options.faults, options.truth, log)


def _add_verb(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "simulate",
        parents=[run_options(every)],
        help="simulate the sensors, and write the event log",
    )
    verb.add_argument(
        "--events", type=path, metavar="FILE.csv", help="event log (default: standard output)"
    )
    verb.add_argument(
        "--report",
        type=path,
        metavar="FILE.html",
        help="report with timeline, floor plan and figures; FILE.svg: the pictures alone",
    )
    verb.add_argument(
        "--samples",
        type=path,
        metavar="DIR",
        help="folder for all updates, a CSV file for each sensor",
    )
    verb.add_argument(
        "--start",
        type=argument_type(parse_start),
        metavar="ISO-TIME",
        help="date and time of t = 0, such as 2026-03-01T08:00; logs get a column 'time'",
    )
    verb.add_argument(
        "--spreadsheet",
        nargs="?",
        const="point",
        choices=("point", "comma"),
        metavar="comma",
        help="CSV to open in a spreadsheet: with a byte order mark, and a leading ' where a name "
        "looks like a formula; `comma`: with semicolons and decimal commas, as in German",
    )
    verb.add_argument(
        "--format",
        action="append",
        default=[],
        choices=list(FORMATS),
        metavar="NAME",
        help=f"also write the log in this format, to the --out after it; can be repeated: "
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
    mqtt.add_options(verb, required=False)
    verb.add_argument(
        "--bake", action="store_true", help="bake the outputs to keyframes; needs --save"
    )
    verb.add_argument("--save", type=path, metavar="FILE.blend", help="save the file as a copy")


VERBS = {"simulate": Verb(_add_verb, simulate)}
