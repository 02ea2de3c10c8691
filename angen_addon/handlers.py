# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's application handlers: they note what changes and show values at the playhead.

They do nothing in a render, whose depsgraph has other visibility and subdivision than the
viewport, and call no operators.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

from . import live, state


@persistent
def on_frame_change(scene: Any, depsgraph: Any) -> None:
    if depsgraph.mode == "RENDER":
        return
    state.CACHE.note(depsgraph, edited=False)
    if state.CACHE.running:
        return
    frame = scene.frame_current + scene.frame_subframe
    recording = state.CACHE.recording(scene)
    if recording is not None and recording.covers(frame):
        live.show_recorded(recording, scene.view_layers[depsgraph.view_layer.name], frame)
    elif scene.angen_live:
        following = state.CACHE.live
        if following is None or following.scene_uid != scene.session_uid:
            following = state.CACHE.live = live.Live(scene)
        view_layer = scene.view_layers[depsgraph.view_layer.name]
        following.follow(scene, view_layer, depsgraph)


@persistent
def on_edit(scene: Any, depsgraph: Any) -> None:
    if depsgraph.mode == "RENDER":
        return
    state.CACHE.note(depsgraph, edited=True)
    if any(_is_users_edit(update) for update in depsgraph.updates):
        state.CACHE.scene_edited(scene)


def _is_users_edit(update: Any) -> bool:
    """Whether an object was moved, reshaped, added or removed (which its collection tells)."""
    return isinstance(update.id, (bpy.types.Object, bpy.types.Collection)) and (
        update.is_updated_transform or update.is_updated_geometry
    )


@persistent
def on_data_replaced(*_: Any) -> None:
    """Undo, redo and file load make all data anew: whatever refers to the old is void."""
    state.CACHE.clear()


HANDLERS = (
    ("frame_change_post", on_frame_change),
    ("depsgraph_update_post", on_edit),
    ("load_pre", on_data_replaced),
    ("undo_pre", on_data_replaced),
    ("redo_pre", on_data_replaced),
)


def ensure() -> None:
    """Puts back handlers that other code threw out: without them changes go unnoticed."""
    for name, handler in HANDLERS:
        registered = getattr(bpy.app.handlers, name)
        if handler not in registered:
            registered.append(handler)


def register() -> None:
    ensure()


def unregister() -> None:
    for name, handler in HANDLERS:
        registered = getattr(bpy.app.handlers, name)
        if handler in registered:
            registered.remove(handler)
    state.CACHE.clear()
