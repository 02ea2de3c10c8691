# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever things are called, `partners` tells them apart."""

import random

import pytest
from angen_sensors.sensor_logic.wording import joined, split

CASES = [
    [],
    ["box"],
    ["left", "right"],
    ["a;b", "c"],
    ["a", "b;c"],
    ["a\\", "b"],
    ["a\\;b"],
    ["\\;", ";\\", ";;", "\\\\"],
    ["Stuhl, groß", "x\ny"],
]


@pytest.mark.parametrize("names", CASES)
def test_there_and_back(names):
    assert split(joined(names)) == sorted(names)


def test_no_two_sets_of_names_look_alike():
    rng = random.Random(7)
    seen = {}
    for _ in range(20_000):
        names = {
            "".join(rng.choices("a;\\", k=rng.randint(1, 4))) for _ in range(rng.randint(1, 3))
        }
        text = joined(names)
        assert seen.setdefault(text, names) == names
        assert split(text) == sorted(names)


def test_ordinary_names_stay_as_they_are():
    assert joined(["right", "left", "Küche: Stuhl (2)"]) == "Küche: Stuhl (2);left;right"
