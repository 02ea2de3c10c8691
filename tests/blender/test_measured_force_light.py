# SPDX-License-Identifier: GPL-3.0-or-later
"""Force resistors and light sensors in the situations that were measured with real parts."""

import csv

import pytest

from benchmarks.common import ROOT, apart

ROWS = ROOT / "benchmarks" / "measured_force_light.csv"


@pytest.mark.slow
def test_each_measured_row_is_simulated_within_its_tolerance():
    with ROWS.open(encoding="utf-8", newline="") as file:
        rows = {row["id"]: row for row in csv.DictReader(file)}
    found = apart("measured_force_light.simulate", True)
    assert set(found) == set(rows)
    outside = {
        name: (value, rows[name]["low"], rows[name]["high"])
        for name, value in found.items()
        if not float(rows[name]["low"]) <= value <= float(rows[name]["high"])
    }
    assert not outside
    assert found["LED1"] > found["LED2"] > found["LED3"]


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
