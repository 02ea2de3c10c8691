# SPDX-License-Identifier: GPL-3.0-or-later
"""The Ängen home and a walker as boxes: the scene that every engine can be given alike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene.sensors import all_sensors, read_pose
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, fan_directions
from angen_sensors.sensor_logic.model import Pose

from .common import open_home
from .walkers import Boxes, Walker

Array = np.typing.NDArray[np.float64]
FRAME = 600
# Looks a second: the detectors' update rate, which is the scene's frame rate here.
RATE = 10
# Across the living room, towards the sofa: feet on the floor finish.
START, TOWARDS, FLOOR = np.array([6.6, 4.0]), math.radians(20), 0.055
WALKER = Walker("walk", 1.70, 1.2)
BUNDLE = 0


@dataclass
class BoxHome:
    """Still boxes, where the walker is at each look, and every ray of every detector: `origins`,
    `directions` (n, 3), `reach` (n,) for each of the detectors."""

    still: Boxes
    walker: list[Boxes]
    rays: list[tuple[Array, Array, Array]]


def make(seconds: float) -> BoxHome:
    scene = open_home()
    scene.frame_set(FRAME)
    poses = [
        read_pose(s, s.object.matrix_world, 1.0)
        for s in all_sensors(bpy.context.view_layer)
        if s.kind.identifier == "PIR"
    ]
    still = _boxes([pose.origin for pose in poses])
    rays = [_rays(pose) for pose in poses]
    walker = []
    for look in range(round(seconds * RATE)):
        body = WALKER.boxes(START, TOWARDS, look / RATE)
        walker.append(Boxes(body.centre + np.array([0, 0, FLOOR]), body.half, body.axes))
    return BoxHome(still, walker, rays)


def _rays(pose: Pose) -> tuple[Array, Array, Array]:
    """Every tilt of the thesis's fan."""
    parameters = PirParameters()
    directions = fan_directions(parameters).reshape(-1, 3) @ pose.axes.T
    origins = pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), parameters.range_max - parameters.range_min)
    return origins, directions, reach


def _boxes(keep_out: Sequence[Array]) -> Boxes:
    """A box about every mesh of the home, turned as its object is; none that a detector is in,
    nor the person, who is animated."""
    centres, halves, axes = [], [], []
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for obj in bpy.context.view_layer.objects:
        if obj.type != "MESH" or not obj.visible_get() or obj.angen_ignored:
            continue
        if any(m.type == "ARMATURE" for m in obj.modifiers):
            continue
        evaluated = obj.evaluated_get(depsgraph)
        matrix = np.array(evaluated.matrix_world, np.float64)
        corners = np.array(evaluated.bound_box, np.float64)
        size = np.linalg.norm(matrix[:3, :3], axis=0)
        half = np.maximum((corners.max(axis=0) - corners.min(axis=0)) / 2 * size, 1e-4)
        turn = matrix[:3, :3] / size
        middle = (corners.max(axis=0) + corners.min(axis=0)) / 2
        centre = matrix[:3, :3] @ middle + matrix[:3, 3]
        # Near a detector's lens nothing starts inside of a box.
        if any((np.abs((at - centre) @ turn) < half + 0.06).all() for at in keep_out):
            continue
        if np.linalg.det(turn) < 0.0:
            turn = turn * np.array([1.0, 1.0, -1.0])
        centres.append(centre)
        halves.append(half)
        axes.append(turn)
    return Boxes(np.array(centres), np.array(halves), np.array(axes))


TRIANGLES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip


def triangles(boxes: Boxes) -> Array:
    """(12 n, 3, 3)."""
    return boxes.corners()[:, TRIANGLES].reshape(-1, 3, 3)


def blender_scene(home: BoxHome) -> Any:
    """The boxes as objects, those of the walker keyed at each frame; a frame a look."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, len(home.walker)
    scene.render.fps, scene.angen_live = RATE, False
    for i in range(len(home.still.half)):
        _box(f"still {i}", home.still, i)
    parts = [_box(f"walker {i}", home.walker[0], i) for i in range(len(home.walker[0].half))]
    for frame, body in enumerate(home.walker, 1):
        for i, part in enumerate(parts):
            part.matrix_world = _matrix(body, i)
            part.keyframe_insert("location", frame=frame)
            part.keyframe_insert("rotation_quaternion", frame=frame)
    bpy.context.view_layer.update()
    return scene


def _box(name: str, boxes: Boxes, index: int) -> Any:
    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    mesh = bpy.data.meshes.new(name)
    half = boxes.half[index]
    mesh.from_pydata([tuple(sign * half) for sign in signs], [], TRIANGLES.tolist())
    obj = bpy.data.objects.new(name, mesh)
    obj.rotation_mode = "QUATERNION"
    obj.matrix_world = _matrix(boxes, index)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _matrix(boxes: Boxes, index: int) -> Any:
    from mathutils import Matrix

    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = boxes.axes[index], boxes.centre[index]
    return Matrix(matrix.tolist())
