# SPDX-License-Identifier: GPL-3.0-or-later
"""What was done on a day: when anything moves, and who moves it."""

import numpy as np
from angen_sensors.residents.acting.timeline import Acted, Clip, Hold, Switch, Swung, Timeline
from angen_sensors.residents.body.pose import BodyPose


def body(*moves: tuple[float, float], away: tuple[tuple[float, float], ...] = ()) -> Timeline:
    """A body that moves from the first time to the second of each, and is away now and then."""
    clips = [Clip(start, end, standing) for start, end in moves]
    return Timeline([*clips, *(Clip(*one, standing, still=True, away=True) for one in away)])


def standing(times: np.ndarray) -> BodyPose:
    raise AssertionError("nobody asks for the pose")


ACTED = Acted(
    {"anna": body((10, 20), (20, 25), (90, 99), away=((99, 100),)), "bo": body((22, 30))},
    {"Door": [Swung(11, 12.5, 0, 1.6, "anna"), Swung(40, 42, 1.6, 0, "bo")]},
    [Switch(0, "Lamp", False, ""), Switch(50, "Lamp", True, "bo")],
    {"Cup": [Hold(0, None), Hold(26, 1, person="bo"), Hold(28, None)]},
)


def test_spans_are_all_that_moves_in_order_and_apart() -> None:
    assert ACTED.spans(0, 60).tolist() == [[0, 0], [10, 30], [40, 42], [50, 50]]
    assert ACTED.spans(80, 120).tolist() == [[90, 99], [100, 100]]
    assert ACTED.spans(15, 41).tolist() == [[15, 30], [40, 41]]
    assert Acted({}).spans(0, 60).shape == (0, 2)


def test_who_moves_a_thing_is_told() -> None:
    asked = [("Door", 11), ("Door", 41), ("Lamp", 49), ("Lamp", 50), ("Cup", 20), ("Cup", 29)]
    assert [ACTED.mover(*one) for one in asked] == ["anna", "bo", "", "bo", "", "bo"]
    assert ACTED.mover("Table", 5) == ""
