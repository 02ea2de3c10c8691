# SPDX-License-Identifier: GPL-3.0-or-later
"""The pressure sensor's reading of contact forces, its weight and its partner; and the resistor.

The force-sensing resistor is compared with its data sheet and closed forms.
"""

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
from angen_sensors.sensor_logic.forces.world import PadForces, Partner
from angen_sensors.sensor_logic.kind import FORCES
from angen_sensors.sensor_logic.kinds.pressure import (
    ForceResistor,
    PressurePad,
    PressureParameters,
    pad_reading,
    spread_factor,
    typical_resistance,
)
from angen_sensors.sensor_logic.model import PadContact, Pose, Update
from angen_sensors.sensor_logic.noise import generator
from hypothesis import given
from hypothesis import strategies as st
from tiers import mostly_slow

IDEAL = PressureParameters()
HERE = Pose(np.zeros(3), np.eye(3))
NOTHING = np.zeros(3)


def pushed(name, force, place=(0, 0, 0), uid=1):
    return Partner(name, frozenset({uid}), np.array([place], float), np.array([force], float))


def contact(*partners, weight=NOTHING, chosen=None, **forces):
    return PadContact(PadForces(tuple(partners), **forces), np.array(weight, float), chosen)


def read(parameters, *contacts):
    pad = PressurePad()
    return [pad.update(parameters, update_of(c)) for c in contacts]


def update_of(one, number=0):
    noise = lambda: generator(0, "pad", number)  # noqa: E731
    return Update(number, 0.0, HERE, {FORCES: lambda: one}, noise, noise)


TURNED = Pose(np.zeros(3), np.array(((0, 0, 1.0), (0, 1, 0), (-1, 0, 0))))
KEPT = replace(IDEAL, subtract_own_weight=False)
A, FLOOR = pushed("a", (0, 0, -30)), pushed("floor", (0, 0, 35), uid=2)
OWN = (0, 0, -5)
READ = {
    # Only the force into the pad counts: no friction, and no support from below.
    "normal": (IDEAL, HERE, contact(pushed("a", (3, 4, -10)), FLOOR), 10, "a"),
    "turned": (IDEAL, TURNED, contact(pushed("a", (-7, 0, -10))), 7, "a"),
    "chosen": (IDEAL, HERE, contact(A, pushed("b", (0, 0, -9), uid=2), chosen={2}), 9, "b"),
    "next to nothing": (IDEAL, HERE, contact(A, pushed("b", (0, 0, -0.01), uid=2)), 30.01, "a"),
    "own weight": (IDEAL, HERE, contact(A, weight=OWN), 30, "a"),
    "with own weight": (KEPT, HERE, contact(A, weight=OWN), 35, "a"),
    "what holds it up": (IDEAL, HERE, contact(A, FLOOR, weight=OWN, chosen={2}), 30, "floor"),
    "with own weight on it": (KEPT, HERE, contact(A, FLOOR, weight=OWN, chosen={2}), 35, "floor"),
    "nothing": (IDEAL, HERE, contact(), 0, ""),
}


@pytest.mark.parametrize(("parameters", "pose", "what", "force", "name"), READ.values(), ids=READ)
def test_force_and_partners(parameters, pose, what, force, name):
    found = pad_reading(parameters, pose, what)
    assert (found.force, found.partners) == (pytest.approx(force), name)
    assert name or all(map(math.isnan, found.centre))


def test_centre_of_pressure_is_in_the_pads_axes():
    pose = Pose(np.array((1.0, 2, 3)), np.array(((0, -1.0, 0), (1, 0, 0), (0, 0, 1))))
    two = (pushed("a", (0, 0, -30), (1.1, 2, 3)), pushed("b", (0, 0, -10), (1.3, 2, 3)))
    found = pad_reading(IDEAL, pose, contact(*two))
    # 0.15 along the world's x is −0.15 along the pad's y.
    assert found.centre == pytest.approx((0.0, -0.15), abs=1e-12)
    assert found.partners == "a;b"


def pressed_by(area, force=7.355):
    one = Partner("a", frozenset({1}), np.zeros((1, 3)), np.array([[0, 0, -force]]), area)
    parameters = replace(IDEAL, overall_area=2.625e-4)
    (reading,) = read(parameters, contact(one))
    assert reading.value == pytest.approx(force), "the force itself is the whole one"
    return 1.0 / reading.fields["resistance_ohm"]


@pytest.mark.parametrize(("grams", "less"), [(250, 0.12), (500, 0.20), (750, 0.31)])
def test_a_flat_weight_larger_than_the_part_presses_its_rim_too(grams, less):
    """Measured with an FSR 402: 12, 20, 31 % less conductance than under a finger."""
    finger, flat = (pressed_by(area, grams * GRAM) for area in (1e-4, 4e-3))
    assert 1.0 - flat / finger == pytest.approx(less, abs=0.05)


