# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender HOME.blend --command angen VERB …`: runs the verbs without a window."""

from __future__ import annotations

import argparse
import io
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.files import OutputError, file_names
from ...sensor_logic.formats.source import SourceError
from ...sensor_logic.kind import LIGHT
from ...sensor_logic.layout.entries import LayoutError
from ...sensor_logic.log.event_log import (
    differences,
    events,
    for_spreadsheets,
    read_events,
    rows_csv,
    samples_csv,
)
from ...sensor_logic.recording.tracks import Recording
from ..advice.lacking import lacking
from ..coverage import command as coverage
from ..days import command as days
from ..doctor import command as doctor
from ..explain.command import ExplainedTime
from ..layout.apply import apply_layout
from ..output.describe import describe
from ..output.exports import Exports
from ..output.faulty import Faults
from ..output.mqtt.address import AddressError, address_of
from ..output.mqtt.link import MqttError
from ..output.mqtt.sending import Sending
from ..output.output_files import Outputs, check_outputs
from ..output.report import check_name, report_text
from ..output.run_log import log_of_run
from ..process.quiet import fill_closed_streams, standard_output_silenced
from ..recording import bake
from ..recording.stored_recording import stored_run
from ..residents.places import check as residents_places
from ..residents.places.floor import PlaceError
from ..runtime import state
from ..runtime.simulation import simulate
from ..runtime.time_base import ends_before_time
from ..scene.sensors import NoSuchSensor, Sensor, SensorError, all_sensors, chosen, simulated
from ..scene.units import lengths_of
from . import run_advice
from .arguments import parse
from .console import BAD_INPUT, DONE, FAILED, note
from .interrupt import Interrupt
from .leaving import leave_hard
from .progress import ProgressLine

SHOWN_DIFFERENCES = 50
INTERRUPTED = "interrupted; nothing was written"


class BadInput(Exception):
    """The command or a file that it names is wrong; the text says why, and what would work."""


def run_command(arguments: list[str], program: str = "blender FILE.blend --command angen") -> int:
    """Runs a command on the open file; returns the exit status."""
    fill_closed_streams()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # The log is UTF-8, whatever the terminal's encoding.
        sys.stdout.reconfigure(encoding="utf-8")
    try:
        options = parse(arguments, program)
    except SystemExit as stop:
        return int(stop.code or 0)
    verbs: dict[str, Callable[[argparse.Namespace, Outputs], int]] = {
        "simulate": _simulate,
        "list": _list,
        "apply": _apply,
        "check": _check,
        "explain": _explain,
        "coverage": _coverage,
        "place": _place,
        "doctor": _doctor,
        "places": _places,
        "day": _day,
    }
    try:
        with Interrupt(_give_up) as options.interrupt, Outputs() as outputs:
            with standard_output_silenced():
                status = verbs[options.verb](options, outputs)
            options.interrupt.check()
            if outputs.said and sys.stdout is None and options.verb != "check":
                raise OutputError("standard output is closed")
            outputs.commit()
            return status
    except (BadInput, NoSuchSensor, LayoutError, AddressError, days.DayError) as error:
        note(str(error))
        return BAD_INPUT
    except (SensorError, OutputError, MqttError) as error:
        note(str(error))
        return FAILED
    except BrokenPipeError:
        # The reader of the output has closed it, as `head` does.
        sys.stdout = None  # type: ignore[assignment]
        return FAILED
    except OSError as error:
        # Only standard output is left: errors of files are handled where they are written.
        sys.stdout = None  # type: ignore[assignment]
        note(f"cannot write to standard output: {error.strerror}")
        return FAILED
    except KeyboardInterrupt:
        note(INTERRUPTED)
        return FAILED


def _give_up() -> None:
    note(INTERRUPTED)
    leave_hard(FAILED)


def _open_file(options: argparse.Namespace) -> None:
    """Checks that Blender has opened a file, and opens it again with its scripts if it is trusted.
    Raises BadInput."""
    if not bpy.data.filepath:
        raise BadInput(
            "no blend file is open: it is missing, empty, damaged or of a newer Blender; "
            "Blender may have printed why above"
        )
    if bpy.data.version[:2] > bpy.app.version[:2]:
        saved, here = (".".join(map(str, v[:2])) for v in (bpy.data.version, bpy.app.version))
        note(f"the file was saved by Blender {saved}, this is {here}: newer things in it are lost")
    if options.enable_autoexec:
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath, load_ui=False, use_scripts=True)
    bpy.context.view_layer.update()


