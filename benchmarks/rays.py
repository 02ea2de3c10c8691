# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare the fast ray layer with `scene.ray_cast`: time, range error and events.

The errors of both are taken against the float64 intersection with the triangle that was hit. Both
casters get the same frames of the same scene in one process, one after the other. Times are those
of sensing, without Blender's evaluation of the frame, which is given separately. Detectors update
at 10 Hz, so the time of a frame is the mean over frames with and without updates. The first second,
in which the fast layer reads all still objects, is its start time.
"""

from __future__ import annotations

import random
import time
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import Probes, make_caster
from angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner, single_update
from angen_sensors.angen_addon.runtime.time_base import clock_of, evaluated_depsgraph
from angen_sensors.angen_addon.scene.sensors import Sensor, read_parameters, read_pose
from angen_sensors.sensor_logic.kinds.pir.range_scan import fan_directions
from mathutils import Vector

from .common import box_mesh, link, open_home, progress, rms, sensors_of, spread

# At this frame the person walks from the kitchen to the living room.
FIRST_FRAME = 600
PIRS = (1, 7, 20)
RAYS = (80, 160, 640)
HOME, CROWD = ("Ängen home", 0), ("home and 1000 objects", 1000)
START_FRAMES = 24
# A second, close ray finds the face that a ray hit. It starts this far before the hit (m).
LOOK_BACK_M = 0.01
# Frames between two accuracy checks; doors and the person have moved in between.
STRIDE = 12


def measure(quick: bool) -> dict[str, Any]:
    frames, rounds = (24, 1) if quick else (72, 3)
    cases = [(HOME, pirs, rays, "SAWTOOTH", rounds) for pirs in PIRS for rays in RAYS]
    cases += [(scene, 7, 120, sweep, rounds) for scene in (HOME, CROWD)
              for sweep in ("SAWTOOTH", "ALL")]  # fmt: skip
    # The reference caster takes minutes for these.
    cases[-1] = (CROWD, 7, 120, "ALL", 1)
    cases = cases[3:6] if quick else cases
    rows = []
    for done, (scene, pirs, rays, sweep, repeats) in enumerate(cases):
        progress("rays", done, len(cases), f"{scene[0]}, {pirs} PIRs, {rays} rays, {sweep}")
        rows.append(compare(*scene, pirs, rays, sweep, frames, repeats))
    accuracy = measure_accuracy(12 if quick else 72)
    return {
        "ray_accuracy": accuracy,
        "ray_layer": {"frames": frames, "rounds": rounds, "rows": rows},
    }


@dataclass
class Run:
    """The run of one caster: seconds of start, sensing and evaluation, and all readings."""

    starting: float = 0.0
    sensing: float = 0.0
    evaluating: float = 0.0
    ranges: list[Any] = field(default_factory=list)
    moved: list[bool] = field(default_factory=list)


def compare(
    name: str, crowd: int, pirs: int, rays: int, sweep: str, frames: int, rounds: int
) -> dict[str, Any]:
    """Run both casters on the same frames; return the medians over rounds of times and ratio."""
    scene = open_home()
    add_objects(crowd)
    sensors = detectors(pirs, rays, sweep)
    runs = [
        (run_caster(scene, sensors, "FAST", frames), run_caster(scene, sensors, "SCENE", frames))
        for _ in range(rounds)
    ]
    fast, slow = runs[-1]
    error = max(float(np.abs(a - b).max()) for a, b in zip(fast.ranges, slow.ranges, strict=True))
    return {
        "scene": name, "objects": len(scene.objects), "pirs": pirs, "rays": rays, "sweep": sweep,
        "frames": frames, "start_ms": fast.starting * 1e3,
        "fast_ms": spread([a.sensing / frames * 1e3 for a, _ in runs]),
        "reference_ms": spread([b.sensing / frames * 1e3 for _, b in runs]),
        "ratio": spread([b.sensing / a.sensing for a, b in runs]),
        "evaluation_ms": fast.evaluating / frames * 1e3, "worst_range_error_m": error,
        "updates": len(fast.moved),
        "updates_that_differ": sum(a != b for a, b in zip(fast.moved, slow.moved, strict=True)),
        "updates_with_motion": sum(slow.moved),
    }  # fmt: skip


def run_caster(scene: Any, sensors: list[Sensor], caster_name: str, frames: int) -> Run:
    scene.angen_ray_caster = caster_name
    clock = clock_of(scene)
    runners = [SensorRunner(sensor, clock) for sensor in sensors]
    probes = Probes(scene)
    done = Run()
    cast = probes.caster.cast_at

    def noting_cast(*arguments: Any) -> Any:
        answers = cast(*arguments)
        done.ranges.append(answers[-1].copy())
        return answers

    probes.caster.cast_at = noting_cast  # type: ignore[method-assign]
    first = FIRST_FRAME - scene.frame_start
    scene.frame_set(FIRST_FRAME - START_FRAMES - 1)
    for step in range(first - START_FRAMES, first + frames):
        begin = time.perf_counter()
        scene.frame_set(clock.frame_and_subframe(step)[0])
        depsgraph = evaluated_depsgraph()
        evaluated = time.perf_counter()
        due = [(n, s) for s in runners for n, _ in s.schedule.updates(step, step)]
        if due:
            probes.look(depsgraph, step)
        for number, runner in due:
            done.moved.append(single_update(runner, number, step, probes).reading().active)
        sensing = time.perf_counter() - evaluated
        if step < first:
            done.starting += sensing
        else:
            done.sensing += sensing
            done.evaluating += evaluated - begin
    return done


def detectors(count: int, rays: int = 120, sweep: str = "SAWTOOTH") -> list[Sensor]:
    """Return the first detectors of the home, and copies of them where it has too few.

    The copies are in the same rooms, a little aside and turned.
    """
    own, chance = sensors_of("PIR"), random.Random(1)
    for i in range(count - len(own)):
        copy = own[i % len(own)].object.copy()
        copy.location.z -= 0.05 + 0.05 * (i // len(own))
        copy.rotation_euler.z += chance.uniform(-0.3, 0.3)
        bpy.context.scene.collection.objects.link(copy)
    bpy.context.view_layer.update()
    found = sensors_of("PIR")[:count]
    for sensor in found:
        sensor.settings.pir.rays, sensor.settings.pir.sweep = rays, sweep
    return found


def add_objects(count: int) -> None:
    """Add small still boxes on the floors, each with its own mesh."""
    chance = random.Random(1)
    for i in range(count):
        at = chance.uniform(0, 10.6), chance.uniform(0.3, 8.3), 0.055
        link(f"box {i}", box_mesh([((0.05, 0.05, 0.1), (0.05, 0.05, 0.1))]), at)
    bpy.context.view_layer.update()


def measure_accuracy(frames: int) -> dict[str, Any]:
    """Return the errors in metres over all rays of the home's detectors at some frames."""
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
        for sensor in sensors_of("PIR"):
            errors += _errors(sensor, casters, faces)
    fast, slow = np.array(errors).T
    differ = np.abs(fast - slow) > 1e-5
    return {
        "rays": len(fast), "fast_m": float(np.abs(fast).max()), "fast_rms_m": rms(fast),
        "reference_m": float(np.abs(slow).max()), "reference_rms_m": rms(slow),
        "apart": int(differ.sum()), "apart_fast_m": float(np.abs(fast[differ]).max(initial=0.0)),
        "apart_reference_m": float(np.abs(slow[differ]).max(initial=0.0)),
    }  # fmt: skip


