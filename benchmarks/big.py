# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks.big [--millions 1 3 10] [--only NAME …]`: what large scenes cost.

Seven motion detectors hang in a hall of 30 × 30 m whose hilly ground has so many millions of
triangles: as one mesh, of triangles or of quads, as 1000 meshes, as 1000 objects of one mesh, and
as 1000 instances of one collection; or as one mesh that changes at every frame. A box walks
through. Each scene has a process of its own. Told are seconds, and MB of memory at most beside what
Blender itself takes for the scene: for the start of a run (a run of its first frame alone), for one
of 48 frames, for the digest of the scene that a recording keeps, and for all together. Then the
parts of a start by themselves: to list and read the surfaces, to cast the rays of seven detectors
with all tilts, which builds the trees that they need, and to cast as many again.
"""

from __future__ import annotations

import argparse
import gc
import json
import math
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SIZE_M = 30.0
TILES = 32
FRAMES = 48
COLUMNS = (
    "Blender s",
    "Blender MB",
    "start s",
    "start MB",
    "48 frames s",
    "keep s",
    "all MB",
    "events",
    "list s",
    "first rays s",
    "more rays s",
)


def hills(triangles: int, size: float, at: tuple[float, float] = (0.0, 0.0), sides: int = 3) -> Any:
    """A mesh of hilly ground of about so many triangles, as faces of 3 or 4 sides."""
    import bpy

    side = max(2, math.isqrt(triangles // 2) + 1)
    axis = np.linspace(-size / 2, size / 2, side, dtype=np.float32)
    x, y = (grid.ravel() for grid in np.meshgrid(axis, axis))
    far_x, far_y = x + at[0], y + at[1]
    z = 0.2 * np.sin(2.1 * far_x) * np.cos(1.7 * far_y) + 0.02 * np.sin(40 * far_x + 31 * far_y)
    mesh = bpy.data.meshes.new("hills")
    mesh.vertices.add(len(x))
    mesh.vertices.foreach_set("co", np.stack([x, y, z], 1).astype(np.float32).ravel())
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    around = (0, 1, side + 1, side) if sides == 4 else (0, 1, side + 1, 0, side + 1, side)
    corners = np.stack([first + corner for corner in around], 1)
    count = corners.size // sides
    mesh.loops.add(corners.size)
    mesh.loops.foreach_set("vertex_index", corners.ravel().astype(np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, corners.size, sides, dtype=np.int32))
    mesh.update()
    return mesh


def one_mesh(triangles: int) -> None:
    _link("ground", hills(triangles, SIZE_M))


def one_of_quads(triangles: int) -> None:
    _link("ground", hills(triangles, SIZE_M, sides=4))


def many_meshes(triangles: int) -> None:
    for number, at in enumerate(_tiles()):
        mesh = hills(triangles // TILES**2, SIZE_M / TILES, at)
        _link(f"tile {number}", mesh).location = (*at, 0)


def one_shared(triangles: int) -> None:
    mesh = hills(triangles // TILES**2, SIZE_M / TILES)
    for number, at in enumerate(_tiles()):
        _link(f"tile {number}", mesh).location = (*at, 0)


def instances(triangles: int) -> None:
    import bpy

    collection = bpy.data.collections.new("tile")
    mesh = hills(triangles // TILES**2, SIZE_M / TILES)
    collection.objects.link(bpy.data.objects.new("tile", mesh))
    for number, at in enumerate(_tiles()):
        holder = _link(f"tile {number}", None)
        holder.location = (*at, 0)
        holder.instance_type, holder.instance_collection = "COLLECTION", collection


def one_that_bends(triangles: int) -> None:
    """Its ground heaves by a shape key."""
    ground = _link("ground", hills(triangles, SIZE_M))
    ground.shape_key_add(name="flat")
    high = ground.shape_key_add(name="high")
    points = np.empty(3 * len(ground.data.vertices), np.float32)
    ground.data.vertices.foreach_get("co", points)
    points[2::3] += 0.2
    high.data.foreach_set("co", points)
    for frame, value in ((1, 0.0), (FRAMES, 1.0)):
        high.value = value
        high.keyframe_insert("value", frame=frame)


SCENES: dict[str, Callable[[int], None]] = {
    "one mesh": one_mesh,
    "one mesh of quads": one_of_quads,
    "1000 meshes": many_meshes,
    "1000 objects of a mesh": one_shared,
    "1000 instances": instances,
    "one mesh that bends": one_that_bends,
}


def _tiles() -> list[tuple[float, float]]:
    step = SIZE_M / TILES
    at = (np.arange(TILES) + 0.5) * step - SIZE_M / 2
    return [(float(x), float(y)) for x in at for y in at]


def _link(name: str, data: Any) -> Any:
    import bpy

    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _furnish() -> None:
    """Seven detectors, 2.2 m up, and a box that walks past them."""
    import bpy

    for number in range(7):
        pir = _link(f"PIR {number}", None)
        pir.location = (4.0 * number - 12.0, 2.0 * (number % 3), 2.2)
        pir.rotation_euler = (math.pi / 2, 0, number)
        pir.angen_sensor.kind = "PIR"
        pir.angen_sensor.pir.range_max = 7.0
        pir.angen_sensor.pir.sweep = "ALL"
    mesh = bpy.data.meshes.new("walker")
    corners = [(x, y, z) for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (0, 1.7)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    walker = _link("walker", mesh)
    for frame, x in ((1, -14.0), (240, 14.0)):
        walker.location = (x, 1.0, 0.2)
        walker.keyframe_insert("location", frame=frame)


def measure(name: str, triangles: int) -> dict[str, float]:
    """What one scene costs in this process."""
    import bpy

    from angen_addon.process.standalone import PACKAGE, load_extension

    load_extension().register()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    SCENES[name](triangles)
    bpy.context.scene.angen_live = False
    _furnish()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    started = time.perf_counter()
    bpy.context.view_layer.update()
    scene.frame_set(1)
    blender_s = time.perf_counter() - started
    _forget_peak()
    before = _memory()

    def part(module: str) -> Any:
        return import_module(f"{PACKAGE}.{module}")

    sensors = part("angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
    simulate = part("angen_addon.runtime.simulation").simulate
    spent = []
    for last in (1, FRAMES):
        recording = part("sensor_logic.recording.tracks").Recording()
        started = time.perf_counter()
        for _ in simulate(scene, sensors, 1, last, recording):
            pass
        spent.append(time.perf_counter() - started)
        if last == 1:
            start_mb = _memory(peak=True) - before
    started = time.perf_counter()
    part("angen_addon.recording.stored_recording").stored_run(
        recording, scene, bpy.context.evaluated_depsgraph_get()
    )
    keep_s = time.perf_counter() - started
    events = part("sensor_logic.log").events(recording)
    found = [blender_s, before, spent[0], start_mb, spent[1], keep_s]
    found += [_memory(peak=True) - before, len(events)]
    found += _ray_parts(part("angen_addon.scene.rays.caster").RayCaster())
    return dict(zip(COLUMNS, found, strict=True))


def _ray_parts(caster: Any) -> list[float]:
    """Seconds to list the scene's surfaces, for the rays of seven detectors with all tilts, and
    for the same rays turned a little."""
    import bpy

    depsgraph = bpy.context.evaluated_depsgraph_get()
    started = time.perf_counter()
    caster.update(depsgraph)
    found = [time.perf_counter() - started]
    fan, tilts = np.linspace(-60.0, 60.0, 120), np.arange(0.0, 90.0, 10.0)
    azimuth, below = np.meshgrid(np.radians(fan), np.radians(tilts))
    for turn in (0.0, 0.001):
        started = time.perf_counter()
        for number in range(7):
            around = azimuth.ravel() + number + turn
            level, down = np.cos(below.ravel()), np.sin(below.ravel())
            ways = np.stack([level * np.sin(around), level * np.cos(around), -down], 1)
            origins = np.tile((4.0 * number - 12.0, 2.0 * (number % 3), 2.2), (len(ways), 1))
            caster.cast(0, number, origins, ways, np.full(len(ways), 7.0))
        found.append(time.perf_counter() - started)
    return found


def _memory(peak: bool = False) -> float:
    """MB of memory that this process has now, or has had at most since `_forget_peak`."""
    name = "VmHWM:" if peak else "VmRSS:"
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name)) / 1024


def _forget_peak() -> None:
    """What the building of the scene took at most does not count."""
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.big",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--millions", type=float, nargs="+", default=[1, 3, 10])
    parser.add_argument("--only", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--measure", nargs=2, metavar=("NAME", "TRIANGLES"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        found = measure(options.measure[0], int(options.measure[1]))
        print(f"\n{json.dumps(found)}", flush=True)
        return
    print("| triangles | as | " + " | ".join(COLUMNS) + " |")
    print("|---|---|" + "--:|" * len(COLUMNS))
    for millions in options.millions:
        for name in options.only:
            command = [sys.executable, "-m", "benchmarks.big", "--measure", name]
            done = subprocess.run(
                [*command, str(int(millions * 1e6))], cwd=ROOT, capture_output=True, text=True
            )
            if done.returncode:
                raise SystemExit(done.stderr)
            found = json.loads(done.stdout.splitlines()[-1])
            cells = [f"{value:.4g}" for value in found.values()]
            print(f"| {millions:g} million | {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
