# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure how cost and memory grow.

They grow with the objects, triangles, sensors and frames of a scene, and with the length of a
recording. Each case runs in its own process, so that its memory is measured alone.
"""

from __future__ import annotations

import math
import time
from collections import defaultdict
from typing import Any

import bpy
import numpy as np
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.events import events_csv
from angen_sensors.sensor_logic.recording.file import from_bytes, to_bytes
from angen_sensors.sensor_logic.recording.tracks import Recording, Track

from .common import (
    MIB,
    apart,
    bare_frames,
    link,
    memory_mib,
    new_scene,
    progress,
    run,
    sensors_of,
    spread,
)

BASE = {"objects": 300, "triangles": 12_000, "sensors": 7, "frames": 96}
SWEEPS: dict[str, tuple[int, ...]] = {
    "objects": (10, 30, 100, 300, 1000, 3000),
    "triangles": (10_000, 100_000, 500_000, 2_000_000),
    "sensors": (1, 10, 50, 100, 500),
    "frames": (100, 1000, 5000, 20_000),
}
QUICK: dict[str, tuple[int, ...]] = {
    "objects": (10, 100, 1000),
    "triangles": (10_000, 100_000),
    "sensors": (1, 50),
    "frames": (100, 1000),
}
DAY = 86_400
RATES = {"PIR": (7, 10.0), "OPTICAL_SWITCH": (7, 1.0), "LIGHT": (7, 1.0), "PRESSURE": (1, 1.0)}
FPS, HIGH = 24, 2.2


def measure(quick: bool) -> dict[str, Any]:
    rounds = 1 if quick else 3
    # Round by round, so that a busy moment of the machine spreads over all cases.
    found = defaultdict[tuple[str, int], list[dict[str, float]]](list)
    for turn in range(rounds):
        for name, sizes in (QUICK if quick else SWEEPS).items():
            for size in sizes:
                progress("growth", turn, rounds, f"{size} {name}")
                case = apart("growth.run_scene", *({**BASE, name: size}).values())
                found[name, size].append(case)
    sweeps: dict[str, list[dict[str, Any]]] = {name: [] for name in SWEEPS}
    for (name, size), runs in found.items():
        figures = {key: spread([each[key] for each in runs]) for key in runs[0]}
        sweeps[name].append({"size": size, **figures})
    recording = apart("growth.run_recording", DAY // 24 if quick else DAY)
    return {"base": BASE, "sweeps": sweeps, "recording": recording}


def run_scene(objects: int, triangles: int, sensors: int, frames: int) -> dict[str, float]:
    """Return what detectors cost in a hall of still objects with one moving object.

    All detectors have the thesis's parameters and update at 10 Hz; the scene has 24 fps.
    """
    empty = memory_mib(most=True)
    scene = hall(objects, triangles, sensors, frames)
    built = memory_mib(most=True)
    # After one second every tilt was scanned once: the ranges of still objects are known.
    first, early = run(scene, sensors_of(), 1, 1 + FPS)
    wall, recording = run(scene, sensors_of(), 1, frames)
    tracks = recording.tracks.values()
    steps, looks = (len(next(iter(r.tracks.values()))) for r in (early, recording))
    looked = sorted({int(frame) for track in tracks for frame in track.frames})[steps:]
    evaluation = bare_frames(scene, looked) / len(looked) * 1e3
    ms = (wall - first) / (looks - steps) * 1e3
    return {
        "start_ms": first * 1e3, "ms": ms, "sensing_ms": ms - evaluation,
        "evaluation_ms": evaluation, "scene_mib": built - empty,
        "run_mib": memory_mib(most=True) - built,
    }  # fmt: skip


def run_recording(seconds: int) -> dict[str, Any]:
    """Return what a recording of so many seconds costs: in memory, as event log, and as file.

    It is filled with readings of the home's 22 sensors at the thesis's rates.
    """
    before = memory_mib(most=True)
    recording, rows = Recording(frame_start=1, frame_end=seconds * FPS), 0
    begin = time.perf_counter()
    for kind_name, (count, rate) in RATES.items():
        kind = KINDS[kind_name]
        idle, busy = ({f.name: f.type(on) for f in kind.samples} for on in (0, 1))
        for index in range(count):
            track = Track(f"{kind_name} {index}", kind_name)
            recording.tracks[track.sensor] = track
            for number in range(int(seconds * rate)):
                # Most readings equal the one before, as those of real sensors do.
                active = number // 97 % 5 == 0
                reading = Reading(active, float(active), busy if active else idle)
                track.append(1 + number * FPS / rate, number / rate, reading)
            rows += len(track)
    filled, mib = time.perf_counter(), memory_mib(most=True) - before
    text = events_csv(recording)
    logged = time.perf_counter()
    data = to_bytes(recording, {})
    saved = time.perf_counter()
    again, _ = from_bytes(data)
    loaded = time.perf_counter()
    assert events_csv(again) == text, "a recording that was read again says the same"
    return {
        "seconds": seconds, "rows": rows, "fill_s": filled - begin, "mib": mib,
        "events_s": logged - filled, "events_mib": len(text) / MIB, "save_s": saved - logged,
        "load_s": loaded - saved, "file_mib": len(data) / MIB,
    }  # fmt: skip


def hall(objects: int, triangles: int, sensors: int, frames: int) -> Any:
    """Return a scene with `objects` objects on 20 × 20 m that share `triangles` triangles."""
    scene = new_scene(FPS, frames)
    chance = np.random.default_rng(1)
    link("floor", _sheet("floor", 20.0, 20.0, 1))
    side = max(1, math.ceil(math.sqrt(triangles / objects / 2)))
    for i in range(objects):
        x, y = chance.uniform(-9.5, 9.5, 2).tolist()
        # Each has its own mesh, as most furniture has. Half of them stand, half lie.
        thing = link(f"thing {i}", _sheet(f"thing {i}", 0.5, 0.5, side), (x, y, 0.3))
        thing.rotation_euler.x = math.pi / 2 if i % 2 else 0.0
    mover = link("mover", _sheet("mover", 0.6, 1.7, 8), (0, 0, 0.9))
    mover.rotation_euler.x = math.pi / 2
    for number, frame in enumerate(range(1, frames + 96, 48)):
        mover.location.x = -4.0 if number % 2 else 4.0
        mover.keyframe_insert("location", index=0, frame=frame)
    for i in range(sensors):
        x, y = chance.uniform(-6, 6, 2).tolist()
        sensor = link(f"PIR {i:03d}", None, (x, y, HIGH))
        # Level, in a random direction.
        sensor.rotation_euler = (math.pi / 2, 0, float(chance.uniform(0, 2 * math.pi)))
        sensor.angen_sensor.kind = "PIR"
    bpy.context.view_layer.update()
    return scene


def _sheet(name: str, width: float, depth: float, side: int) -> Any:
    """Return a slightly wavy sheet of side × side squares."""
    x, y = np.meshgrid(
        np.linspace(-width / 2, width / 2, side + 1), np.linspace(-depth / 2, depth / 2, side + 1)
    )
    z = 0.02 * np.sin(20 * x) * np.sin(20 * y) if side > 1 else np.zeros_like(x)
    corner = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    squares = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=2)
    mesh = bpy.data.meshes.new(name)
    points = np.stack([x, y, z], axis=2).reshape(-1, 3)
    mesh.from_pydata(points.tolist(), [], squares.reshape(-1, 4).tolist())
    return mesh
