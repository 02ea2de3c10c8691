# SPDX-License-Identifier: GPL-3.0-or-later
"""The time base of a scene."""

from __future__ import annotations

from typing import Any

import bpy

from ...sensor_logic.clock import Clock


def clock_of(scene: Any) -> Clock:
    """The scene's time base: t = 0 at its start frame."""
    render = scene.render
    return Clock(scene.frame_start, render.fps, render.fps_base, scene.angen_substeps)


def frames_to_run(scene: Any) -> tuple[int, int]:
    """First and last frame that a user wants to see: the preview range, where one is set."""
    if scene.use_preview_range:
        return scene.frame_preview_start, scene.frame_preview_end
    return scene.frame_start, scene.frame_end


def ends_before_time(scene: Any, first: int, last: int) -> str:
    """What the user is told of frames before the scene's first."""
    return (
        f"frames {first}:{last} end before the scene's start, frame {scene.frame_start}, "
        "where time begins"
    )


def evaluated_depsgraph() -> bpy.types.Depsgraph:
    """The evaluated scene of the present context, with pending edits applied."""
    return bpy.context.evaluated_depsgraph_get()
