# SPDX-License-Identifier: GPL-3.0-or-later
"""Doors as residents move them: where leaf and handle are, which side, which ways cross."""

import numpy as np
import pytest
from angen_sensors.residents.acting.places import DOOR, Door

UP = np.array([0.0, 0.0, 1.0])


def door(slides: bool = False, opens: float = np.pi / 2, turn: float = 0.0) -> Door:
    """A leaf of 0.9 m at (2, 1), its hinge there, along x turned by an angle."""
    c, s = np.cos(turn), np.sin(turn)
    frame = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Door(
        "Door", DOOR, np.array([2.0, 1.0, 0.0]), -frame[:, 0] if slides else UP, 0.0, opens, frame,
        np.array([0.0, -0.02, 0.0]), np.array([0.9, 0.02, 2.0]), np.array([0.8, 0.0, 1.0]), slides,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("leaf", "handle"),
    [
        (door(), (2.0, 1.8, 1.0)),
        (door(opens=-np.pi / 2), (2.0, 0.2, 1.0)),
        (door(turn=np.pi / 2), (1.2, 1.0, 1.0)),
        (door(slides=True, opens=0.85), (1.95, 1.0, 1.0)),
    ],
)
def test_the_handle_goes_with_the_leaf(leaf: Door, handle: tuple) -> None:
    assert np.allclose(leaf.handle_at(leaf.open), handle)


@pytest.mark.parametrize("turn", [0.0, 2.0, -1.0])
@pytest.mark.parametrize("opens", [1.5, -1.5])
def test_the_side_that_a_leaf_opens_to(turn: float, opens: float) -> None:
    leaf = door(opens=opens, turn=turn)
    assert leaf.side(leaf.handle_at(opens)) == 1.0
    assert leaf.side(leaf.handle_at(-opens)) == -1.0


@pytest.mark.parametrize(
    ("way", "crossed"),
    [
        ([(2.5, 0.0), (2.5, 2.0)], 1.0),
        ([(2.5, -1.0), (2.5, 0.5), (2.5, 2.0)], 2.0),
        ([(3.5, 0.0), (3.5, 2.0)], None),
        ([(2.5, 0.0), (2.5, 0.9), (0.0, 0.9)], None),
        ([(0.0, 1.0), (4.0, 1.0)], None),
    ],
)
def test_which_ways_cross_a_shut_door(way: list, crossed: float | None) -> None:
    found = door().crossing(np.array(way))
    assert found == (None if crossed is None else pytest.approx(crossed))
