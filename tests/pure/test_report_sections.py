# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of a plan against closed forms, and against scipy's hulls where scipy is there."""

import math
from typing import Any

import numpy as np
import pytest
from angen_sensors.sensor_logic.report.sections import Line, cut, from_above, joined, simplified
from angen_sensors.sensor_logic.report.svg import spread
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import spatial

QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(low: Any, high: Any) -> tuple[Any, Any]:
    """Corners and outward triangles of a box."""
    ends = np.array([low, high], float)
    points = np.array([(ends[i, 0], ends[j, 1], ends[k, 2]) for i in (0, 1) for j in (0, 1)
                       for k in (0, 1)])  # fmt: skip
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    return points, np.array(triangles)


def merged(*meshes: Any) -> tuple[Any, Any]:
    points, triangles, count = [], [], 0
    for p, t in meshes:
        points.append(p)
        triangles.append(t + count)
        count += len(p)
    return np.concatenate(points), np.concatenate(triangles)


def tube(inner: float, outer: float, n: int = 64) -> tuple[Any, Any]:
    """A wall around a round yard, 2 m high, its normals outwards of the matter."""
    turn = np.linspace(0, 2 * math.pi, n, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points = np.concatenate(
        [np.column_stack([ring * r, np.full(n, z)]) for r in (inner, outer) for z in (0.0, 2.0)]
    )
    faces = []
    for i in range(n):
        j = (i + 1) % n
        a, b, c, d = (i, j, n + i, n + j)
        faces += [(a, c, b), (b, c, d)]
        faces += [(2 * n + a, 2 * n + b, 2 * n + c), (2 * n + b, 2 * n + d, 2 * n + c)]
    return points, np.array(faces)


def test_a_cut_box_is_its_rectangle_counter_clockwise() -> None:
    (line,) = cut(*box((1, 2, 0), (4, 4, 3)), height=1.1)
    assert line.closed
    assert line.area == pytest.approx(6.0, abs=1e-12)
    assert line.length == pytest.approx(10.0, abs=1e-12)
    np.testing.assert_allclose(line.points.min(axis=0), (1, 2))


def test_the_hole_of_a_wall_runs_the_other_way() -> None:
    lines = cut(*tube(2.0, 2.3), height=0.7)
    polygon = 64 / 2 * math.sin(2 * math.pi / 64)
    assert sorted(line.area for line in lines) == pytest.approx(
        [-polygon * 4.0, polygon * 5.29], rel=1e-9
    )


def test_a_cut_at_the_height_of_corners_is_closed() -> None:
    """A box on a box of the same plan, cut where they meet."""
    mesh = merged(box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2)))
    (line,) = cut(*mesh, height=1.0)
    assert line.closed and line.area == pytest.approx(1.0)


@pytest.mark.parametrize("height", [-0.1, 3.1])
def test_what_the_plane_misses_has_no_cut(height: float) -> None:
    assert cut(*box((0, 0, 0), (1, 1, 3)), height) == []
    assert cut(np.empty((0, 3)), np.empty((0, 3), int), height) == []


def test_faces_that_share_no_corners_close_too() -> None:
    points, triangles = box((0, 0, 0), (3, 1, 2))
    (line,) = cut(points[triangles].reshape(-1, 3), np.arange(36).reshape(-1, 3), 1.0)
    assert line.closed and line.area == pytest.approx(3.0)


def test_an_edge_that_another_face_divides_closes_too() -> None:
    """The side x = 0 ends at corners between those of its neighbours: T-junctions."""
    points, triangles = box((0, 0, 0), (1, 1, 3))
    side = (points[triangles][:, :, 0] == 0).all(axis=1)
    rest = triangles[~side]
    extra = np.array([(0, y, z) for z in (0, 0.5, 2.5, 3) for y in (0, 1)], float)
    strips = [t for i in (0, 2, 4) for t in ((i, i + 2, i + 1), (i + 1, i + 2, i + 3))]
    mesh = merged((points, rest), (extra, np.array(strips)))
    (line,) = cut(*mesh, height=1.1)
    assert line.closed and abs(line.area) == pytest.approx(1.0)


