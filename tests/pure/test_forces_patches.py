# SPDX-License-Identifier: GPL-3.0-or-later
"""Convex shapes, and contact patches against closed forms, symmetries and MuJoCo's distances."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.forces import shapes
from angen_sensors.sensor_logic.forces.patches import contact_patch
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import spatial
from solids import at


def assert_convex(shape):
    """Assert unit outward normals, all corners inside, loops counter-clockwise, Euler's formula."""
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


@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("flip", [False, True])
def test_triangles_of_a_box_become_six_sides(size, flip):
    """Duplicates, needles and points on edges change nothing."""
    box = shapes.box((size, size, size))
    noise = np.random.default_rng(1).normal(0, 1e-8 * size, box.vertices.shape)
    extra = np.array([box.vertices[0], (size, size, 0), (0, 0, size)])
    triangles = [(f[0], f[i], f[i + 1]) for f in map(list, box.faces) for i in (1, 2)]
    triangles = [t[::-1] if flip else t for t in triangles]
    for points, more in (
        (box.vertices + noise, []),
        (np.vstack([box.vertices, extra]), [(0, 8, 1), (2, 2, 3), (6, 7, 9)]),
    ):
        solid = shapes.polytope(points, triangles + more)
        assert (len(solid.faces), len(solid.vertices), len(solid.rims)) == (6, 8, 12)
        assert_convex(solid)


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


@pytest.mark.parametrize("stretch", [(1, 1, 1), (2, 2, 0.5), (-1, 1, 3)])
def test_turned_round_body_reaches_its_true_radius(stretch):
    matrix = at(3, 1, 2, (1, 1, 0), 0.4) @ np.diag([*stretch, 1.0])
    body = shapes.cylinder(0.5, 1).placed(matrix)
    axis = body.axis[1]
    for angle in np.linspace(0, 6, 11):
        first, second = shapes.perpendiculars(axis)
        direction = math.cos(angle) * first + math.sin(angle) * second
        turned = body.turned(direction)
        reach = ((turned.vertices - body.axis[0]) @ direction).max()
        assert reach == pytest.approx(0.5 * stretch[1], rel=1e-12)
        assert_convex(turned)
    ellipse = shapes.cylinder(0.5, 1).placed(np.diag([1.0, 2, 1, 1]))
    assert ellipse.axis is None


FLOOR = shapes.box((5, 5, 0.1)).placed(at(z=-0.1))
TOLERANCE = 0.002


# Patches

HALVES = [  # a floor of two triangles
    shapes.polygon([(-5, -5, 0), (5, -5, 0), (5, 5, 0)]),
    shapes.polygon([(-5, -5, 0), (5, 5, 0), (-5, 5, 0)]),
]


def area(patch):
    return float(patch.areas.sum())


def middle(patch):
    return patch.areas @ patch.points / patch.areas.sum()


def second(patch):
    local = patch.points - middle(patch)
    return (patch.areas[:, None] * local).T @ local


def assert_sound(patch):
    assert np.isfinite(patch.points).all() and np.isfinite(patch.gaps).all()
    assert (patch.areas > 0).all() and np.linalg.norm(patch.normal) == pytest.approx(1)


@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("angle", [0.0, 0.5, math.pi / 4])
@pytest.mark.parametrize("gap", [-0.001, 0.0, 0.0005])
def test_box_on_a_floor(size, angle, gap):
    floor = FLOOR.placed(np.diag([size, size, size, 1]))
    gap *= size
    box = shapes.box((0.2 * size, 0.15 * size, 0.3 * size))
    patch = contact_patch(
        box.placed(at(size, 0, 0.3 * size + gap, angle=angle)), floor, 0.002 * size
    )
    assert_sound(patch)
    assert patch.normal == pytest.approx((0, 0, 1), abs=1e-12)
    assert patch.gaps == pytest.approx(gap, abs=1e-12 * size)
    assert middle(patch) == pytest.approx((size, 0, gap / 2), abs=1e-12 * size)
    assert area(patch) == pytest.approx(0.12 * size**2)
    rotation = at(angle=angle)[:3, :3]
    moment = 0.12 / 3 * rotation @ np.diag([0.04, 0.0225, 0]) @ rotation.T
    assert second(patch) == pytest.approx(moment * size**4, abs=1e-12 * size**4)
    assert len(patch.gaps) == 8


