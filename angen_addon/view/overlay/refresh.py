# SPDX-License-Identifier: GPL-3.0-or-later
"""When what is drawn is worked out: in the frame handler, or a moment after an edit.

What sensors do not cast at each update is asked of them then, and never while Blender draws.
"""

from __future__ import annotations

import sys
import time
import traceback
from typing import Any

import bpy

from ...runtime import handlers, state
from ...runtime.live import live_of
from .picture import DrawnSensors
from .settings import redraw_views

# s: after an edit; while something is dragged, the drawing follows in steps of this.
SOON = 0.05
# s: once the playhead has stood still for this long, all is drawn as it is at its frame.
REST = 0.25


def wanted(scene: Any) -> bool:
    """Whether anything is drawn at all; there is no viewport in the background."""
    return not bpy.app.background and scene.angen_overlay.show


def wants_rays(scene: Any) -> bool:
    """Whether what the sensors' rays meet is drawn."""
    return wanted(scene) and scene.angen_overlay.fields


def follow(scene: Any, view_layer: Any, depsgraph: Any) -> None:
    """Follows a frame change; to be called after the sensors have sensed."""
    if not wanted(scene):
        state.CACHE.overlay = None
        return
    # An overlay must never keep the handler that it is called in from doing its work.
    try:
        _drawn_sensors(scene).follow(scene, view_layer, depsgraph)
        state.CACHE.overlay.unseen = wants_rays(scene)
    except Exception:
        _give_up(scene)
    if state.CACHE.overlay is not None and state.CACHE.overlay.unseen:
        state.CACHE.overlay.followed_at = time.monotonic()
        if not bpy.app.timers.is_registered(_at_rest):
            bpy.app.timers.register(_at_rest, first_interval=REST)


def note_edit(scene: Any) -> None:
    """Notes an edit of the scene; to be called after each."""
    if wanted(scene):
        if state.CACHE.overlay is not None:
            state.CACHE.overlay.outdated = True
        soon()


def soon() -> None:
    """Brings the drawing up to date once Blender has nothing else to do."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_later):
        bpy.app.timers.register(_later, first_interval=SOON)


def _at_rest() -> float | None:
    """Seconds until the next look at whether the playhead rests; None where nothing is left."""
    drawn = state.CACHE.overlay
    if drawn is None or not drawn.unseen:
        return None
    stood = time.monotonic() - drawn.followed_at
    if stood < REST:
        return REST - stood
    _later()
    return None


def _later() -> None:
    context = bpy.context
    scene = context.scene
    if scene is None or state.CACHE.running or not wanted(scene):
        return
    try:
        # What was removed since Blender evaluated last is still listed, and freed.
        view_layer = context.view_layer
        view_layer.update()
        if wants_rays(scene):
            live_of(scene).look_around(scene, view_layer, view_layer.depsgraph)
        drawn = _drawn_sensors(scene)
        drawn.follow(scene, view_layer, view_layer.depsgraph)
        drawn.unseen = False
    except Exception:
        _give_up(scene)
    redraw_views()


def _drawn_sensors(scene: Any) -> DrawnSensors:
    known = state.CACHE.overlay
    if known is None or known.scene_uid != scene.session_uid:
        known = state.CACHE.overlay = DrawnSensors(scene)
    return known


def _give_up(scene: Any) -> None:
    """Says what went wrong and keeps still until the next edit."""
    traceback.print_exc(file=sys.stderr)
    if state.CACHE.overlay is not None:
        state.CACHE.overlay.fail(scene)


def cancel() -> None:
    for timer in (_later, _at_rest):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    state.CACHE.overlay = None


def register() -> None:
    handlers.tell(sys.modules[__name__])


def unregister() -> None:
    handlers.tell_no_more(sys.modules[__name__])
    cancel()
