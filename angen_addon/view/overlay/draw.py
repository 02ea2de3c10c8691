# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the fields and states of sensors in 3D views, on the GPU.

Nothing is worked out here that could take long or write: where something is missing, the drawing
asks for it (refresh.soon) and leaves it out until it is there.
"""

from __future__ import annotations

from typing import Any

import bpy

from ....panels.readings import Readings, Shown
from ...runtime import state
from . import labels, refresh
from .field import Field
from .figures import Figure
from .picture import Part, figures, picture

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
    readings = Readings(scene)
    return [
        readings.of(seen.sensor) if seen.sensor.handle.visible_in_viewport_get(space) else None
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
    _draw_parts(_parts_to_draw(field, context.scene, states))


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


def _parts_to_draw(field: Field, scene: Any, states: list[Shown | None]) -> list[dict[str, Any]]:
    """The GPU's copies of all figures, each made anew only where it changed or looks otherwise."""
    only_selected = scene.angen_overlay.which == "SELECTED"
    found = []
    for seen, one in zip(field.seen, states, strict=True):
        if one is None or seen.figure is None:
            continue
        selected = seen.selected
        if selected or not only_selected:
            look = one.icon, selected
            found += [_kept(figure, look) for figure in figures(seen, one, field.metres)]
    return found


def _kept(figure: Figure, look: tuple[str, bool]) -> dict[str, Any]:
    """By how they are drawn, the batches of a figure that looks so; the figure keeps them."""
    if figure.drawn is None or figure.drawn[0] != look:
        parts = picture(figure, *look)
        figure.drawn = look, {name: _batch(part) for name, part in parts.items()}
    batches: dict[str, Any] = figure.drawn[1]
    return batches


def _batch(part: Part) -> Any:
    import gpu

    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type="F32", len=3, fetch_mode="FLOAT")
    layout.attr_add(id="color", comp_type="F32", len=4, fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(part.points))
    buffer.attr_fill("pos", part.points)
    buffer.attr_fill("color", part.colours)
    return gpu.types.GPUBatch(type="LINES" if part.corners == 2 else "TRIS", buf=buffer)


def _draw_parts(figures: list[dict[str, Any]]) -> None:
    import gpu

    scale = bpy.context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_mask_set(False)
    viewport = gpu.state.viewport_get()[2:]
    for name in ORDER:
        batches = [parts[name] for parts in figures if name in parts]
        if not batches:
            continue
        gpu.state.depth_test_set("ALWAYS" if name.startswith("top") else "LESS_EQUAL")
        if name in ("fills", "top_fills"):
            shader = gpu.shader.from_builtin("SMOOTH_COLOR")
        else:
            shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
            shader.uniform_float("viewportSize", viewport)
            shader.uniform_float("lineWidth", (THIN if name == "thin" else BOLD) * scale)
        for batch in batches:
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
