# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the light sensor's speed against its error, and compare Cycles with Radiance.

python -m benchmarks.light [--quick] [--only PART] [--beside CHECKOUT] [--page]

Writes docs/light_benchmarks.md, .json and .svg. With --beside, the error and processor time of a
run are also measured with the code of another checkout, such as an older one (`git worktree add
../former COMMIT`). The exit status is 1 if the error of a run breaks its bound.

The errors of an update are relative to a reference with so many light paths that its own noise,
which the table gives too, is far smaller. The errors of a run are taken at random frames of the
story, by several seeds, relative to far more light paths by other seeds without the reference. The
noise of these is given too, and subtracted from the rms. Seconds are those of one update in each
second of the story.
"""

from __future__ import annotations

import argparse
import json
import platform
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from angen_addon.process.standalone import load_extension

EXTENSION = load_extension()
from angen_sensors.angen_addon.scene.light import engine, probe  # noqa: E402
from angen_sensors.angen_addon.scene.light.changes import LightChanges  # noqa: E402
from angen_sensors.angen_addon.scene.light.cycles import CyclesLight  # noqa: E402
from angen_sensors.angen_addon.scene.light.probe import LightRequest  # noqa: E402

from . import page  # noqa: E402
from .bounds import broken  # noqa: E402
from .common import ROOT, has, open_home, progress, rms, spread  # noqa: E402

DATA = page.DOCS / "light_benchmarks.json"
METHODS = ("FOUR_WALL", "ILLUMINANCE")
# Each takes some minutes.
PARTS = (*reversed(METHODS), "plane", "run", "radiance")
REFERENCE, RADIANCE, TRUE_RUN = 65_536, 131_072, 32_768
# At noon of the story: several lamps are on, and the sun shines.
FRAME = 1500
REFERENCE_SEEDS = 3
SAMPLES = (256, 1024, 4096, 16384)
COUNTS = (1, 7, 50)
# Timed without errors: a reading does not depend on the other sensors.
MANY, MANY_SAMPLES = 500, 1024
# Far clip planes in m (the thesis's sensor has 5), and light paths of a timed update.
PLANES, TIMED = (1.0, 2.0, 5.0, 10.0), 1024
# Light paths of an update and of the reference; the home has the last pair. BESIDE is the pair with
# which the other checkout is measured.
WAYS = ((1024, 0), (64, 16_384), (128, 32_768), (256, 32_768))
BESIDE = (256, 16_384)
SEEDS, TRUE_SEEDS = 4, 4
# Frames of the story, step between timed frames, and number of frames whose errors are measured.
FRAMES, STEP, MOMENTS = 4120, 24, 12


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.light", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer light paths; writes no file")
    parser.add_argument("--only", choices=PARTS, help="this part; the others as last measured")
    parser.add_argument("--beside", type=Path, help="another checkout, measured in turns")
    parser.add_argument("--page", action="store_true", help="write the pages from the last data")
    parser.add_argument("--story", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    quick, parts = arguments.quick, (arguments.only,) if arguments.only else PARTS
    if arguments.story:
        print("\n" + json.dumps(story(**json.loads(arguments.story))), flush=True)
        return
    data: dict[str, Any] = json.loads(DATA.read_text()) if DATA.exists() and not quick else {}
    machine = f"{platform.processor() or platform.machine()}, Blender {bpy.app.version_string}"
    EXTENSION.register()
    try:
        for part in () if arguments.page else parts:
            if part != "radiance" or has("pyradiance"):
                data[part] = {"machine": machine, **measured(part, quick, arguments.beside)}
    finally:
        EXTENSION.unregister()
    print(page.text_of("light", data))
    if not quick:
        DATA.write_text(json.dumps(data, indent=1) + "\n")
        page.write_light(data)
    if "run" in parts:
        sys.exit("\n".join(broken("light", data)) or None)


def measured(part: str, quick: bool, beside: Path | None) -> dict[str, Any]:
    if part == "run":
        return measure_run(TRUE_RUN // 16 if quick else TRUE_RUN, quick, beside)
    if part == "plane":
        return measure_plane(quick)
    if part == "radiance":
        from . import radiance

        return radiance.measure(1024 if quick else RADIANCE)
    return measure_speed(part, 4096 if quick else REFERENCE, 1 if quick else 3)


def requests_of(method: str, samples: int, count: int = 7, **other: Any) -> list[LightRequest]:
    """Return the requests of the home's light sensors, in the order of their names.

    Requests beyond the number of sensors repeat them, a bit lower and turned.
    """
    objects = bpy.context.scene.objects
    sensors = sorted((o for o in objects if o.angen_sensor.kind == "LIGHT"), key=lambda o: o.name)
    found = []
    for number in range(count):
        obj, turn = sensors[number % len(sensors)], number // len(sensors) * 0.7
        pose = np.array(obj.matrix_world, np.float64)
        x, z = pose[:3, 0].copy(), pose[:3, 2].copy()
        pose[:3, 0] = np.cos(turn) * x - np.sin(turn) * z
        pose[:3, 2] = np.sin(turn) * x + np.cos(turn) * z
        pose[2, 3] -= 0.1 * (number // len(sensors))
        name = obj.name if number < len(sensors) else f"Light sensor {number:02d}"
        options = {"samples": samples, "exposure": obj.angen_sensor.light.exposure, **other}
        found.append(LightRequest(name, pose, method, **options))
    return found


def values_of(requests: Sequence[LightRequest], kept: CyclesLight | None = None) -> Any:
    """Return the readings, each in the unit of its method."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    found = probe.measure(scene, layer, requests, kept=kept)
    read = [(s.illuminance_lux, s.luminance_percent) for s in (found[r.name] for r in requests)]
    return np.array([lux if percent is None else percent for lux, percent in read], np.float64)


