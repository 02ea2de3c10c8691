# SPDX-License-Identifier: GPL-3.0-or-later
"""The open home, for subcommands: its sensors, its missing files, and a simulation of its frames.

Advice is printed before the run, and progress during the run, both on standard error.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

import bpy

from ...sensor_logic.kind import FORCES, LIGHT
from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.wording import named, uncapitalized
from ...sensor_logic.progress import TimeLeft
from ...sensor_logic.recording.tracks import Recording
from ..advice import sensing as advice
from ..advice import warmth
from ..advice.lacking import lacking
from ..layout.apply import apply_layout
from ..process.console import ProgressText, note, write_message
from ..runtime.simulation import Progress, simulate, unrecorded
from ..runtime.time_base import ends_before_time, outside_scene
from ..scene.instances import is_sensor
from ..scene.lengths import lengths_of
from ..scene.sensors import Sensor, all_sensors, simulated

# Advice before a run, on standard error.


def print_advice(sensors: list[Sensor], quiet: bool) -> None:
    """Print which sensors are switched off.

    Unless `quiet` is true, also print why other sensors may not read what the user expects.
    """
    off = [s.name for s in sensors if not s.settings.enabled]
    if off:
        note(f"switched off: {', '.join(off)}")
    if not quiet:
        for found in advice.background_sets(bpy.context.scene):
            note(uncapitalized(found.text))
        _advise_on_pads(sensors)
        _advise_on_warmth(sensors)
        _advise_on_warm_up(sensors)
        for text in advice.open_for_ever(sensors, bpy.context.evaluated_depsgraph_get()):
            note(text)
        if any(sensor.kind.requires(LIGHT) for sensor in simulated(sensors)):
            for found in advice.opaque_glass(bpy.context.view_layer):
                note(uncapitalized(found.text))
        _advise_on_parameters(sensors)


def _advise_on_warmth(sensors: list[Sensor]) -> None:
    found = warmth.sensing_warmth(simulated(sensors))
    cold = warmth.nothing_warm(bpy.context.view_layer) if found else None
    if cold:
        note(uncapitalized(cold.text))
    for sensor in found:
        slow = warmth.too_slow(sensor)
        if slow:
            note(f"'{sensor.name}': {uncapitalized(slow.text)}")


def _advise_on_warm_up(sensors: list[Sensor]) -> None:
    for sensor in simulated(sensors):
        late = advice.warm_up(sensor, bpy.context.scene)
        if late:
            note(f"'{sensor.name}': {uncapitalized(late.text)}")


def _advise_on_pads(sensors: list[Sensor]) -> None:
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    pads = [s for s in simulated(sensors) if s.kind.requires(FORCES)]
    for ask in (
        lambda pad: advice.without_surface(pad.object),
        lambda pad: advice.sinks(pad.object, scene),
        lambda pad: advice.weightless(pad.object, scene, view_layer),
        lambda pad: advice.hidden_partner(pad, view_layer),
    ):
        found = {pad.name: problem for pad in pads if (problem := ask(pad))}
        if found:
            note(advice.of_several(found))
    short = advice.short_cache(scene) if pads else None
    if short:
        note(short.text)


def _advise_on_parameters(sensors: list[Sensor]) -> None:
    for sensor in simulated(sensors):
        for found in advice.unreachable(sensor, lengths_of(bpy.context.scene)):
            note(f"'{sensor.name}': {uncapitalized(found.text)}")


# Progress on standard error: on a terminal one line that changes, else a line every 10 s.

# A smaller rate would be shown as 0.
SHOWN_RATE = 0.05


class ProgressLine:
    """Prints the progress, speed and time left of a run."""

    def __init__(self, stream: TextIO, quiet: bool) -> None:
        self._stream, self._quiet = stream, quiet
        self._text = ProgressText(quiet, stream)
        self._start = time.perf_counter()
        self._left = TimeLeft()
        self._announced = {""}
        self._last: Progress | None = None

    def show(self, progress: Progress) -> None:
        """Print the progress, if the last print was long enough ago or a slow step begins."""
        self._left.note(progress.share)
        self._last = progress
        # A slow step is announced when it begins; off a terminal, only the first time.
        is_known = progress.doing in self._announced and not self._text.in_terminal
        if not self._text.is_due(bool(progress.doing) and not is_known):
            return
        self._announced.add(progress.doing)
        rate = progress.seconds_done / (time.perf_counter() - self._start)
        parts = [f"frame {progress.frame:g}", f"{100 * progress.share:.0f} %"]
        if rate >= SHOWN_RATE:
            parts.append(f"{rate:.{0 if rate >= 10 else 1}f} times real time")
        self._text.write(", ".join(filter(None, [*parts, self._left.text(), progress.doing])))

    def finish(self, seconds: float, updates: int) -> None:
        """Print the last line: how much was simulated, and how fast.

        `seconds` is the simulated time, and `updates` the number of recorded updates.
        """
        self._text.clear()
        if self._quiet:
            return
        elapsed = max(time.perf_counter() - self._start, 1e-9)
        last, still = self._last, ""
        share = round(100 * (1 - last.evaluated / last.steps)) if last and last.steps else 0
        if share:
            still = f"; nothing moved at {share} % of the steps"
        elif last is not None and last.moving:
            still = f"; no step could be skipped: {last.moving}"
        write_message(
            f"simulated {seconds:.1f} s in {elapsed:.1f} s "
            f"({seconds / elapsed:.0f} times real time), {updates} updates{still}\n",
            self._stream,
        )


def open_home(options: argparse.Namespace) -> None:
    """Check that Blender has opened a blend file. Raise InputError if it has not.

    If the options trust the file, load it again with its drivers and scripts enabled.
    """
    if not bpy.data.filepath:
        raise InputError(
            "no blend file is open: the file is missing, empty, damaged or from a newer Blender; "
            "Blender's messages above may say why"
        )
    if bpy.data.version[:2] > bpy.app.version[:2]:
        saved, here = (".".join(map(str, v[:2])) for v in (bpy.data.version, bpy.app.version))
        note(
            f"the file was saved by Blender {saved}, and this is Blender {here}: data of newer "
            "features are lost"
        )
    if options.enable_autoexec:
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath, load_ui=False, use_scripts=True)
    bpy.context.view_layer.update()


def sensors_of(options: argparse.Namespace, layout: Path | None = None) -> list[Sensor]:
    """Return all sensors of the scene, after applying a layout if one is given.

    Print what the home lacks, such as missing files, and store these texts in `options.lacks`.
    Raise InputError if there are no sensors.
    """
    open_home(options)
    if layout is not None:
        apply_layout(layout)
    sensors = all_sensors(bpy.context.view_layer)
    options.lacks = []
    _print_lacks(options, sensors)
    if not sensors:
        raise InputError(
            f"{Path(bpy.data.filepath).name} has no sensors in its scene "
            f"'{bpy.context.scene.name}': {_sensors_elsewhere()}"
        )
    return sensors


def _sensors_elsewhere() -> str:
    """Return where the file has sensors if the view layer has none, or how to add one."""
    names = [obj.name for obj in bpy.data.objects if is_sensor(obj)]
    scene = bpy.context.scene
    others = [s.name for s in bpy.data.scenes if s != scene and any(n in s.objects for n in names)]
    if any(name in scene.objects for name in names):
        return f"tick the collections of {named(names)} in the Outliner"
    if others:
        return f"its scene {named(others)} has sensors: save the file with that scene open"
    return "add one in Blender with Shift+A, Sensor"


def run_home(
    options: argparse.Namespace,
    sensors: list[Sensor],
    on_progress: Callable[[Recording], None] = lambda _: None,
) -> Recording:
    """Simulate the frames in the options, and return the recording.

    During the run, `on_progress` is called repeatedly with the recording so far.
    """
    scene = bpy.context.scene
    print_advice(sensors, options.quiet)
    others = unrecorded(simulated(sensors))
    if others and not options.quiet:
        note(f"also simulated, since drivers read their outputs: {named(s.name for s in others)}")
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
    """Return the first and the last frame to simulate.

    Print a note if the frames in the options exceed the scene's range. Raise InputError if all of
    them are before the scene's start.
    """
    scene = bpy.context.scene
    first, last = options.frames or (scene.frame_start, scene.frame_end)
    if last < scene.frame_start:
        raise InputError(ends_before_time(scene, first, last))
    outside = outside_scene(scene, first, last)
    if outside:
        note(outside)
    return max(first, scene.frame_start), last


def seconds_to_run(options: argparse.Namespace) -> float:
    """Return the time of the last frame to simulate, in seconds since the scene's start."""
    scene = bpy.context.scene
    last = options.frames[1] if options.frames else scene.frame_end
    return (last - scene.frame_start) * scene.render.fps_base / scene.render.fps


def _print_lacks(options: argparse.Namespace, sensors: list[Sensor]) -> None:
    """Print which files and data the blend file lacks, except those already printed."""
    light = any(sensor.kind.requires(LIGHT) for sensor in simulated(sensors))
    for text in lacking(bpy.context.view_layer, light):
        if text not in options.lacks:
            options.lacks.append(text)
            note(text)
