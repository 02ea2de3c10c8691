# SPDX-License-Identifier: GPL-3.0-or-later
"""The smaller subcommands that work on a blend file: list, apply, check, explain, doctor."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import bpy

from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.log import differences, read_events
from ...sensor_logic.logs.wording import named
from ...sensor_logic.recording.events import events
from .. import doctor
from ..advice.sensing import open_for_ever
from ..explain.explain import ExplainedTime
from ..layout.apply import apply_layout
from ..layout.describe import describe, layout_text
from ..layout.marks import marks_of
from ..output.output_files import Outputs, check_outputs
from ..process.console import DONE, FAILED, note
from ..process.parser import Verb, add_choice, choice_of, path, run_options, tolerance
from ..runtime.time_base import outside_scene
from ..scene.sensors import Sensor, all_sensors, chosen
from .open_home import ProgressLine, open_home, run_home, sensors_of

SHOWN_DIFFERENCES = 50


def _add_list(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser("list", parents=[every], help="list the sensors and their parameters")
    verb.add_argument("--json", action="store_true", help="print JSON, for programs")
    verb.add_argument(
        "--marks",
        action="store_true",
        help="with --json: print the marks of objects too, for residents",
    )
    verb.add_argument(
        "--out", type=path, metavar="FILE", help="the output file (default: standard output)"
    )


def _list(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = sensors_of(options)
    check_outputs({"--out": options.out})
    if options.json:
        marks = marks_of(bpy.context.view_layer) if options.marks else None
        text = layout_text(sensors, marks)
    else:
        text = _table(sensors)
    if options.out:
        outputs.texts[options.out] = text
    else:
        outputs.printed = text
    return DONE


def _table(sensors: Sequence[Sensor]) -> str:
    width = max(len(sensor.name) for sensor in sensors)
    text = ""
    for sensor in sensors:
        facts = describe(sensor)
        remark = "" if facts["enabled"] else "  off"
        line = (
            f"{sensor.name:<{width}}  {sensor.kind.identifier:<14}  "
            f"{facts['update_rate']:6g} Hz  {sensor.room}{remark}"
        )
        text += f"{line.rstrip()}\n"
    return text


def _add_apply(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "apply", parents=[every], help="add and change sensors to match a layout file"
    )
    verb.add_argument(
        "layout", type=path, metavar="LAYOUT.json", help="sensors, as `list --json` prints them"
    )
    verb.add_argument(
        "--save", type=path, metavar="FILE.blend", help="file for the changed home; required"
    )
    verb.add_argument(
        "--remove",
        action="store_true",
        help="delete sensors of the home that are not in the layout",
    )
    verb.add_argument("--quiet", action="store_true", help="print no summary")


def _apply(options: argparse.Namespace, outputs: Outputs) -> int:
    if not options.save:
        raise InputError("apply needs --save FILE.blend, or the changes would be lost")
    open_home(options)
    check_outputs({"--save": options.save})
    if options.save.exists() and options.layout.exists() and options.save.samefile(options.layout):
        raise InputError(f"--save: {options.save} is the layout itself: give another file")
    applied = apply_layout(options.layout, options.remove)
    outputs.save_blend(options.save)
    if not options.quiet:
        note(f"{options.layout.name}: {applied.text}")
        sensors = all_sensors(bpy.context.view_layer)
        for text in open_for_ever(sensors, bpy.context.evaluated_depsgraph_get()):
            note(text)
    return DONE


def _add_check(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "check", parents=[run_options(every)], help="simulate and compare with an event log"
    )
    verb.add_argument(
        "expected", type=path, metavar="EXPECTED.csv", help="event log to compare with"
    )
    verb.add_argument(
        "--tolerance",
        type=tolerance,
        default=0.0,
        metavar="X",
        help="numbers that differ by at most this count as equal (default 0)",
    )
    verb.add_argument(
        "--time-tolerance",
        type=tolerance,
        default=0.0,
        metavar="SECONDS",
        help="times that differ by at most this count as equal (default 0)",
    )


def _check(options: argparse.Namespace, outputs: Outputs) -> int:
    with explained(f"cannot read {options.expected}", OSError):
        expected = read_events(options.expected)
    choice = choice_of(options)
    expected = [event for event in expected if choice.takes(event.sensor, event.kind)]
    recording = run_home(options, chosen(sensors_of(options), choice))
    found = differences(expected, events(recording), options.tolerance, options.time_tolerance)
    outputs.printed = "".join(f"{line}\n" for line in found[:SHOWN_DIFFERENCES])
    if len(found) > SHOWN_DIFFERENCES:
        outputs.printed += f"and {len(found) - SHOWN_DIFFERENCES} more\n"
    note(f"{len(found)} differences" if found else f"{len(expected)} events as expected")
    if options.lacks:
        note("the check fails, because the files or drivers named above are missing or do not work")
    return FAILED if found or options.lacks else DONE


def _add_explain(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "explain", parents=[every], help="name the object that made a sensor report its last event"
    )
    add_choice(verb, is_one=True)
    verb.add_argument(
        "--time",
        type=tolerance,
        required=True,
        metavar="SECONDS",
        help="explain the last event at or before this time of the event log",
    )
    verb.add_argument(
        "--now",
        action="store_true",
        help="explain the reading at this time instead, and what would change it",
    )
    verb.add_argument("--quiet", action="store_true", help="print no progress and no advice")


def _explain(options: argparse.Namespace, outputs: Outputs) -> int:
    sensors = sensors_of(options)
    scene = bpy.context.scene
    found = chosen(sensors, choice_of(options))
    if len(found) > 1:
        names = named(sensor.name for sensor in found)
        raise InputError(f"explain needs one sensor: give --sensor NAME, one of {names}")
    (sensor,) = found
    explained_time = ExplainedTime(scene, sensors, sensor, options.time)
    if explained_time.last > bpy.types.Scene.bl_rna.properties["frame_current"].hard_max:
        raise InputError(
            f"--time {options.time:g} is after Blender's last frame: give an earlier one"
        )
    outside = outside_scene(scene, scene.frame_start, explained_time.last)
    if outside and not options.quiet:
        note(outside)
    line = ProgressLine(sys.stderr, options.quiet)
    progress = None
    with options.interrupt.watched():
        for progress in explained_time.run():
            options.interrupt.check()
            line.show(progress)
        line.finish(progress.seconds_total if progress else 0.0, explained_time.updates)
        outputs.printed = explained_time.text(options.now)
    return DONE


def _add_doctor(verbs: Any, every: argparse.ArgumentParser) -> None:
    verb = verbs.add_parser(
        "doctor", parents=[every], help="find problems in the home that give sensors wrong readings"
    )
    verb.add_argument("--json", action="store_true", help="print JSON, for programs")


def _doctor(options: argparse.Namespace, outputs: Outputs) -> int:
    open_home(options)
    found = doctor.findings()
    outputs.printed = doctor.as_text(found, options.json)
    note(doctor.count(found))
    return FAILED if found else DONE


VERBS = {
    "list": Verb(_add_list, _list),
    "apply": Verb(_add_apply, _apply),
    "check": Verb(_add_check, _check),
    "explain": Verb(_add_explain, _explain),
    "doctor": Verb(_add_doctor, _doctor),
}