def measure_speed(method: str, reference_samples: int, rounds: int) -> dict[str, Any]:
    """Return a row for each number of samples and of sensors, by one method."""
    scene = open_home()
    scene.frame_set(FRAME)
    requests = requests_of(method, reference_samples, max(COUNTS))
    true, noise = _reference(requests)
    rows = []
    for samples in SAMPLES:
        for count in COUNTS:
            progress(f"light, {method}", len(rows), len(SAMPLES) * len(COUNTS), f"{samples} paths")
            part = [replace(request, samples=samples) for request in requests[:count]]
            found, cost = _timed(part, rounds)
            error = np.abs(found / true[:count] - 1.0)
            figures = {"rms": rms(error), "median": float(np.median(error))}
            figures |= {"worst": float(error.max()), "reference_noise": noise}
            row = {"method": method, "samples": samples, "sensors": count}
            rows.append({**row, "ms_a_sensor": cost / count, **figures})
    _, cost = _timed(requests_of(method, MANY_SAMPLES, MANY), rounds)
    many = {"sensors": MANY, "samples": MANY_SAMPLES, "ms_a_sensor": cost / MANY}
    figures = {"static_ms": _static_ms(), "reference_samples": reference_samples}
    return {"rows": rows, "many": many, **figures}


def _timed(requests: Sequence[LightRequest], rounds: int) -> tuple[Any, float]:
    """Return the readings, and the milliseconds of a further update after the person moved."""
    scene, kept, costs = bpy.context.scene, CyclesLight(), []
    values = values_of(requests, kept)
    for number in range(rounds):
        scene.frame_set(FRAME + 1 + number)
        start = time.perf_counter()
        values_of(requests, kept)
        costs.append(time.perf_counter() - start)
    kept.close()
    scene.frame_set(FRAME)
    return values, float(np.median(costs)) * 1000.0


