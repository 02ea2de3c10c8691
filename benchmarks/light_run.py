# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a whole run: the Ängen home's story with its seven sensors, once a second of it.

What an update costs, with all references of the lamps' states that the run needs, and how far its
readings are from those of far more light paths with other random numbers.
"""

from __future__ import annotations

import time
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene_probe.light import engine, probe
from angen_sensors.angen_addon.scene_probe.light.cycles import CyclesLight
from angen_sensors.angen_addon.scene_probe.light.probe import LightRequest

from .light_speed import number
from .ray_layer import HOME

METHODS = ("ILLUMINANCE", "FOUR_WALL")
# Light paths of an update, and of a reference.
WAYS = ((512, 0), (1024, 0), (256, 16_384), (512, 16_384), (512, 65_536))
# As many updates of the story, spread over it, are compared; and by as many seeds.
COMPARED, SEEDS = 14, 2


def measure(paths: int, quick: bool) -> dict[str, Any]:
    """A row for each method and way; `paths`: of what they are compared with."""
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    step = round(scene.render.fps)
    frames = list(range(scene.frame_start, scene.frame_end + 1, step * (12 if quick else 1)))
    compared = frames[:: max(1, len(frames) // COMPARED)]
    rows = []
    for method in METHODS:
        true, noise = _true(compared, method, paths)
        for few, many in WAYS:
            found, costs = _run(frames, method, few, many)
            error = np.array([found[frame] for frame in compared]) / true - 1.0
            rows.append(
                {
                    "method": method,
                    "samples": few,
                    "reference": many,
                    "ms_a_sensor": 1000.0 * sum(costs) / true.shape[1] / len(frames),
                    "ms_further": 1000.0 * float(np.median(costs)) / true.shape[1],
                    "rms": float(np.sqrt(np.mean(error**2))),
                    "median": float(np.median(np.abs(error))),
                    "worst": float(np.abs(error).max()),
                    "noise_rms": noise,
                }
            )
    return {"rows": rows, "updates": len(frames), "compared": len(compared), "paths": paths}


def _requests(method: str, samples: int) -> list[LightRequest]:
    own = sorted(
        (o for o in bpy.context.scene.objects if o.angen_sensor.kind == "LIGHT"),
        key=lambda o: o.name,
    )
    return [
        LightRequest(o.name, np.array(o.matrix_world, np.float64), method, samples=samples)
        for o in own
    ]


def _values(requests: list[LightRequest], kept: CyclesLight) -> Any:
    found = probe.measure(bpy.context.scene, bpy.context.view_layer, requests, kept=kept)
    return np.array([number(found[r.name]) for r in requests])


def _run(frames: list[int], method: str, few: int, many: int) -> tuple[dict[int, Any], list[float]]:
    """Values by frame, and seconds of each update."""
    kept, found, costs = CyclesLight(many), {}, []
    requests = _requests(method, few)
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        start = time.perf_counter()
        found[frame] = _values(requests, kept)
        costs.append(time.perf_counter() - start)
    kept.close()
    return found, costs


def _true(frames: list[int], method: str, paths: int) -> tuple[Any, float]:
    """Means over seeds (frames, sensors), and their relative noise, rms."""
    seed, found, requests = engine.SEED, [], _requests(method, paths)
    try:
        for turn in range(SEEDS):
            engine.SEED = 2000 + turn
            kept = CyclesLight()
            values = []
            for frame in frames:
                bpy.context.scene.frame_set(frame)
                values.append(_values(requests, kept))
            kept.close()
            found.append(values)
    finally:
        engine.SEED = seed
    mean = np.maximum(np.mean(found, axis=0), 1e-9)
    spread = np.std(found, axis=0, ddof=1) / np.sqrt(SEEDS) / mean
    return mean, float(np.sqrt(np.mean(spread**2)))
