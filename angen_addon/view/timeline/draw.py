# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the history of sensors over the Timeline."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
from bpy.types import SpaceDopeSheetEditor

from ...recording.results import RESULTS
from ...runtime.edits import EDITS
from ...scene.instances import Uid, stands_for
from ...scene.sensors import Sensor
from ...translations.interface import language
from .layout import (
    CHIP,
    HISTORIES,
    Colour,
    History,
    TimelinePicture,
    TimelineRegion,
    TimelineText,
    labels,
    place,
    strips,
)

# The mode of the editor in which rows are drawn: in a Dope Sheet they would cover keyframes.
MODE = "TIMELINE"
# Heights in pixels at an interface scale of 1: scrubbing area, scroll bar, row of markers.
SCRUB, SCROLL_BAR, MARKERS = 24.0, 16.0, 22.0
MOST_PAINTERS = 24
# Why there are no rows. Longer texts do not fit the header of Blender 5.2 at 1280 pixels.
TOO_LOW, STALE, NOT_RECORDED = "Too low for rows", "Stale: simulate", "Not recorded"
# Likewise by the setting `rows`.
NO_ROWS = {"ALL": "No sensors", "ROOM": "Select a sensor", "SELECTED": "Select sensors"}


class Painter:
    """Draws the picture of one region, and keeps its GPU batches while only the playhead moves."""

    def __init__(self) -> None:
        self._key: Any = None
        self._batches: list[Any] = []
        self._words: list[TimelineText] = []

    def paint(self, key: Any, make: Callable[[], TimelinePicture]) -> None:
        """Draw a picture; call `make` for a new one if `key` differs from the last call.

        `key` contains everything on which the picture depends.
        """
        import gpu

        if (language(), key) != self._key:
            picture = make()
            self._batches, self._words = _batches(picture), picture.words
            self._key = language(), key
        shader = gpu.shader.from_builtin("FLAT_COLOR")
        gpu.state.blend_set("ALPHA")
        gpu.state.line_width_set(1.0)
        for batch in self._batches:
            batch.draw(shader)
        _draw_words(shader, self._words)
        gpu.state.blend_set("NONE")


# By address of the region, and name of the picture.
_painters: dict[tuple[int, str], Painter] = {}
_handles: list[tuple[Any, str]] = []


def sensors_with_rows(settings: Any, sensors: list[Sensor], context: Any) -> list[Sensor]:
    """Return the sensors that have a row by the setting `rows`.

    The setting selects all sensors, the selected ones, or those in the room of the active sensor.
    """
    active = stands_for(context.view_layer.objects.active)
    if settings.rows == "SELECTED":
        return [s for s in sensors if s.handle == active or s.selected]
    if settings.rows == "ROOM":
        rooms = {s.room for s in sensors if s.handle == active}
        return [s for s in sensors if s.room in rooms]
    return sensors


def draw_window() -> None:
    """Draw the rows: the draw handler of the timeline's main region."""
    found = _rows_here(bpy.context)
    if found is None:
        return
    history, chosen, settings = found
    region, area = bpy.context.region, bpy.context.area
    view = view_of(bpy.context.scene, region)
    if view is None:
        return
    key = (history, view, chosen)
    _painter("strips").paint(key, lambda: strips(history, view, chosen))
    # Write the names on the strips if there is no list of channels beside them.
    aside = any(r.type == "CHANNELS" and r.width > 1 for r in area.regions)
    if settings.names and not aside:
        _painter("names").paint(key, lambda: labels(history, view, chosen, ground=False))


def draw_channels() -> None:
    """Draw the names of the rows: the draw handler of the list of channels beside the timeline."""
    found = _rows_here(bpy.context)
    if found is None or bpy.context.region.width <= 1:
        return
    history, chosen, settings = found
    region = bpy.context.region
    if not settings.names:
        return
    bottom, top, scale = _row_limits(bpy.context.scene, region)
    view = TimelineRegion(region.width, bottom, top, scale, 0.0, 1.0)
    key = (history, view, chosen)
    _painter("list").paint(key, lambda: labels(history, view, chosen, ground=True))


