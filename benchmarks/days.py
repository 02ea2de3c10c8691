# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what days of residents cost, and whether skipping still frames changes a reading.

Whole days of a week's routine in the Ängen home give seconds and memory. In both sample homes,
random stretches of random days are run twice: as usual, and at every frame with all keys at once.
Both runs must give the same readings to the bit.
"""

from __future__ import annotations

import time
from datetime import date, datetime, timedelta
from datetime import time as time_of_day
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime import stillness
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.residents.blender import run as living
from angen_sensors.residents.blender.run import HouseholdDays, Plan

from .common import SAMPLES, apart, box_mesh, link, memory_mib, open_home, progress, sensors_of

PIR, SWITCH, PAD, LIGHT = "PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"
# Homes, each with its routine.
HOMES = (("angen.blend", "week.toml"), ("atelier.blend", "atelier_week.toml"))
START, SEED = date(2026, 3, 2), 1
# The kinds of sensors that are on, and the number of days.
CASES = (
    ("7 PIRs, 7 switches and a pad", (PIR, SWITCH, PAD), 3),
    ("and 7 light sensors", (PIR, SWITCH, PAD, LIGHT), 1),
)
# Start and length (s) of the morning that --quick runs: the residents get up and have breakfast.
MORNING = 25_000.0, 900.0
# Pads that are added to the home's own: name, place and size, in m.
PADS = (
    ("Pad bed", (2.4, 1.05, 0.53), (1.0, 1.0, 0.01)),
    ("Pad toilet", (5.5, 0.68, 0.475), (0.36, 0.4, 0.01)),
    ("Pad kitchen", (0.43, 3.607, 0.528), (0.38, 0.38, 0.01)),
    ("Pad desk", (1.08, 7.25, 0.52), (0.38, 0.38, 0.01)),
    ("Pad dining", (7.25, 4.803, 0.528), (0.38, 0.38, 0.01)),
)
# Number and length (s) of the stretches in each home that run at every frame; with --quick.
CHECKED, QUICK_CHECKED = (3, 300.0), (1, 150.0)


def measure(quick: bool) -> dict[str, Any]:
    rows = []
    for number, (name, kinds, days) in enumerate(CASES[:1] if quick else CASES):
        progress("days", number, len(CASES), name)
        # In its own process, so that the memory is that of this case alone.
        rows.append(apart("days.case", name, kinds, 1 if quick else days, quick))
    return {"cases": rows, "checked": _checked(*(QUICK_CHECKED if quick else CHECKED))}


def _household(kinds: tuple[str, ...], home: str, week: str) -> HouseholdDays:
    scene = open_home(SAMPLES / home)
    return HouseholdDays(scene, sensors_of(*kinds), Plan.read(SAMPLES / week), START, SEED)


def case(name: str, kinds: tuple[str, ...], days: int, morning: bool) -> dict[str, Any]:
    """Return the costs of whole days, or of the first morning."""
    household = _household(kinds, *HOMES[0])
    between = (MORNING[0], sum(MORNING)) if morning else (0.0, living.DAY_S)
    lasts = between[1] - between[0]
    spans = [household.acted(number).spans(*between) for number in range(days)]
    took, events, steps, evaluated = [], [], 0, 0
    with household.keyed() as keys:
        for number in range(days):
            begin = time.perf_counter()
            day, last = _exhausted(household.run(number, keys, between))
            took.append(time.perf_counter() - begin)
            events.append(len(day.events))
            steps, evaluated = steps + last.steps, evaluated + last.evaluated
    return {
        "name": name, "sensors": len(household.sensors), "days": days, "seconds": lasts,
        "day_s": took, "events": events,
        "moving": [float((span[:, 1] - span[:, 0]).sum()) / lasts for span in spans],
        "steps": steps, "evaluated": evaluated, "most_mib": memory_mib(most=True),
    }  # fmt: skip


def pads() -> dict[str, Any]:
    """Return the costs of a morning without pads, with pads, and with pads without bounds.

    They are seconds of processor time. Without bounds, the forces on all pads are computed
    whenever anything moves.
    """
    home, week = HOMES[0]
    scene = open_home(SAMPLES / home)
    for name, place, size in PADS:
        half = np.array(size) / 2.0
        part = link(name, box_mesh([(half, (0.0, 0.0, half[2]))]), place)
        part.angen_sensor.kind = PAD
    bpy.context.view_layer.update()
    parts = scene, sensors_of(PIR, SWITCH, PAD), Plan.read(SAMPLES / week), START, SEED
    household = HouseholdDays(*parts)
    between = (MORNING[0], sum(MORNING))
    # The first run also loads what later ones find.
    _stretch(household, 0, (between[0], between[0] + 100.0))
    # Of the process, which other work on the machine changes less.
    begin, times = time.process_time(), []
    with_pads = _stretch(household, 0, between)[0]
    times.append(time.process_time())
    states_near, Probes.states_near = Probes.states_near, lambda *_: None
    try:
        plain = _stretch(household, 0, between)[0]
    finally:
        Probes.states_near = states_near
    times.append(time.process_time())
    household.sensors = [s for s in household.sensors if s.kind.identifier != PAD]
    _stretch(household, 0, between)
    times.append(time.process_time())
    with_s, plain_s, without_s = np.diff([begin, *times]).tolist()
    count = len(with_pads) - len(household.sensors)
    same = sum(with_pads[name] == plain[name] for name in plain)
    return {
        "pads": count, "seconds": MORNING[1], "sensors": len(with_pads), "same": same,
        "without_s": without_s, "with_s": with_s, "plain_s": plain_s,
    }  # fmt: skip


def _exhausted(run: Any) -> tuple[Any, Any]:
    """Return what a generator returns, and the last value that it yields."""
    last = None
    while True:
        try:
            last = next(run)
        except StopIteration as end:
            return end.value, last


def _checked(count: int, seconds: float) -> dict[str, Any]:
    """Run random stretches of each home with and without skipping, and compare the readings."""
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
            stretch = household, number, (begin, begin + seconds)
            fast, skipping_s = _stretch(*stretch)
            find, most = stillness.find_stillness, living.MOST_MOVEMENT
            stillness.find_stillness = lambda *_: stillness.Stillness(
                np.empty((0, 2)), ("as a reference",)
            )
            living.MOST_MOVEMENT = 1e9
            try:
                plain, plain_s = _stretch(*stretch)
            finally:
                stillness.find_stillness, living.MOST_MOVEMENT = find, most
            found["seconds"] += seconds
            found["sensors"] += len(plain)
            found["same"] += sum(plain[name] == fast[name] for name in plain)
            found["active"] += sum(int(np.asarray(t.active).sum()) for t in plain.values())
            found["skipping_s"] += skipping_s
            found["plain_s"] += plain_s
    return found


def _stretch(
    household: HouseholdDays, number: int, between: tuple[float, float]
) -> tuple[Any, float]:
    """Return the tracks of a part of a day, and the seconds that it took."""
    begin, acted = time.perf_counter(), household.acted(number)
    with household.keyed() as keys:
        day = living.DayRun(
            household.scene, household.sensors, acted, household.residents, keys, number, between
        )
        for _ in day.progress():
            pass
    return day.recording.tracks, time.perf_counter() - begin
