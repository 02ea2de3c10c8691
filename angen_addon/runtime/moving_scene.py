# SPDX-License-Identifier: GPL-3.0-or-later
"""A passing scene of what moves alone: its frames take Blender half the time of the user's own, and
are the same to the bit where nothing can look at the scene that it is in."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import bpy

from ..scene.animation import all_animated, may_set
from ..scene.marks import LIGHT_MARK
from ..scene.rays.geometry import SURFACE_TYPES
from .sensor_runner import SensorRunner
from .stillness import Stillness

# Of the scene, what the time of its frames depends on.
TIME = ("fps", "fps_base", "frame_map_old", "frame_map_new")
# Less of the scene at rest is not worth a scene of its own.
LEAST_OBJECTS = 20


class MovingScene:
    """To be asked for a frame (`go`) in place of the user's scene, and to be closed."""

    def __init__(self, scene: Any, objects: Sequence[Any]) -> None:
        self._scene = bpy.data.scenes.new(".angen_moving")
        self._scene[LIGHT_MARK] = True
        for name in TIME:
            setattr(self._scene.render, name, getattr(scene.render, name))
        for obj in objects:
            self._scene.collection.objects.link(obj)
        # The first time all of it is new: nobody is to take that for what changes at a frame.
        heard = list(bpy.app.handlers.frame_change_post)
        bpy.app.handlers.frame_change_post.clear()
        try:
            self.go(scene.frame_current, 0.0)
        finally:
            bpy.app.handlers.frame_change_post.extend(heard)

    def go(self, frame: int, subframe: float) -> Any:
        """Evaluates it; returns its depsgraph."""
        self._scene.frame_set(frame, subframe=subframe)
        return self._scene.view_layers[0].depsgraph

    def close(self) -> None:
        """Removes it from the file."""
        # Undo, or another file, may have taken it away.
        with suppress(ReferenceError):
            # Blender 4.3 without windows crashes where a scene is removed by itself.
            bpy.data.batch_remove([self._scene])


def moving_scene(
    scene: Any, runners: Sequence[SensorRunner], kept: set[str], still: Stillness, first: int
) -> MovingScene | None:
    """One for a run that begins at frame `first`, and that keeps of frames what is `kept`; None
    where something in the scene may depend on more than what its objects hang on, or little is
    gained: light is asked of the scene itself."""
    keeping = [r for r in runners if set(r.sensor.kind.needs) <= kept]
    if not keeping or still.timed or not _stands_alone(scene, keeping):
        return None
    moved = _moved(scene, first)
    view_layer = bpy.context.view_layer
    # Blender may not name what is hidden at the time, although it comes later.
    shown = [
        obj for obj in view_layer.objects if obj and (obj in moved or may_set(obj, "hide_viewport"))
    ]
    if len(view_layer.objects) - len(shown) < LEAST_OBJECTS or any(map(_looks_around, shown)):
        return None
    return MovingScene(scene, [obj for obj in shown if obj.type in SURFACE_TYPES])


def _stands_alone(scene: Any, keeping: Sequence[SensorRunner]) -> bool:
    """Whether neither physics nor drivers, instances, visibility or moving sensors look at the
    whole scene."""
    if scene.rigidbody_world or scene.render.use_simplify or scene.animation_data:
        return False
    if not all(runner.steady for runner in keeping):
        return False
    if any(len(owner.animation_data.drivers) for owner in all_animated()):
        return False
    return not any(obj.mode != "OBJECT" or obj.instance_type != "NONE" for obj in scene.objects)


def _looks_around(obj: Any) -> bool:
    """Whether what is made of an object may hold instances, or depend on its scene: metaballs join
    with others there."""
    return (
        obj.type == "META"
        or obj.is_instancer
        or any(modifier.type == "NODES" for modifier in obj.modifiers)
    )


def _moved(scene: Any, first: int) -> set[Any]:
    """The objects that can change: Blender names all of them at any change of frame."""
    found: set[Any] = set()

    def note(changed: Any, depsgraph: Any) -> None:
        if changed == scene:
            ids = (update.id.original for update in depsgraph.updates)
            found.update(i for i in ids if isinstance(i, bpy.types.Object))

    # What is new or was edited is named too: that comes first.
    scene.frame_set(first)
    bpy.app.handlers.frame_change_post.append(note)
    try:
        for frame in (first + 1, first):
            scene.frame_set(frame)
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    return found
