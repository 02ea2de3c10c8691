# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors hit the same surfaces as `scene.ray_cast`, whatever the geometry of a home.

Where the viewport shows other surfaces, sensors hit those of the viewport.
"""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime.probes import make_caster
from odd_geometries import ODD
from tiers import mostly_slow

# Rays from a square above, straight down and slanting, none through an edge or a corner.
SIDE = 11
REACH = 3.0
AGREE = 2e-5
# Both cast in single precision, whose rounding error this far from an object's origin is this.
COARSE = {"huge": 0.01, "a_kilometre_off_its_origin": 5e-4}
# Objects without faces, which neither Blender's rays nor the sensors' hit. Hair, points, strokes
# and smoke are drawn without faces. A modifier or a simulation can leave none.
WITHOUT_FACES = {
    "boolean_that_leaves_nothing",
    "curve_without_bevel",
    "edges_alone",
    "empty_with_a_picture",
    "faces_without_area",
    "grease_pencil",
    "hair_curves",
    "masked_away",
    "mesh_without_anything",
    "nodes_that_instance_curves",
    "nodes_that_instance_letters",
    "nodes_that_instance_points",
    "nodes_that_instance_volumes",
    "point_cloud",
    "vertices_alone",
    "volume",
}
# Objects that the viewport does not show, or that are flattened: their matrix has no inverse.
NOT_MET = WITHOUT_FACES | {"disabled_in_viewports", "flattened", "hidden"}
# `scene.ray_cast` hits hidden instancers, and the unmodified mesh in Edit Mode. Sensors hit what
# the viewport shows: only the instances, and the modified mesh.
UNLIKE_BLENDER = {"instances_on_faces", "being_edited_with_a_modifier"}
if bpy.app.version < (4, 3):
    # There it misses the surfaces of curves of the type Surface, which are shown.
    UNLIKE_BLENDER.add("surface")

# The changing geometries that `make test` covers, and those that every kind of sensor reads.
CHANGING = ("built_half", "by_an_armature", "cloth", "mirrored", "nodes_on_a_curve", "text")
READ = ("being_edited", "cloth", "hidden", "mesh_without_anything", "mirrored", "volume_as_mesh")


def rays():
    aside = np.linspace(-0.317, 0.3149, SIDE)
    starts = np.array([(x, y, 0.0) for x in aside for y in aside + 0.00123])
    down, aslant = np.array([0.0, 0.0, -1.0]), np.array([0.48, 0.36, -0.8])
    ways = np.concatenate([np.tile(down, (len(starts), 1)), np.tile(aslant, (len(starts), 1))])
    starts = np.concatenate([starts, starts - 0.47 * (aslant - down)])
    return starts, ways, np.full(len(starts), REACH)


def agreed(name):
    return COARSE.get(name, AGREE)


def met_by_blender(scene, depsgraph):
    """Return ranges (n,) by `scene.ray_cast`."""
    found = []
    for start, way, reach in zip(*rays(), strict=True):
        hit, place, *_ = scene.ray_cast(depsgraph, start, way, distance=reach)
        found.append(np.linalg.norm(np.array(place) - start) if hit else reach)
    return np.array(found)


@pytest.fixture(autouse=True)
def _leave_the_mode():
    yield
    if bpy.context.object and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


@pytest.fixture
def caster(world):
    return make_caster(world.scene)


@pytest.mark.parametrize("name", mostly_slow(ODD, *(set(ODD) - {"particles_that_show_objects"})))
def test_it_is_met_as_blender_meets_it(world, caster, name):
    ODD[name](world)
    depsgraph = world.update()
    caster.update(depsgraph)
    ours = caster.cast(0, 0, *rays())
    assert (ours < REACH).any() == (name not in NOT_MET)
    if name not in UNLIKE_BLENDER:
        assert np.abs(ours - met_by_blender(world.scene, depsgraph)).max() < agreed(name)


@pytest.mark.parametrize("name", mostly_slow(sorted(set(ODD) - UNLIKE_BLENDER), *CHANGING))
def test_it_is_met_as_it_changes(world, caster, name):
    """Frame by frame, as cloth falls and a Build modifier grows; and after the object is moved."""
    obj = ODD[name](world)
    for frame in (1, 2, 3, 4, 8):
        world.scene.frame_set(frame)
        caster.update(world.update())
        theirs = met_by_blender(world.scene, world.update())
        assert np.abs(caster.cast(0, 0, *rays()) - theirs).max() < agreed(name), frame
    obj.location.z -= 0.1
    depsgraph = world.update()
    caster.update(depsgraph)
    moved = met_by_blender(world.scene, depsgraph)
    assert np.abs(caster.cast(0, 0, *rays()) - moved).max() < agreed(name)


def test_a_face_instancer_that_is_not_shown_is_not_met(world, caster):
    """Nine little boxes on a hidden square: rays between them go on."""
    ODD["instances_on_faces"](world)
    caster.update(world.update())
    between = np.array([[0.067, 0.067, 0.0], [0.0, 0.0, 0.0]])
    ways = np.tile([0.0, 0.0, -1.0], (2, 1))
    assert caster.cast(0, 0, between, ways, np.full(2, REACH)) == pytest.approx([REACH, 0.475])


def test_what_is_edited_is_met_as_it_is_shown(world, caster):
    """Two subdivisions leave the middle of a cube's face in place, but not its corner."""
    ODD["being_edited_with_a_modifier"](world)
    caster.update(world.update())
    at = np.array([[0.0011, 0.0013, 0.0], [0.19, 0.19, 0.0]])
    ways = np.tile([0.0, 0.0, -1.0], (2, 1))
    middle, corner = caster.cast(0, 0, at, ways, np.full(2, REACH))
    assert 0.3 < middle < 0.4
    assert corner == REACH


@pytest.mark.parametrize("name", mostly_slow(ODD, *READ))
def test_a_switch_a_detector_and_a_pad_read_it(world, name):
    """A run with every kind near it ends, and with `scene.ray_cast` gives the same."""
    ODD[name](world)
    world.scene.frame_end = 4
    world.switch(range_max=2.0)
    world.pir().location = (0, 0, -0.1)
    hot = world.sensor("PIR", "hot", model="PYROELECTRIC", update_rate=24.0)
    hot.location = (0, 0, -0.1)
    pad = world.box((2, 2, 0.01), (0, 0, -1.0), "floor")
    world.sensor("PRESSURE", "pad", pad, update_rate=24.0)
    light = world.sensor("LIGHT", "light", method="ILLUMINANCE", samples=16, update_rate=24.0)
    light.location = (0, 0, -0.05)
    lamp = bpy.data.lights.new("lamp", "POINT")
    world.link("lamp", lamp, (0.3, 0.2, 0.1))
    fast = world.run(1, 4)
    world.scene.angen_ray_caster = "SCENE"
    slow = world.run(1, 4)
    assert np.isfinite(world.series(fast, "light", "illuminance_lux")).sum() == 4
    if name not in UNLIKE_BLENDER:
        for sensor, column in (("switch", "range_m"), ("pir", "moved"), ("hot", "moved")):
            one, two = (world.series(run, sensor, column) for run in (fast, slow))
            assert one == pytest.approx(two, abs=agreed(name)), sensor
