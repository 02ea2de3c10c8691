# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel Day: a day of a routine as a strip of hours and a list of activities (sidebar)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel, UIList

from ...angen_addon.appearance.panel_parts import ClosedSidebar, draw_lines, draw_progress
from ..blender.followed_day import why_stale
from ..days.rows import HOUR_S, hours_minutes, lasting, time_at
from .strip import colours_of, hour_pixels, icon_of, plain_pixels

# Hours in a line of the strip. A narrow sidebar has room for 12.
HOURS_A_LINE = 12


def _draw_strip(layout: Any, settings: Any, person: str, now: float | None) -> None:
    """Draw the day of a person as a bar of hours, coloured by activity.

    A click on an hour goes to its time. `now` is the shown time in s since midnight, or None.
    """
    layout.label(text=person, translate=False)
    colours = colours_of(settings.done)
    spans = [(d.start, d.end, colours[d.name]) for d in settings.done if d.person == person]
    lines = layout.column(align=True)
    for hour in range(24):
        if hour % HOURS_A_LINE == 0:
            line = lines.row(align=True)
            line.alignment = "LEFT"
        icon = icon_of(hour_pixels(hour, spans, now is not None and now // HOUR_S == hour))
        go = line.operator("angen.day_go", text="", icon_value=icon, emboss=False)
        go.time, go.person = f"{hour:02d}:00", person


class ANGEN_UL_done(UIList):
    """The activities of the day; a click shows one as animation."""

    def draw_item(
        self, context: Context, layout: Any, data: Any, item: Any, icon: int, active: Any,
        active_property: str, index: int,
    ) -> None:  # fmt: skip
        several = len({other.person for other in data.done}) > 1
        parts = [item.name, item.room, item.person if several else ""]
        what = ", ".join(part for part in parts if part)
        text = f"{hours_minutes(item.start)}, {lasting(item.end - item.start)}: {what}"
        row = layout.row(align=True)
        row.alignment = "LEFT"
        icon = icon_of(plain_pixels(colours_of(data.done)[item.name]))
        show = row.operator(
            "angen.day_show", text=text, icon_value=icon, emboss=False, translate=False
        )
        show.index = index


def _draw_run(layout: Any, settings: Any) -> None:
    """Draw the settings for running whole days, in a subpanel that is closed at first."""
    header, body = layout.panel("ANGEN_day_run", default_closed=True)
    header.label(text="Run into a Folder")
    if body is None:
        draw_progress(layout, "angen.day_run")
        return
    column = body.column()
    column.use_property_split = True
    column.prop(settings, "out")
    column.prop(settings, "days")
    body.label(text="Also for Other Tools")
    body.grid_flow(columns=3, even_columns=True, align=True).prop(settings, "formats")
    if not draw_progress(body, "angen.day_run"):
        body.operator("angen.day_run", icon="PLAY")


class ANGEN_PT_day(ClosedSidebar, Panel):
    bl_label = "Day"
    help_page = "residents"

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.angen_day
        column = layout.column()
        column.use_property_split = True
        column.prop(settings, "text")
        if settings.text is None:
            column.prop(settings, "routine")
        for name in ("date", "number", "seed"):
            column.prop(settings, name)
        header, body = layout.panel("ANGEN_day_site", default_closed=True)
        header.label(text="Place on Earth")
        if body is not None:
            body.use_property_split = True
            for name in ("latitude", "longitude", "utc_offset", "north"):
                body.prop(context.scene.angen_site, name)
        if not draw_progress(layout, "angen.day_read"):
            layout.operator("angen.day_read", icon="FILE_REFRESH")
        _draw_run(layout, settings)
        if not settings.done:
            return
        stale = why_stale(context.scene)
        if stale:
            draw_lines(layout, f"The list is stale, {stale}. Read Day again", "ERROR")
        layout.label(text=settings.told)
        layout.label(text="Click an hour to go to it")
        scene = context.scene
        at = time_at(scene.frame_current + scene.frame_subframe)
        now = at if settings.before else None
        for person in dict.fromkeys(item.person for item in settings.done):
            _draw_strip(layout, settings, person, now)
        row = layout.row(align=True)
        row.prop(settings, "time")
        row.operator("angen.day_go", text="Go", icon="TIME").time = ""
        draw_progress(layout, "angen.day_show")
        draw_progress(layout, "angen.day_go")
        layout.template_list("ANGEN_UL_done", "", settings, "done", settings, "active", rows=6)
        if settings.before:
            shown = settings.done[settings.shown]
            layout.label(
                text=f"{hours_minutes(at)}:{at % 60:04.1f}, {shown.name} ({shown.person})",
                icon="TIME",
                translate=False,
            )
            layout.prop(settings, "skip")
            layout.operator("angen.day_leave", icon="LOOP_BACK")


register, unregister = bpy.utils.register_classes_factory((ANGEN_UL_done, ANGEN_PT_day))
