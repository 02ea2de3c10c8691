# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sensor is in, told as its state: from the same state on it reads the same, whatever was
before, so that another process can go on from there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensor_logic.kinds.pressure.force_resistor import ForceResistor
from sensor_logic.kinds.pressure.model import PressureParameters
from sensor_logic.physics.output_timing import OutputTiming, RadioTiming

TIMES = np.arange(400) / 10.0
CUT = 200


@pytest.mark.parametrize("retrigger", [False, True])
@pytest.mark.parametrize(("hold", "blocking"), [(0.0, 0.0), (1.5, 0.0), (1.5, 2.0), (30.0, 0.0)])
def test_an_output_goes_on_alike_from_the_same_state(
    retrigger: bool, hold: float, blocking: float
) -> None:
    random, same, other = np.random.default_rng(3), 0, 0
    how = hold, blocking, 0.0, retrigger
    for _ in range(60):
        triggers = random.random((2, len(TIMES))) < random.choice([0.002, 0.02, 0.2])
        triggers[:, CUT - 25 : CUT] = False
        # One begins later than the other.
        late, parts = int(random.integers(CUT - 100, CUT)), [OutputTiming(), OutputTiming()]
        for part, trigger, begin in zip(parts, triggers, (0, late), strict=True):
            part.run(TIMES[begin:CUT], trigger[begin:CUT], *how)
        one, two = (part.state(float(TIMES[CUT - 1]), blocking) for part in parts)
        rest = [part.run(TIMES[CUT:], triggers[0, CUT:], *how) for part in parts]
        if one == two:
            same += 1
            assert np.array_equal(*rest)
        else:
            other += 1
    assert same
    # Only what is held or blocked for long reaches over the rest.
    assert (other > 0) == (hold > 2.0 or blocking > 0.0)


def test_a_radio_goes_on_alike_from_the_same_state_in_pieces_of_any_length() -> None:
    random, same, other = np.random.default_rng(5), 0, 0
    blocking, blanking = 0.4, 0.8
    delays = random.exponential(0.3, len(TIMES))

    def run(radio: RadioTiming, trigger: Any, begin: int, end: int) -> Any:
        times, late = TIMES[begin:end], delays[begin:end]
        how = 1.5, blocking, 0.0, True, blanking
        return radio.run(times, trigger[begin:end], *how, lambda i: float(late[i]))

    for _ in range(60):
        triggers = random.random((2, len(TIMES))) < random.choice([0.02, 0.2])
        triggers[:, CUT - int(random.integers(0, 40)) : CUT] = False
        parts = [RadioTiming(), RadioTiming()]
        for part, trigger in zip(parts, triggers, strict=True):
            run(part, trigger, 0, CUT)
        one, two = (part.state(float(TIMES[CUT - 1]), blocking, blanking) for part in parts)
        whole = run(parts[0], triggers[0], CUT, len(TIMES))
        pieces = [run(parts[1], triggers[0], k, k + 1) for k in range(CUT, len(TIMES))]
        if one == two:
            same += 1
            assert np.array_equal(whole, np.concatenate(pieces, axis=1))
        other += one != two
    assert same and other


@pytest.mark.parametrize(
    "values",
    [{}, {"hysteresis": 0.1}, {"drift": 0.05}, {"repeatability": 0.05}, {"part_spread": 0.1}],
)
def test_a_resistor_goes_on_alike_from_the_same_state(values: dict[str, float]) -> None:
    random, same, other = np.random.default_rng(4), 0, 0
    parameters = replace(PressureParameters(), **values)
    for _ in range(80):
        loads = random.choice([0.0, 0.21, 1.0, 5.0], (2, 30))
        loads[:, 15:20] = random.choice([0.0, 1.0], (2, 1))
        parts, read = [ForceResistor(0.3), ForceResistor(0.3)], []
        noises = random.standard_normal((2, 30))
        for part, load, noise in zip(parts, loads, noises, strict=True):
            for i in range(20):
                part.update(parameters, float(load[i]), float(i), float(noise[i]))
        alike = parts[0].state(parameters) == parts[1].state(parameters)
        for part in parts:
            follows = zip(loads[0, 20:], noises[0, 20:], strict=True)
            read.append(
                [
                    part.update(parameters, float(f), 20.0 + i, float(n))
                    for i, (f, n) in enumerate(follows)
                ]
            )
        if alike:
            same += 1
            assert read[0] == read[1]
        other += not alike
    assert other and (same or "repeatability" in values)
