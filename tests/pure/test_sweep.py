# SPDX-License-Identifier: GPL-3.0-or-later
"""Movements between two poses, when moving rays meet triangles, and the light that is left."""

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
from angen_sensors.sensor_logic.geometry.trees import TriangleTree
from angen_sensors.sensor_logic.kinds.optical_switch import light_between
from hypothesis import given, settings
from hypothesis import strategies as st
from tiers import mostly_slow


def turn(axis, angle):
    """A rotation (3, 3) by quaternion, another way than the product's."""
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
    half = np.eye(4)
    half[:3, 3] = glide[:3, 3] / 2
    half = half @ about((0, 0, 1), turn((1, 1, 0), 0.6))
    found = Movement(before, whole @ before).at(np.array([0.5]))[0]
    np.testing.assert_allclose(found, half @ before, atol=1e-12)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**31), st.floats(0, math.pi))
def test_a_movement_begins_and_ends_where_it_is_told(seed, angle):
    """Half a turn too; with the rounding of single precision."""
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
    """A half turn while it grows: half of each in between."""
    before = matrix(np.diag([1.0, 2.0, 3.0]), (1, 0, 0))
    after = about((0, 0, 5), turn((0, 0, 1), math.pi - 1e-6)) @ before @ np.diag([3, 1, 1, 1])
    (half,) = Movement(before, after).at(np.array([0.5]))
    grown = matrix(np.diag([2.0, 2.0, 3.0]), (1, 0, 0))
    expected = turn((0, 0, 1), math.pi / 2 - 5e-7) @ grown[:3, :3]
    np.testing.assert_allclose(half[:3, :3], expected, atol=1e-9)
    np.testing.assert_allclose(half[:3, 3], (0, 1, 0), atol=1e-5)


def test_what_changes_its_size_goes_straight():
    before, after = matrix(np.eye(3), (0, 0, 0)), matrix(np.diag([1, 3, 1]), (2, 0, 0))
    movement = Movement(before, after)
    assert (movement.rigid, movement.angle) == (False, 0.0)
    np.testing.assert_allclose(
        movement.at(np.array([0.5]))[0], matrix(np.diag([1, 2, 1]), (1, 0, 0))
    )


def test_nothing_that_goes_straight_is_cut():
    body = Movement(matrix(np.eye(3), (0, 0, 0)), matrix(np.eye(3), (5, 1, 2)))
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
    """(2, 1, 2, 3) from two rays' ends."""
    return np.array([[before], [after]], float)


SQUARE = np.array([[(0, -1, 0), (1, -1, 0), (1, 1, 0)], [(0, -1, 0), (1, 1, 0), (0, 1, 0)]], float)


def union(found):
    """The times of one ray, joined."""
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
    """It goes from 1 m before the beam to 1 m behind it: in the ray's eyes, the ray does."""
    shift = np.array([far, 0, 0])
    ways = ray_way([(1 + width, 0, 0.3), (1 + width, 0, -0.7)], [(-1, 0, 0.3), (-1, 0, -0.7)])
    tree = TriangleTree(SQUARE * (width, 1, 1) + shift)
    found = crossings(ways + shift, np.array([1.0]), tree, 7)
    way = 2 + width
    # The diagonal's two triangles come one after the other.
    ((begin, end),) = union(found)
    rounding = 1e-12 + 4 * np.spacing(far)
    assert (begin, end) == pytest.approx((1 / way, (1 + width) / way), abs=rounding)
    assert found.near == pytest.approx(0.3, abs=1e-9)
    assert found.far == pytest.approx(0.3, abs=1e-9)
    assert set(found.solid.tolist()) == {7}


@pytest.mark.parametrize(
    "before, after",
    [
        ([(2, 0, 0.3), (2, 0, -0.7)], [(1 + 1e-9, 0, 0.3), (1 + 1e-9, 0, -0.7)]),
        ([(2, 0, 0.3), (2, 0, 1e-9)], [(-2, 0, 0.3), (-2, 0, 1e-9)]),
        ([(2, 0, -1e-9), (2, 0, -1)], [(-2, 0, -1e-9), (-2, 0, -1)]),
        ([(2, 1 + 1e-9, 1), (2, 1 + 1e-9, -1)], [(-2, 1 + 1e-9, 1), (-2, 1 + 1e-9, -1)]),
    ],
    ids=["stops before", "too short", "starts behind", "passes beside"],
)
def test_what_just_misses(before, after):
    assert len(crossings(ray_way(before, after), np.ones(1), TriangleTree(SQUARE), 1)) == 0


@pytest.mark.parametrize(
    "before, after",
    [
        ([(2, 0, 0.3), (2, 0, -0.7)], [(1 - 1e-6, 0, 0.3), (1 - 1e-6, 0, -0.7)]),
        ([(2, 0, 0.3), (2, 0, -1e-9)], [(-2, 0, 0.3), (-2, 0, -1e-9)]),
        ([(2, 1 - 1e-9, 1), (2, 1 - 1e-9, -1)], [(-2, 1 - 1e-9, 1), (-2, 1 - 1e-9, -1)]),
    ],
    ids=["just in", "just long enough", "along an edge"],
)
def test_what_just_hits(before, after):
    assert len(crossings(ray_way(before, after), np.ones(1), TriangleTree(SQUARE), 1)) > 0