@pytest.mark.parametrize(("overlap", "count"), [(0.4, 8), (0.2, 8), (0.01, 8), (1e-5, 3), (0, 3)])
def test_box_over_the_rim_of_the_floor(overlap, count):
    box = shapes.box((0.2, 0.15, 0.3)).placed(at(5.2 - overlap, 1, 0.3))
    patch = contact_patch(box, FLOOR, TOLERANCE)
    assert_sound(patch)
    assert len(patch.gaps) == count
    assert middle(patch) == pytest.approx((5 - overlap / 2, 1, 0), abs=1e-5)
    if count == 8:
        assert area(patch) == pytest.approx(overlap * 0.3)
    if overlap > 0:
        assert patch.normal == pytest.approx((0, 0, 1), abs=1e-9)


def test_boxes_that_share_a_corner_and_a_cylinder_on_the_rim_of_a_pad():
    box = shapes.box((0.2, 0.2, 0.2))
    patch = contact_patch(box, box.placed(at(0.4, 0.4, 0.4005)), TOLERANCE)
    assert_sound(patch)
    assert len(patch.gaps) == 1 and patch.points[0] == pytest.approx((0.2, 0.2, 0.20025))
    pad = shapes.box((0.05, 0.05, 0.001)).placed(at(0.18, 0, 0.001))
    patch = contact_patch(shapes.cylinder(0.2, 0.3).placed(at(z=0.302)), pad, TOLERANCE)
    assert patch.normal == pytest.approx((0, 0, 1), abs=1e-9), "not pushed aside"


def test_tilted_box_keeps_what_is_within_tolerance():
    box = shapes.box((0.2, 0.2, 0.3))
    low = 0.3 * math.cos(0.01) + 0.2 * math.sin(0.01)
    patch = contact_patch(box.placed(at(z=low, axis=(1, 0, 0), angle=0.01)), FLOOR, TOLERANCE)
    assert patch.gaps.min() == pytest.approx(0, abs=1e-12)
    assert patch.gaps.max() == pytest.approx(TOLERANCE)
    assert area(patch) == pytest.approx(0.4 * TOLERANCE / math.tan(0.01), rel=1e-4)
    steep = 0.3 * math.cos(0.5) + 0.2 * math.sin(0.5)
    edge = contact_patch(box.placed(at(z=steep, axis=(1, 0, 0), angle=0.5)), FLOOR, TOLERANCE)
    assert len(edge.gaps) == 3 and edge.gaps == pytest.approx(0, abs=1e-12)
    assert np.ptp(edge.points[:, 0]) == pytest.approx(0.4)


@pytest.mark.parametrize("thick", [0.0001, 0.00045, 0.001, 0.01])
@pytest.mark.parametrize("sunk", [0.0, 0.0001, 0.001, 0.005, 0.009])
def test_box_sunk_into_a_plate_goes_up(thick, sunk):
    box = shapes.box((0.2, 0.15, 0.3)).placed(at(0.01, 0.02, 0.3 + thick - sunk, angle=0.2))
    pad = shapes.box((0.05, 0.05, thick / 2)).placed(at(z=thick / 2))
    patch = contact_patch(box, pad, TOLERANCE)
    assert patch.normal == pytest.approx((0, 0, 1), abs=1e-12)
    assert patch.gaps == pytest.approx(-sunk, abs=1e-12)
    assert area(patch) == pytest.approx(0.01)


@pytest.mark.parametrize("gap", [-0.003, -0.0001, 0.0, 0.0001, 0.001])
@pytest.mark.parametrize("shift", [0.0, 0.0005, 0.15])
def test_box_on_two_triangles(gap, shift):
    box = shapes.box((0.2, 0.15, 0.3))
    placed = box.placed(at(shift, 0, 0.3 + gap, angle=0.3))
    patches = [contact_patch(placed, half, TOLERANCE) for half in HALVES]
    for patch in patches:
        assert patch.normal == pytest.approx((0, 0, 1), abs=1e-12)
        assert patch.gaps == pytest.approx(gap, abs=1e-12)
    assert sum(map(area, patches)) == pytest.approx(0.12)
    total = sum(p.areas @ p.points for p in patches) / 0.12
    assert total == pytest.approx((shift, 0, gap / 2), abs=1e-12)
    # A triangle beside the box does not touch.
    assert contact_patch(box.placed(at(2, 1.6, 0.3 + gap)), HALVES[1], TOLERANCE) is None


