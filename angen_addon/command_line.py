# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender HOME.blend --command angen …`: simulate, list, check, explain, coverage and
place without a window."""

from __future__ import annotations

import argparse
import io
import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from ..sensor_logic.event_log import differences, events, events_csv, read_events, samples_csv
from ..sensor_logic.files import OutputError, file_names
from ..sensor_logic.recording import Recording
from . import advice, bake, state, warmth
from .arguments import parse
from .coverage import command as coverage
from .describe import describe
from .explain.command import Moment
from .interrupt import Interrupt, leave_hard
from .kept import keep
from .output_files import check_outputs, save_blend, write
from .progress import ProgressLine, note
from .report import check_name, report_text
from .sensors import NoSuchSensor, Sensor, SensorError, all_sensors, chosen, simulated
from .simulation import simulate
from .station import ends_before_time

SHOWN_DIFFERENCES = 50
DONE, FAILED, BAD_INPUT = 0, 1, 2
INTERRUPTED = "interrupted; nothing was written"


class BadInput(Exception):
    """The command cannot be carried out as given; the text says why and what would work."""


def run_command(arguments: list[str], program: str = "blender FILE.blend --command angen") -> int:
    """Carries out a command on the open file; returns the exit status."""
    if sys.stdout is None:
        note("standard output is closed")
        return FAILED
    if isinstance(sys.stdout, io.TextIOWrapper):
        # The log is UTF-8 whatever the terminal speaks.
        sys.stdout.reconfigure(encoding="utf-8")
    try:
        options = parse(arguments, program)
    except SystemExit as stop:
        return int(stop.code or 0)
    verbs: dict[str, Callable[[argparse.Namespace], int]] = {
        "simulate": _simulate,
        "list": _list,
        "check": _check,
        "explain": _explain,
        "coverage": _coverage,
        "place": _place,
    }
    interrupt = Interrupt(_give_up)
    # Blender takes Ctrl-C for itself and would go on to the end.
    before = signal.signal(signal.SIGINT, interrupt.on_signal)
    options.interrupt = interrupt
    try:
        status = verbs[options.verb](options)
        sys.stdout.flush()
        return status
    except (BadInput, NoSuchSensor) as error:
        note(str(error))
        return BAD_INPUT
    except (SensorError, OutputError) as error:
        note(str(error))
        return FAILED
    except BrokenPipeError:
        # Who reads our output had enough, as `head` does.
        sys.stdout = None  # type: ignore[assignment]
        return FAILED
    except OSError as error:
        # Files are dealt with where they are written.
        sys.stdout = None  # type: ignore[assignment]
        note(f"cannot write to standard output: {error.strerror}")
        return FAILED
    except KeyboardInterrupt:
        note(INTERRUPTED)
        return FAILED
    finally:
        signal.signal(signal.SIGINT, before or signal.SIG_DFL)


def _give_up() -> None:
    note(INTERRUPTED)
    leave_hard(FAILED)


def _sensors() -> list[Sensor]:
    if not bpy.data.filepath:
        raise BadInput(
            "no blend file is open: it is missing, empty, damaged or of a newer Blender; "
            "see Blender's own message above, if any"
        )
    if bpy.data.version[:2] > bpy.app.version[:2]:
        saved, here = (".".join(map(str, v[:2])) for v in (bpy.data.version, bpy.app.version))
        note(f"the file was saved by Blender {saved}, this is {here}: newer things in it are lost")
    sensors = all_sensors(bpy.context.view_layer)
    if not sensors:
        raise BadInput(
            f"{Path(bpy.data.filepath).name} has no sensors in its scene "
            f"'{bpy.context.scene.name}': add one in Blender with Shift+A, Sensor"
        )
    return sensors


def _run(options: argparse.Namespace) -> Recording:
    """Simulates what the options ask for."""
    scene = bpy.context.scene
    sensors = chosen(_sensors(), options.sensor)
    _tell_of_off(sensors)
    if not options.quiet:
        _tell_of_pads(sensors)
        _tell_of_warmth(sensors)
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
    line.finish(
        progress.seconds_total if progress else 0.0,
        sum(len(track) for track in recording.tracks.values()),
    )
    return recording


def _tell_of_off(sensors: list[Sensor]) -> None:
    """Says which sensors will report nothing."""
    off = [s.name for s in sensors if not s.settings.enabled]
    if off:
        note(f"switched off: {', '.join(off)}")


def _tell_of_warmth(sensors: list[Sensor]) -> None:
    """Says what keeps pyroelectric detectors from feeling what their user expects."""
    found = warmth.pyroelectric(simulated(sensors))
    text = warmth.nothing_warm(bpy.context.view_layer) if found else ""
    if text:
        note(f"{text[0].lower()}{text[1:]}")
    for sensor in found:
        text = warmth.too_slow(sensor)
        if text:
            note(f"'{sensor.name}': {text[0].lower()}{text[1:]}")


def _tell_of_pads(sensors: list[Sensor]) -> None:
    """Says what keeps pressure pads from reading what their user expects."""
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    pads = [s for s in simulated(sensors) if s.kind.motion]
    for ask in (
        lambda pad: advice.without_surface(pad.object),
        lambda pad: advice.sinks(pad.object, scene),
        lambda pad: advice.weightless(pad.object, scene, view_layer),
    ):
        told = {pad.name: text for pad in pads if (text := ask(pad))}
        if told:
            note(advice.of_several(told))
    short = advice.short_cache(scene) if pads else ""
    if short:
        note(short)


def _simulate(options: argparse.Namespace) -> int:
    if options.bake and not options.save:
        raise BadInput("--bake changes the file: give --save FILE.blend too, or it would be lost")
    try:
        check_outputs(options.events, options.samples, options.save, options.report)
        if options.report:
            check_name(options.report, "--report")
    except OutputError as error:
        raise BadInput(str(error)) from None
    recording = _run(options)
    texts: dict[Path, str] = {}
    if options.events:
        texts[options.events] = events_csv(recording, options.start)
    if options.samples is not None:
        for sensor, name in file_names(recording.tracks).items():
            path = options.samples / name
            if options.events and path.resolve() == options.events.resolve():
                raise OutputError(f"--events names the samples of '{sensor}': {path}")
            texts[path] = samples_csv(recording.tracks[sensor], options.start)
    if options.report:
        told = chosen(_sensors(), options.sensor)
        texts[options.report] = report_text(
            options.report, bpy.context.scene, told, recording, options.start
        )
    if options.bake:
        baked = bake.bake(simulated(all_sensors(bpy.context.view_layer)), recording)
        for text in baked.notes:
            note(text)
    if options.save:
        # Whoever opens the copy can scrub through what was recorded.
        scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
        state.CACHE.keep(scene, keep(recording, scene, depsgraph))
        save_blend(options.save)
    write(texts, options.samples)
    if not options.events:
        sys.stdout.write(events_csv(recording, options.start))
    return DONE


def _list(options: argparse.Namespace) -> int:
    sensors = _sensors()
    found = [describe(sensor) for sensor in sensors]
    if options.json:
        print(json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False))
        return DONE
    width = max(len(sensor.name) for sensor in sensors)
    for sensor, facts in zip(sensors, found, strict=True):
        remark = "" if facts["enabled"] else "  off"
        print(
            f"{sensor.name:<{width}}  {sensor.kind.identifier:<14}  "
            f"{facts['update_rate']:6g} Hz  {sensor.room}{remark}".rstrip()
        )
    return DONE


def _check(options: argparse.Namespace) -> int:
    try:
        expected = read_events(options.expected)
    except OSError as error:
        raise BadInput(f"cannot read {options.expected}: {error.strerror}") from None
    except ValueError as error:
        raise BadInput(str(error)) from None
    if options.sensor:
        expected = [event for event in expected if event.sensor in options.sensor]
    recording = _run(options)
    found = differences(expected, events(recording), options.tolerance, options.time_tolerance)
    for line in found[:SHOWN_DIFFERENCES]:
        print(line)
    if len(found) > SHOWN_DIFFERENCES:
        print(f"and {len(found) - SHOWN_DIFFERENCES} more")
    note(f"{len(found)} differences" if found else f"{len(expected)} events as expected")
    return FAILED if found else DONE


def _explain(options: argparse.Namespace) -> int:
    scene, sensors = bpy.context.scene, _sensors()
    (sensor,) = chosen(sensors, [options.sensor])[:1]
    moment = Moment(scene, sensors, sensor, options.time)
    if moment.last > bpy.types.Scene.bl_rna.properties["frame_current"].hard_max:
        raise BadInput(f"--time {options.time:g}: Blender's frames end before that")
    line = ProgressLine(sys.stderr, options.quiet)
    progress = None
    with options.interrupt.watched():
        for progress in moment.run():
            options.interrupt.check()
            line.show(progress)
        line.finish(progress.seconds_total if progress else 0.0, moment.updates)
        text = moment.text()
    sys.stdout.write(text)
    return DONE


def _coverage(options: argparse.Namespace) -> int:
    return _mapped(options, coverage.coverage)


def _place(options: argparse.Namespace) -> int:
    return _mapped(options, coverage.place)


def _mapped(options: argparse.Namespace, work: Callable[..., str]) -> int:
    try:
        coverage.check_files(options)
    except OutputError as error:
        raise BadInput(str(error)) from None
    sys.stdout.write(work(options, _sensors()))
    return DONE


_command: Any = None


def register() -> None:
    global _command
    _command = bpy.utils.register_cli_command("angen", run_command)


def unregister() -> None:
    bpy.utils.unregister_cli_command(_command)
