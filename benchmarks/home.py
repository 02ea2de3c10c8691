# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeat the thesis's own measurements: the Ängen home with 22 sensors at the thesis's rates.

Simulation speed is simulated time over real time, with Blender's evaluation of every frame
included: by kinds of sensors (figure 8.3), by rays (8.1) and by number of detectors (8.2). The
kinds are timed by the operator *Simulate* and by the command line, the rest by the generator behind
both. `measure_live` compares playback with and without live readings, without a window, and checks
that live readings equal those of a run.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import bpy
from angen_sensors.angen_addon.recording.results import RESULTS
from angen_sensors.angen_addon.runtime.live import known_live
from angen_sensors.angen_addon.scene import memory

from .common import (
    HOME,
    ROOT,
    Stopwatch,
    bare_frames,
    enable_only,
    open_home,
    progress,
    run,
    sensors_of,
    spread,
)
from .rays import detectors

# The kinds that are on; all kinds together are the thesis's full home.
PIR, SWITCH, PAD, LIGHT = "PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"
CASES = (
    ("7 PIRs", (PIR,)),
    ("and 7 switches", (PIR, SWITCH)),
    ("and a pad", (PIR, SWITCH, PAD)),
    ("and 7 light sensors", (PIR, SWITCH, PAD, LIGHT)),
)
RAYS = (80, 160, 320, 640)
DENSE_RAYS = 2560
COUNTS = (1, 2, 4, 7, 14, 28, 56)
# The frames of --quick, in which the person comes home.
QUICK_FRAMES = (24, 191)
LIVE_CASES = (
    ("7 PIRs", (PIR,)),
    ("7 PIRs and 7 switches", (PIR, SWITCH)),
    ("and the pad", (PIR, SWITCH, PAD)),
)
# The frames that are played: the person goes from the kitchen to the sofa. In the first frame the
# sensors start anew, so frames before FIRST are not timed.
FIRST, LAST, AHEAD = 900, 1100, 5


def measure(quick: bool) -> dict[str, Any]:
    scene = open_home()
    first, last = QUICK_FRAMES if quick else (scene.frame_start, scene.frame_end)
    rounds = 1 if quick else 3
    seconds = (last - first + 1) * scene.render.fps_base / scene.render.fps
    return {
        "seconds": seconds,
        "cases": _by_kind(scene, first, last, seconds, rounds),
        "rays": _by_rays(first, last, seconds, rounds),
        "counts": _by_count(COUNTS[::2] if quick else COUNTS, first, last, seconds, rounds),
    }


def _by_kind(
    scene: Any, first: int, last: int, seconds: float, rounds: int
) -> list[dict[str, Any]]:
    """Time each case by the operator *Simulate*, and by the command line in its own process.

    The bare frames are timed in the same rounds.
    """
    rows = []
    updates: dict[str, int] = {}
    operator, bare, command = (defaultdict[str, list[float]](list) for _ in range(3))
    for turn in range(rounds):
        for name, kinds in CASES:
            progress("home", turn, rounds, name)
            enable_only(kinds)
            begin = time.perf_counter()
            bpy.ops.angen.simulate(frame_start=first, frame_end=last)
            operator[name].append(time.perf_counter() - begin)
            recording = RESULTS.recording(scene)
            assert recording is not None
            tracks = recording.tracks.values()
            updates[name] = sum(len(track) for track in tracks)
            frames = sorted({int(frame) for track in tracks for frame in track.frames})
            bare[name].append(bare_frames(scene, frames))
            command[name].append(_by_command_line(kinds, first, last))
    for name, kinds in CASES:
        enable_only(kinds)
        watch = Stopwatch()
        with watch.running():
            run(scene, sensors_of(), first, last)
        rows.append({
            "name": name, "sensors": sum(sensor.settings.enabled for sensor in sensors_of()),
            "updates": updates[name], "wall_s": spread(operator[name]),
            "speed": spread([seconds / wall for wall in operator[name]]),
            "parts_s": dict(watch.seconds), "evaluation_alone_s": min(bare[name]),
            "command_line_s": spread(command[name]),
        })  # fmt: skip
    return rows


