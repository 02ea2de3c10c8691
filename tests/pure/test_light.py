# SPDX-License-Identifier: GPL-3.0-or-later
"""Photometry, the photoresistor, its divider and converter, and the light sensor's model.

They are compared with closed forms and literal tables.
"""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic import physics
from angen_sensors.sensor_logic.kind import LIGHT
from angen_sensors.sensor_logic.kinds.light import (
    KIND,
    LightParameters,
    LightSensor,
    conductance,
    equivalent_lux,
    follow,
)
from angen_sensors.sensor_logic.model import LightSample, Pose, Update
from angen_sensors.sensor_logic.noise import generator
from angen_sensors.sensor_logic.physics import counts, illuminance, luminance, luminance_percent
from hypothesis import given
from hypothesis import strategies as st

GL5528 = (14_000.0, 0.7, 1e6)
OHMS = st.floats(1.0, 1e8)
LUX = {"method": "ILLUMINANCE", "threshold": 50.0}
DIGITAL = {**LUX, "output": "DIGITAL", "lux_step": 0.0, "lux_max": 1e6, "integration_time": 0.0}
HERE = Pose(np.zeros(3), np.eye(3))


# The divider and the converter behind it


@pytest.mark.parametrize(
    ("resistance", "volts"),
    [(10_000.0, 2.5), (0.0, 5.0), (30_000.0, 1.25), (2_500.0, 4.0), (math.inf, 0.0)],
)
def test_voltages_worked_out_by_hand(resistance, volts):
    assert physics.voltage(5.0, 10_000.0, resistance) == pytest.approx(volts, abs=1e-12)


@given(supply=st.floats(1.0, 24.0), load=OHMS, resistance=OHMS)
def test_currents_of_both_resistors_are_the_same(supply, load, resistance):
    """Ohm and Kirchhoff: the current through the sensing resistor equals that through the load."""
    volts = physics.voltage(supply, load, resistance)
    assert volts / load == pytest.approx(supply / (load + resistance), rel=1e-12)
    assert 0.0 < volts <= supply


@pytest.mark.parametrize(
    ("volts", "bits", "code"),
    [
        (0.0, 10, 0), (5.0, 10, 1023), (2.5, 10, 511), (2.5, 1, 0), (4.9999, 1, 0), (5.0, 1, 1),
        (5.0, 32, 4_294_967_295), (-0.1, 10, 0), (5.1, 10, 1023),
    ],
)  # fmt: skip
def test_codes_of_the_converter(volts, bits, code):
    assert physics.adc(volts, 5.0, bits) == code


@given(code=st.integers(0, 4094))
def test_a_code_holds_until_the_next_one_begins(code):
    step = 5.0 / 4095
    assert physics.adc((code + 0.01) * step, 5.0, 12) == code
    assert physics.adc((code + 0.99) * step, 5.0, 12) == code


# Photometry


def test_a_watt_of_white_is_683_lux_and_the_channels_have_their_shares():
    assert luminance([1, 1, 1]) == pytest.approx(1.0, abs=1e-15)
    assert luminance(np.eye(3)).tolist() == [0.2126, 0.7152, 0.0722]
    assert illuminance([1, 1, 1]) == pytest.approx(683.0)
    assert illuminance([1, 1, 1], 179.0) == pytest.approx(179.0)
    assert illuminance([-1, -1, -1]) == 0.0


@pytest.mark.parametrize(
    ("light", "exposure", "count"),
    [(-1, 1, 0), (0, 1, 0), (0.00196, 1, 0), (0.00197, 1, 1), (0.5, 1, 128), (1.0, 1, 255)]
    + [(7.0, 1, 255), (math.nan, 1, 0), (math.inf, 1, 255), (-math.inf, 1, 0)]
    + [(0.25, 4, 255), (0.25, 0, 0)],
)
def test_eight_bits_round_to_the_nearest_count(light, exposure, count):
    assert counts([light], float(exposure)).tolist() == [count]


