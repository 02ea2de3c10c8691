# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways over a floor, held to scipy's distance transform and Dijkstra's shortest paths."""

from itertools import pairwise

import numpy as np
import pytest
from angen_sensors.residents.acting.ways import Floor, NoWay, length, way


def flat(rows: str, size: float = 0.25) -> Floor:
    """A floor drawn from the top: `#` is not free."""
    lines = rows.strip().split("\n")[::-1]
    free = np.array([[sign != "#" for sign in line.strip()] for line in lines]).T
    return Floor(np.zeros(2), size, free)


def random_floor(seed: int) -> Floor:
    rng = np.random.default_rng(seed)
    free = np.ones((60, 45), bool)
    for _ in range(14):
        x, y = rng.integers(0, 55), rng.integers(0, 40)
        free[x : x + rng.integers(1, 14), y : y + rng.integers(1, 12)] = False
    return Floor(rng.normal(size=2), 0.1, free)


def distance_to_things(floor: Floor, points: np.ndarray) -> np.ndarray:
    """From points (n, 2) to the squares that are not free."""
    low = floor.low + np.argwhere(~floor.free) * floor.size
    off = np.maximum(low - points[:, None], points[:, None] - low - floor.size)
    return np.linalg.norm(np.maximum(off, 0.0), axis=2).min(axis=1)


@pytest.mark.parametrize("seed", range(8))
def test_clearance_is_the_distance_to_what_is_not_free(seed: int) -> None:
    ndimage = pytest.importorskip("scipy.ndimage")
    floor = random_floor(seed)
    exact = ndimage.distance_transform_edt(np.pad(floor.free, 1))[1:-1, 1:-1]
    assert np.allclose(floor.clearance, (exact - 0.5) * floor.size)


@pytest.mark.parametrize("seed", range(8))
def test_a_way_is_there_where_there_is_one_and_hardly_longer_than_the_shortest(seed: int) -> None:
    sparse = pytest.importorskip("scipy.sparse")
    from scipy.sparse.csgraph import dijkstra

    floor, radius = random_floor(seed), 0.15
    wide = floor.clearance >= radius - 1e-9
    cells = np.argwhere(wide)
    number = np.full(wide.shape, -1)
    number[wide] = np.arange(len(cells))
    rows, columns, steps = [], [], []
    for (x, y), here in zip(cells.tolist(), range(len(cells)), strict=True):
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            i, j = x + dx, y + dy
            if not (0 <= i < wide.shape[0] and 0 <= j < wide.shape[1] and wide[i, j]):
                continue
            if not (wide[i, y] and wide[x, j]):
                continue
            rows.append(here)
            columns.append(number[i, j])
            steps.append(np.hypot(dx, dy) * floor.size)
    graph = sparse.coo_matrix((steps, (rows, columns)), (len(cells), len(cells))).tocsr()
    rng = np.random.default_rng(seed)
    for _ in range(6):
        a, b = rng.integers(len(cells), size=2).tolist()
        start, goal = (floor.middle(tuple(cells[k])) for k in (a, b))
        shortest = dijkstra(graph, directed=False, indices=a)[b]
        if np.isinf(shortest):
            with pytest.raises(NoWay):
                way(floor, start, goal, radius)
            continue
        found = way(floor, start, goal, radius)
        assert (found[0] == start).all() and (found[-1] == goal).all()
        straight = np.linalg.norm(goal - start)
        assert straight - 1e-9 <= length(found) <= 1.5 * shortest + 1e-9
        for p, q in pairwise(found):
            between = p + (q - p) * np.linspace(0, 1, 50)[:, None]
            # Between the middles of cells the distance is off by half a diagonal at most.
            assert distance_to_things(floor, between).min() >= radius - 0.71 * floor.size


def test_a_walker_keeps_off_walls_where_there_is_room_and_cuts_corners() -> None:
    floor = flat("""
        ....................
        ....................
        ....................
        ############........
        ....................
        ....................
        ....................
    """)
    found = way(floor, np.array([0.6, 0.4]), np.array([0.6, 1.4]), 0.2)
    # Around the end of the wall, at x = 3.
    assert len(found) <= 8 and found[:, 0].max() > 3.3
    assert length(found) < 8.0


def test_where_there_is_no_way_the_nearest_place_is_told() -> None:
    floor = flat("""
        ....#....
        ....#....
        ....#....
    """)
    with pytest.raises(NoWay) as caught:
        way(floor, np.array([0.4, 0.4]), np.array([2.0, 0.4]), 0.1)
    assert caught.value.nearest[0] == pytest.approx(0.875)
    with pytest.raises(NoWay, match="no room"):
        way(floor, np.array([0.4, 0.4]), np.array([2.0, 0.4]), 2.0)


def test_who_stands_at_a_basin_gets_away_from_it() -> None:
    floor = flat("""
        ........
        ........
        ........
        ........
    """)
    start = np.array([0.02, 0.5])
    found = way(floor, start, np.array([1.5, 0.5]), 0.3)
    assert (found[0] == start).all() and length(found) < 1.6
