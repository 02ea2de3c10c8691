# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare the ray layer with other engines on the same boxes and the same rays.

The engines are Blender's `scene.ray_cast`, BVH trees in world space, MuJoCo's rangefinder and
multi-ray, and Embree. The scene is the Ängen home and a walker as boxes, which every engine can
represent exactly. The reference is a float64 intersection of ray and box. Each engine casts ten
looks a second for seven detectors, 120 rays at nine tilts each; the walker moves at every look.
MuJoCo's touch sensor is compared with the pad, and Radiance with the light sensors.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.runtime.probes import make_caster
from angen_sensors.angen_addon.runtime.time_base import evaluated_depsgraph
from angen_sensors.angen_addon.scene.sensors import read_pose
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, fan_directions
from angen_sensors.sensor_logic.model import Pose
from mathutils import Matrix
from mathutils.bvhtree import BVHTree

from . import pressure_scenes
from .bounds import OURS, REFERENCE
from .common import box_mesh, has, link, new_scene, open_home, progress, rms, sensors_of, spread
from .pressure_scenes import numbers
from .walkers import Boxes, Walker, ranges_to

Array = np.typing.NDArray[np.float64]
FRAME = 600
# Looks a second: the detectors' update rate, and the scene's frame rate.
RATE = 10
# Across the living room, towards the sofa. FLOOR (m) is the height of the finished floor.
START, TOWARDS, FLOOR = np.array([6.6, 4.0]), math.radians(20), 0.055
WALKER = Walker("walk", 1.70, 1.2)
# Single precision may miss a surface where a ray passes its edge: errors above EDGE (m) are edges.
EDGE = 1e-3
MASS, GRAVITY = 5.0, 9.81
TOUCH_STEP = 0.001
# The triangles of a box as indices of its corners.
TRIANGLES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip
# A look: the seconds of sensing, and the ranges of all detectors (n,).
Looks = Iterator[tuple[float, Array]]


@dataclass
class BoxHome:
    """Still boxes, the walker at each look, and every ray of every detector.

    `rays` has `origins` (n, 3), `directions` (n, 3) and `reach` (n,) for each detector.
    """

    still: Boxes
    walker: list[Boxes]
    rays: list[tuple[Array, Array, Array]]


def measure(quick: bool) -> dict[str, Any]:
    home = box_home(0.5 if quick else 3.0)
    rounds = 1 if quick else 3
    exact = np.concatenate([_exact(home, walker) for walker in home.walker])
    engines = [(name, work) for name, module, work in ENGINES if has(module)]
    runs: dict[str, list[list[tuple[float, Array]]]] = {name: [] for name, _ in engines}
    for turn in range(rounds):
        for name, work in engines:
            progress("peers", turn, rounds, name)
            runs[name].append(list(work(home)))
    light = None
    if has("pyradiance"):
        from . import radiance

        light = radiance.measure_speed(rounds, quick)
    return {
        "boxes": len(home.still.half) + len(home.walker[0].half),
        "rays_a_look": sum(len(r[2]) for r in home.rays), "looks_a_second": RATE,
        "looks": len(home.walker),
        "missing": [name for name, module, _ in ENGINES if not has(module)], "edge_m": EDGE,
        "rays": [_row(name, found, exact) for name, found in runs.items()],
        "touch": _touch(rounds) if has("mujoco") else None, "light": light,
    }  # fmt: skip


def _row(name: str, runs: list[list[tuple[float, Array]]], exact: Array) -> dict[str, Any]:
    # The first look is the start, in which still objects are hit.
    later = [[seconds for seconds, _ in looks[1:]] for looks in runs]
    error = np.abs(np.concatenate([ranges for _, ranges in runs[-1]]) - exact)
    off_edges = error[error <= EDGE]
    return {
        "engine": name,
        "ms_a_second": spread([sum(times) / len(times) * RATE * 1e3 for times in later]),
        "start_ms": spread([looks[0][0] * 1e3 for looks in runs]), "rms_m": rms(off_edges),
        "worst_m": float(off_edges.max()), "at_edges": int((error > EDGE).sum()),
        "rays": len(error),
    }  # fmt: skip


def box_home(seconds: float) -> BoxHome:
    open_home().frame_set(FRAME)
    poses = [read_pose(s, s.object.matrix_world, 1.0) for s in sensors_of("PIR")]
    walker = []
    for look in range(round(seconds * RATE)):
        body = WALKER.boxes(START, TOWARDS, look / RATE)
        walker.append(Boxes(body.centre + np.array([0, 0, FLOOR]), body.half, body.axes))
    still = _boxes([pose.origin for pose in poses])
    return BoxHome(still, walker, [_rays(pose) for pose in poses])