@pytest.mark.parametrize(
    ("walls", "percent"),
    [(np.ones((4, 3)), 100.0), (np.zeros((4, 3)), 0.0), (np.full((4, 3), 1 / 255), 100 / 255)]
    + [(np.array([[1.0] * 3, [0] * 3, [0] * 3, [0] * 3]), 25.0)],
)
def test_four_walls_are_percent_of_white(walls, percent):
    assert luminance_percent(walls, 1.0) == pytest.approx(percent)


# The photoresistor


@pytest.mark.parametrize(
    ("lux", "ohm", "volt"),
    [(0, 1e6, 0.0495), (1, 65566, 0.6617), (10, 13807, 2.1002), (100, 2785.6, 3.9107)]
    + [(1000, 557.0, 4.7362)],
)
def test_gl5528_over_the_decades(lux, ohm, volt):
    (reading,) = sense([lux], **LUX)
    assert reading.fields["resistance_ohm"] == pytest.approx(ohm, rel=1e-4)
    assert reading.fields["voltage_v"] == pytest.approx(volt, abs=1e-4)
    assert reading.fields["illuminance_lux"] == lux
    assert reading.fields["luminance_percent"] is None


@given(st.floats(0.0, 2e5), st.floats(1e3, 2e5), st.floats(0.4, 1.2), st.floats(1e5, 1e8))
def test_the_light_can_be_told_from_the_conductance(lux, r10, gamma, dark):
    siemens = conductance(lux, r10, gamma, dark)
    # Where the dark conductance is most of the total, digits are lost to it.
    lost = (1 / dark) / max(siemens - 1 / dark, 1e-300)
    back = equivalent_lux(siemens, r10, gamma, dark)
    assert back == pytest.approx(lux, rel=1e-11 * (1 + lost / gamma), abs=1e-9)


@given(st.floats(1e-7, 1), st.floats(1e-7, 1), st.lists(st.floats(0, 0.1), min_size=1, max_size=5))
def test_many_small_steps_are_one_long_step(before, target, steps):
    """63 % of the step is reached after one time constant, which differs each way."""
    stepwise = before
    for dt in steps:
        stepwise = follow(stepwise, target, dt, 0.02, 0.03)
    time = 0.02 if target > before else 0.03
    expected = target + (before - target) * math.exp(-sum(steps) / time)
    assert stepwise == pytest.approx(expected, rel=1e-9)
    assert follow(before, target, 0.0, 0.0, 0.0) == target


# The sensor


def sense(lights, rate=1.0, name="sensor", **settings):
    """Return the readings over a list of lights, in the unit of the method."""
    parameters = LightParameters(**settings)
    assert parameters.problems() == []
    field = "luminance_percent" if parameters.method == "FOUR_WALL" else "illuminance_lux"
    model = LightSensor()
    return [
        model.update(
            parameters,
            Update(
                i,
                i / rate,
                HERE,
                {LIGHT: lambda light=light: LightSample(**{field: light})},
                lambda i=i: generator(0, name, i),
            ),
        )
        for i, light in enumerate(lights)
    ]


def of(readings, field):
    return [reading.fields[field] for reading in readings]


def test_four_walls_publish_percent_and_lit_has_a_hysteresis():
    (reading,) = sense([42.0])
    assert reading.value == 42.0
    fields = {"note": "", "luminance_percent": 42.0, "illuminance_lux": None, "lit": False}
    assert reading.fields == {**fields, "resistance_ohm": None, "voltage_v": None}
    assert of(sense([50.0, 50.1, 50.0, 49.9], **LUX), "lit") == [False, True, False, False]
    lights = [50, 54, 56, 46, 45.0, 54, 56]
    lit = of(sense(lights, hysteresis=10.0, **LUX), "lit")
    assert lit == [False, False, True, True, False, False, True]


