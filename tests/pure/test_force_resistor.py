# SPDX-License-Identifier: GPL-3.0-or-later
"""The force-sensing resistor against its data sheet and against closed forms."""

import contextlib
import io
import itertools
import math
import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.pressure import (
    ForceResistor,
    PressureParameters,
    spread_factor,
    typical_resistance,
)
from angen_sensors.sensor_logic.parameters import is_chosen, specs
from hypothesis import given
from hypothesis import strategies as st
from tiers import mostly_slow

PAGE = Path(__file__).resolve().parents[2] / "docs" / "force_resistor.md"
IDEAL = PressureParameters()
GRAM = 9.80665e-3
# A film without the ends of its range, to test the curve alone.
WIDE = replace(IDEAL, force_min=0.001, force_max=1000.0)
HYSTERESIS = replace(IDEAL, hysteresis=0.1)
DRIFT = replace(IDEAL, drift=0.05)


def resistances(parameters, loads, times=None, noise=0.0, part=0.0):
    """Resistances of one part under the loads (N), at the times (s) or all at once."""
    resistor = ForceResistor(part)
    times = times if times is not None else [0.0] * len(loads)
    return np.array(
        [
            resistor.update(parameters, load, time, noise).resistance_ohm
            for load, time in zip(loads, times, strict=True)
        ]
    )


# The typical part


@pytest.mark.parametrize(
    ("force", "code"), [(0.2, 260), (1.0, 642), (5.0, 854), (10.0, 910), (20.0, 952)]
)
def test_codes_with_10_kohm_5_v_and_10_bits(force, code):
    assert ForceResistor().update(IDEAL, force, 0.0, 0.0).adc == code


def test_the_same_codes_in_one_growing_load_whatever_the_noise():
    resistor = ForceResistor(part_noise=1.7)
    loads = [0.0, 0.1, 0.2, 1.0, 5.0, 10.0, 20.0, 3000.0]
    found = [resistor.update(IDEAL, f, t, -2.0).adc for t, f in enumerate(loads)]
    assert found[2:] == [260, 642, 854, 910, 952, 952]


@pytest.mark.parametrize(
    ("grams", "ohms"),
    [
        (20, 30_000),
        (50, 10_000),
        (100, 6_000),
        (1_000, 1_250),
        (2_000, 750),
        (4_000, 450),
        (7_000, 300),
        (10_000, 250),
    ],
)
def test_points_of_the_data_sheet(grams, ohms):
    assert typical_resistance(WIDE, grams * GRAM) == pytest.approx(ohms, rel=1e-9)


def test_between_two_points_the_curve_is_straight_on_logarithmic_axes():
    assert typical_resistance(WIDE, math.sqrt(100 * 1000) * GRAM) == pytest.approx(
        math.sqrt(6_000 * 1_250), rel=1e-9
    )
    # Beyond the last point its line goes on: 250·(250/300)^x at 7000·(10/7)^(1 + x) g.
    assert typical_resistance(WIDE, 10_000 * (10 / 7) * GRAM) == pytest.approx(
        250 * 250 / 300, rel=1e-9
    )


@given(force=st.floats(0.2, 20.0), ohms=st.floats(100.0, 1e6), exponent=st.floats(0.1, 2.0))
def test_power_law(force, ohms, exponent):
    parameters = replace(IDEAL, resistor="POWER_LAW", resistance_at_1n=ohms, exponent=exponent)
    expected = min(ohms * force**-exponent, 10e6)
    assert typical_resistance(parameters, force) == pytest.approx(expected, rel=1e-9)


def test_default_power_law_is_within_20_percent_of_the_table():
    power_law = replace(IDEAL, resistor="POWER_LAW")
    off = [
        typical_resistance(power_law, force) / typical_resistance(IDEAL, force) - 1.0
        for force in np.geomspace(0.2, 20.0, 500)
    ]
    assert max(np.abs(off)) < 0.2
    assert max(off) > 0.15 and min(off) < -0.15, "a fit: it errs both ways"


