# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender HOME.blend --command angen VERB …`: runs the verbs without a window."""

from __future__ import annotations

import argparse
import io
import json
import sys
from collections.abc import Callable
from typing import Any

import bpy

from ...sensor_logic.error import AngenError, InputError
from ...sensor_logic.log.event_log import (
    differences,
    events,
    read_events,
)
from ...sensor_logic.wording import named
from ..coverage import command as coverage
from ..days import command as days
from ..doctor import command as doctor
from ..explain.command import ExplainedTime
from ..layout.apply import apply_layout
from ..output.describe import describe
from ..output.output_files import Outputs, check_outputs
from ..process.quiet import fill_closed_streams, standard_output_silenced
from ..residents.places import check as residents_places
from ..scene.sensors import chosen
from ..scene.units import lengths_of
from .arguments import parse
from .console import DONE, FAILED, note
from .home import open_home, run_home, sensors_of
from .interrupt import Interrupt
from .leaving import leave_hard
from .parser import choice_of
from .progress import ProgressLine
from .simulate import simulate

SHOWN_DIFFERENCES = 50
INTERRUPTED = "interrupted; nothing was written"


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
        "simulate": simulate,
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
                raise AngenError("standard output is closed")
            outputs.commit()
            return status
    except AngenError as error:
        note(str(error))
        return error.status
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


def _list(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = sensors_of(options)
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
    if not options.save:
        raise InputError("apply changes the file: give --save FILE.blend, or it would be lost")
    open_home(options)
    check_outputs({"--save": options.save})
    if options.save.exists() and options.layout.exists() and options.save.samefile(options.layout):
        raise InputError(f"--save: {options.save} is the layout itself, and would overwrite it")
    applied = apply_layout(options.layout, options.remove)
    outputs.save_blend(options.save)
    if not options.quiet:
        note(f"{options.layout.name}: {applied.text}")
    return DONE


def _check(options: argparse.Namespace, outputs: Outputs) -> int:
    try:
        expected = read_events(options.expected)
    except OSError as error:
        raise InputError(f"cannot read {options.expected}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(str(error)) from None
    choice = choice_of(options)
    expected = [event for event in expected if choice.takes(event.sensor, event.kind)]
    recording = run_home(options, chosen(sensors_of(options), choice))
    found = differences(expected, events(recording), options.tolerance, options.time_tolerance)
    outputs.said = "".join(f"{line}\n" for line in found[:SHOWN_DIFFERENCES])
    if len(found) > SHOWN_DIFFERENCES:
        outputs.said += f"and {len(found) - SHOWN_DIFFERENCES} more\n"
    note(f"{len(found)} differences" if found else f"{len(expected)} events as expected")
    if options.lacks:
        note("the check fails, as the home lacks what is named above")
    return FAILED if found or options.lacks else DONE


def _doctor(options: argparse.Namespace, outputs: Outputs) -> int:
    open_home(options)
    found = doctor.findings()
    outputs.said = doctor.as_text(found, options.json)
    note(doctor.count(found))
    return FAILED if found else DONE


def _places(options: argparse.Namespace, outputs: Outputs) -> int:
    open_home(options)
    found = residents_places.check_places(bpy.context.evaluated_depsgraph_get())
    lengths = lengths_of(bpy.context.scene)
    as_text = residents_places.as_text(found, lengths)
    outputs.said = residents_places.as_json(found) if options.json else as_text
    note(found.count)
    return FAILED if found.lost or found.places.problems else DONE


def _explain(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = sensors_of(options)
    scene = bpy.context.scene
    found = chosen(sensors, choice_of(options))
    if len(found) > 1:
        names = named(sensor.name for sensor in found)
        raise InputError(f"explain is about one sensor, and these are {len(found)}: {names}")
    (sensor,) = found
    explained = ExplainedTime(scene, sensors, sensor, options.time)
    if explained.last > bpy.types.Scene.bl_rna.properties["frame_current"].hard_max:
        raise InputError(f"--time {options.time:g}: Blender's frames end before that")
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
    sensors = sensors_of(options, options.layout)
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
    coverage.check_files(options)
    work(options, sensors_of(options), outputs)
    return DONE


_command: Any = None


def register() -> None:
    global _command
    _command = bpy.utils.register_cli_command("angen", run_command)


def unregister() -> None:
    bpy.utils.unregister_cli_command(_command)