@pytest.mark.parametrize("x", [-0.01, -1e-4, 0.0, 1e-4, 0.01])
def test_ball_over_the_seam_of_two_triangles(x):
    ball = shapes.sphere(0.1).placed(at(x, 0, 0.0999))
    patches = [contact_patch(ball, half, TOLERANCE) for half in HALVES]
    gaps = sorted(p.gaps[0] for p in patches)
    assert gaps[0] == pytest.approx(-0.0001)
    assert gaps[1] == pytest.approx(math.hypot(0.0999, x / math.sqrt(2)) - 0.1)


SLANT = math.atan(0.25)  # of the cone's side to its axis
ROUND = [
    (shapes.sphere(0.1), (1, 0, 0), 0.0, 0.1, 1),
    (shapes.capsule(0.1, 0.2), (1, 0, 0), 0.0, 0.3, 1),
    (shapes.capsule(0.1, 0.2), (1, 0, 0), math.pi / 2, 0.1, 3),
    (shapes.capsule(0.1, 0.2), (1, 0, 0), 0.5, 0.1 + 0.2 * math.cos(0.5), 1),
    (shapes.cylinder(0.1, 0.2), (1, 0, 0), math.pi / 2, 0.1, 3),
    (shapes.cylinder(0.1, 0.2), (1, 0.3, 0), 0.5, 0.1 * math.sin(0.5) + 0.2 * math.cos(0.5), 1),
    (shapes.cone(0.1, 0.2), (1, 0.3, 0), math.pi, 0.2, 1),
    (shapes.cone(0.1, 0.2), (1, 0.3, 0), 0.5, 0.1 * math.sin(0.5) + 0.2 * math.cos(0.5), 1),
    (shapes.cone(0.1, 0.2), (1, 0.2, 0), math.pi / 2 + SLANT, 0.2 * math.sin(SLANT), 3),
]


@pytest.mark.parametrize(("shape", "axis", "angle", "height", "count"), ROUND)
@pytest.mark.parametrize("roll", [0.0, 0.03, 0.06])
@pytest.mark.parametrize("gap", [-0.0005, 0.0, 0.001])
def test_round_bodies_over_a_floor(shape, axis, angle, height, count, roll, gap):
    body = shape.placed(at(z=height + gap, axis=axis, angle=angle) @ at(angle=roll))
    patch = contact_patch(body, FLOOR, TOLERANCE)
    assert patch.normal == pytest.approx((0, 0, 1), abs=1e-9)
    assert patch.gaps == pytest.approx(gap, abs=1e-7)
    assert len(patch.gaps) == count


@pytest.mark.parametrize("shape", [shapes.cylinder(0.1, 0.2), shapes.cone(0.1, 0.2)])
def test_standing_round_body(shape):
    patch = contact_patch(shape.placed(at(1, 2, 0.2, angle=0.01)), FLOOR, TOLERANCE)
    assert area(patch) == pytest.approx(math.pi * 0.01, rel=0.003)
    expected = math.pi * 0.1**4 / 4 * np.diag([1, 1, 0])
    assert second(patch) == pytest.approx(expected, rel=0.006, abs=1e-9)
    assert len(patch.gaps) <= 20


def test_crossed_edges_touch_in_a_point():
    roof = shapes.box((0.2, 0.2, 0.2))
    for gap in (-0.01, -0.0001, 0.0, 0.001):
        upper = roof.placed(at(z=0.4 * math.sqrt(2) + gap, axis=(0, 1, 0), angle=math.pi / 4))
        patch = contact_patch(roof.placed(at(axis=(1, 0, 0), angle=math.pi / 4)), upper, TOLERANCE)
        assert len(patch.gaps) == 1 and patch.gaps[0] == pytest.approx(gap, abs=1e-12)
        assert patch.normal == pytest.approx((0, 0, -1), abs=1e-9)