def _errors(sensor: Any, casters: dict[str, Any], faces: _Faces) -> list[tuple[float, float]]:
    """Return the signed errors of both casters for each ray of one detector that hits a face."""
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
    """The triangles of every face in world space, in float64, at one frame."""

    def __init__(self, scene: Any, depsgraph: Any) -> None:
        self._scene = scene
        self._depsgraph = depsgraph
        self._triangles: dict[str, dict[int, list[Any]]] = {}

    def exact_range(self, start: Any, way: Any, near: float) -> float | None:
        """Return the exact range of a ray whose range is about `near`; None if it is ambiguous."""
        look_from = Vector(start + way * (near - LOOK_BACK_M))
        hit, _, _, face, seen, matrix = self._scene.ray_cast(
            self._depsgraph, look_from, Vector(way), distance=2 * LOOK_BACK_M
        )
        if not hit or seen.type != "MESH":
            return None
        ranges = [
            _intersect_triangle(start, way, *t) for t in self._triangles_of(seen, face, matrix)
        ]
        met = [r for r in ranges if r is not None]
        return min(met, key=lambda r: abs(r - near)) if met else None

    def _triangles_of(self, seen: Any, face: int, matrix: Any) -> list[Any]:
        """Return the triangles of a face in world space."""
        if seen.name not in self._triangles:
            mesh = seen.evaluated_get(self._depsgraph).data
            mesh.calc_loop_triangles()
            to_world = np.array(matrix, np.float64)
            points = np.array([v.co for v in mesh.vertices], np.float64)
            points = points @ to_world[:3, :3].T + to_world[:3, 3]
            faces: dict[int, list[Any]] = {}
            for triangle in mesh.loop_triangles:
                corners = points[list(triangle.vertices)]
                faces.setdefault(triangle.polygon_index, []).append(corners)
            self._triangles[seen.name] = faces
        return self._triangles[seen.name][face]


def _intersect_triangle(start: Any, way: Any, a: Any, b: Any, c: Any) -> float | None:
    """Return the range of a ray to a triangle by Möller and Trumbore (1997), in float64."""
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
