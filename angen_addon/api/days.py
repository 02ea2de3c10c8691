# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs days in an open home, for scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ...sensor_logic.choice import NoSuchSensor, SensorChoice
from ...sensor_logic.days.rows import Day
from ..days import run as living
from ..days.run import DayError, Household, Plan
from ..runtime.simulation import Progress
from ..scene.sensors import SensorError, chosen, simulated
from .error import AngenError, raised_as_angen_error

if TYPE_CHECKING:
    from .home import Home


def run_days(
    home: Home,
    routine: str | Path,
    start: date | str,
    days: int = 1,
    seed: int = 0,
    sensors: Iterable[str] | None = None,
    diary: str | Path | None = None,
    progress: Callable[[float], object] | None = None,
) -> Iterator[Day]:
    """Simulates days of a routine file from the date `start`, with all sensors or those named.

    Yields each day once it is complete: `date`, `events`, `activities`, `people`, with times in µs
    since its midnight. `diary`: a file of activities, instead of those that the routine plans.
    `progress` is called with the share done, 0 to 1; an exception from it ends the run. At the end
    the home is as before. Raises AngenError.
    """
    with raised_as_angen_error(DayError, NoSuchSensor, SensorError):
        chosen_sensors = simulated(chosen(home.all_sensors(), SensorChoice(tuple(sensors or ()))))
        if not chosen_sensors:
            raise AngenError(f"{home.path.name} has no sensors to simulate")
        plan = Plan.read(Path(routine), Path(diary) if diary is not None else None)
        try:
            first = date.fromisoformat(start) if isinstance(start, str) else start
        except ValueError:
            raise AngenError(f"start: '{start}' is not a date such as 2026-03-02") from None
        household = Household(bpy.context.scene, chosen_sensors, plan, first, seed)

        def report(number: int, step: Progress) -> None:
            if progress is not None:
                progress((number + step.seconds_done / max(step.seconds_total, 1e-9)) / days)

        yield from living.run_days(household, range(days), report)