def test_deep_corner_has_all_that_is_under_the_floor():
    """A cube's corner, 30 mm deep: an equilateral triangle in the floor."""
    tip = math.atan(math.sqrt(2))
    turn = at(axis=(1, 0, 0), angle=tip) @ at(angle=math.pi / 4)
    cube = shapes.box((0.2, 0.2, 0.2)).placed(at(z=0.2 * math.sqrt(3) - 0.03) @ turn)
    patch = contact_patch(cube, FLOOR, TOLERANCE)
    assert patch.gaps.min() == pytest.approx(-0.03)
    assert area(patch) == pytest.approx(0.03**2 * 3 * math.sqrt(3) / 2)
    assert middle(patch)[:2] == pytest.approx((0, 0), abs=1e-6)


SHAPES = [
    shapes.box((0.3, 0.2, 0.1)),
    shapes.box((0.5, 0.5, 0.0001)),
    shapes.box((0.001, 0.001, 0.5)),
    shapes.sphere(0.2),
    shapes.capsule(0.1, 0.3),
    shapes.cylinder(0.2, 0.15),
    shapes.cone(0.2, 0.25),
    shapes.polygon([(-0.4, -0.3, 0), (0.5, 0, 0), (0, 0.4, 0)]),
    shapes.polygon([(-0.4, 0, 0), (0.4, 0, 0), (0, 1e-4, 0)], radius=0.02),
    shapes.polytope(
        [(0, 0, 0.3), (0.3, 0, -0.1), (-0.2, 0.3, -0.1), (-0.2, -0.25, -0.1)],
        [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 2, 3)],
        0.01,
    ),
]
NUMBERS = st.integers(0, 2**31)


def placed_pair(seed):
    rng = np.random.default_rng(seed)
    a, b = (SHAPES[i] for i in rng.integers(len(SHAPES), size=2))
    matrices = [
        at(*p, axis, angle)
        for p, axis, angle in (
            (rng.normal(0, 0.2, 3), rng.normal(size=3), rng.uniform(0, 6)) for _ in range(2)
        )
    ]
    return a, b, matrices


@settings(max_examples=150, deadline=None, derandomize=True)
@given(NUMBERS)
def test_order_does_not_matter_and_nothing_is_nan(seed):
    a, b, matrices = placed_pair(seed)
    a, b = a.placed(matrices[0]), b.placed(matrices[1])
    one, two = contact_patch(a, b, 0.05), contact_patch(b, a, 0.05)
    assert (one is None) == (two is None)
    if one is not None:
        assert_sound(one)
        assert one.gaps.max() <= 0.05 + 1e-9
        assert np.array_equal(one.points, two.points) and np.array_equal(one.normal, -two.normal)
        assert np.array_equal(one.gaps, two.gaps) and np.array_equal(one.areas, two.areas)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(NUMBERS, st.sampled_from([1.0, 1e4]))
def test_moving_both_moves_the_contact(seed, far):
    a, b, matrices = placed_pair(seed)
    rng = np.random.default_rng(seed + 1)
    motion = at(*rng.normal(0, far, 3), axis=rng.normal(size=3), angle=rng.uniform(0, 6))
    one = contact_patch(a.placed(matrices[0]), b.placed(matrices[1]), 0.05)
    two = contact_patch(a.placed(motion @ matrices[0]), b.placed(motion @ matrices[1]), 0.05)
    assert (one is None) == (two is None)
    if one is not None:
        assert two.normal == pytest.approx(motion[:3, :3] @ one.normal, abs=1e-6)
        if a is not b and a.axis is None and b.axis is None:  # otherwise frames are free to turn
            assert two.gaps.min() == pytest.approx(one.gaps.min(), abs=1e-6)
            assert area(two) == pytest.approx(area(one), rel=1e-5)
            expected = motion[:3, :3] @ middle(one) + motion[:3, 3]
            assert middle(two) == pytest.approx(expected, abs=1e-4)


def hull(rng):
    points = rng.normal(size=(int(rng.integers(5, 40)), 3)) * rng.uniform(0.2, 1, 3)
    solid = spatial.ConvexHull(points)
    return shapes.polytope(points, solid.simplices), points[solid.vertices]


