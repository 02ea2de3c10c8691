# SPDX-License-Identifier: GPL-3.0-or-later
"""What is too slow while scrubbing, and what an edit made old, is done a moment after the playhead
and the user have come to rest."""

from __future__ import annotations

import time

import bpy

from . import state
from .live import live_of
from .playhead import recorded_here

# s: the playhead rests once it has stood still for this long.
REST = 0.4
BUSY = 1.0
# s: in which the window answers.
NEXT = 0.02


def soon() -> None:
    """To be called at each frame change and edit after which something is left to be done."""
    state.CACHE.shown_at = time.monotonic()
    if not bpy.app.background and not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=REST)


def _look() -> float | None:
    """Seconds until the next look; None where nothing is left to be done."""
    context = bpy.context
    scene, view_layer = context.scene, context.view_layer
    if scene is None or not scene.angen_live or (not state.CACHE.running and recorded_here(scene)):
        # What is shown is not what is sensed live.
        return None
    stood = time.monotonic() - state.CACHE.shown_at
    if stood < REST:
        return REST - stood
    if state.CACHE.running or _is_busy():
        return BUSY
    following = live_of(scene)
    if following.is_old(scene):
        following.catch_up(scene, view_layer)
    elif following.left_to_do:
        # One sensor after the other, so that the window answers in between.
        following.do_the_rest(scene, view_layer, at_most=1)
    else:
        return None
    for window in _windows():
        for area in window.screen.areas:
            area.tag_redraw()
    return NEXT


def _is_busy() -> bool:
    """Whether the animation plays, or something is being dragged."""
    return any(
        window.screen.is_animation_playing
        or any(op.bl_idname.startswith("TRANSFORM_OT") for op in window.modal_operators)
        for window in _windows()
    )


def _windows() -> list[bpy.types.Window]:
    return list(bpy.context.window_manager.windows)


def cancel() -> None:
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
