# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray layer against others, in one run, on the same boxes and the same rays: Blender's
`scene.ray_cast`, BVH trees in world space, MuJoCo's rangefinder and multi-ray, and Embree.

The reference is a float64 intersection of ray and box. All see ten looks a second of seven
detectors, 120 rays at nine tilts each; every look moves the walker. MuJoCo's touch sensor is put
beside the pad.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from angen_sensors.angen_addon.runtime.probes import make_caster
from angen_sensors.angen_addon.runtime.time_base import evaluated_depsgraph

from . import peers_light, pressure_scenes
from .box_home import RATE, BoxHome, blender_scene, make, triangles
from .common import spread
from .progress import progress
from .walkers import ranges_to

Array = np.typing.NDArray[np.float64]
# Where a ray passes an edge, single precision meets the one or the other side of it.
EDGE = 1e-3
MASS, GRAVITY = 5.0, 9.81
TOUCH_STEP = 0.001
# A look: seconds of sensing, and the ranges of all detectors (n,).
Looks = Iterator[tuple[float, Array]]


def measure(quick: bool) -> dict[str, Any]:
    home = make(0.5 if quick else 3.0)
    rounds = 1 if quick else 3
    exact = [_exact(home, look) for look in range(len(home.walker))]
    engines = [(name, work) for name, module, work in ENGINES if _has(module)]
    taken: dict[str, list[float]] = {name: [] for name, _ in engines}
    starts: dict[str, list[float]] = {name: [] for name, _ in engines}
    errors: dict[str, Array] = {}
    for turn in range(rounds):
        for name, work in engines:
            progress("peers", turn, rounds, name)
            looks = list(work(home))
            times = [seconds for seconds, _ in looks[1:]]
            # The first look is the start: still things are met there.
            taken[name].append(sum(times) / len(times) * RATE)
            starts[name].append(looks[0][0])
            found = np.concatenate([ranges for _, ranges in looks])
            errors[name] = np.abs(found - np.concatenate(exact))
    return {
        "boxes": len(home.still.half) + len(home.walker[0].half),
        "rays_a_look": sum(len(r[2]) for r in home.rays),
        "looks_a_second": RATE,
        "looks": len(home.walker),
        "missing": [name for name, module, _ in ENGINES if not _has(module)],
        "edge_m": EDGE,
        "rays": [
            {
                "engine": name,
                "ms_a_second": spread([t * 1e3 for t in taken[name]]),
                "start_ms": spread([t * 1e3 for t in starts[name]]),
                "rms_m": float(np.sqrt(np.mean(_off_edges(errors[name]) ** 2))),
                "worst_m": float(_off_edges(errors[name]).max()),
                "at_edges": int((errors[name] > EDGE).sum()),
                "rays": len(errors[name]),
            }
            for name, _ in engines
        ],
        "touch": _touch(rounds),
        "light": peers_light.measure(rounds, quick) if _has("pyradiance") else None,
    }


def _has(module: str) -> bool:
    return not module or importlib.util.find_spec(module) is not None


def _off_edges(errors: Array) -> Array:
    return errors[errors <= EDGE]


def _exact(home: BoxHome, look: int) -> Array:
    found = []
    for origins, directions, reach in home.rays:
        ranges = reach.copy()
        for boxes in (home.still, home.walker[look]):
            ranges = ranges_to(boxes, origins, directions, ranges)
        found.append(ranges)
    return np.concatenate(found)


def _layer(caster_name: str) -> Callable[[BoxHome], Looks]:
    def looks(home: BoxHome) -> Looks:
        """As in a run; Blender's evaluation of the frame is left out, as no peer has one."""
        scene = blender_scene(home)
        scene.angen_ray_caster = caster_name
        caster = make_caster(scene)
        for frame in range(1, len(home.walker) + 1):
            scene.frame_set(frame)
            depsgraph = evaluated_depsgraph()
            begin = time.perf_counter()
            caster.update(depsgraph)
            found = [caster.cast(i + 1, 0, *rays) for i, rays in enumerate(home.rays)]
            yield time.perf_counter() - begin, np.concatenate(found)

    return looks


