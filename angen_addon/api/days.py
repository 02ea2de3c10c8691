# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs days in an open home, for scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from datetime import date
from pathlib import Path

import bpy

from ...sensor_logic.days.rows import Day
from ...sensor_logic.error import AngenError
from ..days import run as living
from ..days.run import Household, Plan
from ..runtime.simulation import Progress
from ..scene.sensors import Sensor


def household_of(sensors: Sequence[Sensor], plan: Plan, start: date | str, seed: int) -> Household:
    """The household of the open home from a date on. Raises AngenError."""
    try:
        first = date.fromisoformat(start) if isinstance(start, str) else start
    except ValueError:
        raise AngenError(f"start: '{start}' is not a date such as 2026-03-02") from None
    return Household(bpy.context.scene, sensors, plan, first, seed)


def run_days(
    sensors: Sequence[Sensor],
    routine: str | Path,
    start: date | str,
    days: int = 1,
    seed: int = 0,
    diary: str | Path | None = None,
    progress: Callable[[float], object] | None = None,
) -> Iterator[Day]:
    """Simulates days of a routine file from the date `start`, with these sensors.

    Yields each day once it is complete: `date`, `events`, `activities`, `people`, with times in µs
    since its midnight. `diary`: a file of activities, instead of those that the routine plans.
    `progress` is called with the share done, 0 to 1; an exception from it ends the run. At the end
    the home is as before. Raises AngenError.
    """
    plan = Plan.read(Path(routine), Path(diary) if diary is not None else None)
    household = household_of(sensors, plan, start, seed)

    def report(number: int, step: Progress) -> None:
        if progress is not None:
            progress((number + step.seconds_done / max(step.seconds_total, 1e-9)) / days)

    yield from living.run_days(household, range(days), report)
