# SPDX-License-Identifier: GPL-3.0-or-later
"""What a range-scanning motion detector finds, by its settings, of who moves in its room.

The model under test is the product's own (`RangeScan`), its rays are met in closed form.
Every setting sees the same passes of the same walkers.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan
from angen_sensors.sensor_logic.model import Update

from .progress import progress
from .walkers import FURNITURE, SENSOR, WALKERS, WALLS, Boxes, Walker, passes, ranges_to

Array = np.typing.NDArray[np.float64]
THESIS = PirParameters()
THESIS_RATE = 10.0
DEGREE = math.pi / 180
# Every ray of this one looks at every update, 1.5° apart up and down, 0.2° aside.
DENSE = replace(THESIS, rays=600, vertical_step=1.5 * DEGREE, sweep="ALL")
ALL = replace(THESIS, sweep="ALL")
RECOMMENDED = replace(THESIS, rays=160, vertical_step=5 * DEGREE, sweep="ALL")
Setting = tuple[str, str, PirParameters, float]
# Seconds of an empty room in which noise has the chance to raise an alarm.
EMPTY_S = 3600.0


def settings(quick: bool) -> list[Setting]:
    """Group, name, parameters, update rate in Hz; each group changes one thing."""
    found: list[Setting] = [
        ("chosen", "dense reference", DENSE, THESIS_RATE),
        ("chosen", "thesis", THESIS, THESIS_RATE),
        ("chosen", "thesis, all tilts", ALL, THESIS_RATE),
        ("chosen", "recommended", RECOMMENDED, THESIS_RATE),
    ]
    quiet: Setting = _above_noise(0.01)
    if quick:
        return [*found, quiet]
    for rays in (20, 40, 80, 120, 160, 320, 640):
        found.append(("rays, saw-tooth", f"{rays}", replace(THESIS, rays=rays), THESIS_RATE))
    for rays in (20, 40, 80, 120, 160, 320, 640):
        found.append(("rays, all tilts", f"{rays}", replace(ALL, rays=rays), THESIS_RATE))
    for step in (2.5, 5.0, 10.0, 22.5, 45.0):
        for sweep in ("SAWTOOTH", "ALL"):
            changed = replace(THESIS, sweep=sweep, vertical_step=step * DEGREE)
            name = "saw-tooth" if sweep == "SAWTOOTH" else "all tilts"
            found.append((f"tilt step, {name}", f"{step:g}°", changed, THESIS_RATE))
    for rate in (2.0, 5.0, 10.0, 20.0, 60.0):
        found.append(("update rate, saw-tooth", f"{rate:g} Hz", THESIS, rate))
    for rate in (2.0, 5.0, 10.0, 20.0):
        found.append(("update rate, all tilts", f"{rate:g} Hz", ALL, rate))
    for threshold in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5):
        changed = replace(ALL, threshold=threshold)
        found.append(("threshold, all tilts", f"{threshold:g} m", changed, THESIS_RATE))
    for sigma in (0.002, 0.005, 0.01, 0.02):
        changed = replace(ALL, noise_sigma=sigma)
        found.append(("noise at 0.05 m, all tilts", f"{sigma:g} m", changed, THESIS_RATE))
    return [*found, quiet, _above_noise(0.02)]


def _above_noise(sigma: float) -> Setting:
    """A threshold of seven standard deviations of a difference of two ranges."""
    changed = replace(ALL, noise_sigma=sigma, threshold=7 * math.sqrt(2) * sigma)
    name = f"{sigma:g} m, {changed.threshold:.3g} m"
    return "noise and a threshold of 7 σ√2, all tilts", name, changed, THESIS_RATE


def measure(quick: bool) -> dict[str, Any]:
    count = 10 if quick else 40
    rows = []
    chosen = settings(quick)
    for done, (group, name, parameters, rate) in enumerate(chosen):
        progress("pir", done, len(chosen), f"{group}: {name}")
        begin = time.perf_counter()
        row: dict[str, Any] = {
            "group": group,
            "name": name,
            "rays_a_second": parameters.rays * rate * _tilts_an_update(parameters),
            "walkers": {w.name: _seen(w, parameters, rate, count) for w in WALKERS},
            "false_alarms_an_hour": _false_alarms(parameters, rate, quick),
        }
        row["seconds"] = time.perf_counter() - begin
        rows.append(row)
    return {"passes": count, "rows": rows, "least_share": least_share(count)}


def least_share(count: int) -> float:
    """Below what a share is with 2.5 % chance, when all of `count` passes were seen (exact)."""
    return float(0.025 ** (1.0 / count))


def _tilts_an_update(parameters: PirParameters) -> int:
    return parameters.tilt_count if parameters.sweep == "ALL" else 1


class _Room:
    """Rays against the room, remembered by bundle, and against whoever is in it."""

    def __init__(self) -> None:
        self._still = Boxes.upright((*WALLS, *FURNITURE))
        self._known: dict[tuple[int, int], Array] = {}
        self._body: Boxes | None = None
        self._met: dict[tuple[int, int], Array] = {}

    def put(self, body: Boxes) -> None:
        """Who is there now. Somebody who stands as before is not met anew."""
        if self._body is None or not body.same_as(self._body):
            self._body, self._met = body, {}

    def cast(self, bundle: int, origins: Array, directions: Array, reach: Array) -> Array:
        key = (bundle, len(reach))
        if key not in self._known:
            found = reach.copy()
            for i in range(len(self._still.half)):
                one = Boxes(*(a[i : i + 1] for a in vars(self._still).values()))
                found = ranges_to(one, origins, directions, found)
            self._known[key] = found
        if self._body is None:
            return self._known[key]
        if key not in self._met:
            self._met[key] = ranges_to(self._body, origins, directions, self._known[key])
        return self._met[key]


def _reading(
    model: RangeScan, parameters: PirParameters, number: int, rate: float, room: _Room, seed: int
) -> bool:
    def noise() -> np.random.Generator:
        return np.random.default_rng((seed, number))

    update = Update(number, number / rate, SENSOR, {RAYS: room.cast}, noise, noise)
    return model.update(parameters, update).active


def _seen(walker: Walker, parameters: PirParameters, rate: float, count: int) -> dict[str, Any]:
    """Share of the passes detected, and how long after it set off; a pass begins with a body that
    stands still until every tilt was scanned twice, at another phase of the sweep each time."""
    room = _Room()
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
        # Updates that said so while nothing moved yet: by noise, or falsely.
        "early": early,
    }


def _false_alarms(parameters: PirParameters, rate: float, quick: bool) -> float:
    """How often the output goes on in an hour of an empty room; without noise nothing changes."""
    if parameters.noise_sigma == 0.0:
        return 0.0
    room, model, before, alarms = _Room(), RangeScan(), False, 0
    seconds = EMPTY_S / (60 if quick else 6)
    for number in range(int(seconds * rate)):
        active = _reading(model, parameters, number, rate, room, 1)
        alarms += active and not before
        before = active
    return alarms * 3600.0 / seconds