def _trees(home: BoxHome) -> Looks:
    """Two BVH trees in world space; that of the walker is built anew at each look."""
    from mathutils.bvhtree import BVHTree

    def tree_of(corners: Array) -> Any:
        faces = np.arange(len(corners) * 3).reshape(-1, 3)
        return BVHTree.FromPolygons(corners.reshape(-1, 3).tolist(), faces.tolist(), epsilon=0.0)

    still = None
    for walker in home.walker:
        begin = time.perf_counter()
        still = still or tree_of(triangles(home.still))
        moving = tree_of(triangles(walker))
        found = []
        for origins, directions, reach in home.rays:
            for start, way, limit in zip(
                origins.tolist(), directions.tolist(), reach.tolist(), strict=True
            ):
                distance = still.ray_cast(start, way, limit)[3]
                limit = limit if distance is None else distance
                distance = moving.ray_cast(start, way, limit)[3]
                found.append(limit if distance is None else distance)
        yield time.perf_counter() - begin, np.array(found)


def _embree(home: BoxHome) -> Looks:
    """Two scenes of Intel's ray tracer; that of the walker is built anew at each look."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    def scene_of(corners: Array) -> Any:
        made = EmbreeScene()
        TriangleMesh(made, corners.astype(np.float32))
        return made

    origins, directions, reach = (np.concatenate([rays[i] for rays in home.rays]) for i in range(3))
    starts, ways = origins.astype(np.float32), directions.astype(np.float32)
    still = None
    for walker in home.walker:
        begin = time.perf_counter()
        still = still or scene_of(triangles(home.still))
        ranges = np.minimum(
            still.run(starts, ways, query="DISTANCE"),
            scene_of(triangles(walker)).run(starts, ways, query="DISTANCE"),
        )
        yield time.perf_counter() - begin, np.minimum(ranges.astype(np.float64), reach)


def _mujoco_text(home: BoxHome, rangefinders: bool) -> str:
    def geom(boxes: Any, i: int, moving: bool) -> str:
        place = f'pos="{_numbers(boxes.centre[i])}" quat="{_numbers(_quaternion(boxes, i))}"'
        size = f'size="{_numbers(boxes.half[i])}"'
        if moving:
            return f'<body mocap="true" {place}><geom type="box" {size}/></body>'
        return f'<geom type="box" {size} {place}/>'

    text = '<mujoco><default><geom contype="0" conaffinity="0"/></default><worldbody>'
    text += "".join(geom(home.still, i, False) for i in range(len(home.still.half)))
    walker = home.walker[0]
    text += "".join(geom(walker, i, True) for i in range(len(walker.half)))
    sensors = ""
    if rangefinders:
        # In a body of their own: a rangefinder passes through what its body has.
        text += "<body>"
        rays = [ray for bundle in home.rays for ray in zip(*bundle, strict=True)]
        for i, (origin, way, reach) in enumerate(rays):
            text += f'<site name="s{i}" pos="{_numbers(origin)}" zaxis="{_numbers(way)}"/>'
            sensors += f'<rangefinder site="s{i}" cutoff="{float(reach)!r}"/>'
        text += "</body>"
    return f"{text}</worldbody><sensor>{sensors}</sensor></mujoco>"


def _mujoco_moves(home: BoxHome, data: Any, look: int) -> None:
    walker = home.walker[look]
    for i in range(len(walker.half)):
        data.mocap_pos[i] = walker.centre[i]
        data.mocap_quat[i] = _quaternion(walker, i)


def _quaternion(boxes: Any, index: int) -> Array:
    import mujoco

    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(boxes.axes[index]).ravel())
    return found


def _rangefinders(home: BoxHome) -> Looks:
    import mujoco

    model = mujoco.MjModel.from_xml_string(_mujoco_text(home, True))
    data = mujoco.MjData(model)
    reach = np.concatenate([rays[2] for rays in home.rays])
    for look in range(len(home.walker)):
        begin = time.perf_counter()
        _mujoco_moves(home, data, look)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_sensorPos(model, data)
        found = np.array(data.sensordata)
        yield time.perf_counter() - begin, np.where(found < 0.0, reach, np.minimum(found, reach))


def _multi_ray(home: BoxHome) -> Looks:
    """All rays of a detector in one call, from its lens; the start's offset is taken off."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(_mujoco_text(home, False))
    data = mujoco.MjData(model)
    for look in range(len(home.walker)):
        begin = time.perf_counter()
        _mujoco_moves(home, data, look)
        mujoco.mj_kinematics(model, data)
        found = []
        for origins, directions, reach in home.rays:
            offset = 0.05
            lens = origins[0] - directions[0] * offset
            met = np.zeros(len(reach), np.int32)
            ranges = np.zeros(len(reach))
            mujoco.mj_multiRay(
                model, data, lens, directions.ravel(), None, True, -1, met, ranges, None,
                len(reach), float(reach[0] + offset),
            )  # fmt: skip
            found.append(np.where(ranges < 0.0, reach, np.minimum(ranges - offset, reach)))
        yield time.perf_counter() - begin, np.concatenate(found)


