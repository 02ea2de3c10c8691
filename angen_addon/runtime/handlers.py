# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's application handlers: they register changes, and show readings at the playhead.

Slow work, such as measuring light, waits until the playhead rests. The handlers do nothing during a
render, because its depsgraph has the visibility and subdivision of renders, not of the viewport.
They call no operators.
"""

from __future__ import annotations

import time
from typing import Any, Protocol

import bpy
from bpy.app.handlers import persistent

from ..advice import lacking
from ..recording import store as recording_store
from ..recording.results import RESULTS
from ..scene import facts, memory
from ..scene.former_choices import replace_former_choices
from ..scene.light.changes import SHADING
from ..scene.light.scene import remove_leftover_scenes
from . import playhead
from .edits import EDITS
from .live import known_live, live_of, outdate
from .playhead import fresh_recording
from .running import is_publishing, is_running, running

# Work that is too slow while scrubbing is put off until the playhead does not move and the user
# drags nothing.

# s: the playhead counts as resting once it has not moved for this long.
REST = 0.4
# s: pause before the timer tries again, if a run goes on or the user drags something.
BUSY = 1.0
# s: pause between measuring the light of two sensors, in which the window can react.
NEXT = 0.02

# When a frame was last shown, by `time.monotonic`.
_shown_at = 0.0


def schedule_sensing() -> None:
    """Start the timer that senses once the playhead rests and the user drags nothing."""
    global _shown_at
    _shown_at = time.monotonic()
    if not bpy.app.background and not bpy.app.timers.is_registered(_sense_at_rest):
        bpy.app.timers.register(_sense_at_rest, first_interval=REST)


def _sense_at_rest() -> float | None:
    """Sense anew if live readings are outdated; otherwise measure one sensor's light.

    Return the time in s until Blender must call this function again; None to stop the timer.
    """
    context = bpy.context
    scene, view_layer = context.scene, context.view_layer
    if scene is None or not scene.angen_live or (not is_running() and fresh_recording(scene)):
        # No live readings are shown.
        return None
    idle = time.monotonic() - _shown_at
    if idle < REST:
        return REST - idle
    if is_running() or _is_busy():
        return BUSY
    live = live_of(scene)
    if live.is_old(scene):
        live.catch_up(scene, view_layer)
    elif live.has_waiting_light:
        # One sensor at a time, so that the window can react in between.
        live.measure_waiting(scene, view_layer, at_most=1)
    else:
        return None
    for window in _windows():
        for area in window.screen.areas:
            area.tag_redraw()
    return NEXT


def _is_busy() -> bool:
    """Return whether the animation plays, or the user drags something."""
    return any(
        window.screen.is_animation_playing
        or any(op.bl_idname.startswith("TRANSFORM_OT") for op in window.modal_operators)
        for window in _windows()
    )


def _windows() -> list[bpy.types.Window]:
    return list(bpy.context.window_manager.windows)


def _forget_timer(function: Any) -> None:
    if bpy.app.timers.is_registered(function):
        bpy.app.timers.unregister(function)


def cancel_sensing() -> None:
    """Stop the timer that `schedule_sensing` starts."""
    if bpy.app.timers.is_registered(_sense_at_rest):
        bpy.app.timers.unregister(_sense_at_rest)


class View(Protocol):
    """A drawing of the sensors, such as the overlay, that handlers keep up to date.

    The handlers call `follow` after a frame change, and `note_edit` after an edit. `wants_rays`
    returns whether the view draws the hits of rays, even while a recording is shown.
    """

    def wants_rays(self, scene: Any) -> bool: ...
    def follow(self, scene: Any, view_layer: Any, depsgraph: Any) -> None: ...
    def note_edit(self, scene: Any) -> None: ...


# The registered views. They register themselves, because this package does not import them.
_views: list[View] = []


def add_view(view: View) -> None:
    """Register a view: from now on, handlers call its methods at frame changes and edits."""
    _views.append(view)


def remove_view(view: View) -> None:
    _views.remove(view)


@persistent
def on_frame_change(scene: Any, depsgraph: Any) -> None:
    """Show the recording at the new frame, or sense there if it is not recorded.

    Then update the views.
    """
    if depsgraph.mode == "RENDER":
        return
    # Blender does not report what handlers of other code change after this one.
    EDITS.note(depsgraph, edited=has_other_frame_handlers(), by_frame=True)
    if is_running() or not _is_shown(scene, depsgraph):
        return
    view_layer = scene.view_layers[depsgraph.view_layer.name]
    for recording in RESULTS.followed(scene):
        recording.note_frame(scene, depsgraph, *EDITS.sensors_and_revision(view_layer))
    publish = not playhead.show_recorded(scene, view_layer) and scene.angen_live
    if publish or any(view.wants_rays(scene) for view in _views):
        live = live_of(scene)
        live.follow(scene, view_layer, depsgraph, publish)
        if publish and live.has_waiting_light:
            schedule_sensing()
    for view in _views:
        view.follow(scene, view_layer, depsgraph)


def _is_shown(scene: Any, depsgraph: Any) -> bool:
    """Return whether the depsgraph belongs to the view layer in the window.

    Other view layers are evaluated at each frame change too, but have no readings. If the window
    shows another scene, or there is no window, return true.
    """
    context = bpy.context
    if context.scene is None or context.scene.session_uid != scene.session_uid:
        return True
    return bool(context.view_layer.name == depsgraph.view_layer.name)


@persistent
def on_edit(scene: Any, depsgraph: Any) -> None:
    """Mark the recordings, maps and live readings that an edit makes stale; sense anew later."""
    if depsgraph.mode == "RENDER":
        return
    by_run = is_publishing() and not has_other_edit_handlers()
    EDITS.note(depsgraph, edited=not by_run)
    if is_running():
        return
    playing = any(w.screen.is_animation_playing for w in bpy.context.window_manager.windows)
    followed = RESULTS.followed(scene) if _is_shown(scene, depsgraph) else []
    for recording in followed:
        view_layer = scene.view_layers[depsgraph.view_layer.name]
        recording.note_edit(scene, depsgraph, *EDITS.sensors_and_revision(view_layer), playing)
    RESULTS.note_other_scene(scene, depsgraph)
    if _has_edit(depsgraph.updates, playing):
        outdate()
    live = known_live()
    if live is not None and live.outdated:
        schedule_sensing()
    for view in _views:
        view.note_edit(scene)


def _has_edit(updates: Any, playing: bool) -> bool:
    """Return whether updates of the depsgraph come from an edit that can change readings.

    When the animation starts to play, Blender reports all actions as updated. If `playing`, updates
    with an action therefore do not count.
    """
    if playing and any(isinstance(update.id, bpy.types.Action) for update in updates):
        return False
    return any(_is_edit(update) for update in updates)


def _is_edit(update: Any) -> bool:
    """Return whether a depsgraph update can change readings.

    Readings can change if an object moved, or changed its shape or its collections. They can also
    change with an action, or with a datablock that affects shading or light.
    """
    changed = update.id
    if isinstance(changed, (bpy.types.Action, *SHADING)):
        return True
    return isinstance(changed, (bpy.types.Object, bpy.types.Collection)) and (
        update.is_updated_transform or update.is_updated_geometry
    )


def settings_changed(owner: Any) -> None:
    """Check all recordings after a setting of `owner`, an object or scene, has changed.

    Blender does not report changes of settings of this extension.
    """
    EDITS.count()
    if not is_running():
        RESULTS.check(owner)
        outdate()


@persistent
def before_load(*_: Any) -> None:
    """Forget what is kept in memory of the open file, before another file opens."""
    memory.forget_file()


@persistent
def after_load(*_: Any) -> None:
    """Convert settings of earlier versions in the loaded file, and restore its recordings."""
    _forget_timer(_read_open_file)
    _read_open_file()


def _read_open_file() -> None:
    remove_leftover_scenes()
    replaced = replace_former_choices()
    recording_store.restore()
    if replaced:
        recording_store.report(replaced)
    _verify_again()
    _show_recorded()
    if bpy.context.scene is not None:
        lacking.look(bpy.context.view_layer)
    schedule_sensing()


@persistent
def after_import(*_: Any) -> None:
    """Convert settings of earlier versions in objects that were appended or linked."""
    replaced = replace_former_choices()
    if replaced:
        recording_store.report(replaced)


@persistent
def before_undo(*_: Any) -> None:
    """Remove all references to Blender's data, because undo or redo will replace that data."""
    memory.forget_references()