def _sensors(options: argparse.Namespace) -> list[Sensor]:
    """All sensors of the scene. Prints what the home lacks, such as missing files, and lists it in
    `options.lacks`. Raises BadInput without sensors."""
    _open_file(options)
    sensors = all_sensors(bpy.context.view_layer)
    options.lacks = []
    _print_lacks(options, sensors)
    if not sensors:
        raise BadInput(
            f"{Path(bpy.data.filepath).name} has no sensors in its scene "
            f"'{bpy.context.scene.name}': add one in Blender with Shift+A, Sensor"
        )
    return sensors


def _run(
    options: argparse.Namespace,
    sensors: list[Sensor],
    on_progress: Callable[[Recording], None] = lambda _: None,
) -> Recording:
    """Simulates the frames in the options; calls `on_progress` with the growing recording."""
    scene = bpy.context.scene
    run_advice.print_advice(sensors, options.quiet)
    first, last = options.frames or (scene.frame_start, scene.frame_end)
    if last < scene.frame_start:
        raise BadInput(ends_before_time(scene, first, last))
    recording = Recording()
    line = ProgressLine(sys.stderr, options.quiet)
    progress = None
    with options.interrupt.watched():
        for progress in simulate(scene, sensors, first, last, recording):
            options.interrupt.check()
            line.show(progress)
            if not progress.doing:
                on_progress(recording)
    line.finish(
        progress.seconds_total if progress else 0.0,
        sum(len(track) for track in recording.tracks.values()),
    )
    # Drivers can fail at any frame.
    _print_lacks(options, sensors)
    return recording


def _print_lacks(options: argparse.Namespace, sensors: list[Sensor]) -> None:
    """Prints what the file needs and lacks, each once."""
    light = any(sensor.kind.requires(LIGHT) for sensor in simulated(sensors))
    for text in lacking(bpy.context.view_layer, light):
        if text not in options.lacks:
            options.lacks.append(text)
            note(text)


def _simulate(options: argparse.Namespace, outputs: Outputs) -> int:
    if options.bake and not options.save:
        raise BadInput("--bake changes the file: give --save FILE.blend too, or it would be lost")
    if not options.events and sys.stdout is None:
        raise BadInput("standard output is closed: give --events FILE.csv")
    faults = _faults(options)
    address = address_of(options)
    if address and faults.plan:
        raise BadInput(
            "--faults changes the log after the run, --mqtt sends what is read in it: simulate "
            "with --faults, then `angen replay` the log"
        )
    sensors = _sensors(options)
    selected = chosen(sensors, options.sensor)
    files = {"--events": options.events, "--save": options.save, "--report": options.report}
    try:
        faults.check_names(sensor.name for sensor in sensors)
        exports = Exports(options.format, options.out)
        files |= {**exports.files, "--truth": faults.truth}
        for flag, path in files.items():
            if path and faults.file and path.resolve() == faults.file.resolve():
                raise OutputError(f"{flag}: {path} is also read; give another name")
        check_outputs(
            files, options.samples, file_names(s.name for s in simulated(selected)).values()
        )
        if options.report:
            check_name(options.report, "--report")
    except (OutputError, SourceError) as error:
        raise BadInput(str(error)) from None
    with Sending(address, simulated(selected), options) as sending:
        recording = _run(options, selected, sending.take)
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
        baked = bake.bake(simulated(all_sensors(bpy.context.view_layer)), recording)
        for text in baked.notes:
            note(text)
    if options.save:
        # So that whoever opens the copy can scrub through the recording.
        scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
        state.CACHE.keep(scene, stored_run(recording, scene, depsgraph))
        outputs.save_blend(options.save)
    return DONE if is_whole else FAILED


def _faults(options: argparse.Namespace) -> Faults:
    """Raises BadInput."""
    try:
        log = options.events or (options.out[0] if options.out else None)
        return Faults(options.faults, options.truth, log)
    except SourceError as error:
        raise BadInput(str(error)) from None
    except OSError as error:
        raise BadInput(f"cannot read {error.filename}: {error.strerror}") from None


