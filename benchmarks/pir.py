# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what motion detectors notice of moving people and animals, by their settings.

`measure` compares the settings of the range scan on the same passes of the same walkers.
`measure_pyroelectric` measures what the error and the cost of the pyroelectric detector depend on,
and where it differs from the range scan. The models are those of the product. Ranges come from
closed-form intersections, except for the cost, which is measured in the sample home.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner, single_update
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph
from angen_sensors.sensor_logic.kind import RAYS, WARMTH
from angen_sensors.sensor_logic.kinds.pir import MotionDetector
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan
from angen_sensors.sensor_logic.model import Emission, Update

from .common import open_home, progress, rms, sensors_of, spread
from .walkers import FURNITURE, SENSOR, WALKERS, WALLS, Boxes, Walker, passes, ranges_to

Array = np.typing.NDArray[np.float64]
THESIS = PirParameters()
HZ, DEGREE = 10.0, math.pi / 180
# All rays of this fan scan at every update, 1.5° apart vertically and 0.2° horizontally.
DENSE = replace(THESIS, rays=600, vertical_step=1.5 * DEGREE, sweep="ALL")
ALL = replace(THESIS, sweep="ALL")
RECOMMENDED = replace(THESIS, rays=160, vertical_step=5 * DEGREE, sweep="ALL")
SWEEPS = (("saw-tooth", THESIS), ("all tilts", ALL))
PYROELECTRIC = PirParameters(model="PYROELECTRIC", range_max=5.0)
Setting = tuple[str, str, PirParameters, float]
# Seconds of an empty room in which noise may raise an alarm.
EMPTY_S = 3600.0
ZONE_RAYS, RATES = (1, 2, 4, 8, 12, 24, 48), (60.0, 24.0, 10.0)
# With --quick: the default, and the finest, which must come close to the dense reference.
QUICK_RAYS, QUICK_RATES = (12, 48), (60.0, 24.0)
DENSE_RAYS, DENSE_RATE = 300, 120.0
ROOM_CELSIUS, ZERO = 20.0, 273.15
PERSON_CELSIUS, CAT_CELSIUS = 29.0, 27.0
REST_BEFORE, REST_AFTER = 1.0, 1.5
# Frames of the sample home in which the person walks from the kitchen to the living room.
FIRST, FRAMES = 600, 48


class Room:
    """The furnished room of `benchmarks.walkers` with one body, as a source of ranges and warmth.

    The ranges of the empty room are kept by bundle of rays.
    """

    def __init__(self, celsius: float = PERSON_CELSIUS, room: float = ROOM_CELSIUS) -> None:
        self._still = Boxes.upright((*WALLS, *FURNITURE))
        self._still_ranges: dict[tuple[int, int], Array] = {}
        self._body: Boxes | None = None
        self._body_ranges: dict[tuple[int, int], Array] = {}
        self.celsius, self.room = celsius, room

    def put(self, body: Boxes) -> None:
        """Place the body. Its ranges are kept if it has not moved."""
        if self._body is None or not body.same_as(self._body):
            self._body, self._body_ranges = body, {}

    def cast(self, bundle: int, origins: Array, directions: Array, reach: Array) -> Array:
        key = (bundle, len(reach))
        if key not in self._still_ranges:
            self._still_ranges[key] = ranges_to(self._still, origins, directions, reach)
        if self._body is None:
            return self._still_ranges[key]
        if key not in self._body_ranges:
            self._body_ranges[key] = ranges_to(
                self._body, origins, directions, self._still_ranges[key]
            )
        return self._body_ranges[key]

    def warmth(self, bundle: int, origins: Array, directions: Array, reach: Array) -> Emission:
        body = self.cast(bundle, origins, directions, reach)
        is_body = body < self._still_ranges[bundle, len(reach)]
        kelvin = np.where(is_body, self.celsius, self.room) + ZERO
        return Emission(kelvin, np.full(len(kelvin), 0.95), self.room + ZERO)


