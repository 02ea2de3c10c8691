# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what large scenes cost.

python -m benchmarks.big [--millions 1 3 10] [--only NAME …]

Seven motion detectors hang in a hall of 30 × 30 m, and a box walks through it. The hilly ground has
the given number of millions of triangles: as one mesh (of triangles or of quads), as 1000 meshes,
as 1000 objects of one mesh, as 1000 instances of one collection, or as one mesh that changes at
every frame. Each scene is measured in its own process.

The table has seconds, and the peak of memory (MB) in addition to what Blender takes for the scene:
for the start of a run (a run of its first frame), for a run of 48 frames, for the digest of the
scene that a recording keeps, and for all together.
"""

from __future__ import annotations

import argparse
import gc
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from .common import apart, box_mesh, link, memory_mib, new_scene, run, sensors_of

SIZE_M = 30.0
TILES = 32
FRAMES = 48
COLUMNS = ("Blender s", "Blender MB", "start s", "start MB", "48 frames s", "keep s", "all MB")


def hills(triangles: int, size: float, at: tuple[float, float] = (0.0, 0.0), sides: int = 3) -> Any:
    """Return a mesh of hilly ground of about `triangles` triangles, with faces of 3 or 4 sides."""
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
    mesh.loops.add(corners.size)
    mesh.loops.foreach_set("vertex_index", corners.ravel().astype(np.int32))
    mesh.polygons.add(corners.size // sides)
    mesh.polygons.foreach_set("loop_start", np.arange(0, corners.size, sides, dtype=np.int32))
    mesh.update()
    return mesh


def _tiles() -> list[tuple[float, float]]:
    """Return the centres (x, y) of the tiles of the ground, in metres."""
    at = ((np.arange(TILES) + 0.5) * SIZE_M / TILES - SIZE_M / 2).tolist()
    return [(x, y) for x in at for y in at]


def many_meshes(triangles: int) -> None:
    for x, y in _tiles():
        link("tile", hills(triangles // TILES**2, SIZE_M / TILES, (x, y)), (x, y, 0))


def one_shared(triangles: int) -> None:
    mesh = hills(triangles // TILES**2, SIZE_M / TILES)
    for x, y in _tiles():
        link("tile", mesh, (x, y, 0))


def instances(triangles: int) -> None:
    collection = bpy.data.collections.new("tile")
    mesh = hills(triangles // TILES**2, SIZE_M / TILES)
    collection.objects.link(bpy.data.objects.new("tile", mesh))
    for x, y in _tiles():
        holder = link("tile", None, (x, y, 0))
        holder.instance_type, holder.instance_collection = "COLLECTION", collection


def one_that_bends(triangles: int) -> None:
    """Add a ground whose shape key raises it over the frames."""
    ground = link("ground", hills(triangles, SIZE_M))
    ground.shape_key_add(name="flat")
    high = ground.shape_key_add(name="high")
    points = np.empty(3 * len(ground.data.vertices), np.float32)
    ground.data.vertices.foreach_get("co", points)
    points[2::3] += 0.2
    high.data.foreach_set("co", points)
    for frame, value in ((1, 0.0), (FRAMES, 1.0)):
        high.value = value
        high.keyframe_insert("value", frame=frame)


SCENES: dict[str, Callable[[int], Any]] = {
    "one mesh": lambda triangles: link("ground", hills(triangles, SIZE_M)),
    "one mesh of quads": lambda triangles: link("ground", hills(triangles, SIZE_M, sides=4)),
    "1000 meshes": many_meshes,
    "1000 objects of a mesh": one_shared,
    "1000 instances": instances,
    "one mesh that bends": one_that_bends,
}


def _furnish() -> None:
    """Add seven detectors, 2.2 m up, and a box that walks past them."""
    for number in range(7):
        pir = link(f"PIR {number}", None, (4.0 * number - 12.0, 2.0 * (number % 3), 2.2))
        pir.rotation_euler = (math.pi / 2, 0, number)
        pir.angen_sensor.kind = "PIR"
        pir.angen_sensor.pir.range_max, pir.angen_sensor.pir.sweep = 7.0, "ALL"
    walker = link("walker", box_mesh([((0.2, 0.2, 0.85), (0, 0, 0.85))]))
    for frame, x in ((1, -14.0), (240, 14.0)):
        walker.location = (x, 1.0, 0.2)
        walker.keyframe_insert("location", frame=frame)


def measure(name: str, triangles: int) -> list[float]:
    """Return what one scene costs in this process, in the order of `COLUMNS`."""
    from angen_sensors.angen_addon.recording.stored_recording import stored_run

    scene = new_scene(24, FRAMES)
    SCENES[name](triangles)
    _furnish()
    started = time.perf_counter()
    bpy.context.view_layer.update()
    scene.frame_set(1)
    blender_s = time.perf_counter() - started
    # The memory that building the scene took does not count.
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")
    before = memory_mib()
    start_s, _ = run(scene, sensors_of(), 1, 1)
    start_mb = memory_mib(most=True) - before
    frames_s, recording = run(scene, sensors_of(), 1, FRAMES)
    started = time.perf_counter()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    stored_run(recording, scene, depsgraph)
    keep_s = time.perf_counter() - started
    return [blender_s, before, start_s, start_mb, frames_s, keep_s, memory_mib(most=True) - before]


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.big",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--millions", type=float, nargs="+", default=[1, 3, 10])
    parser.add_argument("--only", nargs="+", choices=list(SCENES), default=list(SCENES))
    options = parser.parse_args()
    print("| triangles | as | " + " | ".join(COLUMNS) + " |")
    print("|---|---|" + "--:|" * len(COLUMNS))
    for millions in options.millions:
        for name in options.only:
            cells = [f"{value:.4g}" for value in apart("big.measure", name, int(millions * 1e6))]
            print(f"| {millions:g} million | {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
