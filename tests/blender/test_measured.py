# SPDX-License-Identifier: GPL-3.0-or-later
"""Situations that were measured with real devices come out as measured."""

import numpy as np
import pytest

from benchmarks import measured, measured_people
from benchmarks.common import apart
from benchmarks.measured_stage import Trial


def rebuilt(source):
    """Return the ids of the measured rows of a source that have a tolerance."""
    return {row["id"] for row in measured.rows_of(source, {}) if row["low"] is not None}


@pytest.mark.slow
@pytest.mark.parametrize("source", measured.SOURCES)
def test_what_a_quick_run_rebuilds_is_within_its_tolerance(source):
    figures = apart(f"{source}.simulate", True)
    quick = measured_people.QUICK_ROWS if source == "measured_people" else rebuilt(source)
    assert set(figures) == set(quick)
    rows = [row for row in measured.rows_of(source, figures) if row["id"] in figures]
    assert not [(row["id"], row["simulated"]) for row in rows if not row["within"]]


def test_each_row_with_a_tolerance_has_a_figure_of_situations_that_are_there():
    assert set(measured_people.ROWS) == rebuilt("measured_people")
    names = {name for names, _ in measured_people.ROWS.values() for name in names}
    assert names == set(measured_people.SITUATIONS)


def test_figures_of_a_log_by_hand():
    """Five samples of a radar with three gates; the floor of gate 0 is below its threshold."""
    moving = np.array([[18, 40, 20], [18, 60, 10], [18, 0, 5], [18, 80, 30], [18, 5, 9]], float)
    log = Trial(
        np.arange(5) / 5.0,
        presence=np.array([1, 1, 1, 1, 0], bool),
        moving=np.array([1, 1, 0, 1, 0], bool),
        metres=np.array([0.8, 0.9, 0.9, 0.7, 6.0]),
        moving_gates=moving,
        still_gates=np.array([[0, 0, 50], [0, 0, 50], [0, 0, 50], [0, 0, 10], [0, 0, 9]], float),
        moving_thresholds=np.array([50.0, 30.0, 25.0]),
        still_thresholds=np.array([0.0, 0.0, 40.0]),
        pir=np.array([0, 1, 1, 0, 0], bool),
    )
    expected = {
        "E1": 60.0, "D4": 37.0, "D7": 14.8, "D10": 60.0, "G3": 18 / 37,
        "F1": np.std([40, 60, 80]) / 60, "G4": 14.8 / 37,
        "G7": 100.0, "S1": 33.8, "X1": 80.0, "M2": 80.0, "P1": 40.0, "O1": 40.0,
        "U1": 0.4, "L4": 0.0, "L5": 0.2, "L3": 0.2,
    }  # fmt: skip
    found = {row: measured_people.ROWS[row][1]([log]) for row in expected}
    assert found == pytest.approx(expected)


@pytest.mark.parametrize("simulated", [True, False], ids=["rigid bodies", "animated"])
def test_a_flat_weight_reads_a_higher_resistance_than_a_finger(physics, simulated):
    """The same 750 g: 31 % less conductance was measured under what is larger than the part."""
    side, thin = 0.0081, 0.000225  # a square of the overall area, half sizes
    ohms = {}
    for x, (name, half) in enumerate({"finger": 0.005, "flat": 0.03}.items()):
        parameters = {"area": 1.267e-4, "overall_area": 2.625e-4, "rim_force": 1.75}
        physics.pad(name, (side, side, thin), (x, 0, thin), "PASSIVE", **parameters)
        at, size = (x, 0, 2 * thin + half), (half,) * 3
        add = physics.body if simulated else physics.carried
        add(f"load {name}", size, at, 0.75)
    physics.frames(12)
    for name, readings in physics.run().items():
        assert readings.known()[-1] == pytest.approx(0.75 * 9.81, rel=1e-3)
        ohms[name] = 10_000.0 * (1023.0 / readings.adc[-2] - 1.0)
    assert 1.0 - ohms["finger"] / ohms["flat"] == pytest.approx(0.31, abs=0.05)
