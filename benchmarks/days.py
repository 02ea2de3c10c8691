# SPDX-License-Identifier: GPL-3.0-or-later
"""Days that somebody lives in the home by its routine of a week: how long each takes, what memory;
and in both sample homes, whether random stretches of random days, evaluated at every frame and with
all their keys at once, read the same to the bit."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from datetime import date, datetime, timedelta
from datetime import time as time_of_day
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime import skipping
from angen_sensors.angen_addon.scene.sensors import all_sensors
from angen_sensors.residents.blender import run as living
from angen_sensors.residents.blender.run import Household, Plan

from .progress import progress

SAMPLES = Path(__file__).resolve().parent.parent / "sample_blends"
# Homes and their routines.
HOMES = (("angen.blend", "week.toml"), ("atelier.blend", "atelier_week.toml"))
START, SEED = date(2026, 3, 2), 1
# Kinds that are on, and how many days.
CASES = (
    ("7 PIRs, 7 switches and a pad", ("PIR", "OPTICAL_SWITCH", "PRESSURE"), 3),
    ("and 7 light sensors", ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"), 1),
)
# s of the first day that a glance takes: somebody gets up and has breakfast.
MORNING = 25_000.0, 900.0
# Stretches of each home, and s, that are evaluated at every frame; those of a glance.
CHECKED, GLANCE = (3, 300.0), (1, 150.0)
MIB = 2**20
# The program of a process that measures one case and prints it.
CASE = """
import json, sys
from angen_addon.process.standalone import load_extension
load_extension().register()
from benchmarks import days
print(json.dumps(days.case(*json.loads(sys.argv[1]))), flush=True)
"""


def measure(quick: bool) -> dict[str, Any]:
    rows = []
    for number, (name, kinds, days) in enumerate(CASES[:1] if quick else CASES):
        progress("days", number, len(CASES), name)
        rows.append(_alone(name, kinds, 1 if quick else days, quick))
    return {"cases": rows, "checked": _checked(*(GLANCE if quick else CHECKED))}


def _household(kinds: tuple[str, ...], home: str, week: str) -> Household:
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / home), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier in kinds]
    return Household(scene, sensors, Plan.read(SAMPLES / week), START, SEED)


def _alone(*case: Any) -> dict[str, Any]:
    """A case in a process of its own, so that its memory is its own."""
    done = subprocess.run(
        [sys.executable, "-c", CASE, json.dumps(case)],
        cwd=SAMPLES.parent,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"days of {case[0]} failed:\n{done.stderr[-2000:]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def case(name: str, kinds: tuple[str, ...], days: int, morning: bool) -> dict[str, Any]:
    """Whole days, or the first morning."""
    household = _household(kinds, *HOMES[0])
    between = (MORNING[0], sum(MORNING)) if morning else (0.0, living.DAY_S)
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


def _checked(count: int, seconds: float) -> dict[str, Any]:
    """Random stretches of each home with and without skipping and exchanging keys."""
    random = np.random.default_rng(SEED)
    found: dict[str, Any] = {"stretches": []} | dict.fromkeys(
        ("seconds", "sensors", "same", "active", "skipping_s", "plain_s"), 0
    )
    for home, week in HOMES:
        household = _household(CASES[0][1], home, week)
        for _ in range(count):
            number = int(random.integers(7))
            begins = household.acted(number).spans(0.0, living.DAY_S - seconds)[:, 0]
            begin = round(float(random.choice(begins)), 1)
            moment = datetime.combine(START, time_of_day()) + timedelta(number, begin)
            found["stretches"].append(f"{home}, {moment:%A %H:%M:%S}")
            progress("days", len(found["stretches"]), 2 * count, found["stretches"][-1])
            fast, skipping_s = _stretch(household, number, begin, seconds)
            plain, plain_s = _plain(household, number, begin, seconds)
            found["seconds"] += seconds
            found["sensors"] += len(plain)
            found["same"] += sum(plain[name] == fast[name] for name in plain)
            found["active"] += sum(int(np.asarray(t.active).sum()) for t in plain.values())
            found["skipping_s"] += skipping_s
            found["plain_s"] += plain_s
    return found


def _plain(household: Household, number: int, begin: float, seconds: float) -> tuple[Any, float]:
    """A stretch that is evaluated at every frame, with all its keys at once."""
    find, most = skipping.find, living.MOST_MOVEMENT
    skipping.find = lambda *_: skipping.Stillness(np.empty((0, 2)), ("as a reference",))
    living.MOST_MOVEMENT = 1e9
    try:
        return _stretch(household, number, begin, seconds)
    finally:
        skipping.find, living.MOST_MOVEMENT = find, most


def _stretch(household: Household, number: int, begin: float, seconds: float) -> tuple[Any, float]:
    """What is read in a part of a day, and how long that takes."""
    took = time.perf_counter()
    with household.keyed() as keys:
        day = living.DayRun(
            household.scene,
            household.sensors,
            household.acted(number),
            household.residents,
            keys,
            number,
            (begin, begin + seconds),
        )
        for _ in day.progress():
            pass
    return day.recording.tracks, time.perf_counter() - took


def _most_memory() -> float:
    """MiB that this process ever had, Blender's own included."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / MIB if sys.platform == "darwin" else most / 1024