def test_the_larger_the_contact_the_more_the_rim_carries():
    found = [pressed_by(area) for area in (0.0, 1e-5, 1.2e-4, 1.5e-4, 2e-4, 2.6e-4, 1.0)]
    assert found[0] == found[1] == found[2], "unknown, or within the active area"
    assert found[2] > found[3] > found[4] > found[5] >= found[6]
    assert pressed_by(1.0, 1.5) == pressed_by(0.0, 1.5), "a light touch"
    (problem,) = replace(IDEAL, overall_area=1e-4).problems()
    assert "overall_area" in problem and "smaller than the active area" in problem


# Known and unknown


def test_what_is_not_known_leaves_the_last_known_reading():
    known = contact(pushed("a", (0, 0, -30)))
    unknown = contact(problem="a reason", usable=False, residual=0.7)
    estimate = contact(pushed("b", (0, 0, -12)), problem="an estimate", usable=True)
    readings = read(IDEAL, known, unknown, estimate, known)
    assert [r.fields["force_n"] for r in readings] == [30, 30, 12, 30]
    assert [r.fields["valid"] for r in readings] == [True, False, False, True]
    assert [r.fields["problem"] for r in readings] == ["", "a reason", "an estimate", ""]
    assert [r.fields["partners"] for r in readings] == ["a", "a", "b", "a"]
    assert readings[1].fields["residual"] == 0.7
    (first,) = read(IDEAL, unknown)
    assert first.fields["force_n"] == 0.0 and not first.fields["valid"] and not first.active


@pytest.mark.parametrize(("force", "pressed"), [(0.9, False), (1.0, False), (1.1, True)])
def test_pressed_above_the_threshold(force, pressed):
    (reading,) = read(IDEAL, contact(pushed("a", (0, 0, -force))))
    assert (reading.active, reading.fields["pressed"]) == (pressed, pressed)
    assert reading.value == pytest.approx(force)


def test_the_raw_force_goes_on_where_the_resistor_saturates():
    readings = read(IDEAL, *(contact(pushed("a", (0, 0, -f))) for f in (0.0, 5.0, 20.0, 700.0)))
    assert [r.fields["force_n"] for r in readings] == pytest.approx([0, 5, 20, 700])
    assert [r.fields["adc"] for r in readings][1:] == [854, 952, 952]
    assert readings[0].fields["resistance_ohm"] == IDEAL.unloaded_resistance
    volts = [r.fields["voltage_v"] for r in readings]
    assert volts == sorted(volts) and volts[-1] < IDEAL.supply_voltage


def test_noise_is_as_strong_as_asked():
    pad, parameters = PressurePad(), replace(IDEAL, noise_sigma=0.5)
    updates = (update_of(contact(A), number) for number in range(200))
    values = np.array([pad.update(parameters, update).fields["force_n"] for update in updates])
    assert values.std() == pytest.approx(0.5, rel=0.2)
    assert values.mean() == pytest.approx(30.0, abs=0.15)


# The force-sensing resistor

PAGE = Path(__file__).resolve().parents[2] / "docs" / "force_resistor.md"
GRAM = 9.80665e-3
# A film without the ends of its range, to test the curve alone.
WIDE = replace(IDEAL, force_min=0.001, force_max=1000.0)
HYSTERESIS = replace(IDEAL, hysteresis=0.1)
DRIFT = replace(IDEAL, drift=0.05)


def resistances(parameters, loads, times=None, noise=0.0, part=0.0):
    """Return resistances of one part under the loads (N), at the times (s) or all at once."""
    resistor = ForceResistor(part)
    times = times if times is not None else [0.0] * len(loads)
    return np.array(
        [
            resistor.update(parameters, load, time, noise).resistance_ohm
            for load, time in zip(loads, times, strict=True)
        ]
    )


# The typical part


def test_codes_with_10_kohm_5_v_and_10_bits():
    """One growing load, with any noise."""
    resistor = ForceResistor(part_noise=1.7)
    loads = [0.0, 0.1, 0.2, 1.0, 5.0, 10.0, 20.0, 3000.0]
    found = [resistor.update(IDEAL, f, t, -2.0).adc for t, f in enumerate(loads)]
    assert found[2:] == [260, 642, 854, 910, 952, 952]


@pytest.mark.parametrize(
    ("grams", "ohms"),
    [(20, 30_000), (50, 10_000), (100, 6_000), (1_000, 1_250), (2_000, 750), (4_000, 450)]
    + [(7_000, 300), (10_000, 250)]
    # Straight between two points on logarithmic axes; the last line continues beyond.
    + [(math.sqrt(100 * 1000), math.sqrt(6_000 * 1_250)), (1e5 / 7, 250 * 250 / 300)],
)
def test_points_of_the_data_sheet(grams, ohms):
    assert typical_resistance(WIDE, grams * GRAM) == pytest.approx(ohms, rel=1e-9)


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


def test_unloaded_actuation_and_saturation():
    for force in (0.0, -5.0):
        reading = ForceResistor().update(IDEAL, force, 0.0, 0.0)
        assert (reading.resistance_ohm, reading.adc) == (10e6, 1)
        assert reading.voltage_v == pytest.approx(5.0 * 1e4 / (1e4 + 10e6), rel=1e-12)
    # Interlink: the break brings more than 100 kΩ down to about 10 kΩ.
    assert typical_resistance(IDEAL, 0.15) > 100_000
    assert typical_resistance(IDEAL, 0.5) < 11_000
    middle = math.sqrt(10e6 * typical_resistance(IDEAL, 0.2))
    assert typical_resistance(IDEAL, 0.1) == pytest.approx(middle, rel=1e-9)
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


