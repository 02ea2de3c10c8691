# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute a day of a routine, show one of its activities as animation, and restore the home."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import date, timedelta
from typing import Any

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Context, Operator

from ...angen_addon.relative_path import absolute
from ...angen_addon.runtime import handlers
from ...angen_addon.scene.memory import forgets_at_load
from ...angen_addon.scene.sensors import all_sensors, simulated
from ...angen_addon.translations.interface import translated
from ...operators.long_work import LongWork
from ...operators.polls import can_read_scene, needs
from ...sensor_logic.logs.error import InputError, replaced
from ...sensor_logic.logs.files import read_text
from ...sensor_logic.logs.wording import named
from ...sensor_logic.progress import Work, part_of
from ..acting.places import Places
from ..acting.timeline import Acted
from ..blender import shown
from ..blender.daylight import Daylight
from ..blender.followed_day import note_read, verify, why_stale
from ..blender.run import HouseholdDays, Plan, resident_of
from ..days.rows import HOUR_S, frame_at, hours_minutes
from ..days.truth import activities
from ..routine.routine import time_of_day

WEEKDAYS = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
# The last computed day: computing one takes seconds.
_computed: ComputedDay | None = None


@forgets_at_load
def _forget() -> None:
    global _computed
    _computed = None


@dataclass(frozen=True)
class ComputedDay:
    """A day computed with the panel's settings.

    Attributes
    ----------
    mark
        The session uid of its scene, and the number of the list of its activities.
    acted
        What the residents do.
    places
        The marked places, doors and lamps.
    plan
        The routine, and a diary if there is one.
    on
        The date.
    """

    mark: tuple[int, int]
    acted: Acted
    places: Places
    plan: Plan
    on: date


def settings_of(scene: Any) -> tuple[Plan, date, int]:
    """Return the panel's routine, first day and seed; raise `InputError` if one is invalid."""
    settings = scene.angen_day
    wrong = f"First Day: '{settings.date}' is not a date such as 2026-03-02"
    with replaced(wrong, ValueError, OverflowError):
        start = date.fromisoformat(settings.date)
        # Days are acted with the evening before and the midnight after them.
        start - timedelta(2), start + timedelta(settings.number + 2)
    if settings.text is not None:
        return Plan.from_text(settings.text.as_string(), settings.text.name), start, settings.seed
    if not settings.routine:
        raise InputError("no routine: choose a routine file, or a text in this file")
    path = absolute(settings.routine)
    return Plan.from_text(read_text(path), path.name), start, settings.seed


def _compute_day(scene: Any, anew: bool) -> Work[ComputedDay]:
    """Compute the day that the panel's settings give; yield the progress and return the day.

    The last computed day is used again if it is that of the list, unless `anew` is True. Raise
    `InputError` if a setting is invalid.
    """
    global _computed
    mark = scene.session_uid, secrets.randbelow(2**31) if anew else scene.angen_day.mark
    if _computed is None or _computed.mark != mark:
        plan, start, seed = settings_of(scene)
        number = scene.angen_day.number - 1
        frame = scene.frame_current
        try:
            household = HouseholdDays(scene, [], plan, start, seed, read=False)
            yield from part_of(household.read_in_steps(), 0.0, 0.6, "floors and places")
            acting = household.act_in_steps(number)
            acted = yield from part_of(acting, 0.6, 1.0, "what everybody does")
        finally:
            scene.frame_set(frame)
        _computed = ComputedDay(mark, acted, household.places, plan, start + timedelta(number))
    return _computed


@contextmanager
def _without_shown_activity(scene: Any) -> Iterator[None]:
    """Context manager: on entry, restore the home as it was before an activity was shown.

    If the block fails, show the activity again.
    """
    settings, was = scene.angen_day, _computed
    is_shown, frame, followed = bool(settings.before), scene.frame_current, settings.followed
    shown.leave(scene)
    try:
        yield
    except BaseException:
        if is_shown and was is not None:
            # The home stays without an activity if objects of the day are gone.
            with suppress(InputError):
                _animate_activity(scene, was, settings.shown)
                # A list that was stale stays so.
                settings.followed = followed
                scene.frame_set(frame)
        raise