def _rays(pose: Pose) -> tuple[Array, Array, Array]:
    """Return the rays of all tilts of the thesis's fan: origins, directions and reach."""
    parameters = PirParameters()
    directions = fan_directions(parameters).reshape(-1, 3) @ pose.axes.T
    origins = pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), parameters.range_max - parameters.range_min)
    return origins, directions, reach


def _boxes(keep_out: Sequence[Array]) -> Boxes:
    """Return the bounding box of every mesh of the home in the object's own axes.

    The person, who is animated, and boxes that contain a detector are left out.
    """
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
        # No box may begin close to a detector's lens.
        if any((np.abs((at - centre) @ turn) < half + 0.06).all() for at in keep_out):
            continue
        if np.linalg.det(turn) < 0.0:
            turn = turn * np.array([1.0, 1.0, -1.0])
        centres.append(centre)
        halves.append(half)
        axes.append(turn)
    return Boxes(np.array(centres), np.array(halves), np.array(axes))


def _exact(home: BoxHome, walker: Boxes) -> Array:
    still = [ranges_to(home.still, *rays) for rays in home.rays]
    return np.concatenate(
        [ranges_to(walker, *rays[:2], near) for rays, near in zip(home.rays, still, strict=True)]
    )


def _layer(caster_name: str) -> Callable[[BoxHome], Looks]:
    def looks(home: BoxHome) -> Looks:
        """Cast as a run does, but do not time Blender's evaluation of the frame."""
        scene = _blender_scene(home)
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


def _blender_scene(home: BoxHome) -> Any:
    """Return a scene with the boxes as objects; one frame is one look of the keyed walker."""
    scene = new_scene(RATE, len(home.walker))
    for boxes, name in ((home.still, "still"), (home.walker[0], "walker")):
        for i, half in enumerate(boxes.half):
            obj = link(f"{name} {i}", box_mesh([(half, (0, 0, 0))]))
            obj.rotation_mode = "QUATERNION"
            for frame, body in enumerate(home.walker if name == "walker" else [boxes], 1):
                matrix = np.eye(4)
                matrix[:3, :3], matrix[:3, 3] = body.axes[i], body.centre[i]
                obj.matrix_world = Matrix(matrix.tolist())
                if name == "walker":
                    obj.keyframe_insert("location", frame=frame)
                    obj.keyframe_insert("rotation_quaternion", frame=frame)
    bpy.context.view_layer.update()
    return scene


def triangles(boxes: Boxes) -> Array:
    """Return the triangles of boxes as corners (12 n, 3, 3)."""
    return boxes.corners()[:, TRIANGLES].reshape(-1, 3, 3)


def _trees(home: BoxHome) -> Looks:
    """Cast with two BVH trees in world space; the walker's tree is rebuilt at each look."""

    def tree_of(corners: Array) -> Any:
        faces = np.arange(len(corners) * 3).reshape(-1, 3)
        return BVHTree.FromPolygons(corners.reshape(-1, 3).tolist(), faces.tolist(), epsilon=0.0)

    still = None
    for walker in home.walker:
        begin = time.perf_counter()
        still = still or tree_of(triangles(home.still))
        moving = tree_of(triangles(walker))
        found = []
        for rays in home.rays:
            for start, way, limit in zip(*(part.tolist() for part in rays), strict=True):
                for tree in (still, moving):
                    distance = tree.ray_cast(start, way, limit)[3]
                    limit = limit if distance is None else distance
                found.append(limit)
        yield time.perf_counter() - begin, np.array(found)


def _embree(home: BoxHome) -> Looks:
    """Cast with two Embree scenes; the walker's scene is rebuilt at each look."""
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


def _mujoco_model(home: BoxHome, rangefinders: bool) -> Any:
    import mujoco

    def geom(boxes: Boxes, i: int) -> tuple[str, str]:
        place = f'pos="{numbers(boxes.centre[i])}" quat="{numbers(_quaternion(boxes, i))}"'
        return f'<geom type="box" size="{numbers(boxes.half[i])}"', place

    text = '<mujoco><default><geom contype="0" conaffinity="0"/></default><worldbody>'
    text += "".join("{} {}/>".format(*geom(home.still, i)) for i in range(len(home.still.half)))
    walker = home.walker[0]
    for shape, place in (geom(walker, i) for i in range(len(walker.half))):
        text += f'<body mocap="true" {place}>{shape}/></body>'
    sensors = ""
    if rangefinders:
        # In a separate body, because a rangefinder ignores the geoms of its own body.
        text += "<body>"
        rays = [ray for bundle in home.rays for ray in zip(*bundle, strict=True)]
        for i, (origin, way, reach) in enumerate(rays):
            text += f'<site name="s{i}" pos="{numbers(origin)}" zaxis="{numbers(way)}"/>'
            sensors += f'<rangefinder site="s{i}" cutoff="{float(reach)!r}"/>'
        text += "</body>"
    text = f"{text}</worldbody><sensor>{sensors}</sensor></mujoco>"
    return mujoco.MjModel.from_xml_string(text)


