# SPDX-License-Identifier: GPL-3.0-or-later
"""A day of 86,400 s in the home, in which nothing moves most of the time.

Its story is told again every half an hour. How long a run takes, at how many steps the scene is
evaluated, what it adds to the memory; and whether the readings of a stretch of it are, to the bit,
those of a run that evaluates every step.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime import skipping as stillness
from angen_sensors.angen_addon.runtime.simulation import simulate
from angen_sensors.angen_addon.scene.sensors import Sensor, all_sensors
from angen_sensors.sensor_logic.kind import LIGHT
from angen_sensors.sensor_logic.recording.tracks import Recording

from .day_scene import DAY_S, EVERY_S, FPS, open_day

MIB = 2**20
STATUS = Path("/proc/self/statm")
PAGE = 4096
# The kinds that are on.
CASES = (
    ("7 PIRs and 7 switches", ("PIR", "OPTICAL_SWITCH")),
    ("and a pad", ("PIR", "OPTICAL_SWITCH", "PRESSURE")),
    ("and 7 light sensors", ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")),
)
# Held to the run that skips nothing.
CHECKED_S = 1900
# Every so many of the frames that are evaluated, to tell what that alone costs.
OF_FRAMES = 10


def measure(quick: bool) -> dict[str, Any]:
    seconds = 2 * EVERY_S if quick else DAY_S
    cases = CASES[:1] if quick else CASES
    return {
        "seconds": seconds,
        "every_s": EVERY_S,
        "forms": [_form(name, seconds, name == "strips") for name in ("keys", "strips")],
        "checked": _checked(60 if quick else CHECKED_S),
        "cases": [_case(name, kinds, seconds) for name, kinds in cases],
    }


def _form(name: str, seconds: int, strips: bool) -> dict[str, Any]:
    """How fast the spans in which nothing moves are found, where the day is made of keys or of
    strips of the NLA."""
    before = _memory()
    scene = open_day(seconds, strips)
    begin = time.perf_counter()
    still = stillness.find(scene, {LIGHT})
    took = time.perf_counter() - begin
    fresh = still.fresh(np.arange(scene.frame_start, scene.frame_end + 1))
    return {
        "form": name,
        "find_s": took,
        "spans": len(still.busy),
        "fresh": float(fresh.mean()),
        "scene_mib": _memory() - before,
    }


def _checked(seconds: int) -> dict[str, Any]:
    """The beginning, with and without skipping."""
    scene = open_day(2 * EVERY_S)
    first = scene.frame_start
    last = first + FPS * seconds
    sensors = _sensors(CASES[0][1])
    skipping = _run(scene, sensors, first, last)
    find = stillness.find
    stillness.find = lambda *_: stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    try:
        plain = _run(scene, sensors, first, last)
    finally:
        stillness.find = find
    same = [
        plain["recording"].tracks[s.name] == skipping["recording"].tracks[s.name] for s in sensors
    ]
    return {
        "seconds": seconds,
        "sensors": len(sensors),
        "same": sum(same),
        "plain_s": plain["wall_s"],
        "skipping_s": skipping["wall_s"],
        "plain_share": plain["evaluated"] / plain["steps"],
    }


def _case(name: str, kinds: tuple[str, ...], seconds: int) -> dict[str, Any]:
    scene = open_day(seconds)
    sensors = _sensors(kinds)
    before = _memory()
    found = _run(scene, sensors, scene.frame_start, scene.frame_end)
    tracks = found.pop("recording").tracks.values()
    return {
        "name": name,
        "sensors": len(sensors),
        "readings": sum(len(track) for track in tracks),
        "active": sum(int(np.asarray(track.active).sum()) for track in tracks),
        "tracks_mib": sum(track.nbytes for track in tracks) / MIB,
        "before_mib": before,
        "evaluation_alone_s": _evaluation(scene),
        **found,
    }


def _run(scene: Any, sensors: list[Sensor], first: int, last: int) -> dict[str, Any]:
    """A whole run: its seconds, steps, the greatest memory in it, and what it recorded."""
    recording, most = Recording(), 0.0
    steps = evaluated = 0
    begin = time.perf_counter()
    for number, progress in enumerate(simulate(scene, sensors, first, last, recording)):
        steps, evaluated = progress.steps, progress.evaluated
        if number % 100 == 0:
            most = max(most, _memory())
    return {
        "wall_s": time.perf_counter() - begin,
        "steps": steps,
        "evaluated": evaluated,
        "most_mib": max(most, _memory()),
        "recording": recording,
    }


def _evaluation(scene: Any) -> float:
    """Seconds that Blender takes to evaluate the frames in which something moves, nothing else
    done; taken from some of them."""
    frames = np.arange(scene.frame_start, scene.frame_end + 1)
    frames = frames[stillness.find(scene, {LIGHT}).fresh(frames)]
    some = frames[: len(frames) // OF_FRAMES].tolist()
    following = bpy.app.handlers.frame_change_post
    handlers = list(following)
    following.clear()
    begin = time.perf_counter()
    for frame in some:
        scene.frame_set(frame)
    took = time.perf_counter() - begin
    following.extend(handlers)
    return took * len(frames) / len(some)


def _sensors(kinds: tuple[str, ...]) -> list[Sensor]:
    return [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier in kinds]


def _memory() -> float:
    """MiB that this process has in memory; 0 where the system does not tell."""
    return int(STATUS.read_text().split()[1]) * PAGE / MIB if STATUS.exists() else 0.0
