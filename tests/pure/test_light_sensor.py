# SPDX-License-Identifier: GPL-3.0-or-later
"""The light sensor's model: what it makes of the light that the scene sends it."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import LIGHT
from angen_sensors.sensor_logic.kinds.light import LightParameters, LightSensor, conductance
from angen_sensors.sensor_logic.model import LightSample, Pose, Update
from angen_sensors.sensor_logic.noise import generator
from hypothesis import given
from hypothesis import strategies as st

LUX = {"method": "ILLUMINANCE", "threshold": 50.0}
DIGITAL = {**LUX, "output": "DIGITAL", "lux_step": 0.0, "lux_max": 1e6, "integration_time": 0.0}


HERE = Pose(np.zeros(3), np.eye(3))


def sense(lights, rate=1.0, name="sensor", **settings):
    """The readings over a list of lights, in the unit of the method."""
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


def test_four_walls_publish_percent_and_no_resistance():
    (reading,) = sense([42.0])
    assert reading.value == 42.0
    assert reading.fields == {
        "note": "",
        "luminance_percent": 42.0,
        "illuminance_lux": None,
        "resistance_ohm": None,
        "voltage_v": None,
        "lit": False,
    }


def test_a_resistor_publishes_lux_resistance_and_voltage():
    (reading,) = sense([10.0], **LUX)
    assert reading.fields["luminance_percent"] is None
    assert reading.fields["illuminance_lux"] == 10.0
    assert reading.fields["resistance_ohm"] == pytest.approx(13807, rel=1e-4)
    assert reading.fields["voltage_v"] == pytest.approx(2.1002, abs=1e-4)


def test_lit_is_above_the_threshold():
    assert of(sense([50.0, 50.1, 50.0, 49.9], **LUX), "lit") == [False, True, False, False]


def test_hysteresis_keeps_the_state_between_its_two_levels():
    lights = [50, 54, 56, 46, 45.0, 54, 56]
    lit = of(sense(lights, hysteresis=10.0, **LUX), "lit")
    assert lit == [False, False, True, True, False, False, True]


def test_the_first_reading_is_at_rest():
    (reading,) = sense([1000.0], rise_time=100.0, **LUX)
    assert 1 / reading.fields["resistance_ohm"] == pytest.approx(
        conductance(1000.0, 14_000.0, 0.7, 1e6)
    )


def test_the_resistor_follows_the_light_with_its_own_speed_each_way():
    dark, bright = (conductance(lux, 14_000.0, 0.7, 1e6) for lux in (1.0, 1000.0))
    up, down = 0.05, 0.2
    readings = sense([1, 1000, 1], rate=10.0, rise_time=up, fall_time=down, **LUX)
    rising = bright + (dark - bright) * math.exp(-0.1 / up)
    falling = dark + (rising - dark) * math.exp(-0.1 / down)
    assert [1 / r for r in of(readings, "resistance_ohm")] == pytest.approx([dark, rising, falling])
    # The lamp is seen as lit while the resistor still falls.
    assert of(readings, "lit") == [False, True, True]
    assert of(readings, "illuminance_lux") == [1, 1000, 1]


def test_a_digital_part_counts_whole_steps_up_to_its_full_scale():
    settings = {**DIGITAL, "lux_step": 0.5, "lux_max": 100.0}
    lights = [0.0, 0.49, 0.5, 33.3, 99.99, 100.0, 1e5]
    assert of(sense(lights, **settings), "illuminance_lux") == [0, 0, 0.5, 33, 99.5, 100, 100]


def test_a_bh1750_is_full_at_54612_lux():
    values = {"lux_step": 1 / 1.2, "lux_max": 65535 / 1.2, "integration_time": 0.12}
    (reading,) = sense([1e6], **{**DIGITAL, **values})
    assert reading.value == pytest.approx(54612.5)


def test_integration_is_the_mean_of_the_light_held_over_it():
    settings = {**DIGITAL, "integration_time": 0.25}
    lux = of(sense([10, 20, 40, 80], rate=10.0, **settings), "illuminance_lux")
    # Weights in tenths of a second: the newest light held for 0.1 s, and so on.
    expected = [10, (1 * 20 + 1.5 * 10) / 2.5, (40 + 20 + 0.5 * 10) / 2.5, (80 + 40 + 10) / 2.5]
    assert lux == pytest.approx(expected)


@given(st.floats(0, 1e5), st.floats(0.001, 5.0), st.integers(1, 30))
def test_a_still_light_is_told_whatever_the_integration_time(lux, seconds, updates):
    settings = {**DIGITAL, "integration_time": seconds}
    assert of(sense([lux] * updates, rate=7.0, **settings), "illuminance_lux") == pytest.approx(
        [lux] * updates
    )


def test_a_fast_part_forgets_the_light_before():
    settings = {**DIGITAL, "integration_time": 0.1}
    assert of(sense([10, 20], **settings), "illuminance_lux") == [10, 20]


def test_noise_is_gaussian_and_never_below_zero():
    readings = of(sense([100.0] * 2000, noise_sigma=5.0, **LUX), "illuminance_lux")
    mean = sum(readings) / len(readings)
    sigma = math.sqrt(sum((r - mean) ** 2 for r in readings) / len(readings))
    assert mean == pytest.approx(100.0, abs=4 * 5 / math.sqrt(2000))
    assert sigma == pytest.approx(5.0, rel=0.08)
    assert min(of(sense([0.0] * 50, noise_sigma=5.0, **LUX), "illuminance_lux")) == 0.0


def test_noise_depends_on_the_sensor_and_not_on_the_run():
    one = of(sense([9.0] * 5, noise_sigma=1.0, **LUX), "illuminance_lux")
    assert one == of(sense([9.0] * 5, noise_sigma=1.0, **LUX), "illuminance_lux")
    assert one != of(sense([9.0] * 5, noise_sigma=1.0, name="other", **LUX), "illuminance_lux")


def test_percent_stays_within_0_and_100():
    percent = of(sense([0.0, 100.0] * 50, noise_sigma=20.0), "luminance_percent")
    assert min(percent) == 0.0
    assert max(percent) == 100.0


@pytest.mark.parametrize("light", [None, math.nan])
def test_a_light_that_was_not_measured_is_an_error(light):
    with pytest.raises(ValueError, match="ILLUMINANCE"):
        sense([light], **LUX)


def test_negative_light_is_dark():
    (reading,) = sense([-5.0], **LUX)
    assert reading.value == 0.0
    assert reading.fields["resistance_ohm"] == pytest.approx(1e6)
