# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulate days of the routine and write them into a folder, as `angen day` does."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
from bpy.types import Context, Operator

from ...angen_addon.relative_path import absolute
from ...angen_addon.scene.sensors import all_sensors, simulated
from ...angen_addon.translations.interface import translated
from ...operators.long_work import LongWork
from ...operators.polls import can_read_scene, needs
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.files import check_folder
from ...sensor_logic.logs.wording import part_is
from ...sensor_logic.progress import Doing, Enough, Work, part_of
from ..blender.day_settings import BITS
from ..blender.folder import Folder, check_dates
from ..blender.run import HouseholdDays, moved_share, run_days_in_steps
from ..days.rows import Day
from ..days.truth import DAY_S
from .day import settings_of

# Shares of the time of a run of one day in the sample home, after which the places are read, and
# after which the first day is acted.
READ, ACTED = 0.04, 0.06


@contextmanager
def _panel_names() -> Iterator[None]:
    """Context manager: errors name the panel's field Folder instead of the option --out."""
    try:
        yield
    except AngenError as error:
        raise AngenError(str(error).replace("--out:", "Folder:")) from None


class ANGEN_OT_day_run(LongWork, Operator):
    bl_idname = "angen.day_run"
    bl_label = "Run Days"
    bl_description = (
        "Simulate whole days of the routine, and write events, activities, whereabouts and the "
        "home into the folder, as `angen day` does. The home stays as it is. Esc keeps the days "
        "that are complete"
    )
    bl_options = {"REGISTER"}
    esc = "Esc keeps the days that are complete"
    _playhead = (0, 0.0)

    @classmethod
    def poll(cls, context: Context) -> bool:
        settings = context.scene.angen_day
        return (
            can_read_scene(cls, context)
            and needs(
                cls,
                not settings.before,
                "Leave Day first: days run in the home without a shown activity",
            )
            and needs(
                cls, simulated(all_sensors(context.view_layer)), "Add a sensor first, or enable one"
            )
            and needs(cls, settings.out, "Choose a Folder")
        )

    def _begin(self, context: Context) -> Work[Result]:
        scene = context.scene
        settings = scene.angen_day
        plan, start, seed = settings_of(scene)
        path = absolute(settings.out)
        formats = [name for name in BITS if name in settings.formats]
        check_dates(start, settings.days, formats)
        check_folder(path if path.exists() else path.resolve().parent, "Folder")
        sensors = simulated(all_sensors(context.view_layer))
        # Reading the household sets the first frame: note the playhead.
        self._playhead = scene.frame_current, scene.frame_subframe
        household = HouseholdDays(scene, sensors, plan, start, seed, read=False)
        return self._work(household, path, formats, settings.days)

    def _work(
        self, household: HouseholdDays, path: Path, formats: list[str], days: int
    ) -> Work[Result]:
        """Simulate the days."""
        scene = household.scene
        frame, subframe = self._playhead
        try:
            with _panel_names():
                yield from part_of(household.read_in_steps(), 0.0, READ, "floors and places")
                # Act the first day now: errors come before anything is written.
                acting = household.act_in_steps(0)
                yield from part_of(acting, READ, ACTED, "what everybody does")
                folder = Folder(path, household, formats)
                return (yield from _simulate_days(household, folder, days))
        finally:
            scene.frame_set(frame, subframe=subframe)

    def _finish(self, context: Context, result: Result) -> set[str] | None:
        settings = context.scene.angen_day
        for text in result.notes:
            self.report({"WARNING"}, translated(text))
        if result.whole and bpy.data.is_dirty and bpy.data.filepath:
            self.report(
                {"WARNING"},
                translated("home.toml names the saved file, but the home has unsaved changes"),
            )
        kept = f"{part_is(result.whole, settings.days, 'day')} in {settings.out}"
        if not result.whole:
            kept = "No day is complete, so nothing is kept"
        elif result.whole < settings.days:
            kept += ". Press Run Days again to continue with the next day"
        if result.problem is not None:
            raise AngenError(f"{result.problem}. {kept}")
        self.report({"INFO"}, translated(kept))
        return None if result.whole else {"CANCELLED"}


@dataclass(frozen=True)
class Result:
    """The result of simulating days into a folder.

    Attributes
    ----------
    whole
        The number of complete days before the first one that is missing.
    notes
        Sentences on what the file formats could not store, and on who waits for a place.
    problem
        The error that ended the run early, or None.
    """

    whole: int
    notes: list[str]
    problem: AngenError | None


def _simulate_days(household: HouseholdDays, folder: Folder, days: int) -> Work[Result]:
    """Simulate the days that are missing in the folder."""
    left = [number for number in range(days) if not folder.has(number)]
    problem, made = None, 0
    spans: dict[int, Any] = {}
    try:
        with closing(run_days_in_steps(household, left)) as steps:
            for step in steps:
                if isinstance(step, Day):
                    folder.keep(step)
                    folder.grow(days)
                    made += 1
                    continue
                number, now = step
                if number not in spans:
                    spans = {number: household.acted(number).spans(0.0, DAY_S)}
                part = made + moved_share(spans[number], now.share)
                text = f"day {number + 1} of {days}"
                if now.doing:
                    text = f"day {number + 1} of {days}, {now.doing}"
                yield Doing(ACTED + (1.0 - ACTED) * part / len(left), text, slow=bool(now.doing))
    except Enough:
        pass
    except AngenError as error:
        problem = error
    whole, notes = folder.finish(days)
    if not whole:
        folder.discard()
    return Result(whole, [*notes, *household.take_notes()], problem)


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_day_run,))
