# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis's own figures, on its own work: the Ängen home with 22 sensors at the thesis's rates.

Simulation speed is simulated over real time, the evaluation of every frame by Blender included:
against the kinds of sensors (figure 8.3), the rays (8.1), the number of detectors (8.2), and the
far plane of a light sensor. The program under test is `simulate`, as the operator and the command
line drive it.
"""

from __future__ import annotations

import random
import statistics
import time
from collections.abc import Sequence
from typing import Any

import bpy
from angen_sensors.angen_addon.runtime.simulation import simulate
from angen_sensors.angen_addon.scene.sensors import Sensor, all_sensors
from angen_sensors.sensor_logic.recording.tracks import Recording

from .common import open_home, spread
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
    """Each case in each round, so that a busy moment of the machine meets all of them; then once
    more with the stopwatch, which costs some percent itself."""
    rows = []
    every = all_sensors(bpy.context.view_layer)
    chosen = [[s for s in every if s.kind.identifier in kinds] for _, kinds in CASES]
    taken: list[list[float]] = [[] for _ in CASES]
    for _ in range(rounds):
        for sensors, times in zip(chosen, taken, strict=True):
            times.append(run(scene, sensors, first, last)[0])
    for (name, _), sensors, times in zip(CASES, chosen, taken, strict=True):
        watch = Stopwatch()
        with watch.running():
            recording = run(scene, sensors, first, last)[1]
        rows.append(
            {
                "name": name,
                "sensors": len(sensors),
                "updates": sum(len(track) for track in recording.tracks.values()),
                "wall_s": spread(times),
                "speed": spread([seconds / wall for wall in times]),
                "parts_s": {part: watch.seconds[part] for part in PARTS},
                "evaluation_alone_s": _evaluation(scene, recording),
            }
        )
    return rows


def _evaluation(scene: Any, recording: Recording) -> float:
    """Seconds that Blender takes to evaluate the frames of the updates, nothing else done."""
    frames = sorted({int(f) for track in recording.tracks.values() for f in track.frames})
    begin = time.perf_counter()
    for frame in frames:
        scene.frame_set(frame)
    return time.perf_counter() - begin


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