ENGINES: tuple[tuple[str, str, Callable[[BoxHome], Looks]], ...] = (
    ("Ängen Sensors", "", _layer("FAST")),
    ("Blender `scene.ray_cast`", "", _layer("SCENE")),
    ("mathutils BVHTree", "", _trees),
    ("Embree (embreex)", "embreex", _embree),
    ("MuJoCo rangefinder", "mujoco", _rangefinders),
    ("MuJoCo mj_multiRay", "mujoco", _multi_ray),
)


def _touch(rounds: int) -> dict[str, Any] | None:
    """A box of 5 kg at rest on a pad: seconds for a simulated second, and the error."""
    if not _has("mujoco"):
        return None
    ours, evaluation, theirs = [], [], []
    for _ in range(rounds):
        scene = pressure_scenes.new_scene(last=48)
        pressure_scenes.floor()
        pressure_scenes.pad("pad", (0.2, 0.2, 0.01), (0, 0, 0.01))
        pressure_scenes.box("box", (0.1, 0.1, 0.1), (0, 0, 0.12), MASS)
        begin = time.perf_counter()
        followed = pressure_scenes.follow(scene)
        whole = time.perf_counter() - begin
        seconds = len(followed.seconds) / 24.0
        ours.append(sum(followed.seconds) / seconds * 1e3)
        evaluation.append((whole - sum(followed.seconds)) / seconds * 1e3)
        settled = followed.tracks["pad"].force[24:]
        error = max(abs(force / (MASS * GRAVITY) - 1.0) for force in settled)
        wall, peer_error = _mujoco_touch()
        theirs.append(wall * 1e3)
    return {
        "exact_n": MASS * GRAVITY,
        "ours_ms_a_second": spread(ours),
        "bullet_ms_a_second": spread(evaluation),
        "mujoco_ms_a_second": spread(theirs),
        "ours_error": error,
        "mujoco_error": peer_error,
        "mujoco_step_s": TOUCH_STEP,
    }


def _mujoco_touch() -> tuple[float, float]:
    """Wall seconds of a simulated second, and the relative error of its last tenth."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{TOUCH_STEP}" gravity="0 0 -{GRAVITY}"/><worldbody>
        <geom type="box" size="6 6 0.5" pos="0 0 -0.5"/>
        <body pos="0 0 0.01"><geom type="box" size="0.2 0.2 0.01"/>
        <site name="zone" type="box" size="0.21 0.21 0.012"/></body>
        <body pos="0 0 0.12"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="{MASS}"/></body>
        </worldbody><sensor><touch site="zone"/></sensor></mujoco>"""
    )
    data = mujoco.MjData(model)
    for _ in range(round(1.0 / TOUCH_STEP)):
        mujoco.mj_step(model, data)
    begin, felt = time.perf_counter(), []
    for _ in range(round(1.0 / TOUCH_STEP)):
        mujoco.mj_step(model, data)
        felt.append(float(data.sensordata[0]))
    wall = time.perf_counter() - begin
    worst = max(abs(force / (MASS * GRAVITY) - 1.0) for force in felt[-100:])
    return wall, worst


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)