def settings(quick: bool) -> list[Setting]:
    """Return group, name, parameters and update rate (Hz); each group varies one parameter."""
    found: list[Setting] = [
        ("chosen", "dense reference", DENSE, HZ),
        ("chosen", "thesis", THESIS, HZ),
        ("chosen", "thesis, all tilts", ALL, HZ),
        ("chosen", "recommended", RECOMMENDED, HZ),
    ]
    if quick:
        return [*found, _above_noise(0.01)]
    for sweep, base in SWEEPS:
        for rays in (20, 40, 80, 120, 160, 320, 640):
            found.append((f"rays, {sweep}", f"{rays}", replace(base, rays=rays), HZ))
    for sweep, base in SWEEPS:
        for step in (2.5, 5.0, 10.0, 22.5, 45.0):
            changed = replace(base, vertical_step=step * DEGREE)
            found.append((f"tilt step, {sweep}", f"{step:g}°", changed, HZ))
    for sweep, base in SWEEPS:
        for rate in (2.0, 5.0, 10.0, 20.0, 60.0)[: 5 if base is THESIS else 4]:
            found.append((f"update rate, {sweep}", f"{rate:g} Hz", base, rate))
    for threshold in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5):
        changed = replace(ALL, threshold=threshold)
        found.append(("threshold, all tilts", f"{threshold:g} m", changed, HZ))
    for sigma in (0.002, 0.005, 0.01, 0.02):
        changed = replace(ALL, noise_sigma=sigma)
        found.append(("noise at 0.05 m, all tilts", f"{sigma:g} m", changed, HZ))
    return [*found, _above_noise(0.01), _above_noise(0.02)]


def _above_noise(sigma: float) -> Setting:
    """Return a setting whose threshold is 7 standard deviations of the difference of two ranges."""
    changed = replace(ALL, noise_sigma=sigma, threshold=7 * math.sqrt(2) * sigma)
    name = f"{sigma:g} m, {changed.threshold:.3g} m"
    return "noise and a threshold of 7 σ√2, all tilts", name, changed, HZ


def measure(quick: bool) -> dict[str, Any]:
    count = 10 if quick else 40
    rows = []
    chosen = settings(quick)
    for done, (group, name, parameters, rate) in enumerate(chosen):
        progress("pir", done, len(chosen), f"{group}: {name}")
        begin = time.perf_counter()
        tilts = parameters.tilt_count if parameters.sweep == "ALL" else 1
        row: dict[str, Any] = {
            "group": group,
            "name": name,
            "rays_a_second": parameters.rays * rate * tilts,
            "walkers": {w.name: _seen(w, parameters, rate, count) for w in WALKERS},
            "false_alarms_an_hour": _false_alarms(parameters, rate, quick),
        }
        row["seconds"] = time.perf_counter() - begin
        rows.append(row)
    # Exact 95 % confidence: the true share of passes seen is above this if all were seen.
    return {"passes": count, "rows": rows, "least_share": float(0.025 ** (1.0 / count))}


def _reading(
    model: RangeScan, parameters: PirParameters, number: int, rate: float, room: Room, seed: int
) -> bool:
    """Return whether the model notices motion at an update."""

    def noise() -> np.random.Generator:
        return np.random.default_rng((seed, number))

    update = Update(number, number / rate, SENSOR, {RAYS: room.cast}, noise, noise)
    return model.update(parameters, update).active