@persistent
def after_undo(*_: Any) -> None:
    """Compare the recording and the coverage map with the scene again, and show the recording."""
    remove_leftover_scenes()
    _verify_again()
    _show_recorded()
    if bpy.context.scene is not None:
        live_of(bpy.context.scene).hold_light()
        schedule_sensing()


def _verify_again() -> None:
    """Compare the present scene with its recording and its coverage map."""
    scene = bpy.context.scene
    # Recordings and maps of other scenes are compared once these scenes are evaluated.
    for recording in RESULTS.followed(scene) if scene is not None else ():
        recording.verify(scene, bpy.context.evaluated_depsgraph_get())
    for view in _views if scene is not None else ():
        view.note_edit(scene)


def _show_recorded() -> None:
    """Write the recorded outputs at the playhead to the sensors."""
    # A file that was just loaded, or a step of undo, has the outputs of another time.
    context = bpy.context
    if context.scene is None:
        return
    with running():
        if playhead.show_recorded(context.scene, context.view_layer):
            # Writing the outputs must not count as an edit.
            context.view_layer.update()


@persistent
def before_save(*_: Any) -> None:
    """Add the recordings to the file as texts."""
    recording_store.put_into_file()


@persistent
def after_save(*_: Any) -> None:
    """Remove these texts again, once the file is saved."""
    recording_store.take_out_of_file()


