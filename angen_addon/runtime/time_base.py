# SPDX-License-Identifier: GPL-3.0-or-later
"""The time base of a scene: its clock, its start and the frames to run."""

from __future__ import annotations

from datetime import datetime
from typing import Any

import bpy

from ...sensor_logic.clock import Clock
from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.log import format_frame, iso_time, parse_start


def clock_of(scene: Any) -> Clock:
    """Return the scene's clock, with t = 0 at the start frame."""
    render = scene.render
    return Clock(scene.frame_start, render.fps, render.fps_base, scene.angen_substeps)


def start_of(scene: Any) -> datetime | None:
    """Return the date and time of the scene's first frame, as the user has set it.

    Return None if the user has not set it. Raise InputError if its text is invalid.
    """
    with explained("Start Time", InputError):
        return parse_start(scene.angen_start)


def moment_text(scene: Any, frame: float) -> str:
    """Return the time of day at a frame, to a tenth of a second.

    Without a start time, return the frame and its time since the scene's first frame.
    """
    seconds = (frame - scene.frame_start) * scene.render.fps_base / scene.render.fps
    try:
        start = start_of(scene)
    except InputError:
        start = None
    if start is None:
        return f"frame {format_frame(frame)} ({seconds:.3f} s)"
    # Half a millisecond more: a tenth of a second is never cut to the one before.
    return iso_time(start, seconds + 5e-4)[11:21]


def frames_to_run(scene: Any) -> tuple[int, int]:
    """Return the first and last frame: the preview range if one is set, else the scene's range."""
    if scene.use_preview_range:
        return scene.frame_preview_start, scene.frame_preview_end
    return scene.frame_start, scene.frame_end


def ends_before_time(scene: Any, first: int, last: int) -> str:
    """Return the error text for frames `first` to `last`, which end before the scene's start."""
    return (
        f"frames {first}:{last} end before the scene's start, frame {scene.frame_start}: give "
        "later frames"
    )


def outside_scene(scene: Any, first: int, last: int) -> str:
    """Return a note on those frames from `first` to `last` that are outside the scene's range.

    The note is empty if all frames are inside. A run leaves out frames before the scene's start,
    because they have no time. It simulates frames after the scene's end.
    """
    found = []
    if first < scene.frame_start:
        found.append(f"those before the scene's start, frame {scene.frame_start}, are left out")
    if last > scene.frame_end:
        found.append(f"those after the scene's end, frame {scene.frame_end}, are simulated too")
    return f"frames {first}:{last}: {'; '.join(found)}" if found else ""


def evaluated_depsgraph() -> bpy.types.Depsgraph:
    """Return the evaluated depsgraph of the present context, with pending edits applied."""
    return bpy.context.evaluated_depsgraph_get()
