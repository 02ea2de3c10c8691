# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of days in the open home: lived by a routine, measured against what was done."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import date
from pathlib import Path
from typing import Any

import bpy

from ...residents.blender.folder import digest_of as digest_of_home
from ...residents.blender.run import Household, Plan, run_days
from ...residents.days.rows import Day, DayRows
from ...sensor_logic.error import AngenError
from ...sensor_logic.files import write_files
from ...sensor_logic.study import truth
from ...sensor_logic.study.digest import digest_of
from ...sensor_logic.study.truth import DAY_S, Lived
from ..scene.sensors import Sensor, all_sensors
from .measures import MeasuredRun, coverage
from .tasks import Task, found
from .variants import day_of_run, named


def household_of(task: Task) -> Household | None:
    """Who lives in the open home, as it is before a run changes its sensors, which tell what its
    rooms are called; None for a task without a routine. Raises AngenError."""
    if task.routine is None:
        return None
    sensors = all_sensors(bpy.context.view_layer)
    plan = Plan.read(found(task.routine))
    start = date.fromisoformat(task.start)
    return Household(bpy.context.scene, sensors, plan, start, task.seed)


def lived(task: Task, household: Household, sensors: Sequence[Sensor]) -> list[Day]:
    """The days of a task, sensed by these. Raises AngenError."""
    household.sensors = list(sensors)
    household.causes = bool(task.keep or task.functions)
    kept = _Kept(task, household)
    missing = [number for number in range(task.days) if kept.day(number) is None]
    for number, day in zip(missing, run_days(household, missing), strict=True):
        kept.keep(number, day)
    return [kept.days[number] for number in range(task.days)]


class _Kept:
    """Days that were lived, also in the driver's folder where that is seen from here: a worker that
    is killed loses the day it was at, no more."""

    def __init__(self, task: Task, household: Household) -> None:
        self.days: dict[int, Day] = {}
        facts = digest_of_home(household), task.of_the_home, task.versions, household.causes
        self._digest = digest_of({"day": facts})
        folder = Path(task.days_in)
        self._folder = folder / self._digest if task.days_in and folder.is_dir() else None

    def day(self, number: int) -> Day | None:
        if number not in self.days and self._folder is not None:
            with suppress(OSError, ValueError):
                text = (self._folder / f"{number}.json").read_text(encoding="utf-8")
                found = Day.of_json(text, self._digest)
                if found is not None:
                    self.days[number] = found
        return self.days.get(number)

    def keep(self, number: int, day: Day) -> None:
        self.days[number] = day
        if self._folder is not None:
            # Where it cannot be written, all there is to lose is time.
            with suppress(OSError, AngenError):
                self._folder.mkdir(exist_ok=True)
                write_files({self._folder / f"{number}.json": day.as_json(self._digest)})


def measured(
    together: Sequence[Day], task: Task, on: Sequence[Sensor]
) -> tuple[MeasuredRun, dict[str, str]]:
    """Of a run, among those that lived these days together: its measures, and tables."""
    rows = DayRows.of([day_of_run(day, on) for day in together])
    sensors = named(on)
    rooms = {sensor.name: sensor.room for sensor in sensors}
    lived = truth.lived(rows, task.days)
    found = MeasuredRun()
    known: dict[str, Callable[[], dict[str, Any]]] = {
        "events": lambda: _events(lived, sorted(rooms)),
        "active": lambda: _active(lived, sorted(rooms)),
        "coverage": lambda: {"coverage": coverage(sensors)},
        "truth": lambda: truth.judged(lived, rooms, task.empty_for),
    }
    for name, measure in known.items():
        if name in task.measure:
            found.add(name, measure)
    found.add_functions(task, lived, lived.truth)
    tables = rows.files() if task.keep else {}
    return found, {f"{task.digest}/{name}": text for name, text in tables.items()}


def _events(lived: Lived, names: Sequence[str]) -> dict[str, Any]:
    counts = Counter(event.sensor for event in lived.events if event.time_s > 0.0)
    return {"events": counts.total(), **{f"events {name}": counts[name] for name in names}}


def _active(lived: Lived, names: Sequence[str]) -> dict[str, Any]:
    on = truth.when_on(lived)
    shares = {
        name: sum(end - start for start, end in on.get(name, ())) / (lived.days * DAY_S)
        for name in names
    }
    mean = sum(shares.values()) / len(shares)
    return {"active": mean, **{f"active {name}": share for name, share in shares.items()}}