def _quaternion(boxes: Boxes, index: int) -> Array:
    import mujoco

    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(boxes.axes[index]).ravel())
    return found


def _mujoco(home: BoxHome, rangefinders: bool) -> Looks:
    """Cast with a rangefinder for each ray, or with all rays of a detector in one call."""
    import mujoco

    model = _mujoco_model(home, rangefinders)
    data = mujoco.MjData(model)
    for walker in home.walker:
        begin = time.perf_counter()
        for i, centre in enumerate(walker.centre):
            data.mocap_pos[i], data.mocap_quat[i] = centre, _quaternion(walker, i)
        mujoco.mj_kinematics(model, data)
        if rangefinders:
            mujoco.mj_sensorPos(model, data)
            found = np.array(data.sensordata)
            reach = np.concatenate([rays[2] for rays in home.rays])
            found = np.where(found < 0.0, reach, np.minimum(found, reach))
        else:
            found = np.concatenate([_multi_ray(model, data, *rays) for rays in home.rays])
        yield time.perf_counter() - begin, found


def _multi_ray(model: Any, data: Any, origins: Array, directions: Array, reach: Array) -> Array:
    """Return ranges from the detector's lens, with the offset of the start added."""
    import mujoco

    offset = 0.05
    lens = origins[0] - directions[0] * offset
    met, ranges = np.zeros(len(reach), np.int32), np.zeros(len(reach))
    mujoco.mj_multiRay(
        model, data, lens, directions.ravel(), None, True, -1, met, ranges, None,
        len(reach), float(reach[0] + offset),
    )  # fmt: skip
    return np.where(ranges < 0.0, reach, np.minimum(ranges - offset, reach))


ENGINES: tuple[tuple[str, str, Callable[[BoxHome], Looks]], ...] = (
    (OURS, "", _layer("FAST")),
    (REFERENCE, "", _layer("SCENE")),
    ("mathutils BVHTree", "", _trees),
    ("Embree (embreex)", "embreex", _embree),
    ("MuJoCo rangefinder", "mujoco", lambda home: _mujoco(home, True)),
    ("MuJoCo mj_multiRay", "mujoco", lambda home: _mujoco(home, False)),
)


def _touch(rounds: int) -> dict[str, Any]:
    """Compare pad and touch sensor under a box of 5 kg at rest: seconds and error."""
    ours, evaluation, theirs = [], [], []
    for _ in range(rounds):
        scene = pressure_scenes.new_world(last=48)
        pressure_scenes.floor()
        pressure_scenes.pad("pad", (0.2, 0.2, 0.01), (0, 0, 0.01))
        pressure_scenes.box("box", (0.1, 0.1, 0.1), (0, 0, 0.12), MASS)
        begin = time.perf_counter()
        followed = pressure_scenes.follow(scene)
        whole, sensing = time.perf_counter() - begin, sum(followed.seconds)
        seconds = len(followed.seconds) / 24.0
        ours.append(sensing / seconds * 1e3)
        evaluation.append((whole - sensing) / seconds * 1e3)
        settled = followed.tracks["pad"].force[24:]
        wall, felt = _mujoco_touch()
        theirs.append(wall * 1e3)
    exact = MASS * GRAVITY
    return {
        "exact_n": exact, "ours_ms_a_second": spread(ours),
        "bullet_ms_a_second": spread(evaluation), "mujoco_ms_a_second": spread(theirs),
        "ours_error": max(abs(force / exact - 1.0) for force in settled),
        "mujoco_error": max(abs(force / exact - 1.0) for force in felt),
        "mujoco_step_s": TOUCH_STEP,
    }  # fmt: skip


def _mujoco_touch() -> tuple[float, list[float]]:
    """Return the wall seconds of a simulated second, and the newtons in its last tenth."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{TOUCH_STEP}" gravity="0 0 -{GRAVITY}"/><worldbody>
        <geom type="box" size="6 6 0.5" pos="0 0 -0.5"/>
        <body pos="0 0 0.01"><geom type="box" size="0.2 0.2 0.01"/>
        <site name="zone" type="box" size="0.21 0.21 0.012"/></body>
        <body pos="0 0 0.12"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="{MASS}"/></body>
        </worldbody><sensor><touch site="zone"/></sensor></mujoco>"""
    )
    data, steps = mujoco.MjData(model), round(1.0 / TOUCH_STEP)
    for _ in range(steps):
        mujoco.mj_step(model, data)
    begin, felt = time.perf_counter(), []
    for _ in range(steps):
        mujoco.mj_step(model, data)
        felt.append(float(data.sensordata[0]))
    return time.perf_counter() - begin, felt[-steps // 10 :]