def _by_command_line(kinds: Sequence[str], first: int, last: int) -> float:
    """Return the seconds of `angen simulate` from its start to its event log."""
    words = [word for kind in kinds for word in ("--kind", kind)]
    words += ["--frames", f"{first}:{last}", "--quiet", "--events", os.devnull]
    command = [sys.executable, "-m", "angen_addon", "simulate", str(HOME), *words]
    begin = time.perf_counter()
    subprocess.run(command, cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
    return time.perf_counter() - begin


def _by_rays(first: int, last: int, seconds: float, rounds: int) -> list[dict[str, Any]]:
    """Return the speed, and the share of a dense fan's updates with motion, by number of rays.

    All fans have the same angle.
    """
    scene = open_home()
    taken: dict[int, list[float]] = defaultdict(list)
    moved_by_rays: dict[int, list[int]] = {}
    for rays in (*RAYS * rounds, DENSE_RAYS):
        wall, recording = run(scene, detectors(7, rays), first, last)
        taken[rays].append(wall)
        moved_by_rays[rays] = [on for track in recording.tracks.values() for on in track.active]
    true = moved_by_rays[DENSE_RAYS]
    rows = []
    for rays, times in taken.items():
        both = sum(a and b for a, b in zip(moved_by_rays[rays], true, strict=True))
        moved = sum(moved_by_rays[rays])
        rows.append({
            "rays": rays, "speed": spread([seconds / wall for wall in times]),
            "sensing_s": spread(times), "kept": both / max(sum(true), 1),
            "extra": (moved - both) / max(moved, 1), "updates": len(true),
            "updates_with_motion": sum(true),
        })  # fmt: skip
    return rows


def _by_count(
    counts: Sequence[int], first: int, last: int, seconds: float, rounds: int
) -> list[dict[str, Any]]:
    rows = []
    for count in counts:
        scene = open_home()
        sensors = detectors(count)
        times = [run(scene, sensors, first, last)[0] for _ in range(rounds)]
        rows.append({"pirs": count, "speed": spread([seconds / wall for wall in times])})
    return rows


def measure_live(quick: bool) -> dict[str, Any]:
    rows = []
    for number, (name, kinds) in enumerate(LIVE_CASES):
        progress("live", number, len(LIVE_CASES), name)
        rows.append({"name": name, **_live_case(kinds, 2 if quick else 12)})
    return {"frames": LAST - FIRST, "cases": rows}


def _live_case(kinds: tuple[str, ...], rounds: int) -> dict[str, Any]:
    scene = open_home()
    enable_only(kinds)
    memory.forget_file()
    bpy.context.view_layer.update()
    pairs = [(_played(scene, False), _played(scene, True)) for _ in range(rounds)]
    plain, live = zip(*pairs, strict=True)
    sensors = [sensor for sensor in sensors_of() if sensor.settings.enabled]
    return {
        "sensors": len(sensors), "plain_ms": spread(plain), "live_ms": spread(live),
        "cost_ms": spread([b - a for a, b in pairs]), **_compared(scene, sensors),
    }  # fmt: skip


def _played(scene: Any, live: bool) -> float:
    """Return the milliseconds of processor time per frame."""
    scene.angen_live = live
    begin = 0.0
    for frame in range(FIRST - AHEAD, LAST):
        if frame == FIRST:
            begin = time.process_time()
        scene.frame_set(frame)
    return (time.process_time() - begin) / (LAST - FIRST) * 1000


def _compared(scene: Any, sensors: list[Any]) -> dict[str, int]:
    """Count the live readings that equal those of a run from the first frame on."""
    recording = run(scene, sensors, scene.frame_start, LAST)[1]
    expected = {
        (name, float(frame)): (bool(active), float(value))
        for name, track in recording.tracks.items()
        for frame, active, value in zip(track.frames, track.active, track.value, strict=True)
    }
    scene.angen_live = True
    found = {}
    for frame in range(scene.frame_start, LAST):
        scene.frame_set(frame)
        for name, published in known_live().readings.items():
            reading = published.reading
            found[name, float(published.frame)] = reading.active, reading.value
    same = sum(expected[key] == reading for key, reading in found.items())
    return {"read": len(found), "same": same, "active": sum(one[0] for one in found.values())}
