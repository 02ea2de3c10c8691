# SPDX-License-Identifier: GPL-3.0-or-later
"""Movements between two poses, hits of moving rays on triangles, and the remaining light.

Also rays against surfaces of very many triangles, compared with a test of every triangle.
"""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.geometry.sweep import (
    Movement,
    RayCrossings,
    _intersections,
    crossings,
    pieces_needed,
    seen_from,
)
from angen_sensors.sensor_logic.geometry.trees import RayTree, TriangleTree
from angen_sensors.sensor_logic.kinds.optical_switch import light_between
from hypothesis import given, settings
from hypothesis import strategies as st
from tiers import mostly_slow


def turn(axis, angle):
    """Return a rotation (3, 3) by a quaternion, unlike the product's code."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis) * math.sin(angle / 2)
    w = math.cos(angle / 2)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrix(linear, at):
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = linear, at
    return made


def about(point, linear):
    return matrix(linear, np.asarray(point) - linear @ point)


# Movements


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 0.1, 1.0, 2.0, 3.0, math.pi - 1e-7])
@pytest.mark.parametrize("axis", [(0, 0, 1), (1, -2, 0.5), (-1, 0, 0)])
def test_a_hinge_is_exact_wherever_the_origin_is(angle, axis):
    """Scaled, mirrored, and 1 m from the hinge."""
    shape = turn((3, 1, 2), 0.7) @ np.diag([2.0, -0.5, 0.01])
    before, hinge = matrix(shape, (0.3, -0.2, 0.9)), (0.1, 0.4, -0.2)
    movement = Movement(before, about(hinge, turn(axis, angle)) @ before)
    assert movement.angle == pytest.approx(angle, rel=1e-6)
    shares = np.array([0.0, 0.25, 0.5, 0.9, 1.0])
    for share, found in zip(shares, movement.at(shares), strict=True):
        expected = about(hinge, turn(axis, angle * share)) @ before
        np.testing.assert_allclose(found, expected, atol=2e-8)


def test_a_screw_glides_along_its_axis():
    glide = matrix(np.eye(3), np.array([1, 1, 0]) / math.sqrt(2) * 0.3)
    before = matrix(turn((1, 0, 0), 0.2), (0.5, 0, 0))
    whole = glide @ about((0, 0, 1), turn((1, 1, 0), 1.2))
    half = matrix(np.eye(3), glide[:3, 3] / 2) @ about((0, 0, 1), turn((1, 1, 0), 0.6))
    found = Movement(before, whole @ before).at(np.array([0.5]))[0]
    np.testing.assert_allclose(found, half @ before, atol=1e-12)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**31), st.floats(0, math.pi))
def test_a_movement_begins_and_ends_where_it_is_told(seed, angle):
    """Also half a turn, with the rounding of single precision."""
    chance = np.random.default_rng(seed)
    before = matrix(turn(chance.normal(size=3), 1.0) * 3.0, chance.normal(size=3))
    after = matrix(turn(chance.normal(size=3), angle), chance.normal(size=3)) @ before
    if seed % 2:
        after = after @ np.diag([*chance.uniform(0.3, 3.0, 3), 1.0])
    before, after = (m.astype(np.float32).astype(float) for m in (before, after))
    found = Movement(before, after).at(np.array([0.0, 1.0]))
    np.testing.assert_allclose(found[0], before, atol=1e-8)
    np.testing.assert_allclose(found[1], after, atol=5e-6)


def test_what_is_stretched_and_turned_is_never_flat():
    """In a half turn with growth, half of each is done midway; without a turn it goes straight."""
    before = matrix(np.diag([1.0, 2.0, 3.0]), (1, 0, 0))
    after = about((0, 0, 5), turn((0, 0, 1), math.pi - 1e-6)) @ before @ np.diag([3, 1, 1, 1])
    (half,) = Movement(before, after).at(np.array([0.5]))
    expected = turn((0, 0, 1), math.pi / 2 - 5e-7) @ np.diag([2.0, 2.0, 3.0])
    np.testing.assert_allclose(half[:3, :3], expected, atol=1e-9)
    np.testing.assert_allclose(half[:3, 3], (0, 1, 0), atol=1e-5)
    straight = Movement(np.eye(4), matrix(np.diag([1, 3, 1]), (2, 0, 0)))
    (half,) = straight.at(np.array([0.5]))
    np.testing.assert_allclose(half, matrix(np.diag([1, 2, 1]), (1, 0, 0)))
    # Two that only move are not cut.
    body = Movement(np.eye(4), matrix(np.eye(3), (5, 1, 2)))
    sensor = Movement(matrix(np.eye(3), (0, 1, 0)), matrix(np.eye(3), (0, 3, 0)))
    assert pieces_needed(body, sensor, np.eye(3), 1e-9) == 1


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31), st.floats(0.0, 3.1), st.floats(0.0, 3.1))
def test_the_pieces_stray_no_farther_than_tolerated(seed, angle, other):
    chance = np.random.default_rng(seed)
    poses = [matrix(turn(chance.normal(size=3), a), chance.normal(size=3)) for a in (angle, other)]
    if seed % 2:
        poses[0] = poses[0] @ np.diag([*chance.uniform(0.5, 2.0, 3), 1.0])
    scaled = np.diag([0.5, 0.5, 0.5, 1.0])
    body, sensor = Movement(scaled, poses[0] @ scaled), Movement(np.eye(4), poses[1])
    ends = chance.normal(size=(3, 3))
    tolerance = 1e-4
    n = pieces_needed(body, sensor, ends, tolerance)
    bounds = seen_from(body, sensor, np.linspace(0, 1, n + 1), ends)
    for part in (0.25, 0.5, 0.75):
        exact = seen_from(body, sensor, (np.arange(n) + part) / n, ends)
        straight = bounds[:-1] * (1 - part) + bounds[1:] * part
        strays = np.linalg.norm((exact - straight) @ body.after[:3, :3].T, axis=2)
        assert strays.max() <= tolerance


# Rays against triangles


def ray_way(before, after):
    """Return the movement (2, 1, 2, 3) of a ray between two poses."""
    return np.array([[before], [after]], float)


SQUARE = np.array([[(0, -1, 0), (1, -1, 0), (1, 1, 0)], [(0, -1, 0), (1, 1, 0), (0, 1, 0)]], float)


def union(found):
    """Return the times of one ray, joined."""
    times = []
    for begin, end in sorted(zip(found.begin.tolist(), found.end.tolist(), strict=True)):
        if times and begin <= times[-1][1] + 1e-9:
            times[-1][1] = max(end, times[-1][1])
        else:
            times.append([begin, end])
    return times


@pytest.mark.parametrize("width", [1.0, 0.01, 1e-4, 1e-6])
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_a_flag_passes_as_long_as_it_is_wide(width, far):
    """It goes from 1 m before the beam to 1 m behind it; relative to the flag, the ray moves."""
    shift = np.array([far, 0, 0])
    ways = ray_way([(1 + width, 0, 0.3), (1 + width, 0, -0.7)], [(-1, 0, 0.3), (-1, 0, -0.7)])
    tree = TriangleTree(SQUARE * (width, 1, 1) + shift)
    found = crossings(ways + shift, np.array([1.0]), tree, 7)
    way = 2 + width
    # The two triangles of the square come one after the other.
    ((begin, end),) = union(found)
    rounding = 1e-12 + 4 * np.spacing(far)
    assert (begin, end) == pytest.approx((1 / way, (1 + width) / way), abs=rounding)
    assert found.near == pytest.approx(0.3, abs=1e-9)
    assert found.far == pytest.approx(0.3, abs=1e-9)
    assert set(found.solid.tolist()) == {7}


MISSES_AND_HITS = {
    "stops before": ((2, 0, 0.3), (2, 0, -0.7), 1 + 1e-9, False),
    "just in": ((2, 0, 0.3), (2, 0, -0.7), 1 - 1e-6, True),
    "too short": ((2, 0, 0.3), (2, 0, 1e-9), -2, False),
    "just long enough": ((2, 0, 0.3), (2, 0, -1e-9), -2, True),
    "starts behind": ((2, 0, -1e-9), (2, 0, -1), -2, False),
    "passes beside": ((2, 1 + 1e-9, 1), (2, 1 + 1e-9, -1), -2, False),
    "along an edge": ((2, 1 - 1e-9, 1), (2, 1 - 1e-9, -1), -2, True),
}


@pytest.mark.parametrize("start, end, to, hit", MISSES_AND_HITS.values(), ids=MISSES_AND_HITS)
def test_what_just_misses_and_what_just_hits(start, end, to, hit):
    """A ray from `start` to `end` goes along x to `to`."""
    way = ray_way([start, end], [(to, *start[1:]), (to, *end[1:])])
    assert bool(len(crossings(way, np.ones(1), TriangleTree(SQUARE), 1))) == hit


def test_rays_at_rest_and_triangles_that_are_none():
    ray = [(0.5, 0.2, 0.3), (0.5, 0.2, -0.7)]
    assert union(crossings(ray_way(ray, ray), np.ones(1), TriangleTree(SQUARE), 1)) == [[0.0, 1.0]]
    ways = ray_way([(2, 0, 0.3), (2, 0, -0.7)], [(-2, 0, 0.3), (-2, 0, -0.7)])
    flat = np.zeros((1, 3, 3))
    broken = SQUARE.copy()
    broken[:, 0] = math.nan
    with np.errstate(all="raise"):
        for corners in (flat, broken, np.zeros((0, 3, 3))):
            assert len(crossings(ways, np.ones(1), TriangleTree(corners), 1)) == 0


def met(start, end, triangle):
    """Return the share of the ray at which it hits a triangle, or NaN, by Möller and Trumbore."""
    way, one, two = end - start, triangle[1] - triangle[0], triangle[2] - triangle[0]
    p = np.cross(way, two)
    det = one @ p
    s = start - triangle[0]
    q = np.cross(s, one)
    with np.errstate(all="ignore"):
        u, v, t = (s @ p) / det, (way @ q) / det, (two @ q) / det
    return t if u >= 0 and v >= 0 and u + v <= 1 and 0 <= t <= 1 else math.nan


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**31))
def test_as_many_looks_in_between_find(seed):
    """Rays with arbitrary turns and moves, in two pieces, against 200 samples."""
    chance = np.random.default_rng(seed)
    ways = chance.normal(size=(3, 2, 2, 3))
    triangles = chance.normal(size=(2, 3, 3)) * 0.7
    lengths = np.array([1.0, 2.0])
    found = crossings(ways, lengths, TriangleTree(triangles), 1)
    assert ((found.begin >= 0) & (found.end <= 1) & (found.begin < found.end)).all()
    for ray in range(2):
        mine = found.ray == ray
        begin, end = found.begin[mine], found.end[mine]
        low = np.minimum(found.near, found.far)[mine]
        high = np.maximum(found.near, found.far)[mine]
        for time in (np.arange(200) + 0.5) / 200:
            piece, share = int(time * 2), time * 2 % 1
            start, stop = ways[piece, ray] * (1 - share) + ways[piece + 1, ray] * share
            far = np.array([met(start, stop, t) for t in triangles]) * lengths[ray]
            inside = (begin <= time) & (time <= end)
            if np.abs(np.concatenate([begin, end]) - time).min(initial=1.0) < 1e-6:
                continue
            assert np.isfinite(far).sum() == inside.sum()
            for value in far[np.isfinite(far)]:
                assert ((low[inside] - 1e-7 <= value) & (value <= high[inside] + 1e-7)).any()


def sphere(around, rng):
    """Return triangles (n, 3, 3) of a lumpy sphere of about 0.5 m."""
    down, about = np.linspace(0, math.pi, around + 1), np.linspace(0, 2 * math.pi, around + 1)
    points = np.empty((around + 1, around + 1, 3))
    points[..., 0] = np.outer(np.sin(down), np.cos(about))
    points[..., 1] = np.outer(np.sin(down), np.sin(about))
    points[..., 2] = np.cos(down)[:, None]
    points *= 0.5 + rng.uniform(0.0, 0.5 / around, (around + 1, around + 1, 1))
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])


def turning_past(angle, rays, rng, at=0.0):
    """Return movements of `rays` past a body that turns by `angle`, shifts and deforms."""
    size = matrix(np.eye(3) + rng.normal(size=(3, 3)) * 0.2, rng.normal(size=3) * 0.1)
    moved = matrix(turn(rng.normal(size=3), angle), rng.normal(size=3) * 0.3) @ size
    start, end = rng.normal(size=(2, 3)) * 0.2
    end = start + (end - start) / np.linalg.norm(end - start) * 2.0
    apart = np.arange(rays)[:, None, None] * rng.normal(size=3) * 1e-3
    ends = (np.array([[start, end]]) + apart).reshape(-1, 3)
    body, sensor = Movement(size, moved), Movement(np.eye(4), np.eye(4))
    seen = seen_from(body, sensor, np.linspace(0, 1, 13), ends)
    return seen.reshape(13, rays, 2, 3) + at


def columns(found):
    return np.stack([found.ray, found.begin, found.end, found.near, found.far])


@pytest.mark.parametrize("seed", mostly_slow(range(8), 0, 1))
@pytest.mark.parametrize("rays, at", [(1, 0.0), (3, 1e4), (19, 0.0)])
def test_what_boxes_leave_out_is_never_met(seed, rays, at):
    """A test of all pairs of a ray and a triangle gives the same bits."""
    rng = np.random.default_rng(seed)
    corners = sphere(14, rng) if seed % 2 else rng.normal(size=(300, 3, 3)) * 0.3
    corners = np.concatenate([corners, corners[:1] * math.nan, sphere(2, rng) * 40.0]) + at
    ways = turning_past(rng.uniform(0.0, 3.0), rays, rng, at)
    tree = TriangleTree(corners)
    found = crossings(ways, np.full(rays, 2.0), tree, 1)
    assert len(found) > 5
    pairs = np.indices((12, rays, len(corners))).reshape(3, -1)
    piece, ray, triangle = pairs
    pair, begin, end, near, far = _intersections(
        ways[piece, ray], ways[piece + 1, ray], corners[triangle]
    )
    piece, ray = piece[pair], ray[pair]
    every = np.stack([ray, (piece + begin) / 12, (piece + end) / 12, near * 2.0, far * 2.0])
    np.testing.assert_array_equal(columns(found), every)


# The light in between


TWO = (0, 0.2, 0.4, 0.1, 0.1), (1, 0.3, 0.5, 0.1, 0.1)
ABUTTING = (0, 0.2, 0.4 - 1e-9, 0.1, 0.1), (0, 0.4 + 1e-9, 0.5, 0.1, 0.1)
# It comes nearer, and stops its ray from the threshold on: in the middle of the time.
NEARING = (0, 0.0, 1.0, 0.6, 0.4)


@pytest.mark.parametrize(
    ("rays", "rows", "light"),
    [
        (2, TWO, [1.0, 0.5, 0.0, 0.5, 1.0]),
        (4, TWO, [1.0, 0.75, 0.5, 0.75, 1.0]),
        # Any number of triangles stop a ray once.
        (2, [TWO[0], (0, 0.3, 0.5, 0.2, 0.2)], [1.0, 0.5, 1.0]),
        (1, ABUTTING, [1.0, 0.0, 1.0]),
        # A pass over an end of the interval is no interruption there.
        (1, [(0, 0.0, 0.4, 0.1, 0.1)], [0.0, 1.0]),
        (1, [(0, 0.4, 1.0, 0.1, 0.1)], [1.0, 0.0]),
        (1, [(0, 0.0, 1.0, 0.1, 0.1)], [0.0]),
        # A triangle beyond the threshold stops nothing.
        (1, [(0, 0.2, 0.4, 0.6, 0.6)], []),
        (1, [(0, 0.2, 0.4, 0.5, 0.5)], []),
        (1, [], []),
        (2, [NEARING, (1, 0.0, 0.49, 0.1, 0.1)], [0.5, 1.0, 0.5]),
        (2, [NEARING, (1, 0.0, 0.51, 0.1, 0.1)], [0.5, 0.0, 0.5]),
    ],
)
def test_light_that_is_left(rays, rows, light):
    """Passes of (ray, begin, end, near, far), before a threshold of 0.5 m."""
    table = np.array(rows, float).reshape(-1, 5)
    things = np.ones(len(table), np.int64)
    passes = RayCrossings(table[:, 0].astype(np.intp), *table[:, 1:].T, things)
    assert light_between(passes, table[:, 3:], 0.5, rays).tolist() == light


# Rays against surfaces of very many triangles


def one_by_one(points, triangles, origins, directions, limits):
    """Return the nearest hit of each ray by Möller and Trumbore, in double precision."""
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
    """Return triangles of all sizes scattered far from the origin."""
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
    directions[:60] = np.round(directions[:60])  # some along axes and planes
    directions[~directions.any(axis=1)] = (0, 0, -1)
    limits = rng.choice([1.0, 5.0, np.inf], 300)
    far, met = RayTree(points, triangles).meet(origins, directions, limits)
    expected = one_by_one(points, triangles, origins, directions, limits)
    assert far == pytest.approx(expected, abs=1e-9)
    assert ((met >= 0) == np.isfinite(expected)).all()


def grid(side):
    """Return a square of side 1 at z = 0, of 2 side² triangles with shared corners."""
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


def test_a_single_ray_tells_point_normal_triangle_and_distance():
    points, triangles = grid(10)
    point, normal, number, far = RayTree(points, triangles).ray_cast((0.52, 0.43, 3), (0, 0, -2))
    assert point == pytest.approx([0.52, 0.43, 0]) and far == 3.0
    assert normal == pytest.approx([0, 0, 1])
    assert np.allclose(points[triangles[number]].mean(0), (0.52, 0.43, 0), atol=0.07)
    assert RayTree(points, triangles).ray_cast((0, 0, 3), (0, 0, 1)) == (None,) * 4


def test_corners_that_are_nowhere_take_their_triangles_alone_away():
    points, triangles = grid(20)
    points[0], points[200] = np.nan, np.inf
    tree = RayTree(points, triangles)
    origins = np.array([[0.9, 0.9, 1.0], [0.001, 0.001, 1.0]])
    far, _ = tree.meet(origins, np.tile((0.0, 0.0, -2.0), (2, 1)), np.full(2, 9.0))
    assert far.tolist() == [1.0, np.inf]
    nothing = RayTree(np.full((3, 3), np.nan, np.float32), np.array([[0, 1, 2]], np.int32))
    assert nothing.meet(origins, origins, np.full(2, 9.0))[1].tolist() == [-1, -1]
