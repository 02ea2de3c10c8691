# SPDX-License-Identifier: GPL-3.0-or-later
"""The warmth of what a pyroelectric detector's rays meet."""

import math

import numpy as np
import pytest

ZERO = 273.15
SIGHT = 50.0


@pytest.fixture
def probe(world, addon_part):
    """Looks along directions (n, 3) from a place; emission as the detector is told."""

    class Probe:
        def __init__(self):
            self.probes = addon_part("angen_addon.runtime.probes").Probes(world.scene)

        def __call__(self, place, directions, sensor=0, bundle=0):
            depsgraph = world.update()
            self.probes.look(depsgraph, None)
            directions = np.array(directions, float).reshape(-1, 3)
            directions /= np.linalg.norm(directions, axis=1)[:, None]
            origins = np.tile(np.array(place, float), (len(directions), 1))
            length = np.full(len(directions), SIGHT)
            rays = origins, directions, length
            return self.probes.warmth.see(depsgraph, sensor, bundle, *rays)[0]

    return Probe()


def celsius(seen):
    return (seen.temperature - ZERO).tolist()


AHEAD = [(0, 1, 0)]


@pytest.fixture
def target(world):
    return world.box((1, 1, 1), (0, 3, 0), "target")


def test_what_has_no_temperature_is_as_warm_as_the_room(world, probe, target):
    world.scene.angen_ambient_temperature = 22.5
    seen = probe((0, 0, 0), [(0, 1, 0), (0, -1, 0)])
    assert celsius(seen) == pytest.approx([22.5, 22.5])
    assert seen.ambient == pytest.approx(22.5 + ZERO)


