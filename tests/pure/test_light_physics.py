# SPDX-License-Identifier: GPL-3.0-or-later
"""Photometry and the photoresistor against closed forms and literal tables."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.light import conductance, equivalent_lux, follow
from angen_sensors.sensor_logic.physics import (
    counts,
    illuminance,
    luminance,
    luminance_percent,
    voltage,
)
from hypothesis import given
from hypothesis import strategies as st

GL5528 = (14_000.0, 0.7, 1e6)
LUX = st.floats(0.0, 2e5)


def test_white_has_luminance_one_and_the_channels_their_shares():
    assert luminance([1, 1, 1]) == pytest.approx(1.0, abs=1e-15)
    assert luminance(np.eye(3)).tolist() == [0.2126, 0.7152, 0.0722]


def test_a_watt_of_white_is_683_lux_and_darkness_is_the_end():
    assert illuminance([1, 1, 1]) == pytest.approx(683.0)
    assert illuminance([1, 1, 1], 179.0) == pytest.approx(179.0)
    assert illuminance([-1, -1, -1]) == 0.0


@pytest.mark.parametrize(
    ("light", "count"),
    [(-1, 0), (0, 0), (0.00196, 0), (0.00197, 1), (0.5, 128), (1.0, 255), (7.0, 255)]
    + [(math.nan, 0), (math.inf, 255), (-math.inf, 0)],
)
def test_eight_bits_round_to_the_nearest_count(light, count):
    assert counts([light], 1.0).tolist() == [count]


def test_exposure_scales_the_light_before_it_is_cut_off():
    assert counts([0.25], 4.0).tolist() == [255]
    assert counts([0.25], 0.0).tolist() == [0]


def test_four_walls_are_percent_of_white():
    assert luminance_percent(np.ones((4, 3)), 1.0) == pytest.approx(100.0)
    assert luminance_percent(np.zeros((4, 3)), 1.0) == 0.0
    one_count = np.full((4, 3), 1 / 255)
    assert luminance_percent(one_count, 1.0) == pytest.approx(100 / 255)
    one_wall = np.array([[1.0, 1, 1], [0, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert luminance_percent(one_wall, 1.0) == pytest.approx(25.0)


@pytest.mark.parametrize(
    ("lux", "ohm", "volt"),
    [
        (0, 1e6, 0.0495),
        (1, 65566, 0.6617),
        (10, 13807, 2.1002),
        (100, 2785.6, 3.9107),
        (1000, 557.0, 4.7362),
    ],
)
def test_gl5528_over_the_decades(lux, ohm, volt):
    resistance = 1 / conductance(lux, *GL5528)
    assert resistance == pytest.approx(ohm, rel=1e-4)
    assert voltage(5.0, 10_000.0, resistance) == pytest.approx(volt, abs=1e-4)


@given(LUX, st.floats(1e3, 2e5), st.floats(0.4, 1.2), st.floats(1e5, 1e8))
def test_the_light_can_be_told_from_the_conductance(lux, r10, gamma, dark):
    siemens = conductance(lux, r10, gamma, dark)
    # Where the dark's own conductance is most of it, digits are lost to it.
    lost = (1 / dark) / max(siemens - 1 / dark, 1e-300)
    back = equivalent_lux(siemens, r10, gamma, dark)
    assert back == pytest.approx(lux, rel=1e-11 * (1 + lost / gamma), abs=1e-9)


@given(st.floats(1e-7, 1), st.floats(1e-7, 1), st.lists(st.floats(0, 0.1), min_size=1, max_size=5))
def test_many_small_steps_are_one_long_step(before, target, steps):
    stepwise = before
    for dt in steps:
        stepwise = follow(stepwise, target, dt, 0.02, 0.03)
    assert stepwise == pytest.approx(follow(before, target, sum(steps), 0.02, 0.03), rel=1e-9)


def test_after_one_time_constant_63_percent_is_there():
    assert follow(0.0, 1.0, 0.02, 0.02, 0.03) == pytest.approx(1 - math.exp(-1))
    assert follow(1.0, 0.0, 0.03, 0.02, 0.03) == pytest.approx(math.exp(-1))
    assert follow(0.0, 1.0, 0.0, 0.0, 0.0) == 1.0
