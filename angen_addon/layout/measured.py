# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the pose and the size of a sensor, so that a layout can restore them exactly."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from mathutils import Matrix

from ...sensor_logic.model import Array, pose_from_matrix
from ..scene.rays.geometry import SURFACE_TYPES
from ..scene.sensors import Sensor, unit_scale

Numbers = list[float] | None


def place(sensor: Sensor, depsgraph: Any) -> tuple[Numbers, Numbers]:
    """Return a sensor's location and rotation in the world.

    They are exact if only the object's own location and rotation determine the pose. Otherwise, for
    example with a parent, they are rounded to 10 µm and 1 µrad, up to 10 m from the origin. The
    pose can be set again with that precision.

    Returns
    -------
    location, rotation : list of float
        In m, and XYZ Euler angles in radians. Both are None if the matrix has NaN or no direction.
    """
    metres = unit_scale(depsgraph.scene)
    matrix = sensor.world_matrix(depsgraph)
    evaluated = sensor.object.evaluated_get(depsgraph)
    if not sensor.holders and _is_placed_by_channels(evaluated, matrix):
        location = [shortest(c, metres) for c in evaluated.location]
        return location, [shortest(a) for a in evaluated.rotation_euler]
    try:
        pose = pose_from_matrix(np.array(matrix), metres)
    except ValueError:
        return None, None
    farthest = max(1.0, float(np.abs(pose.origin).max()))
    decimals = 6 - math.ceil(math.log10(farthest))
    angles = Matrix(pose.axes.tolist()).to_euler("XYZ")
    return _rounded(pose.origin, decimals), _rounded(angles, 6)


def _is_placed_by_channels(evaluated: Any, matrix: Any) -> bool:
    """Return whether an object's location, rotation and scale alone give its world matrix."""
    if evaluated.rotation_mode != "XYZ" or min(evaluated.scale) <= 0.0:
        return False
    alone = np.array(
        Matrix.LocRotScale(evaluated.location, evaluated.rotation_euler, evaluated.scale)
    )
    difference = np.abs(np.array(matrix) - alone)
    return bool((difference <= 1e-6 * np.maximum(1.0, np.abs(alone))).all())


def _rounded(values: Any, decimals: int) -> list[float]:
    # Adding zero turns -0 into 0.
    return [round(float(value), decimals) + 0.0 for value in values]


def shortest(value: float, metres: float = 1.0) -> float:
    """Return `value` times `metres`, rounded to as few digits as needed, at least 7.

    The result divided by `metres` equals `value` in single precision, in which Blender stores it.
    """
    found = 0.0
    for digits in (7, 8, 9):
        found = float(f"{value * metres:.{digits}g}")
        if np.float32(found / metres) == np.float32(value):
            break
    return found + 0.0


def bounds(sensor: Sensor, depsgraph: Any) -> list[list[float]] | None:
    """Return the bounds (2, 3) of a sensor's faces in the sensor's space, in m.

    They are the lowest and the highest corner. Return None if the sensor has no faces.
    """
    evaluated = sensor.object.evaluated_get(depsgraph)
    if evaluated.type not in SURFACE_TYPES or not evaluated.is_evaluated:
        return None
    mesh = evaluated.to_mesh()
    try:
        corners = face_bounds(mesh) if mesh is not None else None
    finally:
        evaluated.to_mesh_clear()
    if corners is None:
        return None
    scale = np.array(sensor.world_matrix(depsgraph).to_scale())
    corners = corners * np.abs(scale) * unit_scale(depsgraph.scene)
    return [[float(f"{c:.6g}") + 0.0 for c in corner] for corner in corners.tolist()]


def face_bounds(mesh: Any) -> Array | None:
    """Return the bounds (2, 3) of a mesh's faces in Blender units; None if it has no faces."""
    if not mesh.polygons:
        return None
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    used = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", used)
    solid = points.reshape(-1, 3)[used].astype(float)
    return np.array([solid.min(0), solid.max(0)])