def test_a_corner_that_is_nowhere_takes_its_own_faces_only() -> None:
    points, triangles = merged(box((0, 0, 0), (1, 1, 2)), box((5, 0, 0), (6, 1, 2)))
    points[0] = np.nan
    areas = [line.area for line in cut(points, triangles, 1.0) if line.closed]
    assert areas == [pytest.approx(1.0)]


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10**6), height=st.floats(-0.8, 0.8))
def test_the_cut_of_a_convex_body_is_its_section(seed: int, height: float) -> None:
    """Points of the plane are inside the line where scipy's half spaces say that they are inside
    the body; those within 1 µm of its skin are left out."""
    random = np.random.default_rng(seed)
    hull = spatial.ConvexHull(random.normal(size=(24, 3)))
    lines = cut(hull.points, hull.simplices, height)
    probes = np.column_stack([random.uniform(-2, 2, (200, 2)), np.full(200, height)])
    depth = (hull.equations[:, :3] @ probes.T + hull.equations[:, 3:]).max(axis=0)
    if not lines:
        assert depth.min() > -1e-6
        return
    (line,) = lines
    assert line.closed
    for probe, off in zip(probes, depth, strict=True):
        if abs(off) > 2e-4:  # corners are welded to a tenth of a millimetre
            assert _inside(line.points, probe[:2]) == (off < 0)


def _inside(polygon: Any, point: Any) -> bool:
    one, two = polygon - point, np.roll(polygon, -1, axis=0) - point
    turn = np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1))
    return abs(turn.sum()) > math.pi


def test_from_above_a_table_is_its_top() -> None:
    top, leg = box((0, 0, 0.7), (2, 1, 0.75)), box((0.1, 0.1, 0), (0.15, 0.15, 0.7))
    lines = from_above(*merged(top, leg))
    assert sorted(line.area for line in lines) == pytest.approx([0.0025, 2.0])


def test_from_above_a_floor_with_a_hole_has_two_outlines() -> None:
    points, triangles = box((0, 0, 0), (3, 3, 1))
    grid = np.array([(x, y, 0.0) for y in range(4) for x in range(4)])
    cells = [(y * 4 + x) for y in range(3) for x in range(3) if (x, y) != (1, 1)]
    faces = np.array([t for i in cells for t in ((i, i + 1, i + 5), (i, i + 5, i + 4))])
    assert sorted(line.area for line in from_above(grid, faces)) == pytest.approx([-1.0, 9.0])
    assert from_above(grid, faces[:, ::-1]) == []  # seen from below
    (line,) = from_above(points, triangles)
    assert line.area == pytest.approx(9.0)


def test_open_ends_of_a_wall_are_joined_over_its_thickness() -> None:
    sides = [Line(np.array([(0.0, y), (3.0, y)]), False) for y in (0.0, 0.3)]
    (line,) = joined(sides, 0.5)
    assert line.closed and abs(line.area) == pytest.approx(0.9)
    assert [li.closed for li in joined(sides, 0.2)] == [False, False]


def test_what_is_simplified_stays_within_the_tolerance() -> None:
    turn = np.linspace(0, 2 * math.pi, 1000, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) * 100
    few = simplified(circle, 0.5, closed=True)
    assert 10 < len(few) < 60
    # The sagitta of every side: r − sqrt(r² − (s/2)²).
    side = np.linalg.norm(few - np.roll(few, -1, axis=0), axis=1)
    assert (100 - np.sqrt(100**2 - (side / 2) ** 2)).max() <= 0.5 + 1e-3
    straight = np.stack([np.arange(50.0), np.arange(50.0)], axis=1)
    assert len(simplified(straight, 0.1)) == 2


def test_marks_do_not_cover_each_other() -> None:
    random = np.random.default_rng(1)
    places = np.concatenate([random.uniform(0, 600, (60, 2)), np.full((8, 2), 300.0)])
    found = spread(places, (20.0, 16.0), (0.0, 0.0, 600.0, 600.0))
    gaps = np.abs(found[:, None] - found[None]) / (20.0, 16.0)
    assert (gaps.max(axis=2)[np.triu_indices(len(found), 1)] >= 1.0 - 1e-12).all()
    assert (found >= (10, 8)).all() and (found <= (590, 592)).all()
    assert np.linalg.norm(found - places, axis=1).max() < 80
    alone = spread(np.array([[50.0, 60.0]]), (20.0, 16.0), (0.0, 0.0, 600.0, 600.0))
    np.testing.assert_array_equal(alone, [[50, 60]])
