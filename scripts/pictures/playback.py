# SPDX-License-Identifier: GPL-3.0-or-later
"""What live readings and the drawing cost playback in a window, the one with and without in turn:

    blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/playback.py

Plays frames 900 to 1100 without the recording, and prints milliseconds a frame and their ratio.
"""

from __future__ import annotations

import statistics
import time

import bpy

ROUNDS, SECONDS = 3, 6.5
frames = 0
began = 0.0
took: dict[bool, list[float]] = {False: [], True: []}
coming = [False, True] * ROUNDS
present: list[bool] = []


def count(*_: object) -> None:
    global frames
    frames += 1


def start() -> None:
    scene = bpy.context.scene
    bpy.ops.angen.clear_recording()
    scene.sync_mode = "NONE"
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 900, 1100
    bpy.app.handlers.frame_change_post.append(count)
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
        bpy.ops.screen.animation_play()
    bpy.app.timers.register(turn, first_interval=2.0)


def turn() -> float | None:
    """Ends a round and begins the next."""
    global frames, began
    if present:
        took[present.pop()].append((time.perf_counter() - began) / max(frames, 1) * 1000)
    if not coming:
        for on, told in ((False, "without"), (True, "with")):
            print(told, [round(ms, 1) for ms in took[on]], "ms a frame")
        ratio = statistics.median(took[True]) / statistics.median(took[False])
        print(f"ratio {ratio:.2f}\nREADY", flush=True)
        return None
    present.append(coming.pop(0))
    scene = bpy.context.scene
    scene.angen_live = scene.angen_overlay.show = present[0]
    frames, began = 0, time.perf_counter()
    return SECONDS


bpy.app.timers.register(start, first_interval=3.0)
