# SPDX-License-Identifier: GPL-3.0-or-later
"""Updates against a search over all frames with exact fractions; noise by seed and name.

The same seed and name give the same bits, with the requested strength.
"""

import math
from fractions import Fraction

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock, Schedule
from angen_sensors.sensor_logic.kinds.optical_switch import OpticalSwitchParameters, SlottedSwitch
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan
from angen_sensors.sensor_logic.noise import generator
from hypothesis import given, settings
from hypothesis import strategies as st


def single(value):
    """Return a number as Blender stores and returns it."""
    return float(np.float32(value))


FRAME_RATES = [(24, 1), (25, 1), (30, 1), (30, "1.001"), (60, 1), (24, "1.001"), (120, 1)]
UPDATE_RATES = ["0.1", "0.3", "0.7", "0.9", "1", "3", "7.5", "10", "24", "29.97", "60", "100"]


def found_by_search(fps, base, rate, substeps, last):
    """Return the steps of the updates: for each k/r the first that is not earlier, none twice."""
    found, due = [], Fraction(0)
    step_time, interval = Fraction(base) / Fraction(fps) / substeps, 1 / Fraction(rate)
    for step in range(last + 1):
        if due <= step * step_time:
            found.append(step)
            while due <= step * step_time:
                due += interval
    return found


@pytest.mark.parametrize(
    ("fps", "base", "rate", "number", "step"),
    [
        (24, 1, "10", 1, 3),  # 2.4
        (24, 1, "10", 5, 12),
        (24, 1, "0.7", 7, 240),  # at 10 s exactly
        (24, 1, "0.9", 9, 240),
        (30, 1, "3", 300, 3000),
        (25, 1, "10", 3, 8),  # 7.5
        (30, "1.001", "10", 1000, 2998),  # 2997.003 at 100 s
        (60, 1, "100", 17, 17),  # at most one per frame
        (24, 1, "0.1", 6, 1440),
    ],
)
def test_worked_examples(fps, base, rate, number, step):
    assert Schedule(Clock(1, fps, single(base)), single(rate)).step(number) == step


clocks = st.builds(
    lambda rate, substeps: (rate[0], rate[1], substeps),
    st.sampled_from(FRAME_RATES),
    st.integers(1, 8),
)
rates = st.sampled_from(UPDATE_RATES) | st.decimals(
    "0.1", "100", allow_nan=False, allow_infinity=False, places=2
).map(str)


@settings(max_examples=100, deadline=None, derandomize=True, database=None)
@given(clocks, rates, st.integers(0, 90), st.integers(0, 40))
def test_any_part_of_a_run_has_the_updates_of_the_whole(clock, rate, first, length):
    fps, base, substeps = clock
    schedule = Schedule(Clock(1, fps, single(base), substeps), single(rate))
    last = first + length
    expected = {
        step: number for number, step in enumerate(found_by_search(fps, base, rate, substeps, last))
    }
    assert list(schedule.updates(first, last)) == [
        (number, step) for step, number in expected.items() if step >= first
    ]
    for step in range(first, last + 1):
        assert schedule.last_update(step) == sum(s <= step for s in expected) - 1


def test_time_is_zero_at_the_start_frame_and_nothing_is_sampled_before():
    clock = Clock(101, 30, single("1.001"))
    assert clock.step_time(0) == 0.0
    assert clock.first_step(101) == clock.first_step(96) == 0
    assert clock.step_time(clock.first_step(131)) == pytest.approx(1.001, abs=1e-12)
    assert clock.step_frame(30) == 131
    assert Schedule(Clock(10, 24), 10.0).last_update(-1) == -1
    assert list(Schedule(Clock(10, 24), 10.0).updates(-24, 0)) == [(0, 0)]


def test_substeps_have_frames_with_decimals():
    clock = Clock(1, 24, 1.0, 4)
    assert [clock.step_frame(step) for step in (0, 1, 4, 7)] == [1, 1.25, 2, 2.75]
    parts = [clock.frame_and_subframe(step) for step in (0, 1, 4, 7)]
    assert parts == [(1, 0.0), (1, 0.25), (2, 0.0), (2, 0.75)]
    assert clock.step_time(96) == 1.0


# Noise

COUNT = 1500


def switch_ranges(stage, sigma=0.01, count=COUNT):
    parameters = OpticalSwitchParameters(noise_sigma=sigma)
    readings = stage.run(SlottedSwitch(), parameters, [0.25] * count)
    return np.array([reading.fields["range_m"] for reading in readings])


def test_gaussian_and_unrelated_from_update_to_update(stage):
    z = (switch_ranges(stage) - 0.25) / 0.01
    assert abs(z.mean()) < 4 / math.sqrt(COUNT)
    assert abs(z.std() - 1) < 4 / math.sqrt(2 * COUNT)
    assert abs((z**3).mean()) < 4 * math.sqrt(15 / COUNT)
    assert abs((z**4).mean() - 3) < 4 * math.sqrt(96 / COUNT)
    assert abs((z[1:] * z[:-1]).mean()) < 4 / math.sqrt(COUNT)
    stage.noise = lambda number: None  # calling it would raise
    assert len(set(switch_ranges(stage, sigma=0.0, count=3))) == 1


def test_same_seed_same_bits_and_another_seed_or_name_is_other_noise(stage):
    plain = switch_ranges(stage, count=50)
    assert switch_ranges(stage, count=50).tobytes() == plain.tobytes()
    for stage.seed, stage.sensor in ((1, "sensor"), (0, "sensor.001"), (0, "sensör")):
        assert not np.isin(switch_ranges(stage, count=50), plain).any()


def test_the_bits_are_the_same_everywhere():
    """Written down once, so that a new numpy or another machine cannot change logs unnoticed."""
    drawn = generator(7, "Hall PIR", 3).normal(0.0, 1.0, 3)
    assert [float(x).hex() for x in drawn] == [
        "0x1.db617d4aa8336p-2",
        "-0x1.2ec22c1afd32fp+1",
        "-0x1.1a6dee15df500p+0",
    ]


def test_every_ray_of_a_pir_gets_its_own_noise(stage):
    """The largest of many independent differences.

    At 0.01 m, 120 rays nearly always differ by more than 0.02 m somewhere, and never by 0.08 m (5.7
    sigma of a difference).
    """
    seen = {}
    for threshold in (0.02, 0.08):
        parameters = PirParameters(noise_sigma=0.01, threshold=threshold, vertical_fov=0.0)
        readings = stage.run(RangeScan(), parameters, [2.0] * 100)
        seen[threshold] = sum(reading.fields["moved"] for reading in readings)
    assert seen == {0.02: 99, 0.08: 0}
