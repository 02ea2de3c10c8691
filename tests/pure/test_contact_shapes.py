# SPDX-License-Identifier: GPL-3.0-or-later
"""Convex shapes against counts and distances known by hand."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.contact import shapes


def moved(x=0.0, y=0.0, z=0.0, axis=(0, 0, 1), angle=0.0):
    matrix = np.eye(4)
    axis = np.array(axis, float)
    matrix[:3, :3] = shapes.rotation_about(axis / np.linalg.norm(axis), angle)
    matrix[:3, 3] = x, y, z
    return matrix


def fan(loop):
    return [(loop[0], loop[i], loop[i + 1]) for i in range(1, len(loop) - 1)]


def assert_sound(shape):
    """Unit outward normals, all corners inside, loops counter-clockwise, Euler's formula."""
    assert np.linalg.norm(shape.normals, axis=1) == pytest.approx(1.0)
    heights = shape.vertices @ shape.normals.T
    assert (heights <= shape.offsets + 1e-9 * shape.size).all()
    for face, normal, offset in zip(shape.faces, shape.normals, shape.offsets, strict=True):
        loop = shape.vertices[face]
        assert loop @ normal == pytest.approx(offset, abs=1e-6 * shape.size)
        area = np.cross(loop - loop[0], np.roll(loop, -1, 0) - loop[0]).sum(0)
        assert area @ normal > 0
    assert len(shape.vertices) - len(shape.rims) + len(shape.faces) == 2
    for start, end, left, right in shape.rims:
        across = shape.normals[left] + shape.normals[right]
        along = shape.vertices[end] - shape.vertices[start]
        assert across @ along == pytest.approx(0.0, abs=1e-6 * shape.size)
    assert np.allclose(shape.lo, shape.vertices.min(0) - shape.radius)
    assert np.allclose(shape.hi, shape.vertices.max(0) + shape.radius)


@pytest.mark.parametrize(
    ("shape", "corners", "faces", "edges"),
    [
        (shapes.box((1, 2, 3)), 8, 6, 3),
        (shapes.cylinder(1, 2), 96, 50, 25),
        (shapes.cone(1, 2), 49, 49, 72),
    ],
)
def test_solids(shape, corners, faces, edges):
    assert_sound(shape)
    assert (len(shape.vertices), len(shape.faces), len(shape.edges)) == (corners, faces, edges)


def test_points_and_segments():
    ball, pill = shapes.sphere(0.2), shapes.capsule(0.1, 0.3)
    assert len(ball.vertices) == 1 and not ball.faces and len(ball.edges) == 0
    assert pill.hi == pytest.approx((0.1, 0.1, 0.4)) and pill.edges.tolist() == [[0, 0, 1]]
    assert len(shapes.capsule(0.1, 0).vertices) == 1


@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("flip", [False, True])
def test_triangles_of_a_box_become_six_sides(size, flip):
    box = shapes.box((size, 0.7 * size, 0.4 * size))
    triangles = [t[::-1] if flip else t for face in box.faces for t in fan(face.tolist())]
    noise = np.random.default_rng(1).normal(0, 1e-8 * size, box.vertices.shape)
    solid = shapes.polytope(box.vertices + noise, triangles)
    assert len(solid.faces) == 6 and len(solid.vertices) == 8 and len(solid.rims) == 12
    assert_sound(solid)


def test_duplicates_needles_and_points_on_edges_change_nothing():
    box = shapes.box((1, 1, 1))
    extra = np.vstack([box.vertices, box.vertices[0], (1, 1, 0), (0, 0, 1)])
    faces = [t for face in box.faces for t in fan(face.tolist())]
    faces += [(0, 8, 1), (2, 2, 3), (6, 7, 9)]
    solid = shapes.polytope(extra, faces)
    assert_sound(solid)
    assert len(solid.vertices) == 8 and len(solid.faces) == 6


def test_flat_solid_is_a_polygon():
    corners = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (1, 0.5, 0)]
    flat = shapes.polytope(corners, [(0, 1, 2), (0, 2, 3)], radius=0.01)
    assert flat.flat and len(flat.vertices) == 4 and flat.radius == 0.01
    assert sorted(flat.normals[:, 2].tolist()) == [-1, 1]


@pytest.mark.parametrize(
    "make",
    [
        lambda: shapes.box((1, 0, 1)),
        lambda: shapes.box((1, math.nan, 1)),
        lambda: shapes.sphere(0),
        lambda: shapes.sphere(math.inf),
        lambda: shapes.cylinder(1, -1),
        lambda: shapes.polygon([(0, 0, 0), (1, 1, 1), (2, 2, 2)]),
        lambda: shapes.polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)]),
        lambda: shapes.polygon([(0, 0, 0), (1, 0, 0), (0, math.nan, 0)]),
        lambda: shapes.polytope([(0, 0, 0)] * 4, [(0, 1, 2)]),
        lambda: shapes.polytope([], []),
        lambda: shapes.polytope(shapes.box((1, 1, 1)).vertices, [(0, 1, 3), (0, 1, 5)]),
        lambda: shapes.box((1, 1, 1)).placed(np.diag([1.0, 1, 0, 1])),
    ],
)
def test_nonsense_is_told(make):
    with pytest.raises(ValueError, match=r".+"):
        make()


MATRICES = [
    moved(1, 2, 3, (1, 2, 3), 0.7),
    moved(1e4, -1e4, 5, (0, 1, 1), 2.0),
    np.diag([-1.0, 2, 0.5, 1]),
    np.diag([-1.0, -1, -1, 1]),
    np.array([[1, 0.5, 0, 1], [0, 1, 0.2, 0], [0.1, 0, 2, 0], [0, 0, 0, 1.0]]),
]


@pytest.mark.parametrize("matrix", MATRICES)
@pytest.mark.parametrize(
    "shape", [shapes.box((1, 2, 3)), shapes.cylinder(1, 2), shapes.cone(0.5, 1)]
)
def test_placed_solids_are_sound(shape, matrix):
    placed = shape.placed(matrix)
    assert_sound(placed)
    expected = shape.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    assert np.allclose(placed.vertices, expected, rtol=0, atol=1e-11)


def test_scale_leaves_the_radius():
    pill = shapes.capsule(0.1, 0.3).placed(np.diag([2.0, 2, 2, 1]))
    assert pill.radius == 0.1 and pill.hi == pytest.approx((0.1, 0.1, 0.7))


@pytest.mark.parametrize("stretch", [(1, 1, 1), (2, 2, 0.5), (-1, 1, 3)])
def test_turned_round_body_reaches_its_true_radius(stretch):
    matrix = moved(3, 1, 2, (1, 1, 0), 0.4) @ np.diag([*stretch, 1.0])
    body = shapes.cylinder(0.5, 1).placed(matrix)
    axis = body.axis[1]
    for angle in np.linspace(0, 6, 11):
        first, second = shapes.perpendiculars(axis)
        direction = math.cos(angle) * first + math.sin(angle) * second
        turned = body.turned(direction)
        reach = ((turned.vertices - body.axis[0]) @ direction).max()
        assert reach == pytest.approx(0.5 * stretch[1], rel=1e-12)
        assert_sound(turned)


def test_ellipses_are_not_turned():
    assert shapes.cylinder(0.5, 1).placed(np.diag([1.0, 2, 1, 1])).axis is None