@pytest.mark.parametrize("resistor", ["FSR_402", "POWER_LAW"])
@pytest.mark.parametrize("force_min", mostly_slow([0.0, 0.2, 1.0], 0.2))
def test_more_force_never_reads_a_higher_resistance_and_there_is_no_step(resistor, force_min):
    parameters = replace(IDEAL, resistor=resistor, force_min=force_min)
    forces = np.concatenate([[0.0], np.geomspace(1e-300, 1e-6, 50), np.linspace(1e-6, 30, 300_001)])
    ohms = np.array([typical_resistance(parameters, force) for force in forces])
    assert (np.diff(ohms) <= ohms[:-1] * 1e-12).all()
    # Without an actuation force the power law itself starts steeply: only its fall is tested.
    if force_min:
        assert np.abs(np.diff(np.log(ohms))).max() < 0.01


def test_unloaded_and_pulled():
    for force in (0.0, -5.0):
        reading = ForceResistor().update(IDEAL, force, 0.0, 0.0)
        assert reading.resistance_ohm == 10e6
        assert reading.voltage_v == pytest.approx(5.0 * 1e4 / (1e4 + 10e6), rel=1e-12)
        assert reading.adc == 1


def test_actuation_is_a_steep_break():
    """Interlink: the break brings more than 100 kΩ down to about 10 kΩ."""
    assert typical_resistance(IDEAL, 0.15) > 100_000
    assert typical_resistance(IDEAL, 0.5) < 11_000
    assert typical_resistance(IDEAL, 0.1) == pytest.approx(
        math.sqrt(10e6 * typical_resistance(IDEAL, 0.2)), rel=1e-9
    )


def test_saturation():
    ohms = resistances(IDEAL, [19.0, 20.0, 25.0, 500.0])
    assert ohms[0] > ohms[1] == ohms[2] == ohms[3]


# Hysteresis


@pytest.mark.parametrize("share", [0.01, 0.1, 0.3])
@pytest.mark.parametrize("resistor", ["FSR_402", "POWER_LAW"])
def test_a_full_loop_measures_the_hysteresis(share, resistor):
    """(RF+ − RF−)/RF+ at the data sheet's 1000 g, from loading to 20 N and back; within 1 %."""
    parameters = replace(IDEAL, hysteresis=share, resistor=resistor)
    up = np.linspace(0.0, 20.0, 2001)
    loop = resistances(parameters, np.concatenate([up, up[::-1]]))
    for force in (0.5, 9.81, 5.0):
        i = int(np.argmin(np.abs(up - force)))
        measured = (loop[i] - loop[-1 - i]) / loop[i]
        assert measured == pytest.approx(share, rel=0.01)


def test_first_loading_is_the_typical_curve():
    up = np.linspace(0.0, 20.0, 101)
    assert resistances(HYSTERESIS, up) == pytest.approx(resistances(IDEAL, up), rel=1e-9)


def test_loops_close_at_both_ends():
    loop = resistances(HYSTERESIS, [0.0, 20.0, 0.0, 20.0, 50.0, 0.0])
    assert loop[0] == loop[2] == loop[5] == pytest.approx(10e6, rel=1e-9)
    assert loop[1] == pytest.approx(loop[3], rel=1e-12)
    assert loop[3] == pytest.approx(loop[4], rel=1e-12)


def test_a_minor_loop_stays_inside_the_major_one_and_closes():
    cycle = [10.0, 8.0, 5.0, 8.0, 10.0, 12.0]
    found = resistances(HYSTERESIS, [*cycle, *cycle[:0:-1], *cycle[1:]])
    first = found[: len(cycle)]
    lower = 0.9 * resistances(IDEAL, cycle)
    assert (first >= lower * (1 - 1e-9)).all()
    assert (first <= resistances(IDEAL, cycle) * (1 + 1e-9)).all()
    assert first[4] == pytest.approx(first[0], rel=1e-9), "back at 10 N"
    assert found[-1] == pytest.approx(first[-1], rel=1e-9), "and back at 12 N after a second loop"
    assert first[1] < first[3], "8 N: falling reads lower than rising"


def test_a_swing_inside_the_play_changes_nothing():
    found = resistances(HYSTERESIS, [10.0, 9.9, 10.0, 9.8, 9.9])
    assert found == pytest.approx(found[0], rel=1e-12)