def test_the_resistor_starts_at_rest_and_follows_the_light_with_its_own_speed_each_way():
    dark, bright = (conductance(lux, *GL5528) for lux in (1.0, 1000.0))
    up, down = 0.05, 0.2
    readings = sense([1, 1000, 1], rate=10.0, rise_time=up, fall_time=down, **LUX)
    rising = bright + (dark - bright) * math.exp(-0.1 / up)
    falling = dark + (rising - dark) * math.exp(-0.1 / down)
    assert [1 / r for r in of(readings, "resistance_ohm")] == pytest.approx([dark, rising, falling])
    # The lamp is seen as lit while the resistor still falls.
    assert of(readings, "lit") == [False, True, True]
    assert of(readings, "illuminance_lux") == [1, 1000, 1]


@pytest.mark.parametrize("lux", [50.0, 100.0, 150.0])
def test_a_lux_sensor_in_a_lamp_lit_room_flickers_and_is_still_at_night(lux):
    """Five real sensors: 0.5 to 1.0 % of the reading, and exactly 0 at night."""
    part = next(p for p in KIND.presets if p.identifier == "BH1750FVI").values
    found = np.array(of(sense([lux] * 1000, **part), "illuminance_lux"))
    assert 0.0035 < found.std() / lux < 0.0105
    assert 0.3 < np.mean(np.diff(found) == 0.0) < 0.75, "45 to 70 % equal the one before"
    assert set(of(sense([0.0] * 50, **part), "illuminance_lux")) == {0.0}


BH1750 = {"lux_step": 1 / 1.2, "lux_max": 65535 / 1.2, "integration_time": 0.12}


@pytest.mark.parametrize(
    ("lights", "rate", "settings", "read"),
    [
        (
            [0.0, 0.49, 0.5, 33.3, 99.99, 100.0, 1e5], 1.0, {"lux_step": 0.5, "lux_max": 100.0},
            [0, 0, 0.5, 33, 99.5, 100, 100],
        ),
        ([1e6], 1.0, BH1750, [54612.5]),
        # Weights in tenths of a second: the newest light lasts 0.1 s, and so on.
        (
            [10, 20, 40, 80], 10.0, {"integration_time": 0.25},
            [10, (1 * 20 + 1.5 * 10) / 2.5, (40 + 20 + 0.5 * 10) / 2.5, (80 + 40 + 10) / 2.5],
        ),
        ([10, 20], 1.0, {"integration_time": 0.1}, [10, 20]),
    ],
    ids=["whole steps up to its full scale", "a BH1750 is full", "integration", "a fast part"],
)  # fmt: skip
def test_a_digital_part(lights, rate, settings, read):
    found = of(sense(lights, rate=rate, **{**DIGITAL, **settings}), "illuminance_lux")
    assert found == pytest.approx(read)


@given(st.floats(0, 1e5), st.floats(0.001, 5.0), st.integers(1, 30))
def test_a_still_light_is_told_whatever_the_integration_time(lux, seconds, updates):
    settings = {**DIGITAL, "integration_time": seconds}
    assert of(sense([lux] * updates, rate=7.0, **settings), "illuminance_lux") == pytest.approx(
        [lux] * updates
    )


def test_noise_is_gaussian_and_stays_within_what_can_be():
    readings = of(sense([100.0] * 2000, noise_sigma=5.0, **LUX), "illuminance_lux")
    assert np.mean(readings) == pytest.approx(100.0, abs=4 * 5 / math.sqrt(2000))
    assert np.std(readings) == pytest.approx(5.0, rel=0.08)
    assert min(of(sense([0.0] * 50, noise_sigma=5.0, **LUX), "illuminance_lux")) == 0.0
    percent = of(sense([0.0, 100.0] * 50, noise_sigma=20.0), "luminance_percent")
    assert (min(percent), max(percent)) == (0.0, 100.0)


@pytest.mark.parametrize("light", [None, math.nan])
def test_a_light_that_was_not_measured_is_an_error_and_negative_light_is_dark(light):
    with pytest.raises(ValueError, match="ILLUMINANCE"):
        sense([light], **LUX)
    (reading,) = sense([-5.0], **LUX)
    assert reading.value == 0.0 and reading.fields["resistance_ohm"] == pytest.approx(1e6)