HANDLERS = (
    ("frame_change_post", on_frame_change),
    ("depsgraph_update_post", on_edit),
    ("load_pre", before_load),
    ("load_post", after_load),
    ("undo_pre", before_undo),
    ("undo_post", after_undo),
    ("redo_pre", before_undo),
    ("redo_post", after_undo),
    ("save_pre", before_save),
    ("save_post", after_save),
    ("save_post_fail", after_save),
    # Since Blender 4.3. In 4.2 an appended sensor with a former choice causes an error.
    *(
        (("blend_import_post", after_import),)
        if hasattr(bpy.app.handlers, "blend_import_post")
        else ()
    ),
)


# The frame handlers of this extension. They change nothing but the frame.
frame_handlers: set[Any] = {on_frame_change}


def has_other_frame_handlers() -> bool:
    """Return whether other code has handlers that can change the scene at a frame change."""
    return any(
        handler not in frame_handlers
        for name in ("frame_change_pre", "frame_change_post")
        for handler in getattr(bpy.app.handlers, name)
    )


def has_other_edit_handlers() -> bool:
    """Return whether other code has handlers that can change the scene when it is evaluated."""
    return any(
        handler not in (on_edit, on_frame_change)
        for name in ("depsgraph_update_pre", "depsgraph_update_post")
        for handler in getattr(bpy.app.handlers, name)
    )


def restore_handlers() -> None:
    """Add the handlers again that other code has removed.

    Without them, a run would not notice changes.
    """
    for name, handler in HANDLERS:
        registered = getattr(bpy.app.handlers, name)
        if handler not in registered:
            registered.append(handler)


def _is_without_window() -> bool:
    """Return whether this is a process of a command or script, which ends with its run.

    Blender unregisters extensions at its end, too. Recordings of days take seconds to encode.
    """
    return bool(bpy.app.background)


def register() -> None:
    restore_handlers()
    # Blender hides the open file while it enables an extension.
    bpy.app.timers.register(_read_open_file)


def unregister() -> None:
    """Remove the handlers, and forget what is kept in memory of the open file.

    The file has the recordings then, for the case that it is saved without the extension, or that
    another version of the extension follows.
    """
    _forget_timer(_read_open_file)
    if not _is_without_window():
        recording_store.put_into_file()
    for name, handler in HANDLERS:
        registered = getattr(bpy.app.handlers, name)
        if handler in registered:
            registered.remove(handler)
    cancel_sensing()
    facts.forget_types()
    memory.forget_file()
