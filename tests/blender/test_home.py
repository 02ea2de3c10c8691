# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample home: both ray casters agree on every ray, at frames all through the story."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import probes, time_base
from bl_ext.user_default.angen_sensors.angen_addon.scene import sensors
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.pir.range_scan import fan_directions
from mathutils import Vector
from tiers import mostly_slow

HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"
TOLERANCE_M = 2e-5
# Where the two differ by more, the face is looked at from this close by, and from there exactly.
NEAR_M = 0.001


def exact_range(scene, depsgraph, start, way, about):
    """The range of a ray in float64: where it meets the plane of the face that it hits."""
    near, ahead = Vector(start + way * (about - NEAR_M)), Vector(way)
    hit, _, _, face, seen, matrix = scene.ray_cast(depsgraph, near, ahead, distance=10 * NEAR_M)
    assert hit
    mesh = seen.evaluated_get(depsgraph).data
    corners = np.array([mesh.vertices[v].co for v in mesh.polygons[face].vertices], np.float64)
    to_world = np.array(matrix, np.float64)
    corners = corners @ to_world[:3, :3].T + to_world[:3, 3]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    assert np.abs((corners - corners[0]) @ normal).max() < 1e-9, "the face is not flat"
    return float(normal @ (corners[0] - start)) / float(normal @ way)


@pytest.fixture(scope="module")
def home():
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    bpy.context.scene.angen_live = False
    casters = []
    for name in ("FAST", "SCENE"):
        bpy.context.scene.angen_ray_caster = name
        casters.append(probes.make_caster(bpy.context.scene))
    return bpy.context.scene, casters


@pytest.mark.parametrize("frame", mostly_slow([100, 700, 1000, 3400], 700))
def test_every_ray_reads_what_scene_ray_cast_reads(home, frame):
    """Or, where rounding in world coordinates leads `scene.ray_cast` astray on a ray that grazes
    its face, what the face's plane says."""
    scene, casters = home
    scene.frame_set(frame)
    depsgraph = time_base.evaluated_depsgraph()
    for caster in casters:
        caster.update(depsgraph)
    for sensor in sensors.all_sensors(bpy.context.view_layer):
        if sensor.kind.identifier != "PIR":
            continue
        parameters = sensors.read_parameters(sensor, sensor.settings)
        pose = sensors.read_pose(sensor, sensor.object.matrix_world, 1.0)
        ways = fan_directions(parameters).reshape(-1, 3) @ pose.axes.T
        starts = pose.origin + ways * parameters.range_min
        reach = np.full(len(ways), parameters.range_max)
        fast, slow = (c.cast(sensor.uid, 0, starts, ways, reach) for c in casters)
        for row in np.flatnonzero(np.abs(fast - slow) > TOLERANCE_M).tolist():
            exact = exact_range(scene, depsgraph, starts[row], ways[row], slow[row])
            assert abs(fast[row] - exact) < TOLERANCE_M, (sensor.name, row)
            assert abs(slow[row] - exact) > abs(fast[row] - exact), (sensor.name, row)


def test_the_sofa_knows_all_weights_as_the_person_sits_down_and_gets_up(home):
    from bl_ext.user_default.angen_sensors.angen_addon.runtime import simulation
    from bl_ext.user_default.angen_sensors.sensor_logic.choice import SensorChoice
    from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording

    scene, _ = home
    sofa = sensors.chosen(
        sensors.all_sensors(bpy.context.view_layer), SensorChoice(("Pressure sofa",))
    )
    clock = time_base.clock_of(scene)
    forces = []
    for second, last in ((46, 52), (56, 59), (81, 88)):
        found = Recording()
        frames = [scene.frame_start + round(s * clock.fps) for s in (second, last)]
        for _ in simulation.simulate(scene, sofa, *frames, found):
            pass
        columns = found.tracks["Pressure sofa"].columns
        assert not any(columns["problem"])
        forces.append(list(columns["force_n"]))
    assert forces[0][0] < 100 < 300 < forces[0][-1] < 700
    # All that is above, 74.5 kg, but for what feet and arm rest carry: on her feet at most 37 N, by
    # a balance of elastic layers below her mesh, worked out apart. The README tells this figure.
    assert forces[1] == pytest.approx([697.0] * len(forces[1]), abs=2.0)
    assert forces[2][0] > 300 > 100 > forces[2][-1]
