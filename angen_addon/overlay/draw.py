# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the fields and states of sensors in 3D views, on the GPU.

Nothing is worked out here that could take long or write: where something is missing, the drawing
asks for it (refresh.soon) and leaves it out until it is there.
"""

from __future__ import annotations

from typing import Any

import bpy

from ...panels.readings import Shown, shown
from .. import state
from . import labels, refresh
from .field import Field
from .picture import Part, is_still, lively_figures, picture, still_figures

THIN, BOLD = 1.2, 2.2
ORDER = ("fills", "thin", "bold", "top_fills", "top")


def _field_to_draw(context: Any) -> Field | None:
    """What is drawn in this view, if it is there; else it is asked for."""
    scene, space = context.scene, context.space_data
    if not refresh.wanted(scene) or not space.overlay.show_overlays:
        return None
    field: Field | None = state.CACHE.overlay
    if field is None or field.scene_uid != scene.session_uid:
        refresh.soon()
        return None
    missing = scene.angen_overlay.fields and any(
        seen.figure is None and seen.rays is not None and _wants_field(scene, seen)
        for seen in field.seen
    )
    if field.outdated or field.frame != scene.frame_current or missing:
        refresh.soon()
    return field


def _wants_field(scene: Any, seen: Any) -> bool:
    return scene.angen_overlay.which == "ALL" or seen.selected


def states_of(field: Field, scene: Any, space: Any) -> list[Shown | None]:
    """What each sensor reads; None for those that this view does not show."""
    return [
        shown(seen.sensor, scene) if seen.sensor.handle.visible_in_viewport_get(space) else None
        for seen in field.seen
    ]


def draw_fields() -> None:
    """In the world, before what Blender draws over it."""
    context = bpy.context
    try:
        field = _field_to_draw(context)
        if field is None or not context.scene.angen_overlay.fields:
            return
        states = states_of(field, context.scene, context.space_data)
    except ReferenceError:
        _drop()
        return
    # The labels of this view are what Blender asks for next.
    field.states = context.region.as_pointer(), states
    _draw_parts(_batches(field, context.scene, states))


def draw_labels() -> None:
    """On the screen: signs, names and readings."""
    context = bpy.context
    try:
        field = _field_to_draw(context)
        if field is not None:
            region, states = field.states
            field.states = 0, []
            if region != context.region.as_pointer() or len(states) != len(field.seen):
                states = states_of(field, context.scene, context.space_data)
            labels.draw(context, field, states)
    except ReferenceError:
        _drop()


def _drop() -> None:
    """Undo took away what was drawn."""
    state.CACHE.overlay = None
    refresh.soon()


def _batches(field: Field, scene: Any, states: list[Shown | None]) -> list[dict[str, Any]]:
    """The GPU's copy of the picture, made anew only where it changed: the fields that are still
    apart from those in which something moves, and from what changes with every update."""
    only_selected = scene.angen_overlay.which == "SELECTED"
    selected = tuple(seen.selected for seen in field.seen)
    now = [
        None if only_selected and not chosen else one
        for one, chosen in zip(states, selected, strict=True)
    ]
    looks = [
        (seen.made if seen.figure is not None else None, one.icon, chosen)
        if one is not None
        else None
        for seen, one, chosen in zip(field.seen, now, selected, strict=True)
    ]
    still = tuple(
        look if is_still(seen) else None for seen, look in zip(field.seen, looks, strict=True)
    )
    read = [_reading_of(seen, one) for seen, one in zip(field.seen, now, strict=True)]
    lively = field.extras, still, tuple(looks), read
    return [
        _kept(field, "still", (field.listed, still), still_figures, now),
        _kept(field, "lively", (field.listed, lively), lively_figures, now),
    ]


def _kept(field: Field, name: str, key: Any, figures: Any, states: Any) -> dict[str, Any]:
    known = field.drawn.get(name)
    if known is None or known[0] != key:
        parts = picture(figures(field, states))
        known = field.drawn[name] = key, {n: _batch(part) for n, part in parts.items()}
    batches: dict[str, Any] = known[1]
    return batches


def _reading_of(seen: Any, one: Shown | None) -> Any:
    """What of a reading is drawn."""
    names = seen.appearance.drawn_fields
    if one is None or one.fields is None or not names:
        return None
    return [str(one.fields.get(name)) for name in names], one.problem


def _batch(part: Part) -> Any:
    import gpu

    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type="F32", len=3, fetch_mode="FLOAT")
    layout.attr_add(id="color", comp_type="F32", len=4, fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(part.points))
    buffer.attr_fill("pos", part.points)
    buffer.attr_fill("color", part.colours)
    return gpu.types.GPUBatch(type="LINES" if part.corners == 2 else "TRIS", buf=buffer)


def _draw_parts(batches: list[dict[str, Any]]) -> None:
    import gpu

    scale = bpy.context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_mask_set(False)
    viewport = gpu.state.viewport_get()[2:]
    for name, batch in (
        (name, group[name]) for name in ORDER for group in batches if name in group
    ):
        gpu.state.depth_test_set("ALWAYS" if name.startswith("top") else "LESS_EQUAL")
        if name in ("fills", "top_fills"):
            batch.draw(gpu.shader.from_builtin("SMOOTH_COLOR"))
            continue
        shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
        shader.uniform_float("viewportSize", viewport)
        shader.uniform_float("lineWidth", (THIN if name == "thin" else BOLD) * scale)
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.depth_mask_set(True)
    gpu.state.blend_set("NONE")


_handles: list[Any] = []


def register() -> None:
    if bpy.app.background:
        return
    for function, stage in ((draw_fields, "POST_VIEW"), (draw_labels, "POST_PIXEL")):
        add = bpy.types.SpaceView3D.draw_handler_add
        _handles.append(add(function, (), "WINDOW", stage))


def unregister() -> None:
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    refresh.cancel()
