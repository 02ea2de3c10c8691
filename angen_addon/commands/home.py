# SPDX-License-Identifier: GPL-3.0-or-later
"""The home in the open file: its sensors, what it lacks, and a run over its frames."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import bpy

from ...sensor_logic.error import InputError
from ...sensor_logic.kind import LIGHT
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.wording import named
from ..advice.lacking import lacking
from ..layout.apply import apply_layout
from ..runtime.simulation import simulate, unrecorded
from ..runtime.time_base import ends_before_time, outside_scene
from ..scene.sensors import Sensor, all_sensors, simulated
from . import run_advice
from .console import note
from .progress import ProgressLine


def open_home(options: argparse.Namespace) -> None:
    """Checks that Blender has opened a file, and opens it again with its scripts if it is trusted.
    Raises InputError."""
    if not bpy.data.filepath:
        raise InputError(
            "no blend file is open: it is missing, empty, damaged or of a newer Blender; "
            "Blender may have printed why above"
        )
    if bpy.data.version[:2] > bpy.app.version[:2]:
        saved, here = (".".join(map(str, v[:2])) for v in (bpy.data.version, bpy.app.version))
        note(f"the file was saved by Blender {saved}, this is {here}: newer things in it are lost")
    if options.enable_autoexec:
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath, load_ui=False, use_scripts=True)
    bpy.context.view_layer.update()


def sensors_of(options: argparse.Namespace, layout: Path | None = None) -> list[Sensor]:
    """All sensors of the scene, changed to match a layout. Prints what the home lacks, such as
    missing files, and lists it in `options.lacks`. Raises InputError without sensors."""
    open_home(options)
    if layout is not None:
        apply_layout(layout)
    sensors = all_sensors(bpy.context.view_layer)
    options.lacks = []
    _print_lacks(options, sensors)
    if not sensors:
        raise InputError(
            f"{Path(bpy.data.filepath).name} has no sensors in its scene "
            f"'{bpy.context.scene.name}': add one in Blender with Shift+A, Sensor"
        )
    return sensors


def run_home(
    options: argparse.Namespace,
    sensors: list[Sensor],
    on_progress: Callable[[Recording], None] = lambda _: None,
) -> Recording:
    """Simulates the frames in the options; calls `on_progress` with the growing recording."""
    scene = bpy.context.scene
    run_advice.print_advice(sensors, options.quiet)
    others = unrecorded(simulated(sensors))
    if others and not options.quiet:
        note(f"simulated too, since drivers read their outputs: {named(s.name for s in others)}")
    first, last = _frames_to_run(options)
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


def _frames_to_run(options: argparse.Namespace) -> tuple[int, int]:
    """First and last frame; prints where these are not all the scene's. Raises InputError."""
    scene = bpy.context.scene
    first, last = options.frames or (scene.frame_start, scene.frame_end)
    if last < scene.frame_start:
        raise InputError(ends_before_time(scene, first, last))
    outside = outside_scene(scene, first, last)
    if outside:
        note(outside)
    return max(first, scene.frame_start), last


def seconds_to_run(options: argparse.Namespace) -> float:
    """The time of the last frame that the options ask for, in seconds since the scene's start."""
    scene = bpy.context.scene
    last = options.frames[1] if options.frames else scene.frame_end
    return (last - scene.frame_start) * scene.render.fps_base / scene.render.fps


def _print_lacks(options: argparse.Namespace, sensors: list[Sensor]) -> None:
    """Prints what the file needs and lacks, each once."""
    light = any(sensor.kind.requires(LIGHT) for sensor in simulated(sensors))
    for text in lacking(bpy.context.view_layer, light):
        if text not in options.lacks:
            options.lacks.append(text)
            note(text)