def test_first_loading_is_the_typical_curve_and_loops_close_at_both_ends():
    up = np.linspace(0.0, 20.0, 101)
    assert resistances(HYSTERESIS, up) == pytest.approx(resistances(IDEAL, up), rel=1e-9)
    loop = resistances(HYSTERESIS, [0.0, 20.0, 0.0, 20.0, 50.0, 0.0])
    assert loop[0] == loop[2] == loop[5] == pytest.approx(10e6, rel=1e-9)
    assert loop[1] == pytest.approx(loop[3], rel=1e-12) == pytest.approx(loop[4], rel=1e-12)
    # A swing inside the play changes nothing.
    found = resistances(HYSTERESIS, [10.0, 9.9, 10.0, 9.8, 9.9])
    assert found == pytest.approx(found[0], rel=1e-12)


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


def test_drift_of_a_constant_and_of_a_growing_load():
    """R(t)/R(0) = 1 − 0.05·log10(1 + t/1 s); over the data sheet's 35 days 32.4 %."""
    times = [0.0, 9.0, 99.0, 999.0, 35 * 86400.0]
    found = resistances(DRIFT, [9.81] * len(times), times)
    expected = [1.0, 0.95, 0.90, 0.85, 1.0 - 0.05 * math.log10(1.0 + 35 * 86400.0)]
    assert found / found[0] == pytest.approx(expected, rel=1e-9)
    assert expected[-1] == pytest.approx(0.676, abs=5e-4)
    # A load that grows by a hundredth each second after an hour at rest, for a decade of force.
    loads = [1.0, *(1.01**k for k in range(230))]
    found = resistances(DRIFT, loads, [0.0, *range(3600, 3830)])
    assert (np.diff(found) < 0.0).all()
    found = resistances(replace(IDEAL, drift=0.1), [5.0, 5.0], [0.0, 100 * 365 * 86400.0])
    assert found[-1] > 0.0


def sampled(load_at, rate, until=600.0):
    times = [k / rate for k in range(int(until * rate) + 1)]
    found = resistances(DRIFT, [load_at(time) for time in times], times)
    return found[:: round(rate)]


LOADS = {
    "steps": (lambda time: [5.0, 9.0, 9.4, 3.0, 0.0, 6.0][min(int(time // 100), 5)], 1e-9),
    "growing": (lambda time: 2.0 + time / 100.0, 0.003),
    "swinging": (lambda time: 5.0 + 4.0 * math.sin(time / 20.0), 0.003),
}


@pytest.mark.parametrize(("load_at", "error"), LOADS.values(), ids=LOADS)
def test_drift_hardly_depends_on_the_update_rate(load_at, error):
    assert sampled(load_at, 1.0) == pytest.approx(sampled(load_at, 100.0), rel=error)


@pytest.mark.parametrize(
    ("loads", "times", "share"),
    [
        ([5.0, 5.4, 4.6], [0.0, 10.0, 999.0], 0.15),  # below a tenth it continues to drift
        ([5.0, 10.0], [0.0, 999.0], 0.075),  # half has drifted and half starts again
        ([5.0, 2.0], [0.0, 999.0], 0.15),
        ([5.0, 0.0, 5.0], [0.0, 999.0, 1000.0], 0.0),  # released and pressed again
        ([300.0, 600.0, 200.0], [0.0, 50.0, 999.0], 0.15),  # beyond saturation all is the same
    ],
)
def test_what_share_of_the_resistance_drift_takes_away(loads, times, share):
    left = resistances(DRIFT, loads, times)[-1] / typical_resistance(IDEAL, loads[-1])
    assert 1.0 - left == pytest.approx(share, rel=1e-9, abs=1e-12)


# Spread


@pytest.mark.parametrize("spread", [0.02, 0.06, 0.5])
def test_spread_factor_has_mean_one_and_the_asked_deviation(spread):
    """Over the whole normal distribution, by Gauss-Hermite quadrature."""
    draws, weights = np.polynomial.hermite_e.hermegauss(40)
    weights = weights / weights.sum()
    factors = np.array([spread_factor(spread, draw) for draw in draws])
    mean = factors @ weights
    assert mean == pytest.approx(1.0, rel=1e-9)
    assert math.sqrt((factors - mean) ** 2 @ weights) == pytest.approx(spread, rel=1e-9)
    assert spread_factor(0.0, 3.0) == 1.0 and spread_factor(spread, -8.0) > 0.0


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


# Parameters and the page


def test_the_table_of_the_page_is_what_its_program_prints():
    text = PAGE.read_text(encoding="utf-8")
    program = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    table = re.search(r"```text\n(.*?)```", text, re.DOTALL)
    assert program and table
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(program[1], {})
    assert printed.getvalue() == table[1]