def test_object_collection_and_material(world, probe, target):
    bpy = world.bpy
    outer, inner = (bpy.data.collections.new(name) for name in ("outer", "inner"))
    world.scene.collection.children.link(outer)
    outer.children.link(inner)
    world.scene.collection.objects.unlink(target)
    inner.objects.link(target)
    world.warm(outer, 40.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([40.0])
    world.warm(inner, 45.0, 0.5)
    seen = probe((0, 0, 0), AHEAD)
    assert celsius(seen) == pytest.approx([45.0]) and seen.emissivity == pytest.approx([0.5])
    world.warm(target, 50.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([50.0])
    material = bpy.data.materials.new("hot")
    target.data.materials.append(material)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([50.0])
    world.warm(material, 60.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([60.0])
    material.angen_warmth.use_temperature = False
    target.angen_warmth.use_temperature = False
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([45.0])


def checkered(world, name="checkered"):
    """A wall of 4 × 4 quads, 2 m wide, across +Y at y = 3, of four materials at 30 … 33 °C; the
    fourth has no temperature. Which is where: by the column."""
    points = [(x / 2 - 1, 0, z / 2 - 1) for z in range(5) for x in range(5)]
    faces = [
        (5 * z + x, 5 * z + x + 1, 5 * z + x + 6, 5 * z + x + 5) for z in range(4) for x in range(4)
    ]
    obj = world.link(name, world.mesh(points, faces, name), (0, 3, 0))
    for i in range(4):
        material = world.bpy.data.materials.new(f"{name} {i}")
        obj.data.materials.append(material)
        if i < 3:
            world.warm(material, 30.0 + i)
    obj.data.polygons.foreach_set("material_index", [i % 4 for i in range(16)])
    return obj


COLUMNS = [(x, 3, z) for z in (-0.75, -0.2, 0.3, 0.8) for x in (-0.75, -0.25, 0.25, 0.75)]
EXPECTED = [30.0, 31.0, 32.0, 20.0] * 4


@pytest.mark.parametrize("place", [0.0, 1000.0])
def test_each_face_has_the_temperature_of_its_material(world, probe, place):
    """Also where the tree is built of triangles, as for meshes far from their origin."""
    obj = checkered(world)
    for vertex in obj.data.vertices:
        vertex.co.x += place
    obj.location.x = -place
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx(EXPECTED)
    world.warm(obj, 25.0)
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx([30.0, 31.0, 32.0, 25.0] * 4)


def test_faces_of_what_moves_turns_and_is_subdivided(world, probe):
    obj = checkered(world)
    probe((0, 0, 0), COLUMNS)
    obj.location.x = 0.5
    # Column by column the materials have moved by one; the last ray passes beside the wall.
    moved = [(x + 0.5, 3, z) for x, _, z in COLUMNS]
    assert celsius(probe((0, 0, 0), moved)) == pytest.approx(EXPECTED)
    obj.location.x, obj.rotation_euler = 0, (0, math.pi, 0)
    turned = [20.0, 32.0, 31.0, 30.0] * 4
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx(turned)
    obj.modifiers.new("finer", "SUBSURF").levels = 2
    obj.modifiers["finer"].subdivision_type = "SIMPLE"
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx(turned)


def test_faces_agree_with_blenders_own_ray_cast(world, probe):
    """A sphere of random materials, met from all round."""
    bpy = world.bpy
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1.0)
    ball = bpy.context.object
    chance = np.random.default_rng(3)
    for i in range(6):
        material = bpy.data.materials.new(f"m{i}")
        world.warm(material, 20.0 + 5 * i)
        ball.data.materials.append(material)
    ball.data.polygons.foreach_set("material_index", chance.integers(0, 6, len(ball.data.polygons)))
    depsgraph = world.update()
    origins = chance.normal(size=(200, 3))
    origins *= 5 / np.linalg.norm(origins, axis=1)[:, None]
    for origin in origins:
        way = -origin / 5 + chance.uniform(-0.1, 0.1, 3)
        hit, _, _, face, _, _ = world.scene.ray_cast(depsgraph, origin.tolist(), way.tolist())
        expected = 20.0 + 5 * ball.data.polygons[face].material_index if hit else 20.0
        assert celsius(probe(origin, [way])) == pytest.approx([expected])


def test_slots_that_belong_to_the_object(world, probe, target):
    mine, of_data = (world.bpy.data.materials.new(name) for name in ("mine", "of data"))
    world.warm(mine, 41.0)
    world.warm(of_data, 42.0)
    target.data.materials.append(of_data)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([42.0])
    target.material_slots[0].link = "OBJECT"
    target.material_slots[0].material = mine
    target.update_tag()
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([41.0])


def test_instances_are_as_warm_as_their_source(world, probe):
    bpy = world.bpy
    source = world.box((1, 1, 1), (0, 0, 0), "source")
    collection = bpy.data.collections.new("instanced")
    world.scene.collection.objects.unlink(source)
    collection.objects.link(source)
    empty = world.link("instance", None, (0, 3, 0))
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    world.warm(source, 37.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([37.0])


def test_a_kettle_that_heats_up(world, probe, target):
    world.warm(target, 20.0)
    world.key(target, "angen_warmth.temperature", {1: 20.0, 41: 100.0})
    found = []
    for frame in (1, 11, 21, 41):
        world.scene.frame_set(frame)
        found += celsius(probe((0, 0, 0), AHEAD))
    assert found == pytest.approx([20, 40, 60, 100], abs=0.1)


def test_a_material_that_heats_up(world, probe):
    obj = checkered(world)
    material = obj.data.materials[0]
    world.key(material, "angen_warmth.temperature", {1: 30.0, 21: 50.0})
    for frame, first in ((1, 30.0), (21, 50.0)):
        world.scene.frame_set(frame)
        assert celsius(probe((0, 0, 0), COLUMNS[:2])) == pytest.approx([first, 31.0], abs=0.1)


def test_the_sensors_own_housing_is_not_seen(world, probe, target):
    housing = world.box((0.1, 0.1, 0.1), (0, 0.2, 0), "housing")
    world.warm(housing, 60.0)
    world.warm(target, 30.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([60.0])
    assert celsius(probe((0, 0, 0), AHEAD, sensor=housing.session_uid)) == pytest.approx([30.0])
