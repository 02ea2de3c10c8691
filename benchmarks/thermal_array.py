# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the error of infrared arrays by the number of rays of a pixel, and what a run costs.

In the Ängen home, each motion detector becomes an array of 8 × 8 pixels. The frames of few rays
are compared with those of 1024 rays a pixel, while the person walks. The plain grid is measured
beside the lattice that the model uses. A run is timed beside the bare evaluation of its frames, in
the same process.
"""

from __future__ import annotations

import time
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.authoring.presets import find_preset
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner, single_update
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph
from angen_sensors.sensor_logic.geometry.pixels import all_cells, lattice_cells, pixel_directions
from angen_sensors.sensor_logic.kind import WARMTH
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.kinds.thermal_array.array import SIGHT, celsius
from angen_sensors.sensor_logic.physics import radiosity

from .common import (
    bare_frames,
    enable_only,
    open_home,
    progress,
    rms,
    run,
    sensors_of,
    spread,
)

KIND, PIR = "THERMAL_ARRAY", "PIR"
# At this frame the person walks from the kitchen to the living room.
FIRST, STRIDE = 600, 12
# The sides of plain grids, and the rays of lattices.
GRIDS, LATTICES = (2, 3, 4, 5, 6, 8), (5, 8, 13, 21, 34, 55)
DENSE = 32
# K. A pixel has an edge in it if its dense rays differ by more than this.
EDGE = 0.5
# By name: the parameters of the arrays, and how many there are. The first is a part with its noise.
PARTS: dict[str, tuple[dict[str, Any], int]] = {
    "8 × 8 pixels, 60° × 60°": (dict(find_preset(KINDS[KIND], "AMG8833").values), 7),
    "32 × 24 pixels, 55° × 35°": (
        {"columns": 32, "rows": 24, "horizontal_fov": 0.9599, "vertical_fov": 0.6109},
        1,
    ),
}


def measure(quick: bool) -> dict[str, Any]:
    return {
        "dense": DENSE**2,
        "errors": errors(4 if quick else 24),
        "runs": [
            timed(name, count, rays, 24 if quick else 240, 1 if quick else 3)
            for name, (_, count) in PARTS.items()
            for rays in (13, 21, 34)
        ],
    }


def arrays(scene: Any, count: int, **values: Any) -> list[Any]:
    """Warm the person, and make the first detectors arrays; return them."""
    person = bpy.data.objects["Person"].angen_warmth
    person.use_temperature, person.temperature = True, 29.0
    for detector in sensors_of(PIR)[:count]:
        detector.settings.kind = KIND
        for name, value in values.items():
            setattr(detector.settings.thermal_array, name, value)
    enable_only((KIND,))
    bpy.context.view_layer.update()
    return sensors_of(KIND)


def errors(frames: int) -> list[dict[str, Any]]:
    """Return the error of each pattern of rays against dense rays, and the time of its casts."""
    scene = open_home()
    clock = clock_of(scene)
    runners = [SensorRunner(sensor, clock) for sensor in arrays(scene, 7)]
    probes = Probes(scene)
    patterns = {f"grid {k} × {k}": (k, all_cells(k)) for k in GRIDS}
    patterns |= {f"lattice {n}": (n, lattice_cells(n)) for n in LATTICES}
    dense = DENSE, all_cells(DENSE)
    found: dict[str, list[Any]] = {name: [] for name in patterns}
    seconds = dict.fromkeys(patterns, 0.0)
    true, mixed = [], []
    for number in range(frames):
        progress("thermal_array", number, frames, "error")
        frame = FIRST + number * STRIDE
        scene.frame_set(frame)
        depsgraph = evaluated_depsgraph()
        step = frame - scene.frame_start
        probes.look(depsgraph, step)
        for runner in runners:
            taken = single_update(runner, 0, step, probes)
            assert taken is not None
            parameters, update = taken.parameters, taken.updates[0]
            for bundle, (name, pattern) in enumerate([("", dense), *patterns.items()]):
                ways = pixel_directions(
                    update.pose.axes, parameters.field_of_view, parameters.pixels, *pattern
                )
                origins = np.broadcast_to(update.pose.origin, ways.shape)
                begin = time.perf_counter()
                seen = update.ask(WARMTH, bundle, origins, ways, np.full(len(ways), SIGHT))
                took = time.perf_counter() - begin
                each = radiosity(seen).reshape(parameters.columns * parameters.rows, -1)
                if not name:
                    true.append(celsius(each.mean(axis=1)))
                    mixed.append(np.ptp(celsius(each), axis=1) > EDGE)
                else:
                    found[name].append(celsius(each.mean(axis=1)))
                    seconds[name] += took
    probes.close()
    exact, at_edge = np.array(true), np.array(mixed)
    busy = at_edge.any(axis=1)
    rows = []
    for name, (_, cells) in patterns.items():
        error = np.array(found[name]) - exact
        rows.append({
            "name": name, "rays": len(cells[0]), "rms_k": rms(error),
            "busy_rms_k": rms(error[busy]), "edge_rms_k": rms(error[at_edge]),
            "worst_k": float(np.abs(error).max()),
            "cast_ms": seconds[name] / exact.shape[0] * 1e3,
            "pixels": exact.size, "with_edge": float(at_edge.mean()), "busy": float(busy.mean()),
            "contrast_k": float(np.ptp(exact)),
        })  # fmt: skip
    return rows


def timed(name: str, count: int, rays: int, frames: int, rounds: int) -> dict[str, Any]:
    """Return the time of a run relative to the bare frames, and in ms for each frame."""
    scene = open_home()
    sensors = arrays(scene, count, **PARTS[name][0] | {"rays": rays})
    walls, bare, updates = [], [], 0
    for _ in range(rounds):
        wall, recording = run(scene, sensors, FIRST, FIRST + frames - 1)
        updates = sum(len(track) for track in recording.tracks.values())
        due = sorted({int(f) for track in recording.tracks.values() for f in track.frames})
        walls.append(wall)
        bare.append(bare_frames(scene, due))
    return {
        "name": name, "arrays": count, "rays": rays, "updates": updates,
        "ratio": spread([a / b for a, b in zip(walls, bare, strict=True)]),
        "ms_an_update": spread([(a - b) / updates * 1e3 for a, b in zip(walls, bare, strict=True)]),
    }  # fmt: skip
