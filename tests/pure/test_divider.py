# SPDX-License-Identifier: GPL-3.0-or-later
"""The voltage divider and the converter behind it."""

import math

import pytest
from angen_sensors.sensor_logic import physics
from hypothesis import given
from hypothesis import strategies as st

OHMS = st.floats(1.0, 1e8)


@pytest.mark.parametrize(
    ("resistance", "volts"),
    [(10_000.0, 2.5), (0.0, 5.0), (30_000.0, 1.25), (2_500.0, 4.0), (math.inf, 0.0)],
)
def test_voltages_worked_out_by_hand(resistance, volts):
    assert physics.voltage(5.0, 10_000.0, resistance) == pytest.approx(volts, abs=1e-12)


@given(supply=st.floats(1.0, 24.0), load=OHMS, resistance=OHMS)
def test_currents_of_both_resistors_are_the_same(supply, load, resistance):
    """Ohm and Kirchhoff: what flows through the sensing resistor flows through the load."""
    volts = physics.voltage(supply, load, resistance)
    assert volts / load == pytest.approx(supply / (load + resistance), rel=1e-12)
    assert 0.0 < volts <= supply


@pytest.mark.parametrize(
    ("volts", "bits", "code"),
    [
        (0.0, 10, 0),
        (5.0, 10, 1023),
        (2.5, 10, 511),
        (2.5, 1, 0),
        (4.9999, 1, 0),
        (5.0, 1, 1),
        (5.0, 32, 4_294_967_295),
        (-0.1, 10, 0),
        (5.1, 10, 1023),
    ],
)
def test_codes_of_the_converter(volts, bits, code):
    assert physics.adc(volts, 5.0, bits) == code


@given(code=st.integers(0, 4094))
def test_a_code_holds_until_the_next_one_begins(code):
    step = 5.0 / 4095
    assert physics.adc((code + 0.01) * step, 5.0, 12) == code
    assert physics.adc((code + 0.99) * step, 5.0, 12) == code
