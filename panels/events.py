# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel of the active sensor's events (sidebar), and the popover of the timeline's header."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy
from bpy.types import Context, DOPESHEET_HT_header, Panel

from ..angen_addon.appearance.facts import Explanation
from ..angen_addon.appearance.panel_parts import (
    LABEL_SHARE,
    MARGIN_LETTERS,
    USUAL_WIDTH,
    WIDTH_OF_LETTER,
    Sidebar,
    draw_lines,
    draw_row,
)
from ..angen_addon.explain.explain import MEMORY
from ..angen_addon.recording.results import RESULTS
from ..angen_addon.runtime.edits import EDITS
from ..angen_addon.runtime.playhead import why_not_recorded
from ..angen_addon.runtime.time_base import moment_text
from ..angen_addon.translations.interface import translated, translating
from ..angen_addon.view.active import active_sensor
from ..angen_addon.view.timeline.draw import MODE, TOO_LOW, why_no_rows
from ..angen_addon.view.timeline.layout import HISTORIES, HistoryRow
from ..operators.markers import event_name
from ..operators.recording import why_not_fresh
from ..sensor_logic.logs.wording import capital
from ..sensor_logic.recording.tracks import Recording, Track

# How many letters fit a line of a popover, beside an icon.
POPOVER_LETTERS = 26


class ANGEN_PT_events(Sidebar, Panel):
    bl_label = "Events"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return active_sensor(context) is not None

    def draw(self, context: Context) -> None:
        layout, scene = self.layout, context.scene
        recording = RESULTS.recording(scene)
        sensor = active_sensor(context)
        if sensor is None:
            return
        track = recording.track_of(sensor.uid) if recording else None
        if recording is None:
            draw_lines(layout, why_not_fresh(scene), "INFO")
            return
        if track is None or not len(track):
            draw_lines(layout, why_not_recorded(sensor), "INFO")
            return
        history = HISTORIES.get(recording, EDITS.sensors(context.view_layer))
        row = history.row_of(sensor.uid)
        if row is not None:
            _draw_events(layout, scene, recording, track, row)


def _draw_events(
    layout: Any, scene: Any, recording: Recording, track: Track, row: HistoryRow
) -> None:
    frame = scene.frame_current + scene.frame_subframe + 1e-4
    events = row.events.tolist()
    passed = sum(track.frames[i] <= frame for i in events)
    # The name comes last, because Blender cuts the end of a text that does not fit.
    text = f"{passed} of {len(events)} events passed: {track.sensor}"
    layout.label(text=text, icon="PREVIEW_RANGE")
    line = layout.row(align=True)
    line.operator("angen.event_jump", text="Previous", icon="PREV_KEYFRAME").direction = "PREVIOUS"
    line.operator("angen.event_jump", text="Next", icon="NEXT_KEYFRAME").direction = "NEXT"
    if len(row.states) < len(events):
        if not scene.angen_timeline.values:
            layout.label(text=f"{len(row.states)} of {len(events)} shown: changes of state")
        layout.prop(scene.angen_timeline, "values")
    line = layout.row(align=True)
    line.operator("angen.markers_add", icon="MARKER_HLT")
    line.operator("angen.markers_clear", text="", icon="TRASH")
    logged = [i for i in row.log.tolist() if track.frames[i] <= frame]
    if not logged:
        return
    index = logged[-1]
    at = capital(moment_text(scene, track.frames[index]))
    draw_lines(layout, f"{at}: {event_name(track, index)}", "TIME")
    layout.operator("angen.explain", text="Explain This Event", icon="QUESTION")
    now = track.at(frame)
    if now is not None and not track.active[now]:
        layout.operator("angen.explain", text="Why Not Now?", icon="QUESTION").now = True
    explanation = MEMORY.recall(recording, track.uid, now)
    explanation = explanation or MEMORY.recall(recording, track.uid, index)
    if explanation is not None:
        _draw_explanation(layout, explanation)


def _draw_explanation(layout: Any, explanation: Explanation) -> None:
    if explanation.doubt:
        draw_lines(layout, f"Doubtful: {explanation.doubt}", "ERROR")
    draw_lines(layout, explanation.headline, "INFO")
    column = layout.column(align=True)
    region = bpy.context.region
    scale = bpy.context.preferences.system.ui_scale or 1.0
    wide = (1.0 - LABEL_SHARE) * (region.width if region else USUAL_WIDTH) / scale
    letters = max(12, int(wide / WIDTH_OF_LETTER) - MARGIN_LETTERS // 2)
    of_names = int(LABEL_SHARE / (1.0 - LABEL_SHARE) * letters)
    for name, text in (map(translated, fact) for fact in explanation.facts):
        if len(name) > of_names:
            # The column of names is too narrow for this name.
            for line in textwrap.wrap(f"{name}: {text}", of_names + letters):
                column.label(text=line, translate=False)
            continue
        for line in textwrap.wrap(text, letters, break_on_hyphens=False):
            draw_row(column, name, line, translate=False)
            name = ""


def _draw_wrapped(layout: Any, text: str) -> None:
    """Draw a text in the lines of a popover, whose width is not that of its region."""
    column = layout.column(align=True)
    for number, line in enumerate(textwrap.wrap(text, POPOVER_LETTERS, break_on_hyphens=False)):
        column.label(text=line, icon="BLANK1" if number else "INFO")


class ANGEN_PT_timeline(Panel):
    bl_label = "Sensor History"
    bl_space_type = "DOPESHEET_EDITOR"
    bl_region_type = "HEADER"
    bl_description = "What the timeline shows of the sensors"

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.angen_timeline
        layout.prop(settings, "show")
        column = layout.column()
        column.active = settings.show
        column.prop(settings, "rows", expand=True)
        column.prop(settings, "names")
        if RESULTS.recording(context.scene) is None:
            _draw_wrapped(layout, why_not_fresh(context.scene))
        elif why_no_rows(context) == TOO_LOW:
            _draw_wrapped(layout, "Drag the upper edge of the Timeline up to see rows")
        layout.separator()
        line = layout.row(align=True)
        line.operator("angen.markers_add", icon="MARKER_HLT")
        line.operator("angen.markers_clear", text="", icon="TRASH")


@translating
def draw_in_timeline_header(self: Any, context: Context) -> None:
    if context.space_data.mode != MODE:
        return
    row = self.layout.row(align=True)
    row.prop(context.scene.angen_timeline, "show", text="", icon="SEQ_HISTOGRAM")
    why = why_no_rows(context)
    # The reason takes the place of the name, since the header has no room for both.
    icon = "INFO" if why else "NONE"
    row.popover(ANGEN_PT_timeline.__name__, text=why or "Sensors", icon=icon)


CLASSES = (ANGEN_PT_events, ANGEN_PT_timeline)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    DOPESHEET_HT_header.append(draw_in_timeline_header)


def unregister() -> None:
    DOPESHEET_HT_header.remove(draw_in_timeline_header)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
