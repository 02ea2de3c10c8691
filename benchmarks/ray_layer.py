# SPDX-License-Identifier: GPL-3.0-or-later
"""The fast ray layer against `scene.ray_cast`: time a frame, worst range error, events.

Both casters get the same frames of the same scene in one process, one after the other; times are
those of sensing, without Blender's evaluation of the frame, which is given separately. Detectors
update at 10 Hz, so the time of a frame is the mean over frames with and without updates. The first
second, in which the fast layer processes everything that stands still, is its start time.
"""

from __future__ import annotations

import random
import time
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph
from angen_sensors.angen_addon.scene.sensors import Sensor, all_sensors

from .common import HOME as HOME
from .common import open_home, spread
from .progress import progress

# The frame at which the person walks from the kitchen to the living room.
FIRST_FRAME = 600
PIRS = (1, 7, 20)
RAYS = (80, 160, 640)
CROWD = 1000
START_FRAMES = 24


@dataclass
class Run:
    """One caster's run: the seconds for the start, for sensing and for evaluation; all readings."""

    starting: float = 0.0
    sensing: float = 0.0
    evaluating: float = 0.0
    ranges: list[Any] = field(default_factory=list)
    moved: list[bool] = field(default_factory=list)


def measure(quick: bool) -> dict[str, Any]:
    frames, rounds = (24, 1) if quick else (72, 3)
    home, crowded = ("Ängen home", 0), (f"home and {CROWD} objects", CROWD)
    cases = [
        (*home, p, r, "SAWTOOTH", rounds) for p in (PIRS[1:2] if quick else PIRS) for r in RAYS
    ]
    if not quick:
        cases.append((*home, 7, 120, "SAWTOOTH", rounds))
        cases.append((*home, 7, 120, "ALL", rounds))
        cases.append((*crowded, 7, 120, "SAWTOOTH", rounds))
        cases.append((*crowded, 7, 120, "ALL", 1))
    rows = []
    for done, (name, crowd, pirs, rays, sweep, repeats) in enumerate(cases):
        progress("rays", done, len(cases), f"{name}, {pirs} PIRs, {rays} rays, {sweep}")
        rows.append(compare(name, crowd, pirs, rays, sweep, frames, repeats))
    return {"frames": frames, "rounds": rounds, "rows": rows}


def compare(
    name: str, crowd: int, pirs: int, rays: int, sweep: str, frames: int, rounds: int
) -> dict[str, Any]:
    """Both casters on the same frames; the median over rounds of times and of their ratio."""
    scene = open_home()
    add_objects(crowd)
    sensors = detectors(pirs, rays, sweep)
    fast_times, slow_times, ratios = [], [], []
    for _ in range(rounds):
        fast = run(scene, sensors, "FAST", frames)
        slow = run(scene, sensors, "SCENE", frames)
        fast_times.append(fast.sensing / frames * 1e3)
        slow_times.append(slow.sensing / frames * 1e3)
        ratios.append(slow.sensing / fast.sensing)
    error = max(float(np.abs(a - b).max()) for a, b in zip(fast.ranges, slow.ranges, strict=True))
    return {
        "scene": name,
        "objects": len(scene.objects),
        "pirs": pirs,
        "rays": rays,
        "sweep": sweep,
        "frames": frames,
        "start_ms": fast.starting * 1e3,
        "fast_ms": spread(fast_times),
        "reference_ms": spread(slow_times),
        "ratio": spread(ratios),
        "evaluation_ms": fast.evaluating / frames * 1e3,
        "worst_range_error_m": error,
        "updates": len(fast.moved),
        "updates_that_differ": sum(a != b for a, b in zip(fast.moved, slow.moved, strict=True)),
        "updates_with_motion": sum(slow.moved),
    }


def run(scene: Any, sensors: list[Sensor], caster_name: str, frames: int) -> Run:
    scene.angen_ray_caster = caster_name
    # Values at the playhead would be sensed a second time.
    scene.angen_live = False
    clock = clock_of(scene)
    runners = [SensorRunner(sensor, clock) for sensor in sensors]
    probes = Probes(scene)
    done = Run()
    cast = probes.caster.cast_at

    def noting_cast(*arguments: Any) -> Any:
        answers = cast(*arguments)
        done.ranges.append(answers[-1].copy())
        return answers

    probes.caster.cast_at = noting_cast  # type: ignore[method-assign]
    first = FIRST_FRAME - scene.frame_start
    scene.frame_set(FIRST_FRAME - START_FRAMES - 1)
    for step in range(first - START_FRAMES, first + frames):
        begin = time.perf_counter()
        scene.frame_set(clock.frame_and_subframe(step)[0])
        depsgraph = evaluated_depsgraph()
        evaluated = time.perf_counter()
        due = [(n, s) for s in runners for n, _ in s.schedule.updates(step, step)]
        if due:
            probes.look(depsgraph, None)
        for number, runner in due:
            done.moved.append(runner.take(number, step, depsgraph, probes).reading().active)
        sensing = time.perf_counter() - evaluated
        if step < first:
            done.starting += sensing
        else:
            done.sensing += sensing
            done.evaluating += evaluated - begin
    return done


def detectors(count: int, rays: int, sweep: str) -> list[Sensor]:
    """The home's first detectors, and copies of them a little aside where it has too few."""
    own = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier == "PIR"]
    for i in range(count - len(own)):
        copy = own[i % len(own)].object.copy()
        copy.location.z -= 0.1 * (1 + i // len(own))
        bpy.context.scene.collection.objects.link(copy)
    bpy.context.view_layer.update()
    found = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier == "PIR"][:count]
    for sensor in found:
        sensor.settings.pir.rays = rays
        sensor.settings.pir.sweep = sweep
    return found


def add_objects(count: int) -> None:
    """Small boxes on the floors, all still, each with a mesh of its own."""
    chance = random.Random(1)
    corners = [(x, y, z) for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.2)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    for i in range(count):
        mesh = bpy.data.meshes.new(f"box {i}")
        mesh.from_pydata(corners, [], faces)
        box = bpy.data.objects.new(f"box {i}", mesh)
        box.location = (chance.uniform(0, 10.6), chance.uniform(0.3, 8.3), 0.055)
        bpy.context.scene.collection.objects.link(box)
    bpy.context.view_layer.update()
