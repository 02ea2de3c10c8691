# SPDX-License-Identifier: GPL-3.0-or-later
"""Infrared arrays in the situations that were measured with real parts."""

import csv

import pytest

from benchmarks.common import ROOT, apart

ROWS = ROOT / "benchmarks" / "measured_thermal.csv"


@pytest.mark.slow
def test_each_measured_row_is_simulated_within_its_tolerance():
    with ROWS.open(encoding="utf-8", newline="") as file:
        rows = {row["id"]: row for row in csv.DictReader(file)}
    found = apart("measured_thermal.simulate", True)
    assert set(found) == set(rows)
    outside = {
        name: (value, rows[name]["low"], rows[name]["high"])
        for name, value in found.items()
        if not float(rows[name]["low"]) <= value <= float(rows[name]["high"])
    }
    assert not outside