def test_a_ray_that_does_not_move_is_met_all_the_time():
    ray = [(0.5, 0.2, 0.3), (0.5, 0.2, -0.7)]
    assert union(crossings(ray_way(ray, ray), np.ones(1), TriangleTree(SQUARE), 1)) == [[0.0, 1.0]]


def test_triangles_that_are_none_are_never_met():
    ways = ray_way([(2, 0, 0.3), (2, 0, -0.7)], [(-2, 0, 0.3), (-2, 0, -0.7)])
    flat = np.zeros((1, 3, 3))
    broken = SQUARE.copy()
    broken[:, 0] = math.nan
    with np.errstate(all="raise"):
        for corners in (flat, broken, np.zeros((0, 3, 3))):
            assert len(crossings(ways, np.ones(1), TriangleTree(corners), 1)) == 0


def met(start, end, triangle):
    """Share of the ray at which it meets a triangle, or NaN: Möller and Trumbore's way."""
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
    """Rays that turn and move anyhow, in two pieces, against 200 looks."""
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
    """Triangles (n, 3, 3) of a lumpy sphere of about 0.5 m."""
    down, about = np.linspace(0, math.pi, around + 1), np.linspace(0, 2 * math.pi, around + 1)
    points = np.empty((around + 1, around + 1, 3))
    points[..., 0] = np.outer(np.sin(down), np.cos(about))
    points[..., 1] = np.outer(np.sin(down), np.sin(about))
    points[..., 2] = np.cos(down)[:, None]
    points *= 0.5 + rng.uniform(0.0, 0.5 / around, (around + 1, around + 1, 1))
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])


def turning_past(angle, rays, rng, at=0.0):
    """Ways of `rays` past a body that turns by `angle` and shifts, stretched and sheared."""
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
    """All pairs of a ray and a triangle asked, one after the other, tell the same to the bit."""
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


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
def test_only_triangles_near_the_rays_are_asked(angle):
    """Of 45 000, a few for each of 20 rays in 12 pieces of time; where there are four times as
    many, not four times as much."""
    rng = np.random.default_rng(5)
    ways = turning_past(angle, 20, rng)
    asked = []
    for around in (75, 150):
        tree = TriangleTree(sphere(around, rng))
        asked.append(sum(len(ray) for _, ray, _ in tree.near(ways[:-1], ways[1:])))
    assert 0 < asked[1] < 2.5 * asked[0]
    assert asked[1] < 240 * (20 + 100 * angle)


def test_where_they_are_found_does_not_depend_on_how_many_are_compared_at_once(monkeypatch):
    rng = np.random.default_rng(2)
    ways, tree = turning_past(1.0, 3, rng), TriangleTree(sphere(20, rng))
    whole = crossings(ways, np.ones(3), tree, 1)
    monkeypatch.setattr("angen_sensors.sensor_logic.geometry.trees.PAIRS_AT_ONCE", 7)
    np.testing.assert_array_equal(columns(crossings(ways, np.ones(3), tree, 1)), columns(whole))


# The light in between


def made(*rows):
    """Passes of (ray, begin, end, near, far)."""
    table = np.array(rows, float).reshape(-1, 5)
    thing = np.ones(len(table), np.int64)
    return RayCrossings(table[:, 0].astype(np.intp), *table[:, 1:].T, thing)


def light(rays, *rows, threshold=0.5):
    given_passes = made(*rows)
    ranges = np.stack([given_passes.near, given_passes.far], axis=1)
    return light_between(given_passes, ranges, threshold, rays).tolist()


def test_light_while_one_thing_passes_two_rays():
    rows = (0, 0.2, 0.4, 0.1, 0.1), (1, 0.3, 0.5, 0.1, 0.1)
    assert light(2, *rows) == [1.0, 0.5, 0.0, 0.5, 1.0]
    assert light(4, *rows) == [1.0, 0.75, 0.5, 0.75, 1.0]


def test_a_ray_is_stopped_once_by_whatever_many():
    assert light(2, (0, 0.2, 0.4, 0.1, 0.1), (0, 0.3, 0.5, 0.2, 0.2)) == [1.0, 0.5, 1.0]


def test_faces_that_abut_leave_no_gap():
    rows = (0, 0.2, 0.4 - 1e-9, 0.1, 0.1), (0, 0.4 + 1e-9, 0.5, 0.1, 0.1)
    assert light(1, *rows) == [1.0, 0.0, 1.0]


def test_what_is_there_at_an_end_is_not_interrupted_there():
    assert light(1, (0, 0.0, 0.4, 0.1, 0.1)) == [0.0, 1.0]
    assert light(1, (0, 0.4, 1.0, 0.1, 0.1)) == [1.0, 0.0]
    assert light(1, (0, 0.0, 1.0, 0.1, 0.1)) == [0.0]


def test_what_is_beyond_the_threshold_stops_nothing():
    assert light(1, (0, 0.2, 0.4, 0.6, 0.6)) == []
    assert light(1, (0, 0.2, 0.4, 0.5, 0.5)) == []
    assert light(1) == []


def test_what_comes_nearer_stops_from_the_threshold_on():
    """Two rays: where the second stops tells when the first does."""
    near = (0, 0.0, 1.0, 0.6, 0.4)
    assert light(2, near, (1, 0.0, 0.49, 0.1, 0.1)) == [0.5, 1.0, 0.5]
    assert light(2, near, (1, 0.0, 0.51, 0.1, 0.1)) == [0.5, 0.0, 0.5]
