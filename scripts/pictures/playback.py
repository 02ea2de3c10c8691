# SPDX-License-Identifier: GPL-3.0-or-later
r"""Measure what live readings and the overlay cost playback in a window.

blender --factory-startup --addons bl_ext.user_default.angen_sensors \
    sample_blends/angen.blend --python scripts/pictures/playback.py

Neither, live readings, and both take turns. Frames 900 to 1100 are played without the recording.
Prints mean milliseconds per frame: of the clock, of all processors (software OpenGL takes several),
and of the extension's own Python.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import bpy
from bl_ext.user_default.angen_sensors.angen_addon.runtime import live
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay import draw, refresh

# Frames of a round; the first few do not count, because the sensors start anew in them.
ROUNDS, FRAMES, FIRST = 4, 40, 6
SETTINGS = {"none": (False, False), "live": (True, False), "live and drawn": (True, True)}
rounds_left = list(SETTINGS) * ROUNDS
current = "none"
frame = drawn = 0
began = processors = python = 0.0
took: dict[str, list[tuple[float, ...]]] = {name: [] for name in SETTINGS}


def timed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that adds its seconds to `python`."""

    def run(*args: Any) -> None:
        global python
        start = time.thread_time()
        function(*args)
        python += time.thread_time() - start

    return run


def count() -> None:
    """Count a drawn frame, and end the round after `FRAMES` of them.

    This is no frame handler, because other handlers make live sensing assume that anything changed.
    """
    global frame, drawn, began, processors, python
    if frame != bpy.context.scene.frame_current:
        frame = bpy.context.scene.frame_current
        drawn += 1
        if drawn == 0:
            began, processors, python = time.perf_counter(), time.process_time(), 0.0
        elif drawn == FRAMES:
            spent = time.perf_counter() - began, time.process_time() - processors, python
            took[current].append(tuple(seconds / FRAMES * 1000 for seconds in spent))
            bpy.app.timers.register(next_round, first_interval=0.01)


def start() -> None:
    scene = bpy.context.scene
    bpy.ops.angen.clear_recording()
    scene.sync_mode = "NONE"
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 900, 1100
    draw.unregister()
    draw.draw_fields, draw.draw_labels = timed(draw.draw_fields), timed(draw.draw_labels)
    draw.register()
    live.Live.follow = timed(live.Live.follow)
    refresh.follow = timed(refresh.follow)
    bpy.types.SpaceView3D.draw_handler_add(count, (), "WINDOW", "POST_PIXEL")
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
        bpy.ops.screen.animation_play()
    bpy.app.timers.register(next_round, first_interval=2.0)


def next_round() -> None:
    """Begin the next round, or print the result after the last."""
    global current, drawn
    if rounds_left:
        current = rounds_left.pop(0)
        scene = bpy.context.scene
        scene.angen_live, scene.angen_overlay.show = SETTINGS[current]
        drawn = -FIRST
        return
    middle = {n: [statistics.median(v) for v in zip(*r, strict=True)] for n, r in took.items()}
    none = middle["none"]
    for name, rounds in took.items():
        clock, cpu, own = middle[name]
        print(
            f"{name:15} {clock:6.1f} ms, {cpu:6.1f} of processors, {own:5.2f} of Python; "
            f"{clock / none[0]:.2f} and {cpu / none[1]:.2f} times none",
            [f"{wall:.0f}/{cpu:.0f}/{own:.1f}" for wall, cpu, own in rounds],
        )
    print("READY", flush=True)


bpy.app.timers.register(start, first_interval=3.0)
