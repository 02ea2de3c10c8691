# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks.pir_pyroelectric [--quick]`: what the pyroelectric detector's error and
cost depend on, and where it and the range scan differ. Writes docs/data/pir_pyroelectric.json and
the tables of docs/pir.md; with --quick it prints them only.
"""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from angen_addon.standalone import load_extension

DOCS = Path(__file__).resolve().parent.parent / "docs"
DATA, PAGE = DOCS / "data" / "pir_pyroelectric.json", DOCS / "pir.md"
MARKERS = "<!-- {name}: python -m benchmarks.pir_pyroelectric -->", "<!-- end of {name} -->"
RAYS, RATES = (1, 2, 4, 8, 12, 24, 48), (60.0, 24.0, 10.0)
DENSE_RAYS, DENSE_RATE = 300, 120.0
ROOM_CELSIUS, ZERO = 20.0, 273.15
BODY_CELSIUS = {"cat": 27.0}
PERSON_CELSIUS = 29.0
REST_BEFORE, REST_AFTER = 1.0, 1.5
# Of the sample home: frames in which the person walks from the kitchen to the living room.
FIRST, FRAMES = 600, 48


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.pir_pyroelectric",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="less of it; writes no file")
    quick = parser.parse_args().quick
    extension = load_extension()
    extension.register()
    try:
        data = measure(quick)
    finally:
        extension.unregister()
    for name, text in tables(data).items():
        print(f"{name}\n{text}")
    if not quick:
        DATA.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
        PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), data), encoding="utf-8")


def measure(quick: bool) -> dict[str, Any]:
    from .common import machine

    return {
        "machine": machine(),
        "quick": quick,
        "error": measure_error(3 if quick else 12),
        "cost": measure_cost(12 if quick else FRAMES),
        "models": measure_models(3 if quick else 20),
    }


class Scene:
    """The furnished room of `benchmarks.walkers` with one who moves in it, as both models ask."""

    def __init__(self, walker: Any, way: tuple[Any, float, float], celsius: float, room: float):
        from .walkers import FURNITURE, WALLS, Boxes

        self._still = Boxes.upright((*WALLS, *FURNITURE))
        self._known: dict[int, tuple[Any, Any]] = {}
        self.walker, (self._start, self._yaw, self.length) = walker, way
        self.celsius, self.room = celsius, room
        self.time = 0.0

    def _ranges(self, bundle: int, origins: Any, directions: Any, reach: Any) -> tuple[Any, Any]:
        from .walkers import ranges_to

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
        from angen_sensors.sensor_logic.model import Emission

        room, body = self._ranges(bundle, origins, directions, reach)
        kelvin = np.where(body < room, self.celsius, self.room) + ZERO
        return Emission(kelvin, np.full(len(kelvin), 0.95), self.room + ZERO)


def run(scene: Scene, parameters: Any, rate: float) -> tuple[list[Any], float]:
    """Readings of one pass, with rest before and after; seconds until the first detection."""
    from angen_sensors.sensor_logic.model import Update
    from angen_sensors.sensor_logic.motion_detector import MotionDetector

    from .walkers import SENSOR

    detector, readings, latency = MotionDetector(), [], np.inf
    seconds = scene.walker.seconds(scene.length)
    for k in range(int((REST_BEFORE + seconds + REST_AFTER) * rate)):
        scene.time = k / rate - REST_BEFORE
        update = Update(
            k, k / rate, SENSOR, scene.cast, _none, _none, _none, _none, scene.warmth
        )  # fmt: skip
        readings.append(detector.update(parameters, update))
        if readings[-1].active:
            latency = min(latency, max(scene.time, 0.0))
    return readings, latency


def _none() -> Any:
    raise AssertionError("not asked for")


def peak(readings: list[Any]) -> float:
    return max(abs(reading.fields["signal"]) for reading in readings)


def pyroelectric() -> Any:
    from angen_sensors.sensor_logic.pir import PirParameters

    return PirParameters(model="PYROELECTRIC", range_max=5.0)


def measure_error(count: int) -> list[dict[str, Any]]:
    """Relative error of the peak signal, rms and worst over walks through the room."""
    from .walkers import WALKERS, passes

    walk = next(walker for walker in WALKERS if walker.name == "walk")
    scenes = [Scene(walk, way, PERSON_CELSIUS, ROOM_CELSIUS) for way in passes(walk, count)]
    dense = replace(pyroelectric(), zone_rays=DENSE_RAYS)
    exact = np.array([peak(run(scene, dense, DENSE_RATE)[0]) for scene in scenes])
    rows = []
    for rays in RAYS:
        for rate in RATES:
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


def measure_cost(frames: int) -> list[dict[str, Any]]:
    """Milliseconds of processor time an update of one detector in the sample home, after its first
    second."""
    import bpy
    from angen_sensors.angen_addon.probes import Probes
    from angen_sensors.angen_addon.sensors import all_sensors
    from angen_sensors.angen_addon.station import Station, clock_of, evaluated_depsgraph

    from .common import HOME

    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    person = bpy.data.objects["Person"].angen_warmth
    person.use_temperature, person.temperature = True, 28.0
    for material in bpy.data.objects["Person"].data.materials:
        if "skin" in material.name:
            material.angen_warmth.use_temperature = True
            material.angen_warmth.temperature = 33.0
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier == "PIR"]
    rows = []
    for model, rays in (("RANGE_SCAN", 120), *(("PYROELECTRIC", r) for r in (4, 12, 48))):
        for sensor in sensors:
            pir = sensor.settings.pir
            pir.model, pir.sweep = model, "ALL"
            pir.rays, pir.zone_rays = 120, rays
            sensor.settings.update_rate = 24.0
        clock, probes = clock_of(scene), Probes(scene)
        stations = [Station(sensor, clock) for sensor in sensors]
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
            for station in stations:
                reading = station.take(step, step, depsgraph, probes).reading()
                moved += reading.active and step >= first
            if step >= first:
                taken += time.process_time() - begin
                updates += len(stations)
        cast = 1080 if model == "RANGE_SCAN" else 42 * rays
        rows.append(
            {
                "model": model,
                "zone_rays": rays,
                "rays": cast,
                "ms": taken / updates * 1e3,
                "updates": updates,
                "active": moved,
            }
        )
    return rows


def measure_models(count: int) -> list[dict[str, Any]]:
    """Shares of passes detected, and the median latency, of the two models side by side."""
    from angen_sensors.sensor_logic.pir import PirParameters

    from .walkers import WALKERS, passes

    both: tuple[tuple[str, Any, float], ...] = (
        ("thesis", PirParameters(), 10.0),
        ("all tilts", PirParameters(sweep="ALL"), 10.0),
        ("pyroelectric", pyroelectric(), 24.0),
    )
    situations: list[tuple[str, Any, float, float]] = [
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
    for name, walker, celsius, room in situations:
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


def tables(data: dict[str, Any]) -> dict[str, str]:
    return {"error": _error(data), "cost": _cost(data), "models": _models(data)}


def _error(data: dict[str, Any]) -> str:
    from .tables import table

    by = {(row["zone_rays"], row["rate"]): row for row in data["error"]}
    rates = sorted({rate for _, rate in by}, reverse=True)
    rows = [
        [str(rays)]
        + [
            f"{by[rays, rate]['rms']:.1%} / {by[rays, rate]['mean']:+.1%}".replace("-", "−")
            for rate in rates
        ]
        for rays in sorted({rays for rays, _ in by})
    ]
    return table(["rays a zone", *(f"{rate:g} Hz: rms / mean" for rate in rates)], rows)


def _cost(data: dict[str, Any]) -> str:
    from .tables import table

    names = {"RANGE_SCAN": "range scan, all tilts", "PYROELECTRIC": "pyroelectric, {} rays a zone"}
    rows = [
        [names[row["model"]].format(row["zone_rays"]), str(row["rays"]), f"{row['ms']:.2f}"]
        for row in data["cost"]
    ]
    return table(["model", "rays", "ms an update"], rows)


def _models(data: dict[str, Any]) -> str:
    from .tables import table

    labels = ("thesis", "all tilts", "pyroelectric")
    rows = []
    for row in data["models"]:
        cells = [row["situation"]]
        for label in labels:
            late = row[label]["latency_s"]
            cells.append(f"{row[label]['detected']:.0%}" + (f", {late:.2f} s" if late else ""))
        rows.append(cells)
    return table(
        ["who moves", "range scan (thesis)", "range scan, all tilts", "pyroelectric"], rows
    )


def filled(page: str, data: dict[str, Any]) -> str:
    """The page with its tables made anew."""
    for name, text in tables(data).items():
        begin, end = (marker.format(name=name) for marker in MARKERS)
        made: Callable[[re.Match[str]], str] = lambda _, b=begin, t=text, e=end: f"{b}\n{t}{e}"  # noqa: E731
        page = re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", made, page, flags=re.DOTALL)
    return page


if __name__ == "__main__":
    main()
