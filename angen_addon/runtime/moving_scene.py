# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary scene that has only the moving objects.

Blender evaluates its frames in half the time. If no object depends on the scene that it is in, the
poses are exactly the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import bpy

from ...sensor_logic.kind import USES
from ..scene.animation import all_animated, may_set
from ..scene.marks import LIGHT_MARK
from ..scene.rays.geometry import SURFACE_TYPES
from ..scene.uses import watched_object
from .sensor_runner import SensorRunner
from .stillness import Stillness

# Render settings of a scene that decide at what time each frame is.
TIME = ("fps", "fps_base", "frame_map_old", "frame_map_new")
# If fewer objects than this are at rest, a second scene saves no time.
LEAST_OBJECTS = 20


class MovingScene:
    """A temporary scene with only the moving objects, evaluated in place of the user's scene."""

    def __init__(self, scene: Any, objects: Sequence[Any]) -> None:
        self._scene = bpy.data.scenes.new(".angen_moving")
        self._scene[LIGHT_MARK] = True
        for name in TIME:
            setattr(self._scene.render, name, getattr(scene.render, name))
        for obj in objects:
            self._scene.collection.objects.link(obj)
        # The first evaluation updates every object, which handlers must not see as changes.
        handlers = list(bpy.app.handlers.frame_change_post)
        bpy.app.handlers.frame_change_post.clear()
        try:
            self.evaluate(scene.frame_current, 0.0)
        finally:
            bpy.app.handlers.frame_change_post.extend(handlers)

    def evaluate(self, frame: int, subframe: float) -> Any:
        """Evaluate the scene at a frame, and return its depsgraph."""
        self._scene.frame_set(frame, subframe=subframe)
        return self._scene.view_layers[0].depsgraph

    def close(self) -> None:
        """Remove the scene from the file."""
        # Undo, or another file, may have removed it.
        with suppress(ReferenceError):
            # Blender 4.3 without windows crashes where a scene is removed by itself.
            bpy.data.batch_remove([self._scene])


def moving_scene(
    scene: Any, runners: Sequence[SensorRunner], stored: set[str], still: Stillness, first: int
) -> MovingScene | None:
    """Return a scene with only the moving objects, for a run that begins at frame `first`.

    Return None if its readings could differ from readings in the user's scene, or if it would save
    little time. Light is always measured in the user's scene.

    Parameters
    ----------
    scene
        The user's scene.
    runners
        The runners of the sensors in the run.
    stored
        The quantities that can be queried later, since the run captures each frame.
    still
        The times at which the scene can change.
    first
        The first frame of the run.
    """
    keeping = [r for r in runners if set(r.sensor.kind.needs) <= stored]
    if not keeping or still.timed or not _can_move_alone(scene, keeping):
        return None
    moved = _find_moving(scene, first)
    view_layer = bpy.context.view_layer
    # Blender may not report an object that is hidden now and shown later.
    shown = [
        obj for obj in view_layer.objects if obj and (obj in moved or may_set(obj, "hide_viewport"))
    ]
    if len(view_layer.objects) - len(shown) < LEAST_OBJECTS or any(map(_depends_on_scene, shown)):
        return None
    watched = {watched_object(r.sensor) for r in keeping if r.sensor.kind.requires(USES)}
    kept = [obj for obj in shown if obj.type in SURFACE_TYPES or obj in watched]
    return MovingScene(scene, kept)


def _can_move_alone(scene: Any, keeping: Sequence[SensorRunner]) -> bool:
    """Return whether the moving objects would move in the same way in a scene of their own.

    Return false for physics, drivers, instances, objects in Edit Mode or animation of the scene
    itself. Also return false if the parameters or the pose of a sensor in `keeping` can change.
    """
    if scene.rigidbody_world or scene.render.use_simplify or scene.animation_data:
        return False
    if not all(runner.reader.steady for runner in keeping):
        return False
    if any(len(owner.animation_data.drivers) for owner in all_animated()):
        return False
    return not any(obj.mode != "OBJECT" or obj.instance_type != "NONE" for obj in scene.objects)


def _depends_on_scene(obj: Any) -> bool:
    """Return whether an object may make instances, or look different in another scene.

    All metaballs of a scene join into one surface, so they depend on the scene.
    """
    return (
        obj.type == "META"
        or obj.is_instancer
        or any(modifier.type == "NODES" for modifier in obj.modifiers)
    )


def _find_moving(scene: Any, first: int) -> set[Any]:
    """Return the objects of a scene that can differ between frames.

    Blender reports all of them at any change of frame, so two changes near frame `first` suffice.
    """
    found: set[Any] = set()

    def note(changed: Any, depsgraph: Any) -> None:
        if changed == scene:
            ids = (update.id.original for update in depsgraph.updates)
            found.update(i for i in ids if isinstance(i, bpy.types.Object))

    # Blender also reports new and edited objects, but only once: evaluate before listening.
    scene.frame_set(first)
    bpy.app.handlers.frame_change_post.append(note)
    try:
        for frame in (first + 1, first):
            scene.frame_set(frame)
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    return found
