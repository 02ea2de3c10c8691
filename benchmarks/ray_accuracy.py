# SPDX-License-Identifier: GPL-3.0-or-later
"""Both ray casters against the exact range: float64 intersection with the triangle that was hit."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import make_caster
from angen_sensors.angen_addon.runtime.time_base import evaluated_depsgraph
from angen_sensors.angen_addon.scene.sensors import all_sensors, read_parameters, read_pose
from angen_sensors.sensor_logic.kinds.pir.range_scan import fan_directions
from mathutils import Vector

from .common import open_home
from .ray_layer import FIRST_FRAME

# The look from close by that finds out which face a ray hit starts this far before it.
LOOK_BACK_M = 0.01
# Frames between two that are measured: the doors and the person stand elsewhere in each.
STRIDE = 12


def measure(frames: int) -> dict[str, Any]:
    """Worst errors in metres over all rays of the home's detectors at some frames."""
    scene = open_home()
    casters = {}
    for name in ("FAST", "SCENE"):
        scene.angen_ray_caster = name
        casters[name] = make_caster(scene)
    errors = []
    for frame in range(FIRST_FRAME, FIRST_FRAME + frames, STRIDE):
        scene.frame_set(frame)
        depsgraph = evaluated_depsgraph()
        for caster in casters.values():
            caster.update(depsgraph)
        faces = _Faces(scene, depsgraph)
        for sensor in all_sensors(bpy.context.view_layer):
            if sensor.kind.identifier == "PIR":
                errors += _errors(sensor, casters, faces)
    table = np.array(errors)
    apart = np.abs(table[:, 0] - table[:, 1]) > 1e-5
    return {
        "rays": len(table),
        "fast_m": float(np.abs(table[:, 0]).max()),
        "fast_rms_m": float(np.sqrt(np.mean(table[:, 0] ** 2))),
        "reference_m": float(np.abs(table[:, 1]).max()),
        "reference_rms_m": float(np.sqrt(np.mean(table[:, 1] ** 2))),
        "apart": int(apart.sum()),
        "apart_fast_m": float(np.abs(table[apart, 0]).max(initial=0.0)),
        "apart_reference_m": float(np.abs(table[apart, 1]).max(initial=0.0)),
    }


def _errors(sensor: Any, casters: dict[str, Any], faces: _Faces) -> list[tuple[float, float]]:
    """Signed errors of both casters for each ray of one detector that meets a face."""
    parameters = read_parameters(sensor, sensor.settings)
    pose = read_pose(sensor, sensor.object.matrix_world, 1.0)
    ways = fan_directions(parameters).reshape(-1, 3) @ pose.axes.T
    starts = pose.origin + ways * parameters.range_min
    reach = np.full(len(ways), parameters.range_max - parameters.range_min)
    fast, slow = (casters[n].cast(sensor.uid, 0, starts, ways, reach) for n in ("FAST", "SCENE"))
    found = []
    for i in np.flatnonzero((fast < reach) & (slow < reach)).tolist():
        exact = faces.exact_range(starts[i], ways[i], float(fast[i]))
        if exact is not None:
            found.append((float(fast[i]) - exact, float(slow[i]) - exact))
    return found


class _Faces:
    """The triangles of every face in the world, in float64, for one frame."""

    def __init__(self, scene: Any, depsgraph: Any) -> None:
        self._scene = scene
        self._depsgraph = depsgraph
        self._triangles: dict[str, dict[int, list[Any]]] = {}

    def exact_range(self, start: Any, way: Any, near: float) -> float | None:
        """The range of a ray that meets something at about `near`; None where it is unclear."""
        look_from = Vector(start + way * (near - LOOK_BACK_M))
        hit, _, _, face, seen, matrix = self._scene.ray_cast(
            self._depsgraph, look_from, Vector(way), distance=2 * LOOK_BACK_M
        )
        if not hit or seen.type != "MESH":
            return None
        ranges = [_meet_triangle(start, way, *t) for t in self._of_face(seen, face, matrix)]
        met = [r for r in ranges if r is not None]
        return min(met, key=lambda r: abs(r - near)) if met else None

    def _of_face(self, seen: Any, face: int, matrix: Any) -> list[Any]:
        faces = self._triangles.get(seen.name)
        if faces is None:
            mesh = seen.evaluated_get(self._depsgraph).data
            mesh.calc_loop_triangles()
            to_world = np.array(matrix, np.float64)
            points = np.array([v.co for v in mesh.vertices], np.float64)
            points = points @ to_world[:3, :3].T + to_world[:3, 3]
            faces = self._triangles[seen.name] = {}
            for triangle in mesh.loop_triangles:
                corners = points[list(triangle.vertices)]
                faces.setdefault(triangle.polygon_index, []).append(corners)
        return faces[face]


def _meet_triangle(start: Any, way: Any, a: Any, b: Any, c: Any) -> float | None:
    """Möller and Trumbore 1997, in float64."""
    ab, ac = b - a, c - a
    p = np.cross(way, ac)
    determinant = ab @ p
    if determinant == 0.0:
        return None
    s = start - a
    u = (s @ p) / determinant
    q = np.cross(s, ab)
    v = (way @ q) / determinant
    if u < -1e-6 or v < -1e-6 or u + v > 1 + 1e-6:
        return None
    return float((ac @ q) / determinant)
