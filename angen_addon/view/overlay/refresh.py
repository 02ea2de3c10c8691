# SPDX-License-Identifier: GPL-3.0-or-later
"""Decide when the overlay is updated: at a frame change, or shortly after an edit.

At a frame change, each sensor casts only the rays of its present update. All other rays are cast
after an edit, and once the playhead rests. No ray is cast while Blender draws.
"""

from __future__ import annotations

import sys
import time
import traceback
from typing import Any

import bpy

from ...runtime import handlers
from ...runtime.live import live_of
from ...runtime.running import is_running
from ...scene import memory
from .picture import DrawnSensors
from .settings import redraw_views

# s. The delay after an edit, and the interval while something is dragged.
SOON = 0.05
# s. All rays are cast once the playhead has rested for this long.
REST = 0.25

# What is drawn of the sensors; None before the first update.
overlay: DrawnSensors | None = None


@memory.forgets_at_undo
def discard() -> None:
    """Discard what is drawn of the sensors, which refers to their objects."""
    global overlay
    overlay = None


def wanted(scene: Any) -> bool:
    """Return whether the overlay is switched on and there is a window to draw it in."""
    return not bpy.app.background and scene.angen_overlay.show


def wants_rays(scene: Any) -> bool:
    """Return whether the hits of the sensors' rays are drawn."""
    return wanted(scene) and scene.angen_overlay.fields


def follow(scene: Any, view_layer: Any, depsgraph: Any) -> None:
    """Update the overlay after a frame change, once the sensors have sensed."""
    if not wanted(scene):
        discard()
        return
    # An error in the overlay must not end the frame handler that calls this.
    try:
        drawn = _drawn_sensors(scene)
        drawn.follow(scene, view_layer, depsgraph)
        drawn.unseen = wants_rays(scene)
    except Exception:
        _give_up(scene)
    if overlay is not None and overlay.unseen:
        overlay.followed_at = time.monotonic()
        if not bpy.app.timers.is_registered(_update_at_rest):
            bpy.app.timers.register(_update_at_rest, first_interval=REST)


def note_edit(scene: Any) -> None:
    """Mark the overlay as outdated after an edit of the scene, and schedule its update."""
    if wanted(scene):
        if overlay is not None:
            overlay.outdated = True
        soon()


def soon() -> None:
    """Schedule an update of the overlay, for when Blender has nothing else to do."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_update):
        bpy.app.timers.register(_update, first_interval=SOON)


def _update_at_rest() -> float | None:
    """Timer function: update the overlay if the playhead rests.

    Return the time in s until Blender calls this function again; None to end the timer.
    """
    drawn = overlay
    if drawn is None or not drawn.unseen:
        return None
    stood = time.monotonic() - drawn.followed_at
    if stood < REST:
        return REST - stood
    _update()
    return None


def _update() -> None:
    """Cast all rays of the sensors, and update the overlay."""
    context = bpy.context
    scene = context.scene
    if scene is None or is_running() or not wanted(scene):
        return
    try:
        # Until the next evaluation the depsgraph lists objects that were removed and freed.
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
    global overlay
    if overlay is None or overlay.scene_uid != scene.session_uid:
        overlay = DrawnSensors(scene)
    return overlay


def _give_up(scene: Any) -> None:
    """Print the present exception, and draw nothing until the next edit."""
    traceback.print_exc(file=sys.stderr)
    if overlay is not None:
        overlay.fail(scene)


def cancel() -> None:
    """End the timers of this module, and discard the overlay."""
    for timer in (_update, _update_at_rest):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    discard()


def register() -> None:
    handlers.add_view(sys.modules[__name__])


def unregister() -> None:
    handlers.remove_view(sys.modules[__name__])
    cancel()