def _animate_activity(scene: Any, day: ComputedDay, index: int) -> None:
    """Animate the activity with this index in the list.

    Raise `InputError` if the home has no object for one of the persons, or for what they move.
    """
    settings = scene.angen_day
    moved = {*day.acted.swings, *day.acted.holds, *day.acted.times_in_use()}
    gone = sorted(moved - set(bpy.data.objects.keys()))
    if gone:
        raise InputError(f"the home has no object {named(gone)} any more: press Read Day")
    item = settings.done[index]
    residents = {p.name: resident_of(p) for p in day.plan.routine.persons.values()}
    sensors = simulated(all_sensors(bpy.context.view_layer))
    daylight = Daylight(scene, sensors, day.on)
    shown.show(scene, day.acted, day.places, residents, daylight, day.on, item.start, item.end)
    settings.active = settings.shown = index


class ANGEN_OT_day_read(LongWork, Operator):
    bl_idname = "angen.day_read"
    bl_label = "Read Day"
    bl_description = "Compute what the residents do on this day, and list it. Esc cancels"
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(can_read_scene)

    def _begin(self, context: Context) -> Work[ComputedDay]:
        with _without_shown_activity(context.scene):
            day = yield from _compute_day(context.scene, anew=True)
        return day

    def _finish(self, context: Context, day: ComputedDay) -> None:
        settings = context.scene.angen_day
        settings.done.clear()
        found = activities(day.acted, day.places.room_of)
        # Activities of a diary alone come after those of the routine.
        names = [*day.plan.routine.activities, *sorted(done.activity for done in found)]
        places = {name: place for place, name in enumerate(dict.fromkeys(names))}
        for done in found:
            item = settings.done.add()
            item.name, item.person, item.room = done.activity, done.person, done.room
            item.start, item.end = done.start / 1e6, done.end / 1e6
            item.place = places[done.activity]
        _, settings.mark = day.mark
        note_read(context.scene)
        weekday = WEEKDAYS[day.on.weekday()]
        settings.told = f"{weekday} {day.on.isoformat()}: {len(settings.done)} activities"
        self.report({"INFO"}, translated(settings.told))


class _ShowActivity(LongWork):
    """Mix-in of operators that show an activity as animation, and may go to a time in it."""

    @classmethod
    def poll(cls, context: Context) -> bool:
        stale = why_stale(context.scene)
        text = f"The list is stale, {stale}. Press Read Day"
        return can_read_scene(cls, context) and needs(cls, not stale, text)

    def _target(self, settings: Any) -> tuple[int, float | None]:
        """Return the index of the activity, and the time to go to (s since midnight) or None.

        Raise `InputError` if there is no such activity.
        """
        raise NotImplementedError

    def _begin(self, context: Context) -> Work[ComputedDay | None]:
        scene = context.scene
        index, _ = self._target(scene.angen_day)
        verify(scene)
        stale = why_stale(scene)
        if stale:
            raise InputError(f"The list is stale, {stale}. Press Read Day")
        is_shown = scene.angen_day.before and scene.angen_day.shown == index
        if is_shown and shown.has_its_light(scene):
            # Only the playhead moves.
            return None
        with _without_shown_activity(scene):
            day = yield from _compute_day(scene, anew=False)
            _animate_activity(scene, day, index)
        return day

    def _finish(self, context: Context, day: ComputedDay | None) -> None:
        scene = context.scene
        _, time = self._target(scene.angen_day)
        if time is not None:
            scene.frame_set(frame_at(time))
        if day is not None:
            handlers.settings_changed(scene)
            _scroll_timelines(context)


class ANGEN_OT_day_show(_ShowActivity, Operator):
    bl_idname = "angen.day_show"
    bl_label = "Show Activity"
    bl_description = "Show this activity as animation, for scrubbing, simulating and Explain"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(options={"HIDDEN"})

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        done = context.scene.angen_day.done
        if not 0 <= properties.index < len(done):
            return translated(cls.bl_description)
        sentence = _activity_sentence(done[properties.index])
        return f"{sentence}. {translated(cls.bl_description)}"

    def _target(self, settings: Any) -> tuple[int, float | None]:
        if not 0 <= self.index < len(settings.done):
            raise InputError("the list has no such activity: press Read Day first")
        return self.index, settings.done[self.index].start


