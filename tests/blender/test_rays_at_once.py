# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that are met all at once, from one point or one way, against Blender's hierarchy; and what
the caster remembers of solids that move now and then."""

import bmesh
import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import state
from bl_ext.user_default.angen_sensors.angen_addon.scene.contact import posed_bodies
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays import changing_shapes
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays.caster import RayBundle, RayCaster
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays.reference import SceneRayCaster
from mathutils.bvhtree import BVHTree
from random_scene import LAST_FRAME, RandomScene
from tiers import mostly_slow

# Blender's hierarchy is in single precision.
TOLERANCE = 5e-6


def lump(subdivisions=3):
    """Vertices and triangles of a lumpy ball of 1 m."""
    mesh = bmesh.new()
    bmesh.ops.create_icosphere(mesh, subdivisions=subdivisions, radius=1.0)
    for vertex in mesh.verts:
        vertex.co *= 1.0 + 0.3 * np.sin(5.0 * vertex.co.x) * np.cos(4.0 * vertex.co.z)
    mesh.verts.index_update()
    points = np.array([vertex.co for vertex in mesh.verts], np.float32)
    corners = np.array([[vertex.index for vertex in face.verts] for face in mesh.faces])
    mesh.free()
    return points, corners


def tree_of(points, corners):
    return BVHTree.FromPolygons(points.tolist(), corners.tolist(), all_triangles=True, epsilon=0.0)


def met_by(tree, starts, ways, length):
    found = [tree.ray_cast(s, w, m)[3] for s, w, m in zip(starts, ways, length, strict=True)]
    return np.array([np.inf if distance is None else distance for distance in found])


def rays_at(random, at, spread, count, fan=False):
    """Origins and directions of rays from a place, about the way to the origin, perhaps all in a
    plane."""
    ways = -at / max(np.linalg.norm(at), 1e-9) + spread * random.normal(size=(count, 3))
    if fan:
        normal = np.cross(at + 1e-3, random.normal(size=3))
        normal /= np.linalg.norm(normal)
        ways -= (ways @ normal)[:, None] * normal
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    return at + 0.05 * ways, ways


def meet_shape(points, corners, origins, ways):
    """How far rays go to a shape with `points` (3, n) at three frames at which it is the same, inf
    where they miss it, and to which triangle."""
    rays = RayBundle(origins, ways, np.full(len(ways), np.inf))
    shapes, still = np.stack([points] * 3), np.stack([np.eye(4)] * 3)
    hits = changing_shapes.meet(
        shapes,
        corners.T,
        still,
        still,
        rays.pictures,
        origins,
        ways,
        np.ones((3, len(ways)), bool),
    )
    far, face = np.full((3, len(ways)), np.inf), np.zeros((3, len(ways)), int)
    far[hits.frame, hits.ray], face[hits.frame, hits.ray] = hits.far, hits.triangle
    assert (far == far[0]).all() and (face == face[0]).all()
    return far[0], face[0]


@pytest.mark.parametrize("fan", mostly_slow([False, True], True))
@pytest.mark.parametrize("far_off", mostly_slow([0.0, 500.0], 500.0))
@pytest.mark.parametrize(
    ("distance", "spread", "count"),
    mostly_slow(
        [
            (3.0, 0.2, 80),
            (6.0, 0.02, 300),
            (1.5, 0.6, 50),
            (0.0, 1.0, 60),
            (1.0, 3.0, 60),
            (3.0, 0.1, 1),
        ],
        (1.5, 0.6, 50),
        (3.0, 0.1, 1),
    ),
)
def test_rays_from_a_place_meet_a_shape_as_in_its_hierarchy(distance, spread, count, far_off, fan):
    """Far and near, within it and all around; the same triangle as a test of each with each."""
    random = np.random.default_rng(1)
    points, corners = lump()
    tree, hits = tree_of(points, corners), 0
    moved = (points.astype(np.float64) + far_off).T
    for _ in range(12):
        at = random.normal(size=3)
        at *= distance / np.linalg.norm(at)
        origins, ways = rays_at(random, at, spread, count, fan)
        expected = met_by(tree, origins, ways, np.full(count, 9.0))
        apex = changing_shapes.apex_of(origins + far_off, ways)
        assert apex == pytest.approx(at + far_off, abs=1e-6) or count == 1
        far, face = meet_shape(moved, corners, origins + far_off, ways)
        both = np.isfinite(far) & np.isfinite(expected)
        # On the outline a hair's breadth decides.
        assert (np.isfinite(far) != np.isfinite(expected)).sum() <= 1
        np.testing.assert_allclose(far[both], expected[both], atol=TOLERANCE)
        hits += both.sum()
        alone = [
            meet_shape(moved, corners, o[None] + far_off, w[None])
            for o, w in zip(origins, ways, strict=True)
        ]
        assert far.tobytes() == np.concatenate([one[0] for one in alone]).tobytes()
        assert face[both].tolist() == [
            int(one[1][0]) for one, b in zip(alone, both, strict=True) if b
        ]
    assert hits > 3


@pytest.mark.parametrize("passed", [0.0, 2.0])
def test_rays_to_a_place_meet_what_is_on_their_way(passed):
    """Those to a lamp begin all around it and end there, or go on behind it."""
    random = np.random.default_rng(2)
    points, corners = lump()
    tree, hits = tree_of(points, corners), 0
    for _ in range(12):
        lamp = random.normal(size=3) * 2.0
        ways = random.normal(size=(80, 3)) * 0.4 + lamp
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        origins = lamp - ways * random.uniform(1.0, 5.0, (80, 1)) + ways * passed
        expected = met_by(tree, origins, ways, np.full(80, 9.0))
        far, _ = meet_shape(points.T, corners, origins, ways)
        both = np.isfinite(far) & np.isfinite(expected)
        assert (np.isfinite(far) != np.isfinite(expected)).sum() <= 1
        np.testing.assert_allclose(far[both], expected[both], atol=TOLERANCE)
        hits += both.sum()
    assert hits > 100


def test_only_rays_from_one_point_have_one():
    random = np.random.default_rng(2)
    origins, ways = rays_at(random, np.array([1.0, 2.0, 3.0]), 0.3, 9)
    assert changing_shapes.apex_of(origins, ways) == pytest.approx((1.0, 2.0, 3.0))
    aside = np.tile([0.0, 0.0, -1.0], (5, 1))
    assert changing_shapes.apex_of(np.arange(15.0).reshape(5, 3), aside) is None
    assert changing_shapes.apex_of(random.normal(size=(9, 3)), ways) is None


@pytest.mark.parametrize("seed", range(6))
def test_parallel_rays_hit_the_nearest_triangle_within_their_length(seed):
    random = np.random.default_rng(seed)
    points, corners = lump()
    way = random.normal(size=3) if seed else np.array([0.0, 0.0, -1.0])
    way /= np.linalg.norm(way)
    starts = random.uniform(-1.3, 1.3, (700, 3)) - way
    length = random.uniform(0.1, 2.5, len(starts))
    expected = met_by(tree_of(points, corners), starts, np.tile(way, (700, 1)), length)
    surface = posed_bodies.with_bounds(points[corners].astype(np.float64))
    got = posed_bodies.hit_distances(surface, starts, way, length)
    undecided = np.isfinite(got) != np.isfinite(expected)
    assert undecided.sum() <= 2
    both = np.isfinite(got) & np.isfinite(expected)
    # Towards the outline, where a surface is seen nearly edge on, single precision blurs more.
    error = np.abs(got[both] - expected[both])
    assert np.median(error) < 1e-6 and np.quantile(error, 0.98) < 2e-5
    assert 100 < both.sum() < 600


def test_parallel_rays_hit_each_of_many_surfaces_as_if_it_were_the_only_one():
    random = np.random.default_rng(5)
    points, corners = lump()
    starts, length = random.uniform(-1.3, 1.3, (300, 3)), random.uniform(0.1, 2.5, 300)
    way = np.array([0.6, 0.0, -0.8])
    kept = posed_bodies.ParallelRays(starts, way, length)
    met = 0
    for _ in range(12):
        moved = points[corners] * random.uniform(0.2, 1.5) + random.uniform(-1.0, 1.0, 3)
        surface = posed_bodies.with_bounds(moved)
        anew = posed_bodies.hit_distances(surface, starts, way, length)
        assert (kept.hit_distances(surface) == anew).all()
        expected = met_by(
            tree_of(moved.reshape(-1, 3), np.arange(len(moved) * 3).reshape(-1, 3)),
            starts,
            np.tile(way, (300, 1)),
            length,
        )
        assert (np.isfinite(anew) != np.isfinite(expected)).sum() <= 2
        met += int(np.isfinite(anew).sum())
    assert met > 300


def test_parallel_rays_leave_no_gap_along_edges():
    """Straight onto the edges and corners of a grid of triangles."""
    side = np.linspace(0, 1, 6)
    corner = np.array([(x, y, 0.0) for x in side[:-1] for y in side[:-1]])
    a, b = np.array([0.2, 0, 0]), np.array([0, 0.2, 0])
    triangles = np.concatenate(
        [np.stack([corner, corner + a, corner + b], 1),
         np.stack([corner + a, corner + a + b, corner + b], 1)]
    )  # fmt: skip
    at = np.linspace(0.0, 1.0, 21)
    starts = np.array([(x, y, 1.0) for x in at for y in at])
    surface = posed_bodies.with_bounds(triangles)
    got = posed_bodies.hit_distances(
        surface, starts, np.array([0.0, 0.0, -1.0]), np.full(len(starts), 2.0)
    )
    assert got == pytest.approx(np.ones(len(starts)), abs=1e-12)
    beside = posed_bodies.hit_distances(
        surface, starts + [1.01, 0, 0], np.array([0.0, 0, -1.0]), np.full(441, 2)
    )
    assert np.isinf(beside).all()
    no_reach = posed_bodies.hit_distances(
        surface, starts, np.array([0.0, 0.0, -1.0]), np.full(441, 0.99)
    )
    assert np.isinf(no_reach).all()


def test_parallel_rays_pass_over_what_is_no_place():
    triangles = np.full((3, 3, 3), np.nan)
    triangles[1] = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    triangles[2] = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    up = np.array([0.0, 0.0, 1.0])
    got = posed_bodies.hit_distances(
        posed_bodies.with_bounds(triangles), np.array([(0.2, 0.2, -1)]), up, np.ones(1) * 3
    )
    assert got == pytest.approx([1.0])


def test_a_body_that_changes_shape_is_seen_at_each_frame(empty_scene):
    points, corners = lump()
    mesh = bpy.data.meshes.new("lump")
    mesh.from_pydata(points.tolist(), [], corners.tolist())
    body = bpy.data.objects.new("lump", mesh)
    bpy.context.scene.collection.objects.link(body)
    body.rotation_euler, body.scale = (0.3, 0.2, 1.0), (1.0, 1.2, 0.9)
    body.shape_key_add(name="Basis")
    key = body.shape_key_add(name="wide")
    for vertex, point in zip(mesh.vertices, key.data, strict=True):
        point.co = vertex.co * 1.3
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=20)
    pair = RayCaster(), SceneRayCaster(bpy.context.scene)
    for caster in pair:
        state.CACHE.watch(caster.solids)
    random = np.random.default_rng(3)
    hits = 0
    for frame in range(1, 20):
        bpy.context.scene.frame_set(frame)
        at = random.normal(size=3)
        origins, ways = rays_at(random, at * 3.0 / np.linalg.norm(at), 0.2, 24)
        fast, slow = (
            caster.update(bpy.context.evaluated_depsgraph_get())
            or caster.cast(0, 0, origins, ways, np.full(len(ways), 6.0))
            for caster in pair
        )
        wrong = np.abs(fast - slow) > 2e-5
        assert wrong.sum() <= 1, (frame, fast[wrong], slow[wrong])
        hits += int((slow < 6.0).sum())
        assert pair[0].solids.solids[0].geometry.deforms
    assert hits > 150


@pytest.mark.parametrize("seed", range(4))
def test_bundles_that_take_turns_miss_no_change(empty_scene, seed):
    """Each bundle is cast now and then; whatever moved in between, it sees what is there."""
    world = RandomScene(seed, False)
    random = np.random.default_rng(seed)
    pair = RayCaster(), SceneRayCaster(world.scene)
    for caster in pair:
        state.CACHE.watch(caster.solids)
    bundles = [tuple(np.array([tuple(v) for v in part]) for part in world.rays(30)) for _ in "123"]
    sensor = world.scene.objects[0].session_uid
    wrong = hits = 0
    for frame in range(1, min(LAST_FRAME, 24)):
        world.scene.frame_set(frame)
        for caster in pair:
            caster.update(bpy.context.evaluated_depsgraph_get())
        which = int(random.integers(3))
        origins, ways = bundles[which]
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        fast, slow = (c.cast(sensor, which, origins, ways, np.full(30, 6.0)) for c in pair)
        wrong += int((np.abs(fast - slow) > 2e-5).sum())
        hits += int((slow < 6.0).sum())
    # Grazing rays are undecided in single precision.
    assert wrong <= hits / 100
    assert hits > 60