@given(seed=st.integers(0, 10_000))
def test_hysteresis_does_not_depend_on_the_rate(seed):
    """The same path in one step or in twenty steps from turn to turn ends the same."""
    turns = [random.Random(seed).uniform(0.0, 25.0) for _ in range(8)]
    fine = [
        a + (b - a) * k / 20 for a, b in itertools.pairwise([0.0, *turns]) for k in range(1, 21)
    ]
    ends = resistances(HYSTERESIS, [0.0, *fine])[20::20]
    assert ends == pytest.approx(resistances(HYSTERESIS, [0.0, *turns])[1:], rel=1e-9)


# Drift


def test_a_constant_load_drifts_by_its_share_each_decade():
    """R(t)/R(0) = 1 − 0.05·log10(1 + t/1 s); over the data sheet's 35 days 32.4 %."""
    times = [0.0, 9.0, 99.0, 999.0, 35 * 86400.0]
    found = resistances(DRIFT, [9.81] * len(times), times)
    expected = [1.0, 0.95, 0.90, 0.85, 1.0 - 0.05 * math.log10(1.0 + 35 * 86400.0)]
    assert found / found[0] == pytest.approx(expected, rel=1e-9)
    assert expected[-1] == pytest.approx(0.676, abs=5e-4)


def sampled(load_at, rate, until=600.0):
    times = [k / rate for k in range(int(until * rate) + 1)]
    found = resistances(DRIFT, [load_at(time) for time in times], times)
    return found[:: round(rate)]


