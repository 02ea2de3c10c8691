# SPDX-License-Identifier: GPL-3.0-or-later
"""Situations that were measured with real devices come out as measured."""

import csv

import numpy as np
import pytest

from benchmarks import measured_people
from benchmarks.common import ROOT, apart
from benchmarks.measured_stage import Trial

with (ROOT / "benchmarks" / "measured_people.csv").open(encoding="utf-8", newline="") as file:
    ROWS = {row["id"]: row for row in csv.DictReader(file) if row["low"]}


@pytest.mark.slow
def test_a_quick_share_of_the_measured_people_is_within_its_tolerance():
    found = apart("measured_people.simulate", True)
    assert set(found) == set(measured_people.QUICK_ROWS)
    for name, value in found.items():
        assert float(ROWS[name]["low"]) <= value <= float(ROWS[name]["high"]), (name, value)


def test_each_row_with_a_tolerance_has_a_figure_of_situations_that_are_there():
    assert set(measured_people.ROWS) == set(ROWS)
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