class ANGEN_OT_day_go(_ShowActivity, Operator):
    bl_idname = "angen.day_go"
    bl_label = "Go to Time"
    bl_description = "Go to this time of the day, and show its activity as animation"
    bl_options = {"REGISTER", "UNDO"}

    time: StringProperty(
        name="Time",
        description="Time of the day, such as 07:00. Empty: the time in the panel",
        options={"HIDDEN"},
    )
    person: StringProperty(
        name="Person",
        description="Person whose activity is shown. Empty: the person shown now",
        options={"HIDDEN"},
    )

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        settings = context.scene.angen_day
        text = properties.time or settings.time
        try:
            start = time_of_day(text)
        except ValueError:
            return translated(cls.bl_description)
        theirs = [d for d in settings.done if properties.person in ("", d.person)]
        found = [
            _activity_sentence(d) for d in theirs if d.start < start + HOUR_S and d.end > start
        ]
        return "\n".join([translated(f"Go to {text}"), *found])

    def _target(self, settings: Any) -> tuple[int, float | None]:
        text = self.time or settings.time
        with replaced(f"Time: '{text}' is not a time of day such as 07:00", ValueError):
            time = time_of_day(text)
        done = settings.done
        person = self.person or (done[settings.shown].person if settings.before else "")
        during = [i for i, item in enumerate(done) if item.start <= time < item.end]
        theirs = [i for i in during if done[i].person == person] or during
        if not theirs:
            raise InputError(f"no activity at {text} on this day: Read Day, or choose another time")
        return theirs[0], time


def _activity_sentence(item: Any) -> str:
    start, end = hours_minutes(item.start), hours_minutes(item.end)
    where = f"{item.person}, {item.room}" if item.room else item.person
    return translated(f"{item.name} ({where}), {start} to {end}")


class ANGEN_OT_day_leave(Operator):
    bl_idname = "angen.day_leave"
    bl_label = "Leave Day"
    bl_description = "Restore the home as it was before the day was shown"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls, context.scene.angen_day.before, "No activity of a day is shown"
        ) and can_read_scene(cls, context)

    def execute(self, context: Context) -> set[str]:
        changed = shown.leave(context.scene)
        if changed:
            text = (
                "You edited these while the day was shown, so that they may differ from before: "
                f"{named(changed)}. Check them, or undo"
            )
            self.report({"WARNING"}, translated(text))
        handlers.settings_changed(context.scene)
        _scroll_timelines(context)
        return {"FINISHED"}


# The names of the screens that were hidden when the frames of the scene changed: Blender crashes if
# their timelines are scrolled while they are hidden.
_behind: set[str] = set()
# The owner of the subscription to changes of the workspace.
_workspaces = object()


def _scroll_timelines(context: Context) -> None:
    """Show the scene's frames in all timelines; in those of other workspaces once these open."""
    windows = [w for w in context.window_manager.windows if w.scene == context.scene]
    for window in windows:
        _scroll_timelines_of(window)
    shown = {window.screen.name for window in windows}
    _behind.update({screen.name for screen in bpy.data.screens} - shown)
    bpy.msgbus.clear_by_owner(_workspaces)
    key = bpy.types.Window, "workspace"
    bpy.msgbus.subscribe_rna(key=key, owner=_workspaces, args=(), notify=_on_workspace)


def _scroll_timelines_of(window: Any) -> None:
    for area in window.screen.areas:
        if area.type != "DOPESHEET_EDITOR":
            continue
        region = next(region for region in area.regions if region.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.anim.scene_range_frame()
    _behind.discard(window.screen.name)


def _on_workspace() -> None:
    """Scroll the timelines of a workspace soon: its screen is shown after this notification."""
    bpy.app.timers.register(_scroll_behind, first_interval=0.1)


def _scroll_behind() -> None:
    for window in bpy.context.window_manager.windows:
        if window.screen.name in _behind:
            _scroll_timelines_of(window)


_register, _unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_day_read, ANGEN_OT_day_show, ANGEN_OT_day_go, ANGEN_OT_day_leave)
)


def register() -> None:
    _register()


def unregister() -> None:
    bpy.msgbus.clear_by_owner(_workspaces)
    _behind.clear()
    _unregister()