def mujoco_geom(rng, number):
    kind = ("box", "sphere", "capsule", "mesh")[int(rng.integers(4))]
    size = rng.uniform(0.1, 1, 3)
    if kind == "mesh":
        shape, points = hull(rng)
        text = " ".join(map(repr, points.ravel().tolist()))
        mesh = f'<mesh name="m{number}" vertex="{text}"/>'
        return shape, mesh, f'<geom type="mesh" mesh="m{number}"/>'
    shape = {
        "box": lambda: shapes.box(size),
        "sphere": lambda: shapes.sphere(size[0]),
        "capsule": lambda: shapes.capsule(size[0], size[1]),
    }[kind]()
    return shape, "", f'<geom type="{kind}" size="{size[0]} {size[1]} {size[2]}"/>'


@pytest.mark.parametrize("seed", range(60))
def test_distances_are_those_of_mujoco(seed):
    mujoco = pytest.importorskip("mujoco")
    rng = np.random.default_rng(seed)
    (a, mesh_a, geom_a), (b, mesh_b, geom_b) = (mujoco_geom(rng, i) for i in range(2))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><asset>{mesh_a}{mesh_b}</asset><worldbody>"
        f"<body><freejoint/>{geom_a}</body><body><freejoint/>{geom_b}</body>"
        "</worldbody></mujoco>"
    )
    model.opt.ccd_tolerance, model.opt.ccd_iterations = 1e-12, 500
    data = mujoco.MjData(model)
    way = rng.normal(size=3)
    way *= (a.size + b.size) * rng.uniform(0.4, 0.6) / np.linalg.norm(way)
    matrices = [at(*(way * i), rng.normal(size=3), rng.uniform(0, 6)) for i in range(2)]
    for i, matrix in enumerate(matrices):
        data.qpos[7 * i : 7 * i + 3] = matrix[:3, 3]
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, matrix[:3, :3].ravel())
        data.qpos[7 * i + 3 : 7 * i + 7] = quaternion
    mujoco.mj_forward(model, data)
    distance = mujoco.mj_geomDistance(model, data, 0, 1, 100.0, None)
    if distance <= 0:
        pytest.skip("they overlap")
    a, b = a.placed(matrices[0]), b.placed(matrices[1])
    patch = contact_patch(a, b, distance * 1.01)
    assert patch.gaps.min() == pytest.approx(distance, abs=1e-6 * min(a.size, b.size))
    assert contact_patch(a, b, distance * 0.99) is None


def test_noise_does_not_turn_the_contact():
    """A cube sunk as deep from above as from the side keeps its direction."""
    cube = shapes.box((0.1, 0.1, 0.1))
    rng = np.random.default_rng(0)
    normals = []
    for _ in range(30):
        shift = np.array((0.19, 0.0, 0.19)) + rng.normal(0, 1e-7, 3)
        matrix = at(*shift, axis=rng.normal(size=3), angle=1e-7)
        normals.append(contact_patch(cube.placed(matrix), cube, TOLERANCE).normal)
    assert np.ptp(normals, axis=0).max() < 1e-5


def test_points_integrate_second_degree_polynomials_over_any_polygon():
    """Compared with the exact moments of the triangle fan; all points are inside."""
    rng = np.random.default_rng(3)
    for corners in (3, 4, 5, 7, 12):
        angle = np.sort(rng.uniform(0, 2 * math.pi, corners))
        loop = np.column_stack([0.3 * np.cos(angle), 0.2 * np.sin(angle), 0 * angle])
        if corners == 3:
            loop[:, :2] = [(0.0, 0.0), (0.4, 0.0), (0.39, 0.02)]
        patch = contact_patch(shapes.polygon(loop), FLOOR, TOLERANCE)
        total, first, both = 0.0, np.zeros(3), np.zeros((3, 3))
        for i in range(1, corners - 1):
            p = loop[[0, i, i + 1]]
            part = float(np.cross(p[1] - p[0], p[2] - p[0])[2]) / 2
            total += part
            first += part * p.mean(0)
            both += part / 12 * (p.T @ p + np.outer(p.sum(0), p.sum(0)))
        assert area(patch) == pytest.approx(total)
        assert patch.areas @ patch.points == pytest.approx(first, abs=1e-14)
        got = (patch.areas[:, None] * patch.points).T @ patch.points
        assert got == pytest.approx(both, abs=1e-14)
        for p, q in zip(loop, np.roll(loop, -1, 0), strict=True):
            assert (np.cross(q - p, patch.points - p)[:, 2] > -1e-6).all()
