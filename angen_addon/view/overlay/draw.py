# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the fields of view and the states of sensors in 3D views, on the GPU.

Drawing never does long work, and writes nothing to the scene. A missing figure is left out:
`refresh.soon` makes it for a later redraw.
"""

from __future__ import annotations

from typing import Any

import bpy

from ...appearance.figures import Figure
from ...scene.instances import housed_by
from ...view.readings import ReadingTexts
from . import labels, refresh
from .picture import DrawnSensors, Primitives, SensorRow, changing_figures, joined, picture

THIN, BOLD = 1.2, 2.2
# After this many draws without a change a figure is joined with other unchanged ones.
SETTLED = 12
ORDER = ("fills", "thin", "bold", "top_fills", "top")


def _sensors_to_draw(context: Any) -> DrawnSensors | None:
    """Return the sensors to draw in this view, or None; schedule an update if they are outdated."""
    scene, space = context.scene, context.space_data
    if not refresh.wanted(scene) or not space.overlay.show_overlays:
        return None
    drawn = refresh.overlay
    if drawn is None or drawn.scene_uid != scene.session_uid:
        refresh.soon()
        return None
    missing = scene.angen_overlay.fields and not drawn.has_fields
    if drawn.outdated or drawn.frame != scene.frame_current or missing:
        refresh.soon()
    return drawn


def rows_to_draw(drawn: DrawnSensors, scene: Any, space: Any) -> list[SensorRow]:
    """Return the sensors of `drawn` that the 3D view `space` shows.

    Each `SensorRow` also has the reading, and whether the sensor is selected.
    """
    readings, found = ReadingTexts(scene), []
    active = bpy.context.view_layer.objects.active
    housed = housed_by(active) if active is not None and active.select_get() else None
    for seen in drawn.seen:
        if seen.sensor.handle.visible_in_viewport_get(space):
            selected = seen.selected or (housed is not None and seen.sensor.object == housed)
            # The full text has the age of the reading, which changes at each draw.
            full = selected or seen.uid == drawn.hovered
            source = None if full else readings.source(seen.sensor)
            if seen.texts is None or source is None or seen.texts[0] != source:
                seen.texts = source, readings.of(seen.sensor)
            found.append(SensorRow(seen, seen.texts[1], selected))
    return found


def draw_fields() -> None:
    """Draw fields of view in the world: a draw handler, after Blender has drawn the scene."""
    context = bpy.context
    try:
        drawn = _sensors_to_draw(context)
        if drawn is None or not context.scene.angen_overlay.fields:
            return
        rows = rows_to_draw(drawn, context.scene, context.space_data)
    except ReferenceError:
        _drop()
        return
    # Keep the rows: Blender next draws the labels of this view.
    region = context.region.as_pointer()
    drawn.rows = region, rows
    if context.scene.angen_overlay.which == "SELECTED":
        rows = [row for row in rows if row.selected]
    view = drawn.joined.setdefault(region, JoinedBatches())
    _draw_batches(view.batches(rows, drawn.metres))


def draw_labels() -> None:
    """Draw signs, names and readings on the screen: a draw handler."""
    context = bpy.context
    try:
        drawn = _sensors_to_draw(context)
        if drawn is not None:
            region, rows = drawn.rows
            drawn.rows = 0, []
            if region != context.region.as_pointer():
                rows = rows_to_draw(drawn, context.scene, context.space_data)
            labels.draw(context, drawn, rows)
    except ReferenceError:
        _drop()


def _drop() -> None:
    """Discard the overlay after undo has freed the objects that it refers to."""
    refresh.discard()
    refresh.soon()


class JoinedBatches:
    """The figures of one view, joined into few GPU batches.

    The figures that have not changed for a while are joined in one batch, which is kept until one
    of them changes. All others are joined in a second batch, made anew after each change. Drawing
    each figure separately would take 1 ms longer per frame.
    """

    def __init__(self) -> None:
        self._draws = 0
        # By uid of a sensor: what it looked like last, and the number of the first draw of that.
        self._since: dict[Any, tuple[Any, int]] = {}
        self._kept: dict[str, tuple[Any, dict[str, Any]]] = {}

    def batches(self, rows: list[SensorRow], metres: float) -> list[dict[str, Any]]:
        """Return two groups of batches for these sensors: of unchanged figures, and of all others.

        Each group has its batches by their names in `picture`. `metres` is the length of a Blender
        unit in m.
        """
        self._draws += 1
        still: list[tuple[Figure, str, bool]] = []
        rest: list[tuple[Figure, str, bool]] = []
        for seen, shown, selected in rows:
            look = shown.icon, selected
            now = seen, seen.revision, look
            known = self._since.get(seen.uid)
            if known is None or known[0] != now:
                known = self._since[seen.uid] = now, self._draws
            settled = self._draws - known[1] >= SETTLED
            (still if settled else rest).extend((figure, *look) for figure in seen.figures)
            rest += [(figure, *look) for figure in changing_figures(seen, shown, metres)]
        return [self._made("still", still), self._made("rest", rest)]

    def _made(self, name: str, figures: list[tuple[Figure, str, bool]]) -> dict[str, Any]:
        known = self._kept.get(name)
        if known is None or known[0] != figures:
            parts = joined(picture(*one) for one in figures)
            known = self._kept[name] = figures, {n: _batch(part) for n, part in parts.items()}
        return known[1]


def _batch(part: Primitives) -> Any:
    import gpu

    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type="F32", len=3, fetch_mode="FLOAT")
    layout.attr_add(id="color", comp_type="F32", len=4, fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(part.points))
    buffer.attr_fill("pos", part.points)
    buffer.attr_fill("color", part.colours)
    return gpu.types.GPUBatch(type="LINES" if part.corners == 2 else "TRIS", buf=buffer)


def _draw_batches(groups: list[dict[str, Any]]) -> None:
    import gpu

    scale = bpy.context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_mask_set(False)
    viewport = gpu.state.viewport_get()[2:]
    for name in ORDER:
        batches = [group[name] for group in groups if name in group]
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