def steps(time):
    return [5.0, 9.0, 9.4, 3.0, 0.0, 6.0][min(int(time // 100), 5)]


def test_drift_does_not_depend_on_the_update_rate():
    assert sampled(steps, 1.0) == pytest.approx(sampled(steps, 100.0), rel=1e-9)


@pytest.mark.parametrize(
    "load_at", [lambda time: 2.0 + time / 100.0, lambda time: 5.0 + 4.0 * math.sin(time / 20.0)]
)
def test_drift_under_a_changing_load_hardly_depends_on_the_update_rate(load_at):
    assert sampled(load_at, 1.0) == pytest.approx(sampled(load_at, 100.0), rel=0.003)


def test_a_growing_load_never_makes_the_resistance_jump_up():
    """A load that adds a hundredth each second after an hour at rest, for a decade of force."""
    loads = [1.0, *(1.01**k for k in range(230))]
    found = resistances(DRIFT, loads, [0.0, *range(3600, 3830)])
    assert (np.diff(found) < 0.0).all()


def lost(parameters, loads, times):
    """What share of the typical resistance drift has taken away at the end."""
    return 1.0 - resistances(parameters, loads, times)[-1] / typical_resistance(IDEAL, loads[-1])


def test_a_change_below_a_tenth_goes_on_drifting():
    assert lost(DRIFT, [5.0, 5.4, 4.6], [0.0, 10.0, 999.0]) == pytest.approx(0.15, rel=1e-9)


def test_of_a_doubled_load_half_has_drifted_and_half_starts_anew():
    assert lost(DRIFT, [5.0, 10.0], [0.0, 999.0]) == pytest.approx(0.075, rel=1e-9)
    assert lost(DRIFT, [5.0, 2.0], [0.0, 999.0]) == pytest.approx(0.15, rel=1e-9)


def test_released_and_pressed_again_there_is_no_drift():
    assert lost(DRIFT, [5.0, 0.0, 5.0], [0.0, 999.0, 1000.0]) == pytest.approx(0.0, abs=1e-12)


def test_beyond_saturation_the_load_counts_as_the_same():
    assert lost(DRIFT, [300.0, 600.0, 200.0], [0.0, 50.0, 999.0]) == pytest.approx(0.15, rel=1e-9)


def test_the_largest_drift_leaves_a_positive_resistance_for_a_century():
    found = resistances(replace(IDEAL, drift=0.1), [5.0, 5.0], [0.0, 100 * 365 * 86400.0])
    assert found[-1] > 0.0


# Spread


def test_spread_has_the_standard_deviation_of_the_data_sheet():
    """One standard deviation over the mean; 20 000 parts, so within 2 %."""
    parameters = replace(IDEAL, part_spread=0.06)
    draws = np.random.default_rng(1).standard_normal(20_000)
    found = np.array([resistances(parameters, [9.81], part=draw)[0] for draw in draws])
    assert found.std() / found.mean() == pytest.approx(0.06, rel=0.02)
    assert found.mean() == pytest.approx(typical_resistance(IDEAL, 9.81), rel=0.002)


@pytest.mark.parametrize("spread", [0.02, 0.06, 0.5])
def test_spread_factor_has_mean_one_and_the_asked_deviation(spread):
    """Over the whole normal distribution, by Gauss-Hermite quadrature."""
    draws, weights = np.polynomial.hermite_e.hermegauss(40)
    weights = weights / weights.sum()
    factors = np.array([spread_factor(spread, draw) for draw in draws])
    mean = factors @ weights
    assert mean == pytest.approx(1.0, rel=1e-9)
    assert math.sqrt((factors - mean) ** 2 @ weights) == pytest.approx(spread, rel=1e-9)


def test_spread_factor_is_one_without_spread_and_never_negative():
    assert spread_factor(0.0, 3.0) == 1.0
    assert spread_factor(0.5, -8.0) > 0.0


def test_a_part_stays_the_same_part():
    parameters = replace(IDEAL, part_spread=0.06)
    loads = [1.0, 10.0, 5.0, 0.0, 7.0]
    ratio = resistances(parameters, loads, part=1.0) / resistances(IDEAL, loads)
    assert ratio[[0, 1, 2, 4]] == pytest.approx(spread_factor(0.06, 1.0), rel=1e-9)
    assert ratio[3] == 1.0, "what is not touched is open, whatever the part"


def test_repeatability_is_drawn_at_each_press_and_kept_while_pressed():
    parameters = replace(IDEAL, repeatability=0.02)
    resistor = ForceResistor()
    found = [
        resistor.update(parameters, force, 0.0, noise).resistance_ohm
        / typical_resistance(IDEAL, force)
        for force, noise in [(5, 1.0), (5, -1.0), (9, 2.0), (0, 0.5), (5, -1.0), (7, 0.3)]
    ]
    first, second = spread_factor(0.02, 1.0), spread_factor(0.02, -1.0)
    assert found == pytest.approx([first, first, first, 1.0, second, second], rel=1e-9)


def test_the_same_draws_give_the_same_readings():
    parameters = replace(
        IDEAL, hysteresis=0.1, drift=0.05, part_spread=0.06, repeatability=0.02, force_min=0.5
    )
    rng = np.random.default_rng(3)
    loads, noise = rng.uniform(-1.0, 30.0, 300), rng.standard_normal(300)
    one, other = ForceResistor(0.4), ForceResistor(0.4)
    for k, (load, draw) in enumerate(zip(loads, noise, strict=True)):
        reading = one.update(parameters, load, k / 10, draw)
        assert reading == other.update(parameters, load, k / 10, draw)
        assert 0.0 < reading.resistance_ohm <= 10e6 * (1 + 1e-9)
        assert 0 <= reading.adc <= 1023


# Parameters and the page


def test_choices_keep_their_numbers():
    choices = specs(PressureParameters)["resistor"].choices
    assert {choice.identifier: choice.number for choice in choices} == {
        "FSR_402": 0,
        "POWER_LAW": 1,
    }


def test_the_power_law_is_hidden_from_the_table():
    known = specs(PressureParameters)
    for name in ("resistance_at_1n", "exponent"):
        assert not is_chosen(IDEAL, known[name].used_when)
        assert is_chosen(replace(IDEAL, resistor="POWER_LAW"), known[name].used_when)


def test_the_table_of_the_page_is_what_its_program_prints():
    text = PAGE.read_text(encoding="utf-8")
    program = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    table = re.search(r"```text\n(.*?)```", text, re.DOTALL)
    assert program and table
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(program[1], {})
    assert printed.getvalue() == table[1]
