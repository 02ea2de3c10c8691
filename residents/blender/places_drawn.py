# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw arrows in 3D views: where residents look at a marked place, and how doors open."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty
from mathutils import Matrix, Vector

from ...angen_addon.runtime.running import is_running
from ...angen_addon.scene import memory
from ...angen_addon.scene.sensors import unit_scale
from ...angen_addon.translations.dictionary import CONTEXT
from ...angen_addon.view.overlay.settings import redraw_views
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.model import Array
from ..acting.places import LAMP, LEAVES, LIE, SIT, STAND
from .marks import FACING, NONE, SLIDES, facing_of, leaf_of, marked, opening_angle

# Colours by use, different from the colours of sensors' states.
REST, USED, LEAF, LIT = (0.6, 0.5, 1.0), (0.15, 0.8, 0.7), (0.3, 0.85, 0.3), (0.75, 1.0, 0.55)
COLOURS = {SIT: REST, LIE: REST, STAND: REST, LAMP: LIT, **dict.fromkeys(LEAVES, LEAF)}
# m: length of an arrow, of the arrow along a bed, and of its head; height above the object.
LONG_M, BED_M, HEAD_M, ABOVE_M = 0.45, 0.9, 0.12, 0.04
# Segments of a door's swing.
ARC = 12
LINE_WIDTH = 2.4


def lines(obj: Any, metres: float) -> Array:
    """Return the lines to draw for a marked object, shape (n, 2, 3), in Blender units.

    `metres` is the length of a Blender unit, m.
    """
    mark = obj.angen_place
    if mark.use in LEAVES:
        return _door_lines(obj, metres)
    if mark.use == LAMP:
        return _lamp(obj)
    if mark.use not in FACING:
        return np.empty((0, 2, 3))
    look = facing_of(obj, obj.matrix_world)
    long = (BED_M if mark.use == LIE else LONG_M) / metres
    start = _top_point(obj) + np.array([0.0, 0.0, ABOVE_M / metres])
    if mark.use == LIE:
        start[:2] -= look * long / 2.0
    return _arrow(start, np.array([*look, 0.0]), long, HEAD_M / metres)


def _top_point(obj: Any) -> Array:
    """Return the middle of the top of an object's bounding box or, without one, its origin (3,)."""
    if obj.type == "EMPTY" or not obj.bound_box:
        return np.array(obj.matrix_world.translation)
    corners = np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box])
    low, high = corners.min(axis=0), corners.max(axis=0)
    return np.array([*((low + high) / 2.0)[:2], high[2]])


def _arrow(start: Array, way: Array, long: float, head: float) -> Array:
    tip, side = start + way * long, np.array([-way[1], way[0], 0.0])
    back = tip - way * head
    return np.array(
        [(start, tip), (tip, back + side * head / 2.0), (tip, back - side * head / 2.0)]
    )


def _lamp(obj: Any) -> Array:
    switch = obj.angen_place.switch
    if switch is None:
        return np.empty((0, 2, 3))
    return np.array([[switch.matrix_world.translation, obj.matrix_world.translation]])


def _door_lines(obj: Any, metres: float) -> Array:
    """Return the lines that show how a door opens: an arc, or an arrow if it slides."""
    try:
        leaf, _ = leaf_of(obj)
    except AngenError:
        return np.empty((0, 2, 3))
    corners = [obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
    free = leaf.corner.copy()
    free.z = min(corner.z for corner in corners) + ABOVE_M / metres
    mark = obj.angen_place
    if leaf.slides:
        long = mark.slide / metres or SLIDES * leaf.width
        return _arrow(np.array(free), np.array(-leaf.edge), long, HEAD_M / metres)
    hinge = leaf.pivot.copy() if leaf.pivot else free - leaf.edge * leaf.width
    hinge.z = free.z
    turn = opening_angle(leaf, mark.angle)
    swung = [
        hinge + Matrix.Rotation(turn * k / ARC, 3, "Z") @ (free - hinge) for k in range(ARC + 1)
    ]
    pairs = [*pairwise(swung), (hinge, swung[-1])]
    return np.array([[tuple(a), tuple(b)] for a, b in pairs])


def _signature(obj: Any) -> tuple[Any, ...]:
    """Return all values on which the lines of a marked object depend.

    A leaf with keyframes is drawn shut, so its present matrix is left out.
    """
    mark, keyed = obj.angen_place, obj.animation_data is not None and obj.animation_data.action
    at = obj.matrix_world if not (keyed and mark.use in LEAVES) else Matrix()
    switch = mark.switch.matrix_world.translation[:] if mark.switch else ()
    values = mark.use, mark.facing, mark.motion, mark.other_side, mark.angle, mark.slide, switch
    return obj.session_uid, *(value for row in at for value in row), *values


def _batch(objects: list[Any], metres: float, shader: Any) -> Any:
    from gpu_extras.batch import batch_for_shader

    points, colours = [], []
    for obj in objects:
        found = lines(obj, metres).reshape(-1, 3)
        points += [tuple(point) for point in found.tolist()]
        use = obj.angen_place.use
        colours += [(*COLOURS.get(use, USED), 0.35 if use == LAMP else 0.9)] * len(found)
    return batch_for_shader(shader, "LINES", {"pos": points, "color": colours})


def shown(context: Any) -> list[Any]:
    """Return the marked objects whose arrows are drawn: all, or only selected ones."""
    if context.scene.angen_show_places:
        return marked(context.view_layer)
    return [o for o in context.selected_objects if o.angen_place.use != NONE]


# The batch of lines that was drawn last, and what it depends on.
_drawn: tuple[Any, Any] | None = None


@memory.forgets_at_undo
def _forget() -> None:
    global _drawn
    _drawn = None


def draw() -> None:
    """Draw the arrows; no data of the file change."""
    global _drawn
    context = bpy.context
    scene, space = context.scene, context.space_data
    if not scene.angen_overlay.show or not space.overlay.show_overlays or is_running():
        return
    objects = [o for o in shown(context) if o.visible_in_viewport_get(space)]
    if not objects:
        return
    import gpu

    shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
    metres = unit_scale(scene)
    known = metres, *(_signature(obj) for obj in objects)
    if _drawn is None or _drawn[0] != known:
        _drawn = known, _batch(objects, metres, shader)
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", LINE_WIDTH * context.preferences.system.ui_scale)
    _drawn[1].draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _changed(self: Any, context: Any) -> None:
    redraw_views()


_handles: list[Any] = []


def register() -> None:
    bpy.types.Scene.angen_show_places = BoolProperty(
        translation_context=CONTEXT,
        name="Show Places",
        description="Draw arrows for all marked places of residents, and how doors swing. If off, "
        "draw them only for selected objects. Switching off Show in View hides them "
        "too",
        options=set(),
        update=_changed,
    )
    if not bpy.app.background:
        add = bpy.types.SpaceView3D.draw_handler_add
        _handles.append(add(draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    del bpy.types.Scene.angen_show_places
