# SPDX-License-Identifier: GPL-3.0-or-later
"""Days that somebody lives in the home by its routine of a week: how long each takes, what memory,
and whether a stretch of one, evaluated at every frame and with all its keys at once, reads the same
to the bit."""

from __future__ import annotations

import resource
import sys
import time
from datetime import date
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.days import living
from angen_sensors.angen_addon.days.run import Household, Plan
from angen_sensors.angen_addon.runtime import stillness
from angen_sensors.angen_addon.scene.sensors import all_sensors

from .common import open_home
from .progress import progress

WEEK = Path(__file__).resolve().parent.parent / "sample_blends" / "week.toml"
START, SEED = date(2026, 3, 2), 1
# Kinds that are on, and how many days.
CASES = (
    ("7 PIRs, 7 switches and a pad", ("PIR", "OPTICAL_SWITCH", "PRESSURE"), 3),
    ("and 7 light sensors", ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"), 1),
)
# s of a day that are evaluated at every frame: somebody gets up and has breakfast.
CHECKED = 25_000.0, 1800.0
MIB = 2**20


def measure(quick: bool) -> dict[str, Any]:
    rows = []
    for number, (name, kinds, days) in enumerate(CASES[:1] if quick else CASES):
        progress("days", number, len(CASES), name)
        # A glance is at a part of the first morning.
        rows.append(_case(name, kinds, 1 if quick else days, 900.0 if quick else 0.0))
    return {"cases": rows, "checked": _checked(300.0 if quick else CHECKED[1])}


def _household(kinds: tuple[str, ...]) -> Household:
    scene = open_home()
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier in kinds]
    plan = Plan.read(WEEK)
    return Household(scene, sensors, plan, START, SEED)


def _case(name: str, kinds: tuple[str, ...], days: int, seconds: float) -> dict[str, Any]:
    """Whole days, or so many seconds of the first."""
    household = _household(kinds)
    between = (CHECKED[0], CHECKED[0] + seconds) if seconds else (0.0, living.DAY_S)
    spans = [household.acted(number).spans(*between) for number in range(days)]
    took, events, steps, evaluated = [], [], 0, 0
    with household.keyed() as keys:
        for number in range(days):
            begin = time.perf_counter()
            day, last = _gone_through(household.run(number, keys, between))
            took.append(time.perf_counter() - begin)
            events.append(len(day.events))
            steps, evaluated = steps + last.steps, evaluated + last.evaluated
    lasts = between[1] - between[0]
    return {
        "name": name,
        "sensors": len(household.sensors),
        "days": days,
        "seconds": lasts,
        "day_s": took,
        "events": events,
        "moving": [float((span[:, 1] - span[:, 0]).sum()) / lasts for span in spans],
        "steps": steps,
        "evaluated": evaluated,
        "most_mib": _most_memory(),
    }


def _gone_through(run: Any) -> tuple[Any, Any]:
    """What a generator returns, and the last that it yields."""
    last = None
    while True:
        try:
            last = next(run)
        except StopIteration as end:
            return end.value, last


def _checked(seconds: float) -> dict[str, Any]:
    """The same stretch of a day with and without skipping and exchanging keys."""
    household = _household(CASES[0][1])
    begin = CHECKED[0]
    found, skipping_s = _stretch(household, begin, seconds)
    find, most = stillness.find, living.MOST_MOVEMENT
    stillness.find = lambda *_: stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    living.MOST_MOVEMENT = 1e9
    try:
        plain, plain_s = _stretch(household, begin, seconds)
    finally:
        stillness.find, living.MOST_MOVEMENT = find, most
    return {
        "seconds": seconds,
        "sensors": len(plain),
        "same": sum(plain[name] == found[name] for name in plain),
        "active": sum(int(np.asarray(track.active).sum()) for track in plain.values()),
        "skipping_s": skipping_s,
        "plain_s": plain_s,
    }


def _stretch(household: Household, begin: float, seconds: float) -> tuple[Any, float]:
    """What is read in a part of the first day, and how long that takes."""
    took = time.perf_counter()
    with household.keyed() as keys:
        day = living.DayRun(
            household.scene,
            household.sensors,
            household.acted(0),
            household.residents,
            keys,
            0,
            (begin, begin + seconds),
        )
        for _ in day.progress():
            pass
    return day.recording.tracks, time.perf_counter() - took


def _most_memory() -> float:
    """MiB that this process ever had, Blender's own included."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / MIB if sys.platform == "darwin" else most / 1024
