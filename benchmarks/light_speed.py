# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against error of measuring light with Cycles, in the Ängen home with its lamps on.

The reference has so many light paths that its own noise, told beside, is far below the errors.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene.changes import LightChanges
from angen_sensors.angen_addon.scene.light import engine, probe
from angen_sensors.angen_addon.scene.light.cycles import CyclesLight
from angen_sensors.angen_addon.scene.light.probe import LightRequest

from .ray_layer import HOME

# At noon of the story: several lamps are on, and the sun shines.
FRAME = 1500
REFERENCE_SEEDS = 3
SAMPLES = (256, 1024, 4096, 16384)
COUNTS = (1, 7, 50)
# So many are timed alone: each reads the same whatever others there are.
MANY, MANY_SAMPLES = 500, 1024


def measure(method: str, reference_samples: int, rounds: int) -> dict[str, Any]:
    """A row for each number of samples and of sensors, by one method."""
    scene = _open()
    asked = _requests(max(COUNTS), method)
    true, noise = _reference(asked, reference_samples)
    rows = []
    for samples in SAMPLES:
        for count in COUNTS:
            part = [_with(r, engine="CYCLES", samples=samples) for r in asked[:count]]
            found, cost = _timed(part, rounds)
            error = np.abs(found / true[:count] - 1.0)
            rows.append(
                {
                    "method": method,
                    "samples": samples,
                    "sensors": count,
                    "ms_a_sensor": cost / count,
                    "rms": float(np.sqrt(np.mean(error**2))),
                    "median": float(np.median(error)),
                    "worst": float(error.max()),
                    "reference_noise": noise,
                }
            )
    _, cost = _timed(_requests(MANY, method), rounds)
    many = {"sensors": MANY, "samples": MANY_SAMPLES, "ms_a_sensor": cost / MANY}
    return {
        "rows": rows,
        "many": many,
        "static_ms": _static(scene),
        "reference_samples": reference_samples,
    }


def _open() -> Any:
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    scene.frame_set(FRAME)
    return scene


def _requests(count: int, method: str) -> list[LightRequest]:
    """The home's own light sensors, then the same ones a bit lower and turned."""
    own = sorted(
        (o for o in bpy.context.scene.objects if o.angen_sensor.kind == "LIGHT"),
        key=lambda o: o.name,
    )
    found = []
    for number in range(count):
        pose = np.array(own[number % len(own)].matrix_world, np.float64)
        turn = number // len(own) * 0.7
        x, z = pose[:3, 0].copy(), pose[:3, 2].copy()
        pose[:3, 0] = np.cos(turn) * x - np.sin(turn) * z
        pose[:3, 2] = np.sin(turn) * x + np.cos(turn) * z
        pose[2, 3] -= 0.1 * (number // len(own))
        name = own[number].name if number < len(own) else f"Light sensor {number:02d}"
        found.append(LightRequest(name, pose, method))
    return found


def _with(request: LightRequest, **changes: Any) -> LightRequest:
    return LightRequest(**{**request.__dict__, **changes})


def number(sample: Any) -> float:
    """The reading of a sample, in its method's unit."""
    lux, percent = sample.illuminance_lux, sample.luminance_percent
    return float(lux if percent is None else percent)


def _values(requests: Sequence[LightRequest], kept: CyclesLight | None = None) -> Any:
    found = probe.measure(bpy.context.scene, bpy.context.view_layer, requests, kept=kept)
    return np.array([number(found[r.name]) for r in requests])


def _timed(requests: Sequence[LightRequest], rounds: int) -> tuple[Any, float]:
    """Values, and the time of a further update [ms] as in a run: the person has moved on."""
    scene, kept, costs = bpy.context.scene, CyclesLight(), []
    values = _values(requests, kept)
    for number in range(rounds):
        scene.frame_set(FRAME + 1 + number)
        start = time.perf_counter()
        _values(requests, kept)
        costs.append(time.perf_counter() - start)
    kept.close()
    scene.frame_set(FRAME)
    return values, float(np.median(costs)) * 1000.0


def _reference(requests: Sequence[LightRequest], samples: int) -> tuple[Any, float]:
    """Means over seeds, and their relative noise (median over the sensors)."""
    many = [_with(r, engine="CYCLES", samples=samples) for r in requests]
    seed, found = engine.SEED, []
    try:
        for number in range(REFERENCE_SEEDS):
            engine.SEED = 1000 + number
            found.append(_values(many))
    finally:
        engine.SEED = seed
    mean = np.mean(found, axis=0)
    spread = np.std(found, axis=0, ddof=1) / np.sqrt(REFERENCE_SEEDS)
    return np.maximum(mean, 1e-9), float(np.median(spread / np.maximum(mean, 1e-9)))


def _static(scene: Any) -> float:
    """Milliseconds that it takes to find that nothing has changed."""
    changes, layer = LightChanges(), bpy.context.view_layer
    depsgraph = bpy.context.evaluated_depsgraph_get()
    state = changes.look(layer, depsgraph)
    start = time.perf_counter()
    for _ in range(50):
        assert changes.look(layer, depsgraph) == state
    return (time.perf_counter() - start) / 50 * 1000.0
