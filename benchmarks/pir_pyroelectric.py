# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pyroelectric detector's error and cost depend on, and where it and the range scan
differ. Rays are met in closed form but for the cost, which is that in the sample home.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph
from angen_sensors.angen_addon.scene.sensors import Sensor, all_sensors
from angen_sensors.sensor_logic import kind
from angen_sensors.sensor_logic.kinds.pir import MotionDetector
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.model import Emission, Update

from .common import open_home, spread
from .progress import progress
from .walkers import FURNITURE, SENSOR, WALKERS, WALLS, Boxes, Walker, passes, ranges_to

PART = "pir_pyroelectric"
RAYS, RATES = (1, 2, 4, 8, 12, 24, 48), (60.0, 24.0, 10.0)
# Of them in a glance: the default, and the finest, which must come near to the dense reference.
GLANCE_RAYS, GLANCE_RATES = (12, 48), (60.0, 24.0)
DENSE_RAYS, DENSE_RATE = 300, 120.0
ROOM_CELSIUS, ZERO = 20.0, 273.15
BODY_CELSIUS = {"cat": 27.0}
PERSON_CELSIUS = 29.0
REST_BEFORE, REST_AFTER = 1.0, 1.5
# Of the sample home: frames in which the person walks from the kitchen to the living room.
FIRST, FRAMES = 600, 48


def measure(quick: bool) -> dict[str, Any]:
    return {
        "error": measure_error(6 if quick else 12, quick),
        "cost": measure_cost(12 if quick else FRAMES, 1 if quick else 3),
        "models": measure_models(5 if quick else 20),
    }


class Scene:
    """The furnished room of `benchmarks.walkers` with one who moves in it, as both models ask."""

    def __init__(self, walker: Walker, way: tuple[Any, float, float], celsius: float, room: float):
        self._still = Boxes.upright((*WALLS, *FURNITURE))
        self._known: dict[int, tuple[Any, Any]] = {}
        self.walker, (self._start, self._yaw, self.length) = walker, way
        self.celsius, self.room = celsius, room
        self.time = 0.0

    def _ranges(self, bundle: int, origins: Any, directions: Any, reach: Any) -> tuple[Any, Any]:
        known = self._known.get(bundle)
        if known is None or known[0] is not directions:
            known = directions, ranges_to(self._still, origins, directions, reach)
            self._known[bundle] = known
        end = self.walker.seconds(self.length)
        now = self.walker.boxes(self._start, self._yaw, min(max(self.time, 0.0), end))
        return known[1], ranges_to(now, origins, directions, known[1])

    def cast(self, bundle: int, origins: Any, directions: Any, reach: Any) -> Any:
        return self._ranges(bundle, origins, directions, reach)[1]

    def warmth(self, bundle: int, origins: Any, directions: Any, reach: Any) -> Any:
        room, body = self._ranges(bundle, origins, directions, reach)
        kelvin = np.where(body < room, self.celsius, self.room) + ZERO
        return Emission(kelvin, np.full(len(kelvin), 0.95), self.room + ZERO)


def run(scene: Scene, parameters: PirParameters, rate: float) -> tuple[list[Any], float]:
    """Readings of one pass, with rest before and after; seconds until the first detection."""
    detector, readings, latency = MotionDetector(), [], np.inf
    seconds = scene.walker.seconds(scene.length)
    for k in range(int((REST_BEFORE + seconds + REST_AFTER) * rate)):
        scene.time = k / rate - REST_BEFORE
        update = Update(k, k / rate, SENSOR, {kind.RAYS: scene.cast, kind.WARMTH: scene.warmth})
        readings.append(detector.update(parameters, update))
        if readings[-1].active:
            latency = min(latency, max(scene.time, 0.0))
    return readings, latency


def peak(readings: list[Any]) -> float:
    return max(abs(reading.fields["signal"]) for reading in readings)


def pyroelectric() -> PirParameters:
    return PirParameters(model="PYROELECTRIC", range_max=5.0)


def measure_error(count: int, quick: bool) -> list[dict[str, Any]]:
    """Relative error of the peak signal, rms and worst over walks through the room."""
    walk = next(walker for walker in WALKERS if walker.name == "walk")
    scenes = [Scene(walk, way, PERSON_CELSIUS, ROOM_CELSIUS) for way in passes(walk, count)]
    dense = replace(pyroelectric(), zone_rays=DENSE_RAYS)
    exact = np.array([peak(run(scene, dense, DENSE_RATE)[0]) for scene in scenes])
    rows = []
    chosen = GLANCE_RAYS if quick else RAYS
    for done, rays in enumerate(chosen):
        progress(PART, done, len(chosen), f"error with {rays} rays a zone")
        for rate in GLANCE_RATES if quick else RATES:
            parameters = replace(pyroelectric(), zone_rays=rays)
            found = np.array([peak(run(scene, parameters, rate)[0]) for scene in scenes])
            error = found / exact - 1
            rows.append(
                {
                    "zone_rays": rays,
                    "rate": rate,
                    "rms": float(np.sqrt(np.mean(error**2))),
                    "mean": float(error.mean()),
                    "worst": float(np.abs(error).max()),
                    "walks": count,
                }
            )
    return rows


