# SPDX-License-Identifier: GPL-3.0-or-later
"""What is too slow while scrubbing is done a moment after the playhead has come to rest."""

from __future__ import annotations

import time
from typing import Any

import bpy

from . import state
from .playhead import recorded_here

# s: the playhead rests once it has stood still for this long.
REST = 0.4
BUSY = 1.0
# s: in which the window answers.
NEXT = 0.02


def frame_was_shown() -> None:
    """To be called in each frame change after which something is left to be done."""
    state.CACHE.shown_at = time.monotonic()
    if not bpy.app.background and not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=REST)


def _look() -> float | None:
    """Seconds until the next look; None where nothing is left to be done."""
    following, context = state.CACHE.live, bpy.context
    if following is None or not following.left_to_do or not _is_shown(following, context.scene):
        return None
    stood = time.monotonic() - state.CACHE.shown_at
    if stood < REST:
        return REST - stood
    if state.CACHE.running or any(w.screen.is_animation_playing for w in _windows()):
        return BUSY
    # One sensor after the other, so that the window answers in between.
    following.do_the_rest(context.scene, context.view_layer, at_most=1)
    for window in _windows():
        for area in window.screen.areas:
            area.tag_redraw()
    return NEXT if following.left_to_do else None


def _is_shown(following: Any, scene: Any) -> bool:
    """Whether what is shown of this scene is what is sensed live."""
    if scene is None or scene.session_uid != following.scene_uid:
        return False
    return scene.angen_live and (state.CACHE.running or recorded_here(scene) is None)


def _windows() -> list[bpy.types.Window]:
    return list(bpy.context.window_manager.windows)


def cancel() -> None:
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
