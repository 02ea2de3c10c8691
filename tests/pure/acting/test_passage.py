# SPDX-License-Identifier: GPL-3.0-or-later
"""Two people head-on in a passage that is too narrow to pass."""

from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.residents.acting.places import STAND, Place, Places, Storey
from angen_sensors.residents.acting.timeline import STANDING
from angen_sensors.residents.acting.ways import Floor
from angen_sensors.sensor_logic.error import InputError

SIZE = 0.05
ACTIVITIES = "West = stand at West\nEast = stand at East"
# In the third the two places are the passage's ends; in the last a room lies behind a door.
ROOMS = {
    "rooms at both ends": [(0.0, 0.0, 2.0, 2.0), (7.0, 0.0, 9.0, 2.0)],
    "a room at one end": [(0.0, 0.0, 2.0, 2.0)],
    "none": [],
    "a closet with a door": [(4.0, 1.4, 6.0, 3.0)],
}


PLANS = {"anna": [(0, "West"), (10, "East")], "bo": [(0, "East"), (10, "West")]}


@pytest.fixture
def passage(home: Places):
    def made(rooms: str) -> Places:
        low, free = np.array([-0.5, -0.5]), np.zeros((200, 80), bool)
        boxes = [*ROOMS[rooms], (1.0, 0.7, 8.0, 1.3)]
        if "door" in rooms:
            boxes.append((4.5, 1.3, 5.3, 1.4))
        for box in boxes:
            i, j, k, m = (round((v + 0.5) / SIZE) for v in box)
            free[i:k, j:m] = True
        storey = Storey(0.0, Floor(low, SIZE, free), np.zeros(free.shape, np.int64))
        east = 8.4 if "both" in rooms else 7.7
        places = {
            name: Place(name, STAND, np.array([x, 1.0, 0.0]), 0.0, np.array([x, 1.0, 0.0]))
            for name, x in (("West", 0.6 if "room" in rooms else 1.3), ("East", east))
        }
        door = replace(home.doors["Door bathroom"], hinge=np.array([4.5, 1.4, 0.0]))
        return Places(places, {door.name: door} if "door" in rooms else {}, {}, (storey,))

    return made


@pytest.mark.parametrize("rooms", list(ROOMS)[:2] + list(ROOMS)[3:])
def test_one_goes_back_to_where_there_is_room(play, passage, rooms: str) -> None:
    day = play(ACTIVITIES, PLANS, places=passage(rooms))
    assert day.nearest_to_each_other("anna", "bo") > 0.35
    for person, place in (("anna", "East"), ("bo", "West")):
        last = [stay for stay in day.acted.where if stay.person == person][-1]
        assert (last.place, last.posture) == (place, STANDING)
        assert last.start < 600 + 120


def test_where_there_is_none_one_line_says_so(play, passage) -> None:
    told = r"line \d+: stand at \w+: '\w+' and '\w+' meet where they cannot pass each other, and"
    with pytest.raises(InputError, match=told):
        play(ACTIVITIES, PLANS, places=passage("none"))