def _reference(requests: Sequence[LightRequest]) -> tuple[Any, float]:
    """Return the means over seeds, and their relative noise (median over the sensors)."""
    seed, found = engine.SEED, []
    try:
        for engine.SEED in range(1000, 1000 + REFERENCE_SEEDS):
            found.append(values_of(requests))
    finally:
        engine.SEED = seed
    mean = np.maximum(np.mean(found, axis=0), 1e-9)
    noise = np.std(found, axis=0, ddof=1) / np.sqrt(REFERENCE_SEEDS)
    return mean, float(np.median(noise / mean))


def _static_ms() -> float:
    """Return the milliseconds in which `LightChanges` finds that nothing has changed."""
    changes, layer = LightChanges(), bpy.context.view_layer
    depsgraph = bpy.context.evaluated_depsgraph_get()
    state = changes.look(layer, depsgraph)
    start = time.perf_counter()
    for _ in range(50):
        assert changes.look(layer, depsgraph) == state
    return (time.perf_counter() - start) / 50 * 1000.0


def measure_plane(quick: bool) -> dict[str, Any]:
    """Return cost and reading of four walls by the distance of the far clip plane.

    All planes take turns, so that a busy moment of the machine spreads over all of them.
    """
    exact = TIMED if quick else REFERENCE
    scene = open_home()
    scene.frame_set(FRAME)
    rows, turns = [], []
    for plane in PLANES:
        requests = requests_of("FOUR_WALL", exact, clip_end=plane)
        ended = sum(
            _is_clipped_by_surface(request, way) for request in requests for way in _views(request)
        )
        names = [request.name for request in requests]
        percent = dict(zip(names, values_of(requests).tolist(), strict=True))
        rows.append({"far_m": plane, "views": 4 * len(names), "ended": ended, "percent": percent})
        timed = [replace(request, samples=TIMED) for request in requests]
        turns.append((timed, CyclesLight(), []))
    for turn in range((2 if quick else 15) + 1):
        scene.frame_set(FRAME + turn)
        for requests, kept, times in turns:
            start = time.perf_counter()
            values_of(requests, kept)
            # The first update fills the caches of later ones.
            if turn:
                times.append((time.perf_counter() - start) * 1000.0 / len(requests))
    for row, (_, kept, times) in zip(rows, turns, strict=True):
        row["ms_a_sensor"] = spread(times)
        kept.close()
    return {"rows": rows, "samples": TIMED, "exact": exact}


def _views(request: LightRequest) -> list[Any]:
    """Return unit vectors (3,) along the centres of the four views: −Z, −X, +Z, +X."""
    x, z = request.matrix[:3, 0], request.matrix[:3, 2]
    return [-z, -x, z, x]


def _is_clipped_by_surface(request: LightRequest, way: Any) -> bool:
    """Return whether Blender's own ray hits something between both clip planes."""
    start = Vector(request.matrix[:3, 3] + request.clip_start * way)
    reach = request.clip_end - request.clip_start
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return bool(bpy.context.scene.ray_cast(depsgraph, start, Vector(way), distance=reach)[0])


