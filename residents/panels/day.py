# SPDX-License-Identifier: GPL-3.0-or-later
"""Sidebar tab "Sensors": a day of a routine as a strip of hours and a list of activities."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel, UIList

from ...panels.lines import ClosedSidebar, draw_working
from ..days.rows import HOUR_S, hours_minutes, time_at

# The lines of the strip: night and morning, day, and evening.
HOURS_A_LINE = 8


def longest(done: list[Any], start: float, end: float) -> int | None:
    """The index of the activity that takes most of the time from `start` to `end`, or None."""
    shares = [min(item.end, end) - max(item.start, start) for item in done]
    best = max(range(len(done)), key=shares.__getitem__, default=None)
    return None if best is None or shares[best] <= 0 else best


def _strip(layout: Any, asked: Any, person: str) -> None:
    """Buttons for the hours of a day; each shows the longest activity of that hour."""
    layout.label(text=person)
    theirs = [index for index, item in enumerate(asked.done) if item.person == person]
    done = [asked.done[index] for index in theirs]
    lines = layout.column(align=True)
    for hour in range(24):
        if hour % HOURS_A_LINE == 0:
            line = lines.row(align=True)
        best = longest(done, hour * HOUR_S, (hour + 1) * HOUR_S)
        part = line.row(align=True)
        part.enabled = best is not None
        index = -1 if best is None else theirs[best]
        is_shown = bool(asked.before) and index == asked.shown
        show = part.operator("angen.day_show", text=f"{hour:02d}", depress=is_shown)
        show.index = index


class ANGEN_UL_done(UIList):
    """The activities of the day; a click shows one as animation."""

    def draw_item(
        self, context: Context, layout: Any, data: Any, item: Any, icon: int, active: Any,
        active_property: str, index: int,
    ) -> None:  # fmt: skip
        split = layout.split(factor=0.22, align=True)
        split.label(text=hours_minutes(item.start))
        row = split.row()
        row.alignment = "LEFT"
        several = len({other.person for other in data.done}) > 1
        parts = [item.name, item.room, item.person if several else ""]
        text = ", ".join(part for part in parts if part)
        row.operator("angen.day_show", text=text, emboss=False).index = index


class ANGEN_PT_day(ClosedSidebar, Panel):
    bl_label = "Day"

    def draw(self, context: Context) -> None:
        layout, asked = self.layout, context.scene.angen_day
        column = layout.column()
        column.use_property_split = True
        column.prop(asked, "text")
        if asked.text is None:
            column.prop(asked, "routine")
        for name in ("date", "number", "seed"):
            column.prop(asked, name)
        header, body = layout.panel("ANGEN_day_site", default_closed=True)
        header.label(text="Place on Earth")
        if body is not None:
            body.use_property_split = True
            for name in ("latitude", "longitude", "utc_offset", "north"):
                body.prop(context.scene.angen_site, name)
        if not draw_working(layout, "angen.day_read"):
            layout.operator("angen.day_read", icon="FILE_REFRESH")
        if not asked.done:
            return
        layout.label(text=asked.told)
        layout.label(text="Hours; a click shows the longest activity")
        for person in dict.fromkeys(item.person for item in asked.done):
            _strip(layout, asked, person)
        layout.template_list("ANGEN_UL_done", "", asked, "done", asked, "active", rows=6)
        if asked.before:
            scene = context.scene
            shown = asked.done[asked.shown]
            now = time_at(scene.frame_current + scene.frame_subframe)
            layout.label(
                text=f"{hours_minutes(now)}:{now % 60:04.1f}, {shown.name} ({shown.person})",
                icon="TIME",
            )
            layout.operator("angen.day_leave", icon="LOOP_BACK")


register, unregister = bpy.utils.register_classes_factory((ANGEN_UL_done, ANGEN_PT_day))
