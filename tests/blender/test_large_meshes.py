# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of so many triangles that a tree of Blender's would cost too much are met as all others
are."""

import bpy
import numpy as np
import pytest

from benchmarks.big import hills

TRIANGLES = 260_000


@pytest.fixture
def ground(world):
    """Hilly ground of 4 × 4 m 1.5 m below the sensors."""
    return world.link("ground", hills(TRIANGLES, 4.0), (0, 0, -1.5))


def uses_ray_tree(addon_part, solids):
    ray_tree = addon_part("sensor_logic.geometry.trees").RayTree
    return [isinstance(solid.geometry._built.tree, ray_tree) for solid in solids.solids]


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.2, -0.1, 1.0)])
@pytest.mark.parametrize("scale", [(1, 1, 1), (0.5, 1.5, 2)])
def test_ranges_are_those_of_blenders_own_ray_cast(world, ground, turn, scale):
    ground.rotation_euler, ground.scale = turn, scale
    pir = world.pir(range_min=0.0, range_max=3.0, rays=90)
    ranges = {}
    for caster in ("FAST", "SCENE"):
        world.scene.angen_ray_caster = caster
        ranges[caster] = world.rays(pir)[2]
    assert (ranges["FAST"] < 2.9).sum() > 40
    assert ranges["FAST"] == pytest.approx(ranges["SCENE"], abs=5e-5)


def test_a_bump_that_grows_is_seen(world, ground, each_caster):
    """A shape key that lifts the ground under the detector at frame 24."""
    ground.shape_key_add(name="flat")
    high = ground.shape_key_add(name="high")
    points = np.empty(3 * len(ground.data.vertices), np.float32)
    ground.data.vertices.foreach_get("co", points)
    points[2::3] += 0.4
    high.data.foreach_set("co", points)
    world.key(ground.data.shape_keys, 'key_blocks["high"].value', {1: 0, 23: 0, 24: 1}, "CONSTANT")
    world.pir()
    rows = world.log(world.run())
    assert [(row[1], row[5]) for row in rows] == [("1", "0"), ("24", "1"), ("25", "0")]


def test_instances_and_faces_of_large_meshes_are_told_apart(world, addon_part):
    """Two instances of a square of 370 × 370 faces of four corners, whose material changes from
    column to column."""
    side = 370
    points = [(x * 0.01, y * 0.01, 0.0) for y in range(side + 1) for x in range(side + 1)]
    first = [y * (side + 1) + x for y in range(side) for x in range(side)]
    mesh = world.mesh(points, [(i, i + 1, i + side + 2, i + side + 1) for i in first])
    for name in ("stone", "grass"):
        mesh.materials.append(bpy.data.materials.new(name))
    mesh.polygons.foreach_set("material_index", np.arange(side**2, dtype=np.int32) % side % 2)
    collection = bpy.data.collections.new("tile")
    collection.objects.link(bpy.data.objects.new("ground", mesh))
    for name, x in (("left", -5.0), ("right", 5.0)):
        holder = world.link(name, None, (x, 0, -1.5))
        holder.instance_type, holder.instance_collection = "COLLECTION", collection
    depsgraph = world.update()
    caster = addon_part("angen_addon.scene.rays.caster").RayCaster()
    caster.update(depsgraph)
    columns = np.array([3, 100, 211, 368])
    origins = np.array([(x + 0.01 * c + 0.004, 1.0, 0.0) for x in (-5, 5) for c in columns])
    ways, length = np.tile((0.0, 0.0, -1.0), (8, 1)), np.full(8, 9.0)
    seen = caster.see_at(0, 0, origins, ways, length, np.array([0]))[0]
    ranges, met = seen.ranges, seen.met
    assert ranges == pytest.approx([1.5] * 8, abs=1e-6)
    names = [caster.solids.name_of(number) for number in met]
    assert names == ["ground in left"] * 4 + ["ground in right"] * 4
    assert uses_ray_tree(addon_part, caster.solids) == [True, True]
    solid = next(s for s in caster.solids.solids if s.number == met[0])
    faces = seen.faces[:4]
    slots = solid.geometry.material_slots(depsgraph)
    assert slots[faces].tolist() == (columns % 2).tolist()


def test_objects_of_one_mesh_share_its_surface_until_one_has_its_own(world, addon_part):
    """Whatever is edited, each is met where Blender's own ray cast meets it."""
    first = world.wall(1.0, "first")
    walls = [first, *(world.link(name, first.data, (0, 0, -1.0)) for name in ("second", "third"))]
    for x, wall in enumerate(walls):
        wall.location.x = 3.0 * x
    caster = addon_part("angen_addon.scene.rays.caster").RayCaster()
    origins = np.array([(3.0 * x + 0.1, 0.1, 0.0) for x in range(3)])
    ways, length = np.tile((0.0, 0.0, -1.0), (3, 1)), np.full(3, 9.0)

    def ranges():
        caster.solids.forget()
        caster.update(world.update())
        return caster.cast(0, 0, origins, ways, length).tolist()

    def surfaces():
        return len({id(solid.geometry.state) for solid in caster.solids.solids})

    assert ranges() == pytest.approx([1, 1, 1]) and surfaces() == 1
    for vertex in first.data.vertices:
        vertex.co.z = 0.25
    first.data.update()
    assert ranges() == pytest.approx([0.75] * 3) and surfaces() == 1
    modifier = walls[1].modifiers.new("up", "DISPLACE")
    modifier.direction, modifier.mid_level, modifier.strength = "Z", 0.0, 0.5
    assert ranges() == pytest.approx([0.75, 0.25, 0.75]) and surfaces() == 2
    walls[2].data = first.data.copy()
    for vertex in walls[2].data.vertices:
        vertex.co.z = -1.0
    assert ranges() == pytest.approx([0.75, 0.25, 2.0])
    bpy.data.objects.remove(first)
    walls[1].modifiers.clear()
    assert ranges() == pytest.approx([9.0, 0.75, 2.0])