def measure_run(paths: int, quick: bool, beside: Path | None = None) -> dict[str, Any]:
    """Return a row for each method and pair of light paths, compared with `paths` light paths."""
    ways, seeds = (WAYS[-1:], 1) if quick else (WAYS, SEEDS)
    cases = [("this", ROOT, way) for way in ways]
    cases += [("beside", beside.resolve(), BESIDE)] if beside else []
    # A random frame from each of equal parts of the story.
    edges = np.linspace(1, FRAMES + 1, (2 if quick else MOMENTS) + 1).astype(int).tolist()
    drawn = np.random.default_rng(1)
    at = [int(drawn.integers(*part)) for part in pairwise(edges)]
    timed = at if quick else list(range(1, FRAMES + 1, STEP))
    rows = []
    for method in METHODS:
        known = range(2000, 2000 + TRUE_SEEDS)
        found = np.array([run["values"] for run in _story(ROOT, method, paths, 0, known, at)])
        true = np.maximum(found.mean(axis=0), 1e-9)
        noise = found.std(axis=0, ddof=1) / np.sqrt(TRUE_SEEDS) / true
        for code, root, way in cases:
            progress("light of a run", len(rows), len(METHODS) * len(cases), f"{method} {code}")
            found = np.array([r["values"] for r in _story(root, method, *way, range(seeds), at)])
            figures = {"method": method, "code": code, "samples": way[0], "reference": way[1]}
            rows.append(figures | _errors(found / true - 1.0, noise))
        for row, (_, root, way) in zip(rows[-len(cases) :], cases, strict=True):
            (run,) = _story(root, method, *way, range(1), timed)
            row["ms_a_sensor"] = 1000.0 * run["wall_s"] / (true.shape[1] * len(timed))
            row |= {"cpu_s": run["cpu_s"], "to_bare": run["cpu_s"] / run["bare_s"]}
    figures = {"updates": len(timed), "moments": len(at), "paths": paths, "seeds": seeds}
    return {"rows": rows, **figures, "true_seeds": TRUE_SEEDS, "quick": quick}


def _errors(error: Any, noise: Any) -> dict[str, Any]:
    """Return the statistics of relative errors (seeds, moments, sensors).

    `noise` (moments, sensors) is the relative error of the true values, and is subtracted from the
    rms. The standard error of the rms is that over seeds. The rms of each sensor is given too.
    """
    of_seeds = np.mean(error**2, axis=(1, 2)) - np.mean(noise**2)
    square, count = max(float(of_seeds.mean()), 0.0), len(of_seeds)
    off = float(of_seeds.std(ddof=1)) / np.sqrt(count) if count > 1 else None
    sensors = np.mean(error**2, axis=(0, 1)) - np.mean(noise**2, axis=0)
    return {
        "rms": float(np.sqrt(square)),
        "rms_error": off / (2.0 * np.sqrt(square)) if off and square else None,
        "median": float(np.median(np.abs(error))), "worst": float(np.abs(error).max()),
        "noise_rms": rms(noise), "rms_of_sensors": np.sqrt(np.maximum(sensors, 0.0)).tolist(),
    }  # fmt: skip


def _story(
    root: Path, method: str, samples: int, reference: int, seeds: range, frames: list[int]
) -> list[dict[str, Any]]:
    """Return the results of `story` for each seed, by the code of a checkout in its own process."""
    job = {"method": method, "samples": samples, "reference": reference, "frames": frames}
    text = json.dumps({**job, "seeds": list(seeds)})
    # The benchmarks are from this checkout, the extension from the other one.
    code = f"import sys, benchmarks; sys.path.insert(0, {str(root)!r}); "
    code += "from benchmarks.light import main; main()"
    command = [sys.executable, "-c", code, "--story", text]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{root}, {text}: {done.stderr.strip() or done.stdout[-500:]}")
    found: list[dict[str, Any]] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def story(
    method: str, samples: int, reference: int, seeds: list[int], frames: list[int]
) -> list[dict[str, Any]]:
    """Return the light readings of the Ängen home at frames of its story, for each seed.

    `values` has shape (frames, sensors). `cpu_s` and `wall_s` are the seconds of all frames;
    `bare_s` are those that Blender took to evaluate the frames.
    """
    EXTENSION.register()
    scene, found = open_home(), []
    requests = requests_of(method, samples)
    for engine.SEED in seeds:
        lights, values, bare = CyclesLight(reference), [], 0.0
        cpu, wall = time.process_time(), time.perf_counter()
        for frame in frames:
            before = time.process_time()
            scene.frame_set(frame)
            bare += time.process_time() - before
            values.append(values_of(requests, lights).tolist())
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        lights.close()
        found.append({"values": values, "cpu_s": cpu, "wall_s": wall, "bare_s": bare})
    return found


if __name__ == "__main__":
    main()