def _list(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = _sensors(options)
    found = [describe(sensor) for sensor in sensors]
    if options.json:
        outputs.said = json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        return DONE
    width = max(len(sensor.name) for sensor in sensors)
    for sensor, facts in zip(sensors, found, strict=True):
        remark = "" if facts["enabled"] else "  off"
        line = (
            f"{sensor.name:<{width}}  {sensor.kind.identifier:<14}  "
            f"{facts['update_rate']:6g} Hz  {sensor.room}{remark}"
        )
        outputs.said += f"{line.rstrip()}\n"
    return DONE


def _apply(options: argparse.Namespace, outputs: Outputs) -> int:
    _open_file(options)
    try:
        check_outputs({"--save": options.save})
    except OutputError as error:
        raise BadInput(str(error)) from None
    if options.save.exists() and options.layout.exists() and options.save.samefile(options.layout):
        raise BadInput(f"--save: {options.save} is the layout itself, and would overwrite it")
    applied = apply_layout(options.layout, options.remove)
    outputs.save_blend(options.save)
    if not options.quiet:
        note(f"{options.layout.name}: {applied.text}")
    return DONE


def _check(options: argparse.Namespace, outputs: Outputs) -> int:
    try:
        expected = read_events(options.expected)
    except OSError as error:
        raise BadInput(f"cannot read {options.expected}: {error.strerror}") from None
    except ValueError as error:
        raise BadInput(str(error)) from None
    if options.sensor:
        expected = [event for event in expected if event.sensor in options.sensor]
    recording = _run(options, chosen(_sensors(options), options.sensor))
    found = differences(expected, events(recording), options.tolerance, options.time_tolerance)
    outputs.said = "".join(f"{line}\n" for line in found[:SHOWN_DIFFERENCES])
    if len(found) > SHOWN_DIFFERENCES:
        outputs.said += f"and {len(found) - SHOWN_DIFFERENCES} more\n"
    note(f"{len(found)} differences" if found else f"{len(expected)} events as expected")
    if options.lacks:
        note("the check fails, as the home lacks what is named above")
    return FAILED if found or options.lacks else DONE


def _doctor(options: argparse.Namespace, outputs: Outputs) -> int:
    _open_file(options)
    found = doctor.findings()
    outputs.said = doctor.as_text(found, options.json)
    note(doctor.count(found))
    return FAILED if found else DONE


def _places(options: argparse.Namespace, outputs: Outputs) -> int:
    _open_file(options)
    try:
        found = residents_places.check_places(bpy.context.evaluated_depsgraph_get())
    except PlaceError as error:
        raise BadInput(str(error)) from None
    lengths = lengths_of(bpy.context.scene)
    as_text = residents_places.as_text(found, lengths)
    outputs.said = residents_places.as_json(found) if options.json else as_text
    note(found.count)
    return FAILED if found.lost or found.places.problems else DONE


def _explain(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = _sensors(options)
    scene = bpy.context.scene
    (sensor,) = chosen(sensors, [options.sensor])[:1]
    explained = ExplainedTime(scene, sensors, sensor, options.time)
    if explained.last > bpy.types.Scene.bl_rna.properties["frame_current"].hard_max:
        raise BadInput(f"--time {options.time:g}: Blender's frames end before that")
    line = ProgressLine(sys.stderr, options.quiet)
    progress = None
    with options.interrupt.watched():
        for progress in explained.run():
            options.interrupt.check()
            line.show(progress)
        line.finish(progress.seconds_total if progress else 0.0, explained.updates)
        outputs.said = explained.text(options.now)
    return DONE


def _day(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = _sensors(options)
    try:
        return DONE if days.day(options, sensors) else FAILED
    except KeyboardInterrupt:
        # The complete days are written, and their number was printed.
        options.interrupt.came = False
        return FAILED


def _coverage(options: argparse.Namespace, outputs: Outputs) -> int:
    return _mapped(options, outputs, coverage.coverage)


def _place(options: argparse.Namespace, outputs: Outputs) -> int:
    return _mapped(options, outputs, coverage.place)


def _mapped(options: argparse.Namespace, outputs: Outputs, work: Callable[..., None]) -> int:
    try:
        coverage.check_files(options)
    except OutputError as error:
        raise BadInput(str(error)) from None
    work(options, _sensors(options), outputs)
    return DONE


_command: Any = None


def register() -> None:
    global _command
    _command = bpy.utils.register_cli_command("angen", run_command)


def unregister() -> None:
    bpy.utils.unregister_cli_command(_command)