def _rows_here(context: Any) -> tuple[History, frozenset[Uid], Any] | None:
    """Return the rows of the present region, the highlighted uids and the settings, or None."""
    scene, space = context.scene, context.space_data
    if scene is None or not scene.angen_timeline.show or space.mode != MODE:
        return None
    recording = RESULTS.recording(scene)
    if recording is None:
        return None
    settings = scene.angen_timeline
    sensors = EDITS.sensors(context.view_layer)
    history = HISTORIES.get(recording, sensors)
    if settings.rows != "ALL":
        uids = frozenset(s.uid for s in sensors_with_rows(settings, sensors, context))
        history = history.only(uids)
    active = stands_for(context.view_layer.objects.active)
    chosen = frozenset(s.uid for s in sensors if s.handle == active or s.selected)
    return history, chosen, settings


def why_no_rows(context: Any) -> str:
    """Return why the timeline shows no rows although it should, in a few words; else ""."""
    scene, kept = context.scene, RESULTS.kept(context.scene)
    if not scene.angen_timeline.show:
        return ""
    if kept is None:
        return NOT_RECORDED if EDITS.sensors(context.view_layer) else ""
    if kept.stale:
        return STALE
    region = next((r for r in context.area.regions if r.type == "WINDOW"), None)
    found = _rows_here(context)
    if region is None or found is None:
        return ""
    history, _, settings = found
    if not history.rows:
        return NO_ROWS[settings.rows]
    bottom, top, scale = _row_limits(scene, region)
    view = TimelineRegion(region.width, bottom, top, scale, 0.0, 1.0)
    return "" if place(history.rows, view) else TOO_LOW


def _painter(what: str) -> Painter:
    if len(_painters) > MOST_PAINTERS:
        # Most painters belong to regions that no longer exist.
        _painters.clear()
    return _painters.setdefault((bpy.context.region.as_pointer(), what), Painter())


def view_of(scene: Any, region: Any) -> TimelineRegion | None:
    """Return size, limits and frames of the region to draw rows in; None if it is too small."""
    bottom, top, scale = _row_limits(scene, region)
    left, right = (region.view2d.region_to_view(x, 0)[0] for x in (0, region.width))
    if top <= bottom or right <= left:
        return None
    return TimelineRegion(region.width, bottom, top, scale, left, right)


def _row_limits(scene: Any, region: Any) -> tuple[float, float, float]:
    """Return the pixels of the bottom and the top of the rows, and the interface's scale."""
    scale = bpy.context.preferences.system.ui_scale
    bottom = SCROLL_BAR * scale
    if len(scene.timeline_markers):
        bottom += MARKERS * scale
    return bottom, region.height - SCRUB * scale, scale


def _batches(picture: TimelinePicture) -> list[Any]:
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("FLAT_COLOR")
    made = []
    places: list[tuple[float, float]] = []
    colours: list[Colour] = []
    for x0, y0, x1, y1, colour in picture.quads:
        places += [(x0, y0), (x1, y0), (x1, y1), (x0, y0), (x1, y1), (x0, y1)]
        colours += [colour] * 6
    if places:
        made.append(batch_for_shader(shader, "TRIS", {"pos": places, "color": colours}))
    places, colours = [], []
    for x0, y0, x1, y1, colour in picture.lines:
        # A line through the middle of pixels is one pixel wide.
        places += [(x0, y0 + 0.5), (x1, y1 + 0.5)]
        colours += [colour] * 2
    if places:
        made.append(batch_for_shader(shader, "LINES", {"pos": places, "color": colours}))
    return made


def _draw_words(shader: Any, words: list[TimelineText]) -> None:
    import blf
    from gpu_extras.batch import batch_for_shader

    for word in words:
        blf.size(0, word.size)
        wide = blf.dimensions(0, word.text)[0]
        x = word.x - wide if word.to_the_left else word.x
        y = word.y - 0.36 * word.size
        pad = 2.0
        corners = (x - pad, y - pad), (x + wide + pad, y + word.size - pad)
        (x0, y0), (x1, y1) = corners
        places = [(x0, y0), (x1, y0), (x1, y1), (x0, y0), (x1, y1), (x0, y1)]
        batch_for_shader(shader, "TRIS", {"pos": places, "color": [CHIP] * 6}).draw(shader)
        blf.color(0, *word.colour)
        blf.position(0, x, y, 0)
        blf.draw(0, word.text)


def register() -> None:
    if bpy.app.background:
        return
    for region, handler in (("WINDOW", draw_window), ("CHANNELS", draw_channels)):
        handle = SpaceDopeSheetEditor.draw_handler_add(handler, (), region, "POST_PIXEL")
        _handles.append((handle, region))


def unregister() -> None:
    while _handles:
        SpaceDopeSheetEditor.draw_handler_remove(*_handles.pop())
    _painters.clear()
    HISTORIES.clear()
