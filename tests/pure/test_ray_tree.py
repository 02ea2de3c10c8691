# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against surfaces of very many triangles, held to every triangle asked one by one."""

import numpy as np
import pytest
from angen_sensors.sensor_logic.geometry.trees import RayTree
from tiers import mostly_slow


def one_by_one(points, triangles, origins, directions, limits):
    """The nearest hit of each ray by Möller and Trumbore's equations, in double precision."""
    ways = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    a, b, c = (points[triangles[:, i]].astype(float) for i in range(3))
    best = np.full(len(ways), np.inf)
    for i, (start, way) in enumerate(zip(origins, ways, strict=True)):
        with np.errstate(all="ignore"):
            across = np.cross(way, c - a)
            whole = np.einsum("ij,ij->i", b - a, across)
            u = np.einsum("ij,ij->i", start - a, across) / whole
            up = np.cross(start - a, b - a)
            v = up @ way / whole
            far = np.einsum("ij,ij->i", c - a, up) / whole
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (far >= 0) & (far <= limits[i])
        best[i] = far[hit].min(initial=np.inf)
    return best


def soup(rng, count, size):
    """Triangles of all sizes strewn about, far from the origin."""
    middles = rng.uniform(-5, 5, (count, 1, 3)) + (40, 0, -7)
    corners = middles + rng.normal(size=(count, 3, 3)) * size
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * count, dtype=np.int32).reshape(
        -1, 3
    )


@pytest.mark.parametrize("count", mostly_slow([1, 7, 8, 9, 65, 600, 5000], 1, 7, 8, 9, 65, 600))
@pytest.mark.parametrize("size", [0.01, 0.3, 4.0])
def test_every_ray_meets_what_it_meets_one_by_one(count, size):
    rng = np.random.default_rng(count)
    points, triangles = soup(rng, count, size)
    origins = rng.uniform(-6, 6, (300, 3)) + (40, 0, -7)
    directions = rng.normal(size=(300, 3)) * rng.uniform(0.1, 10, (300, 1))
    directions[:60] = np.round(directions[:60])  # Some along axes and planes.
    directions[~directions.any(axis=1)] = (0, 0, -1)
    limits = rng.choice([1.0, 5.0, np.inf], 300)
    far, met = RayTree(points, triangles).meet(origins, directions, limits)
    expected = one_by_one(points, triangles, origins, directions, limits)
    assert far == pytest.approx(expected, abs=1e-9)
    assert ((met >= 0) == np.isfinite(expected)).all()


def grid(side):
    """A square of a side of 1 at z = 0, of 2 side² triangles whose corners are shared."""
    x, y = np.meshgrid(np.linspace(0, 1, side + 1), np.linspace(0, 1, side + 1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1).astype(np.float32)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    corners = [first + c for c in (0, 1, side + 2, 0, side + 2, side + 1)]
    return points, np.stack(corners, 1).reshape(-1, 3).astype(np.int32)


def test_no_ray_slips_through_along_edges_and_corners():
    points, triangles = grid(37)
    tree = RayTree(points, triangles)
    ends = points[(points[:, :2] > 0).all(1) & (points[:, :2] < 1).all(1)].astype(float)
    middles = (ends[:-1] + ends[1:]) / 2
    for targets in (ends, middles):
        for origin in ((0.31, 0.62, 1.7), (-3.0, 5.0, 0.01), (1e3, 2e3, 5e3)):
            origins = np.tile(origin, (len(targets), 1))
            far, _ = tree.meet(origins, targets - origins, np.full(len(targets), np.inf))
            inner = (targets[:, :2] > 0.01).all(1) & (targets[:, :2] < 0.99).all(1)
            wanted = np.linalg.norm(targets - origins, axis=1)
            assert far[inner] == pytest.approx(wanted[inner], rel=1e-9)


def test_a_ray_alone_and_among_others_reads_the_same_bits():
    rng = np.random.default_rng(3)
    points, triangles = soup(rng, 3000, 0.5)
    tree = RayTree(points, triangles)
    origins = np.tile((40.0, 0.0, -7.0), (2500, 1))
    directions = rng.normal(size=(2500, 3))
    far, met = tree.meet(origins, directions, np.full(2500, 9.0))
    for i in range(0, 2500, 97):
        one = tree.meet(origins[i : i + 1], directions[i : i + 1], np.array([9.0]))
        assert (one[0][0], one[1][0]) == (far[i], met[i])


def test_corners_that_are_nowhere_take_their_triangles_alone_away():
    points, triangles = grid(20)
    points[0], points[200] = np.nan, np.inf
    tree = RayTree(points, triangles)
    origins = np.array([[0.9, 0.9, 1.0], [0.001, 0.001, 1.0]])
    far, _ = tree.meet(origins, np.tile((0.0, 0.0, -2.0), (2, 1)), np.full(2, 9.0))
    assert far.tolist() == [1.0, np.inf]
    nothing = RayTree(np.full((3, 3), np.nan, np.float32), np.array([[0, 1, 2]], np.int32))
    assert nothing.meet(origins, origins, np.full(2, 9.0))[1].tolist() == [-1, -1]


def test_a_single_ray_tells_point_normal_triangle_and_distance():
    points, triangles = grid(10)
    point, normal, number, far = RayTree(points, triangles).ray_cast((0.52, 0.43, 3), (0, 0, -2))
    assert point == pytest.approx([0.52, 0.43, 0]) and far == 3.0
    assert normal == pytest.approx([0, 0, 1])
    assert np.allclose(points[triangles[number]].mean(0), (0.52, 0.43, 0), atol=0.07)
    assert RayTree(points, triangles).ray_cast((0, 0, 3), (0, 0, 1)) == (None,) * 4
