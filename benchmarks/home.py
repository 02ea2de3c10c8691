# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis's own figures, on its own work: the Ängen home with 22 sensors at the thesis's rates.

Simulation speed is simulated over real time, the evaluation of every frame by Blender included:
against the kinds of sensors (figure 8.3), the rays (8.1), the number of detectors (8.2), and the
far plane of a light sensor. The kinds are timed by the operator *Simulate* and by the command line,
the rest by the generator behind both.
"""

from __future__ import annotations

import os
import random
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from typing import Any

import bpy
from angen_sensors.angen_addon.runtime.simulation import simulate
from angen_sensors.angen_addon.runtime.state import CACHE
from angen_sensors.angen_addon.scene.sensors import Sensor, all_sensors
from angen_sensors.sensor_logic.recording.tracks import Recording

from .common import HOME, open_home, spread
from .ray_layer import detectors
from .stopwatch import PARTS, Stopwatch

# The kinds that are on: the thesis's full home is all of them.
CASES = (
    ("7 PIRs", ("PIR",)),
    ("and 7 switches", ("PIR", "OPTICAL_SWITCH")),
    ("and a pad", ("PIR", "OPTICAL_SWITCH", "PRESSURE")),
    ("and 7 light sensors", ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")),
)
RAYS = (80, 160, 320, 640)
DENSE_RAYS = 2560
COUNTS = (1, 2, 4, 7, 14, 28, 56)
FAR_PLANES = (1.0, 2.0, 5.0, 10.0, 20.0)
# Where the person comes home, of which a glance is taken.
GLANCE = (48, 167)


def measure(quick: bool) -> dict[str, Any]:
    scene = open_home()
    first, last = GLANCE if quick else (scene.frame_start, scene.frame_end)
    rounds = 1 if quick else 3
    seconds = (last - first + 1) * scene.render.fps_base / scene.render.fps
    return {
        "seconds": seconds,
        "cases": _by_kind(scene, first, last, seconds, rounds),
        "rays": _by_rays(first, last, seconds, rounds),
        "counts": _by_count(COUNTS[::2] if quick else COUNTS, first, last, seconds, rounds),
        "far": _by_far_plane(FAR_PLANES[::2] if quick else FAR_PLANES, 3 if quick else 16),
    }


def run(scene: Any, sensors: list[Sensor], first: int, last: int) -> tuple[float, Recording]:
    """Seconds of a whole run, and what it recorded."""
    recording = Recording()
    begin = time.perf_counter()
    for _ in simulate(scene, sensors, first, last, recording):
        pass
    return time.perf_counter() - begin, recording


def _by_kind(
    scene: Any, first: int, last: int, seconds: float, rounds: int
) -> list[dict[str, Any]]:
    """Time each case as users wait for it: by the operator *Simulate*, and by the command line in a
    process of its own. The bare frames are timed beside it, in the same rounds."""
    rows = []
    every = all_sensors(bpy.context.view_layer)
    updates = {name: 0 for name, _ in CASES}
    operator: dict[str, list[float]] = {name: [] for name, _ in CASES}
    bare: dict[str, list[float]] = {name: [] for name, _ in CASES}
    command: dict[str, list[float]] = {name: [] for name, _ in CASES}
    for _ in range(rounds):
        for name, kinds in CASES:
            for sensor in every:
                sensor.settings.enabled = sensor.kind.identifier in kinds
            begin = time.perf_counter()
            bpy.ops.angen.simulate(frame_start=first, frame_end=last)
            operator[name].append(time.perf_counter() - begin)
            recording = CACHE.recording(scene)
            assert recording is not None
            updates[name] = sum(len(track) for track in recording.tracks.values())
            bare[name].append(_evaluation(scene, recording))
            command[name].append(_by_command_line(kinds, first, last))
    for name, kinds in CASES:
        for sensor in every:
            sensor.settings.enabled = sensor.kind.identifier in kinds
        watch = Stopwatch()
        with watch.running():
            run(scene, every, first, last)
        rows.append(
            {
                "name": name,
                "sensors": sum(sensor.settings.enabled for sensor in every),
                "updates": updates[name],
                "wall_s": spread(operator[name]),
                "speed": spread([seconds / wall for wall in operator[name]]),
                "parts_s": {part: watch.seconds[part] for part in PARTS},
                "evaluation_alone_s": min(bare[name]),
                "command_line_s": spread(command[name]),
            }
        )
    return rows


def _by_command_line(kinds: Sequence[str], first: int, last: int) -> float:
    """Seconds of `angen simulate`, from its start to its event log."""
    words = [word for kind in kinds for word in ("--kind", kind)]
    words += ["--frames", f"{first}:{last}", "--quiet", "--events", os.devnull]
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "angen_addon", "simulate", str(HOME), *words],
        cwd=HOME.parent.parent,
        check=True,
        stderr=subprocess.DEVNULL,
    )
    return time.perf_counter() - begin


def _evaluation(scene: Any, recording: Recording) -> float:
    """Seconds that Blender takes to evaluate the frames of the updates, no other code listening."""
    frames = sorted({int(f) for track in recording.tracks.values() for f in track.frames})
    handlers = bpy.app.handlers.frame_change_post, bpy.app.handlers.depsgraph_update_post
    before = [list(functions) for functions in handlers]
    for functions in handlers:
        functions.clear()
    try:
        begin = time.perf_counter()
        for frame in frames:
            scene.frame_set(frame)
        return time.perf_counter() - begin
    finally:
        for functions, known in zip(handlers, before, strict=True):
            functions.extend(known)


def _by_rays(first: int, last: int, seconds: float, rounds: int) -> list[dict[str, Any]]:
    """Speed, and what is kept of the updates at which a dense fan sees movement. The fans of one
    angle differ in their number of rays alone."""
    scene = open_home()
    taken: dict[int, list[float]] = {rays: [] for rays in (*RAYS, DENSE_RAYS)}
    said: dict[int, list[int]] = {}
    for _ in range(rounds):
        for rays in RAYS:
            taken[rays].append(_with_rays(scene, rays, first, last, said))
    taken[DENSE_RAYS].append(_with_rays(scene, DENSE_RAYS, first, last, said))
    true = said[DENSE_RAYS]
    rows = []
    for rays, times in taken.items():
        both = sum(a and b for a, b in zip(said[rays], true, strict=True))
        rows.append(
            {
                "rays": rays,
                "speed": spread([seconds / wall for wall in times]),
                "sensing_s": spread(times),
                "kept": both / max(sum(true), 1),
                "extra": (sum(said[rays]) - both) / max(sum(said[rays]), 1),
                "updates": len(true),
                "updates_with_motion": sum(true),
            }
        )
    return rows


def _with_rays(scene: Any, rays: int, first: int, last: int, said: dict[int, list[int]]) -> float:
    sensors = detectors(7, rays, "SAWTOOTH")
    wall, recording = run(scene, sensors, first, last)
    said[rays] = [moved for track in recording.tracks.values() for moved in track.active]
    return wall


def _by_count(
    counts: Sequence[int], first: int, last: int, seconds: float, rounds: int
) -> list[dict[str, Any]]:
    """More detectors than the home has are copies of them, aside and turned, in the same rooms."""
    rows = []
    for count in counts:
        scene = open_home()
        sensors = _crowd(count)
        times = [run(scene, sensors, first, last)[0] for _ in range(rounds)]
        rows.append({"pirs": count, "speed": spread([seconds / wall for wall in times])})
    return rows


def _crowd(count: int) -> list[Sensor]:
    chance = random.Random(1)
    own = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier == "PIR"]
    for i in range(count - len(own)):
        copy = own[i % len(own)].object.copy()
        copy.location.z -= 0.05 + 0.05 * (i // len(own))
        copy.rotation_euler.z += chance.uniform(-0.3, 0.3)
        bpy.context.scene.collection.objects.link(copy)
    bpy.context.view_layer.update()
    found = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier == "PIR"]
    return found[:count]


def _by_far_plane(planes: Sequence[float], updates: int) -> list[dict[str, Any]]:
    """Milliseconds of an update of one light sensor that looks at four walls."""
    rows = []
    for far in planes:
        scene = open_home()
        every = all_sensors(bpy.context.view_layer)
        sensor = next(s for s in every if s.kind.identifier == "LIGHT")
        sensor.settings.light.method = "FOUR_WALL"
        sensor.settings.light.clip_end = far
        first = GLANCE[0]
        watch = Stopwatch()
        with watch.running():
            recording = run(scene, [sensor], first, first + 24 * updates)[1]
        times = [t * 1e3 for t in watch.calls["light"]]
        rows.append(
            {
                "far_m": far,
                "ms": spread(times),
                "percent": statistics.median(recording.tracks[sensor.name].value),
            }
        )
    return rows
