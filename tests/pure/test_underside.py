# SPDX-License-Identifier: GPL-3.0-or-later
"""Undersides and centres of mass of surfaces, against closed forms."""

import numpy as np
import pytest
from angen_sensors.sensor_logic.contact.shapes import rotation_about
from angen_sensors.sensor_logic.contact.underside import (
    _numbered,
    centre_of_mass,
    clustered,
    firmness,
    gathered,
    is_closed,
    underside,
)
from hypothesis import given, settings
from hypothesis import strategies as st

UP = np.array((0.0, 0.0, 1.0))
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
INDEX = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])
FAR = np.full(3, 1e9)


def box(half, at=(0, 0, 0)):
    return (CORNERS * half + at)[INDEX]


def below(triangles, closed=True, up=UP, lo=-FAR, hi=FAR):
    return underside(triangles, closed, up, lo, hi)


def test_centre_of_a_box():
    assert centre_of_mass(box((1, 2, 3), (5, 6, 7)), True) == pytest.approx((5, 6, 7))


def test_centre_of_two_boxes_is_weighted_by_volume():
    both = np.concatenate([box((1, 1, 1)), box((1, 1, 3), (4, 0, 0))])
    assert centre_of_mass(both, True) == pytest.approx((3, 0, 0))


def test_centre_of_a_tetrahedron():
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    assert centre_of_mass(points[faces], True) == pytest.approx(np.full(3, 0.25))


def test_centre_of_an_open_surface_is_that_of_its_area():
    sheet = box((1, 1, 1))[[2, 3]]
    assert centre_of_mass(sheet, False) == pytest.approx(sheet.reshape(-1, 3).mean(0), abs=0.4)
    square = np.array([[(0, 0, 0), (2, 0, 0), (2, 1, 0)], [(0, 0, 0), (2, 1, 0), (0, 1, 0.0)]])
    assert centre_of_mass(square, False) == pytest.approx((1, 0.5, 0))


def test_inside_out_and_far_away_is_the_same_centre():
    triangles = box((0.2, 0.1, 0.9), (2000, -1000, 3))
    assert centre_of_mass(triangles[:, ::-1], True) == pytest.approx((2000, -1000, 3), abs=1e-6)


def test_closed():
    assert is_closed(INDEX)
    assert not is_closed(INDEX[1:])
    assert is_closed(np.empty((0, 3), int))


def test_underside_of_a_box_is_its_foot():
    found = below(box((0.2, 0.1, 0.5)))
    assert found.areas.sum() == pytest.approx(0.08)
    assert found.points[:, 2] == pytest.approx(-0.5)
    middle = found.areas @ found.points / found.areas.sum()
    assert middle[:2] == pytest.approx((0, 0), abs=1e-9)


@pytest.mark.parametrize("flip", [False, True])
def test_inside_out_is_the_same(flip):
    triangles = box((0.2, 0.1, 0.5))
    found = below(triangles[:, ::-1] if flip else triangles)
    assert found.points[:, 2] == pytest.approx(-0.5)


def test_both_sides_of_an_open_surface_count():
    sheet = np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0.0)]])
    for one in (sheet, sheet[:, ::-1]):
        assert below(one, closed=False).areas.sum() == pytest.approx(0.5)


def test_the_box_that_is_looked_into_limits_it():
    lo, hi = np.array((-0.05, -1, -1)), np.array((0.05, 1, 1))
    found = below(box((0.2, 0.1, 0.5)), lo=lo, hi=hi)
    assert (np.abs(found.points[:, 0]) <= 0.05).all()
    assert found.areas.sum() == pytest.approx(0.02, rel=0.25)


def test_nothing_below():
    found = below(box((0.2, 0.1, 0.5)), lo=np.full(3, 5.0))
    assert found.points.shape == (0, 3) and found.areas.shape == (0,)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1), st.floats(0, 6)
)
def test_area_seen_from_below_is_the_shadow(axis, angle):
    """Of a convex body at any turn: half of Σ |n·up|·A; steep faces are left out."""
    turn = rotation_about(np.array(axis) / np.linalg.norm(axis), angle)
    found = below(box((0.2, 0.1, 0.5)) @ turn.T)
    sizes = 4 * np.array((0.1 * 0.5, 0.2 * 0.5, 0.2 * 0.1))
    cosines = np.abs(turn[2])
    assert found.areas.sum() == pytest.approx((sizes * cosines)[cosines > 0.1].sum(), rel=1e-6)


@pytest.mark.parametrize("size", [0.01, 1.0, 50.0])
def test_large_bodies_do_not_take_more_points(size):
    found = below(box((size, size, size)))
    assert 1 <= len(found.points) < 4000
    assert found.areas.sum() == pytest.approx(4 * size * size)


def test_gathering_keeps_areas_and_their_centre():
    rng = np.random.default_rng(0)
    points, areas = rng.uniform(-1, 1, (500, 3)), rng.uniform(0, 1, 500)
    places, total = gathered(points, areas, 0.5)
    assert len(places) <= 5**3
    assert total.sum() == pytest.approx(areas.sum())
    assert total @ places == pytest.approx(areas @ points)
    places, total = clustered(points, areas)
    assert total @ places == pytest.approx(areas @ points)


def test_firmness():
    """1 where it just touches, 0 at the tolerance; in between, and sunk in, in proportion."""
    found = firmness([0.0, 0.015, 0.03, 0.1, -0.03], 0.03)
    assert found == pytest.approx((1, 0.5, 0, 0, 2))


@given(st.lists(st.integers(0, 40), min_size=1, max_size=30))
def test_cells_are_numbered_in_order_by_a_table_or_by_sorting(cells):
    known = np.array(cells)
    rank = {cell: number for number, cell in enumerate(sorted(set(cells)))}
    for count in (41, 10**15):
        numbers, found = _numbered(known, count)
        assert numbers.tolist() == [rank[cell] for cell in cells]
        assert found == len(rank)
