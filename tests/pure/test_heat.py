# SPDX-License-Identifier: GPL-3.0-or-later
"""How warm things are in use: closed forms, and times at which a day looks at them."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.heat import HEATS, STEP, Heat, warm_share, warm_steps

POT = Heat("Pot", 80.0, 100.0, 1000.0)


def test_warming_up_and_cooling_down() -> None:
    uses = [(0.0, 100.0), (600.0, 700.0)]
    first = 1 - math.exp(-1)
    assert warm_share(POT, uses, -1.0) == 0.0
    assert warm_share(POT, uses, 100.0) == pytest.approx(first)
    left = first * math.exp(-0.5)
    assert warm_share(POT, uses, 600.0) == pytest.approx(left)
    assert warm_share(POT, uses, 700.0) == pytest.approx(1 - (1 - left) * math.exp(-1))
    # What is always in use is as warm as can be; later uses do not count.
    assert warm_share(POT, [(-math.inf, math.inf)], 5.0) == 1.0
    assert warm_share(POT, uses, 50.0) == warm_share(POT, [(0.0, math.inf)], 50.0)


def test_it_runs_on() -> None:
    kettle = HEATS["KETTLE"]
    brief, long = [(0.0, 5.0)], [(0.0, 5.0 + kettle.runs_on)]
    plain = Heat("", kettle.excess, kettle.rise, kettle.fall)
    for time in (3.0, 100.0, 155.0, 500.0):
        assert warm_share(kettle, brief, time) == warm_share(plain, long, time)
    # Uses that follow within that time are one.
    assert warm_share(kettle, [(0.0, 5.0), (60.0, 65.0)], 200.0) == pytest.approx(
        warm_share(plain, [(0.0, 65.0 + kettle.runs_on)], 200.0)
    )


@pytest.mark.parametrize("sort", HEATS)
def test_between_the_steps_of_a_day_it_hardly_changes(sort: str) -> None:
    heat, uses = HEATS[sort], [(1000.0, 1400.0), (9000.0, 9040.0)]
    steps = np.array([0.0, 1000.0, *warm_steps(heat, uses), 86_400.0])
    assert len(steps) < 300
    times = np.arange(0.0, 86_400.0, 7.0)
    now = np.array([warm_share(heat, uses, time) for time in times])
    since = np.sort(steps)[np.searchsorted(np.sort(steps), times, side="right") - 1]
    before = np.array([warm_share(heat, uses, float(time)) for time in since])
    assert (heat.excess * abs(now - before)).max() < STEP + 0.01