def measure_cost(frames: int, rounds: int) -> list[dict[str, Any]]:
    """Milliseconds of processor time an update of one detector in the sample home, after its first
    second."""
    scene = open_home()
    person = bpy.data.objects["Person"].angen_warmth
    person.use_temperature, person.temperature = True, 28.0
    for material in bpy.data.objects["Person"].data.materials:
        if "skin" in material.name:
            material.angen_warmth.use_temperature = True
            material.angen_warmth.temperature = 33.0
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier == "PIR"]
    rows = []
    for model, rays in (("RANGE_SCAN", 120), *(("PYROELECTRIC", r) for r in (4, 12, 48))):
        progress(PART, len(rows), 4, f"cost of {model} in the home")
        for sensor in sensors:
            pir = sensor.settings.pir
            pir.model, pir.sweep = model, "ALL"
            pir.rays, pir.zone_rays = 120, rays
            sensor.settings.update_rate = 24.0
        runs = [_in_home(scene, sensors, frames) for _ in range(rounds)]
        rows.append(
            {
                "model": model,
                "zone_rays": rays,
                "rays": 1080 if model == "RANGE_SCAN" else 42 * rays,
                "ms": spread([milliseconds for milliseconds, *_ in runs]),
                "updates": runs[0][1],
                "active": runs[0][2],
            }
        )
    return rows


def _in_home(scene: Any, sensors: list[Sensor], frames: int) -> tuple[float, int, int]:
    """Milliseconds an update, updates, and those that said that something moves."""
    clock, probes = clock_of(scene), Probes(scene)
    runners = [SensorRunner(sensor, clock) for sensor in sensors]
    taken, updates, moved = 0.0, 0, 0
    first = FIRST - scene.frame_start
    for step in range(first - 24, first + frames):
        scene.frame_set(step + scene.frame_start)
        depsgraph = evaluated_depsgraph()
        probes.look(depsgraph, None)
        # Trees of what has moved are built once for all sensors, whatever their model.
        for solid in probes.caster.solids.solids:
            if solid.moving and np.isfinite(solid.geometry.lo).all():
                solid.geometry.tree(depsgraph)
        begin = time.process_time()
        for runner in runners:
            reading = runner.take(step, step, depsgraph, probes).reading()
            moved += reading.active and step >= first
        if step >= first:
            taken += time.process_time() - begin
            updates += len(runners)
    return taken / updates * 1e3, updates, moved


def measure_models(count: int) -> list[dict[str, Any]]:
    """Shares of passes detected, and the median latency, of the two models side by side."""
    both: tuple[tuple[str, PirParameters, float], ...] = (
        ("thesis", PirParameters(), 10.0),
        ("all tilts", PirParameters(sweep="ALL"), 10.0),
        ("pyroelectric", pyroelectric(), 24.0),
    )
    situations: list[tuple[str, Walker, float, float]] = [
        (w.name, w, BODY_CELSIUS.get(w.name, PERSON_CELSIUS), ROOM_CELSIUS) for w in WALKERS
    ]
    walk = next(walker for walker in WALKERS if walker.name == "walk")
    situations += [
        ("walk, room of 28 °C", walk, 31.0, 28.0),
        ("walk, room of 31 °C", walk, 31.5, 31.0),
        ("walk of something as warm as the room", walk, ROOM_CELSIUS, ROOM_CELSIUS),
        ("walk at 0.1 m/s", replace(walk, speed=0.1), PERSON_CELSIUS, ROOM_CELSIUS),
    ]
    rows = []
    for done, (name, walker, celsius, room) in enumerate(situations):
        progress(PART, done, len(situations), name)
        row: dict[str, Any] = {"situation": name, "passes": count}
        for label, parameters, rate in both:
            latencies = np.array(
                [
                    run(Scene(walker, way, celsius, room), parameters, rate)[1]
                    for way in passes(walker, count)
                ]
            )
            seen = latencies[np.isfinite(latencies)]
            row[label] = {
                "detected": len(seen) / count,
                "latency_s": float(np.median(seen)) if len(seen) else None,
            }
        rows.append(row)
    return rows
