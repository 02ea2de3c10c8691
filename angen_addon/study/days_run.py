# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of days in the open home: lived by a routine, measured against what was done."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from datetime import date
from typing import Any

import bpy

from ...sensor_logic.days.rows import Days
from ...sensor_logic.study import truth
from ...sensor_logic.study.truth import DAY_S, Lived
from ..api.error import raised_as_angen_error
from ..days.run import DayError, Household, Plan, run_days
from ..scene.sensors import Sensor, all_sensors
from .measures import coverage, of_functions
from .tasks import Done, Task, found


def household_of(task: Task) -> Household | None:
    """Who lives in the open home, as it is before a run changes its sensors, which tell what its
    rooms are called; None for a task without a routine. Raises AngenError."""
    if task.routine is None:
        return None
    sensors = all_sensors(bpy.context.view_layer)
    with raised_as_angen_error(DayError):
        plan = Plan.read(found(task.routine))
        start = date.fromisoformat(task.start)
        return Household(bpy.context.scene, sensors, plan, start, task.seed)


def done(task: Task, household: Household, sensors: Sequence[Sensor]) -> Done:
    """Lives the days of a task, sensed by these, and measures them. Raises AngenError."""
    begin = time.perf_counter()
    household.sensors = list(sensors)
    with raised_as_angen_error(DayError):
        tables = Days.of(list(run_days(household, range(task.days)))).files()
    seconds = time.perf_counter() - begin
    rooms = {sensor.name: sensor.room for sensor in sensors}
    lived = truth.read(tables, task.days)
    values: dict[str, Any] = {"sensors_on": len(sensors)}
    if "events" in task.measure:
        counts = Counter(event.sensor for event in lived.events if event.time_s > 0.0)
        values["events"] = counts.total()
        values |= {f"events {name}": counts[name] for name in sorted(rooms)}
    if "active" in task.measure:
        values |= _active(lived, sorted(rooms))
    if "coverage" in task.measure:
        values["coverage"] = coverage(sensors)
    if "truth" in task.measure:
        values |= truth.judged(lived, rooms, task.empty_for)
    values |= of_functions(task, lived, lived.truth)
    kept = {f"{task.digest}/{name}": text for name, text in tables.items()}
    return Done(task.digest, values, seconds, files=kept if "events" in task.keep else {})


def _active(lived: Lived, names: Sequence[str]) -> dict[str, Any]:
    on = truth.when_on(lived)
    shares = {
        name: sum(end - start for start, end in on.get(name, ())) / (lived.days * DAY_S)
        for name in names
    }
    mean = sum(shares.values()) / len(shares)
    return {"active": mean, **{f"active {name}": share for name, share in shares.items()}}
