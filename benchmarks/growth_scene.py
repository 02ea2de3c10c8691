# SPDX-License-Identifier: GPL-3.0-or-later
"""A hall that grows: still objects on a floor, one that moves, and motion detectors."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np

HIGH = 2.2


def hall(objects: int, triangles: int, sensors: int, frames: int) -> Any:
    """`objects` in the same 20 × 20 m however many there are, `triangles` shared among them."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.render.fps, scene.angen_live = 24, False
    chance = np.random.default_rng(1)
    _place("floor", _grid("floor", 20.0, 20.0, 1), (0, 0, 0))
    side = max(1, math.ceil(math.sqrt(triangles / objects / 2)))
    for i in range(objects):
        x, y = chance.uniform(-9.5, 9.5, 2).tolist()
        # Meshes of their own, as most furniture has; half of them stand, half lie.
        thing = _place(f"thing {i}", _grid(f"thing {i}", 0.5, 0.5, side), (x, y, 0.3))
        thing.rotation_euler.x = math.pi / 2 if i % 2 else 0.0
    mover = _place("mover", _grid("mover", 0.6, 1.7, 8), (0, 0, 0.9))
    mover.rotation_euler.x = math.pi / 2
    for number, frame in enumerate(range(1, frames + 96, 48)):
        mover.location.x = -4.0 if number % 2 else 4.0
        mover.keyframe_insert("location", index=0, frame=frame)
    for i in range(sensors):
        sensor = bpy.data.objects.new(f"PIR {i:03d}", None)
        x, y = chance.uniform(-6, 6, 2).tolist()
        sensor.location = (x, y, HIGH)
        # Horizontal, any way.
        sensor.rotation_euler = (math.pi / 2, 0, float(chance.uniform(0, 2 * math.pi)))
        scene.collection.objects.link(sensor)
        sensor.angen_sensor.kind = "PIR"
    bpy.context.view_layer.update()
    return scene


def _place(name: str, mesh: Any, at: tuple[float, float, float]) -> Any:
    obj = bpy.data.objects.new(name, mesh)
    obj.location = at
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _grid(name: str, width: float, depth: float, side: int) -> Any:
    """A slightly wavy sheet of side × side squares."""
    x, y = np.meshgrid(
        np.linspace(-width / 2, width / 2, side + 1), np.linspace(-depth / 2, depth / 2, side + 1)
    )
    z = 0.02 * np.sin(20 * x) * np.sin(20 * y) if side > 1 else np.zeros_like(x)
    corner = np.arange((side + 1) ** 2).reshape(side + 1, side + 1)
    squares = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=2)
    mesh = bpy.data.meshes.new(name)
    points = np.stack([x, y, z], axis=2).reshape(-1, 3)
    mesh.from_pydata(points.tolist(), [], squares.reshape(-1, 4).tolist())
    return mesh
