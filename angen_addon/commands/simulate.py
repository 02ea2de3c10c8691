# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen simulate`: runs the home and writes what its sensors report."""

from __future__ import annotations

import argparse
import sys

import bpy

from ...sensor_logic.error import InputError
from ...sensor_logic.files import file_names
from ...sensor_logic.log.event_log import for_spreadsheets, rows_csv, samples_csv
from ..output.exports import Exports
from ..output.faulty import Faults
from ..output.mqtt.address import address_of
from ..output.mqtt.sending import Sending
from ..output.output_files import Outputs, check_outputs
from ..output.report import check_name, report_text
from ..output.run_log import log_of_run
from ..recording import bake
from ..recording.stored_recording import stored_run
from ..runtime import state
from ..scene.sensors import Sensor, all_sensors, chosen, simulated
from .console import DONE, FAILED, note
from .home import run_home, seconds_to_run, sensors_of
from .parser import choice_of


def simulate(options: argparse.Namespace, outputs: Outputs) -> int:
    if options.bake and not options.save:
        raise InputError("--bake changes the file: give --save FILE.blend too, or it would be lost")
    if not options.events and sys.stdout is None:
        raise InputError("standard output is closed: give --events FILE.csv")
    faults = _faults(options)
    address = address_of(options)
    if address and faults.plan:
        raise InputError(
            "--faults changes the log after the run, --mqtt sends what is read in it: simulate "
            "with --faults, then `angen replay` the log"
        )
    sensors = sensors_of(options)
    selected = chosen(sensors, choice_of(options))
    exports = _exports(options, sensors, selected, faults)
    with Sending(address, simulated(selected), options) as sending:
        recording = run_home(options, selected, sending.take)
        is_whole = sending.finish()
    shown = for_spreadsheets if options.spreadsheet else str
    log, truth = faults.of(log_of_run(recording, bpy.context.scene, selected, options.start))
    outputs.texts |= {path: shown(text) for path, text in truth.items()}
    text = shown(rows_csv((change.event for change in log.changes), options.start))
    if options.events:
        outputs.texts[options.events] = text
    else:
        outputs.said = text
    if options.samples is not None:
        outputs.folders.append(options.samples)
        for sensor, name in file_names(recording.tracks).items():
            rows = samples_csv(recording.tracks[sensor], options.start)
            outputs.texts[options.samples / name] = map(shown, rows)
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
        state.CACHE.keep(scene, stored_run(recording, scene, depsgraph))
        outputs.save_blend(options.save)
    return DONE if is_whole else FAILED


def _exports(
    options: argparse.Namespace, sensors: list[Sensor], selected: list[Sensor], faults: Faults
) -> Exports:
    """The logs in other formats. Raises InputError where a file cannot be written as asked."""
    files = {"--events": options.events, "--save": options.save, "--report": options.report}
    faults.check_names(sensor.name for sensor in sensors)
    exports = Exports(options.format, options.out)
    exports.check_dates(options.start, seconds_to_run(options))
    files |= {**exports.files, "--truth": faults.truth}
    for flag, path in files.items():
        if path and faults.file and path.resolve() == faults.file.resolve():
            raise InputError(f"{flag}: {path} is also read; give another name")
    check_outputs(files, options.samples, file_names(s.name for s in simulated(selected)).values())
    if options.report:
        check_name(options.report, "--report")
    return exports


def _faults(options: argparse.Namespace) -> Faults:
    """Raises InputError."""
    try:
        log = options.events or (options.out[0] if options.out else None)
        return Faults(options.faults, options.truth, log)
    except OSError as error:
        raise InputError(f"cannot read {error.filename}: {error.strerror}") from None
