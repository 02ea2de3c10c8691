# SPDX-License-Identifier: GPL-3.0-or-later
"""A door into a room that is hardly deeper than its leaf is wide: a balcony, a small toilet."""

from dataclasses import replace

import numpy as np
import pytest

from sensor_logic.error import InputError
from sensor_logic.residents.places import STAND, Place, Places, Storey
from sensor_logic.residents.ways import Floor

SIZE = 0.05
ACTIVITIES = "Out = stand at Rail\nIn = stand at Window"
PLANS = {"anna": [(0, "In"), (10, "Out"), (20, "In")]}


@pytest.fixture
def balcony(home: Places):
    def made(depth: float) -> Places:
        low, free = np.array([-0.5, -0.5]), np.zeros((120, 140), bool)
        # A room, the doorway in its wall, and the balcony north of it.
        for box in ((0.0, 0.0, 4.0, 3.0), (2.0, 3.0, 3.0, 3.2), (0.0, 3.2, 3.0, 3.2 + depth)):
            i, j, k, m = (round((v + 0.5) / SIZE) for v in box)
            free[i:k, j:m] = True
        places = {
            name: Place(name, STAND, np.array([x, y, 0.0]), 0.0, np.array([x, y, 0.0]))
            for name, x, y in (("Window", 1.0, 1.0), ("Rail", 0.5, 3.2 + depth / 2))
        }
        door = replace(
            home.doors["Door bathroom"], name="Door", hinge=np.array([2.0, 3.2, 0.0]), open=2.9
        )
        high = door.high.copy()
        high[0] = 1.0
        door = replace(door, high=high)
        return Places(places, {"Door": door}, {}, (Storey(0.0, Floor(low, SIZE, free),
                      np.zeros(free.shape, np.int64)),))  # fmt: skip

    return made


def test_one_goes_out_onto_a_narrow_balcony_and_shuts_its_door(play, balcony) -> None:
    day = play(ACTIVITIES, PLANS, places=balcony(1.2))
    assert [place for _, place in day.told("anna")] == ["Window", "Rail", "Window"]
    assert [swing.after for swing in day.acted.swings["Door"]] == [2.9, 0.0, 2.9, 0.0]
    assert day.nearest_to_leaves("anna") > 0.05


def test_none_goes_where_the_leaf_would_strike_through_them(play, balcony) -> None:
    with pytest.raises(InputError, match=r"stand at Rail: 'anna' finds no way to it"):
        play(ACTIVITIES, PLANS, places=balcony(0.7))
