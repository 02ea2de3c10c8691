# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes a day of a routine, shows a stretch of it as animation, and removes that again."""

from __future__ import annotations

from datetime import date, timedelta
from pathlib import Path
from typing import Any

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Operator

from ...angen_addon.runtime import state
from ...angen_addon.scene.sensors import all_sensors, simulated
from ...operators.polls import can_look, cancelled, needs
from ...sensor_logic.error import InputError, replaced
from ..acting.places import Places
from ..acting.timeline import Acted
from ..blender import shown
from ..blender.daylight import Daylight
from ..blender.run import Household, Plan, resident_of
from ..days.rows import hours_minutes
from ..days.truth import activities

# The last computed day with its settings, until others are chosen: computing takes seconds.
_acted: tuple[Any, Acted, Places, Plan] | None = None


def _settings(scene: Any) -> tuple[Plan, date, int]:
    """Routine, start and seed from the panel's settings. Raises InputError."""
    settings = scene.angen_day
    wrong = f"First Day: '{settings.date}' is not a date such as 2026-03-02"
    with replaced(wrong, ValueError, OverflowError):
        start = date.fromisoformat(settings.date)
        start + timedelta(settings.number)
    if settings.text is not None:
        return Plan.of(settings.text.as_string(), settings.text.name), start, settings.seed
    if not settings.routine:
        raise InputError("choose a routine: a file, or a text in this file")
    return Plan.read(Path(bpy.path.abspath(settings.routine))), start, settings.seed


def _day(scene: Any) -> tuple[Acted, Places, Plan]:
    """The day of the panel's settings; computes it unless it was the last. Raises InputError."""
    global _acted
    plan, start, seed = _settings(scene)
    key = bpy.data.filepath, scene.name, plan.text, start, seed, scene.angen_day.number
    if _acted is None or _acted[0] != key:
        frame = scene.frame_current
        try:
            household = Household(scene, [], plan, start, seed)
            acted = household.acted(scene.angen_day.number - 1)
        finally:
            scene.frame_set(frame)
        _acted = key, acted, household.places, plan
    return _acted[1:]


def _date(settings: Any) -> date:
    return date.fromisoformat(settings.date) + timedelta(settings.number - 1)


class ANGEN_OT_day_read(Operator):
    """Compute what the residents do on this day, and list it"""

    bl_idname = "angen.day_read"
    bl_label = "Read Day"
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(can_look)

    def execute(self, context: Context) -> set[str]:
        global _acted
        scene = context.scene
        shown.leave(scene)
        _acted = None
        try:
            acted, places, _ = _day(scene)
        except InputError as error:
            return cancelled(self, error)
        settings = scene.angen_day
        settings.done.clear()
        for done in activities(acted, places.room_of):
            item = settings.done.add()
            item.name, item.person, item.room = done.activity, done.person, done.room
            item.start, item.end = done.start / 1e6, done.end / 1e6
        day = _date(settings)
        settings.told = f"{day:%A} {day.isoformat()}: {len(settings.done)} activities"
        self.report({"INFO"}, settings.told)
        return {"FINISHED"}


class ANGEN_OT_day_show(Operator):
    """Show this activity as animation, for scrubbing, simulating and Explain"""

    bl_idname = "angen.day_show"
    bl_label = "Show Activity"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(options={"HIDDEN"})

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        done = context.scene.angen_day.done
        if not 0 <= properties.index < len(done):
            return cls.__doc__ or ""
        item = done[properties.index]
        start, end = hours_minutes(item.start), hours_minutes(item.end)
        where = f", {item.room}" if item.room else ""
        return f"{item.name} ({item.person}{where}), {start} to {end}. {cls.__doc__}"

    poll = classmethod(can_look)

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        settings = scene.angen_day
        if not 0 <= self.index < len(settings.done):
            return cancelled(self, "there is no such activity: read the day first")
        item = settings.done[self.index]
        shown.leave(scene)
        try:
            acted, places, plan = _day(scene)
            residents = {p.name: resident_of(p) for p in plan.routine.persons.values()}
        except InputError as error:
            return cancelled(self, error)
        sensors = simulated(all_sensors(context.view_layer))
        daylight = Daylight(scene, sensors, _date(settings))
        shown.show(scene, acted, places, residents, daylight, _date(settings), item.start, item.end)
        settings.active = self.index
        state.CACHE.settings_changed(scene)
        _scroll_timelines(context)
        return {"FINISHED"}


class ANGEN_OT_day_leave(Operator):
    """Restore the home as it was before the day was shown"""

    bl_idname = "angen.day_leave"
    bl_label = "Leave Day"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls, context.scene.angen_day.before, "No stretch of a day is shown"
        ) and can_look(cls, context)

    def execute(self, context: Context) -> set[str]:
        shown.leave(context.scene)
        state.CACHE.settings_changed(context.scene)
        _scroll_timelines(context)
        return {"FINISHED"}


def _scroll_timelines(context: Context) -> None:
    """Timelines show the scene's frames, which are others than before."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type != "DOPESHEET_EDITOR":
                continue
            region = next(region for region in area.regions if region.type == "WINDOW")
            with context.temp_override(window=window, area=area, region=region):
                bpy.ops.anim.scene_range_frame()


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_day_read, ANGEN_OT_day_show, ANGEN_OT_day_leave)
)