def _seen(walker: Walker, parameters: PirParameters, rate: float, count: int) -> dict[str, Any]:
    """Return the share of passes detected, and the latency after the walker starts.

    Before each pass the body stands still until every tilt was scanned twice, each time at another
    phase of the sweep.
    """
    room = Room()
    latencies, said, updates, early = [], 0, 0, 0
    for index, (start, yaw, length) in enumerate(passes(walker, count)):
        model = RangeScan()
        settling = 2 * (parameters.tilt_count if parameters.sweep == "SAWTOOTH" else 1)
        first = index % settling
        sets_off = (first + settling + (index % 7) / 7) / rate
        last = math.floor((sets_off + walker.seconds(length)) * rate)
        latency = math.inf
        for number in range(first, last + 1):
            moving = max(number / rate - sets_off, 0.0)
            room.put(walker.boxes(start, yaw, moving))
            active = _reading(model, parameters, number, rate, room, index)
            if number / rate <= sets_off:
                early += active
            else:
                said += active
                updates += 1
                if active and latency == math.inf:
                    latency = moving
        latencies.append(latency)
    found = sorted(latency for latency in latencies if latency < math.inf)
    return {
        "detected": len(found) / len(latencies),
        "latency_s": found[len(found) // 2] if found else None,
        "latency_90_s": found[int(0.9 * (len(found) - 1))] if found else None,
        "said": said / max(updates, 1),
        # Updates with motion before the walker starts: false ones.
        "early": early,
    }


def _false_alarms(parameters: PirParameters, rate: float, quick: bool) -> float:
    """Return how often the output goes on in an hour of an empty room; 0 without noise."""
    if parameters.noise_sigma == 0.0:
        return 0.0
    room, model, before, alarms = Room(), RangeScan(), False, 0
    seconds = EMPTY_S / (60 if quick else 6)
    for number in range(int(seconds * rate)):
        active = _reading(model, parameters, number, rate, room, 1)
        alarms += active and not before
        before = active
    return alarms * 3600.0 / seconds


def measure_pyroelectric(quick: bool) -> dict[str, Any]:
    return {
        "error": _error(6 if quick else 12, quick),
        "cost": _cost(12 if quick else FRAMES, 1 if quick else 3),
        "models": _models(5 if quick else 20),
    }


def _pass(
    room: Room, walker: Walker, way: Any, parameters: PirParameters, rate: float
) -> tuple[list[Any], float]:
    """Return the readings of one pass, with rest before and after, and the latency (s)."""
    start, yaw, length = way
    detector, readings, latency = MotionDetector(), [], math.inf
    seconds = walker.seconds(length)
    for k in range(int((REST_BEFORE + seconds + REST_AFTER) * rate)):
        now = k / rate - REST_BEFORE
        room.put(walker.boxes(start, yaw, min(max(now, 0.0), seconds)))
        update = Update(k, k / rate, SENSOR, {RAYS: room.cast, WARMTH: room.warmth})
        readings.append(detector.update(parameters, update))
        if readings[-1].active:
            latency = min(latency, max(now, 0.0))
    return readings, latency


def _error(count: int, quick: bool) -> list[dict[str, Any]]:
    """Return the relative error of the peak signal, rms and worst over walks through the room."""
    walk, room = next(walker for walker in WALKERS if walker.name == "walk"), Room()

    def peaks(rays: int, rate: float) -> Array:
        parameters = replace(PYROELECTRIC, zone_rays=rays)
        runs = [_pass(room, walk, way, parameters, rate)[0] for way in passes(walk, count)]
        return np.array([max(abs(r.fields["signal"]) for r in readings) for readings in runs])

    exact, rows = peaks(DENSE_RAYS, DENSE_RATE), []
    chosen = QUICK_RAYS if quick else ZONE_RAYS
    for done, rays in enumerate(chosen):
        progress("pir_pyroelectric", done, len(chosen), f"error with {rays} rays a zone")
        for rate in QUICK_RATES if quick else RATES:
            error = peaks(rays, rate) / exact - 1
            rows.append({
                "zone_rays": rays, "rate": rate, "rms": rms(error), "mean": float(error.mean()),
                "worst": float(np.abs(error).max()), "walks": count,
            })  # fmt: skip
    return rows


def _cost(frames: int, rounds: int) -> list[dict[str, Any]]:
    """Return the milliseconds of processor time of an update in the sample home.

    The first second is left out.
    """
    scene = open_home()
    person = bpy.data.objects["Person"].angen_warmth
    person.use_temperature, person.temperature = True, 28.0
    for material in bpy.data.objects["Person"].data.materials:
        if "skin" in material.name:
            material.angen_warmth.use_temperature = True
            material.angen_warmth.temperature = 33.0
    sensors = sensors_of("PIR")
    rows = []
    for model, rays in (("RANGE_SCAN", 120), *(("PYROELECTRIC", r) for r in (4, 12, 48))):
        progress("pir_pyroelectric", len(rows), 4, f"cost of {model} in the home")
        for sensor in sensors:
            pir = sensor.settings.pir
            pir.model, pir.sweep = model, "ALL"
            pir.rays, pir.zone_rays = 120, rays
            sensor.settings.update_rate = 24.0
        runs = [_in_home(scene, sensors, frames) for _ in range(rounds)]
        rows.append({
            "model": model, "zone_rays": rays, "rays": 1080 if model == "RANGE_SCAN" else 42 * rays,
            "ms": spread([milliseconds for milliseconds, *_ in runs]), "updates": runs[0][1],
            "active": runs[0][2],
        })  # fmt: skip
    return rows


def _in_home(scene: Any, sensors: list[Any], frames: int) -> tuple[float, int, int]:
    """Return the milliseconds of an update, the number of updates, and of those with motion."""
    clock, probes = clock_of(scene), Probes(scene)
    runners = [SensorRunner(sensor, clock) for sensor in sensors]
    taken, updates, moved = 0.0, 0, 0
    first = FIRST - scene.frame_start
    for step in range(first - 24, first + frames):
        scene.frame_set(step + scene.frame_start)
        depsgraph = evaluated_depsgraph()
        probes.look(depsgraph, step)
        # Build the trees of moved solids outside of the time: all models share them.
        for solid in probes.caster.solids.solids:
            if solid.moving and np.isfinite(solid.geometry.lo).all():
                solid.geometry.tree(depsgraph)
        begin = time.process_time()
        for runner in runners:
            reading = single_update(runner, step, step, probes).reading()
            moved += reading.active and step >= first
        if step >= first:
            taken += time.process_time() - begin
            updates += len(runners)
    return taken / updates * 1e3, updates, moved


def _models(count: int) -> list[dict[str, Any]]:
    """Return shares of passes detected and median latencies of both models side by side."""
    models = (("thesis", THESIS, 10.0), ("all tilts", ALL, 10.0))
    models += (("pyroelectric", PYROELECTRIC, 24.0),)
    situations: list[tuple[str, Walker, float, float]] = [
        (w.name, w, CAT_CELSIUS if w.cat else PERSON_CELSIUS, ROOM_CELSIUS) for w in WALKERS
    ]
    walk = next(walker for walker in WALKERS if walker.name == "walk")
    situations += [
        ("walk, room of 28 °C", walk, 31.0, 28.0),
        ("walk, room of 31 °C", walk, 31.5, 31.0),
        ("walk of something as warm as the room", walk, ROOM_CELSIUS, ROOM_CELSIUS),
        ("walk at 0.1 m/s", replace(walk, speed=0.1), PERSON_CELSIUS, ROOM_CELSIUS),
    ]
    rows = []
    for done, (name, walker, *celsius) in enumerate(situations):
        progress("pir_pyroelectric", done, len(situations), name)
        row: dict[str, Any] = {"situation": name, "passes": count}
        for label, parameters, rate in models:
            room, ways = Room(*celsius), passes(walker, count)
            latencies = np.array([_pass(room, walker, w, parameters, rate)[1] for w in ways])
            seen = latencies[np.isfinite(latencies)]
            row[label] = {
                "detected": len(seen) / count,
                "latency_s": float(np.median(seen)) if len(seen) else None,
            }
        rows.append(row)
    return rows
