# SPDX-License-Identifier: GPL-3.0-or-later
"""When sensors sample, against a search over all frames with exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock, Schedule
from hypothesis import given, settings
from hypothesis import strategies as st


def single(value):
    """A number as Blender stores and returns it."""
    return float(np.float32(value))


FRAME_RATES = [(24, 1), (25, 1), (30, 1), (30, "1.001"), (60, 1), (24, "1.001"), (120, 1)]
UPDATE_RATES = ["0.1", "0.3", "0.7", "0.9", "1", "3", "7.5", "10", "24", "29.97", "60", "100"]


def found_by_search(fps, base, rate, substeps, last):
    """Steps of the updates: for each k/r the first step that is not earlier, none twice."""
    found, due = [], Fraction(0)
    step_time, interval = Fraction(base) / Fraction(fps) / substeps, 1 / Fraction(rate)
    for step in range(last + 1):
        if due <= step * step_time:
            found.append(step)
            while due <= step * step_time:
                due += interval
    return found


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize(("fps", "base"), FRAME_RATES)
def test_samples_at_the_first_frame_at_or_after_k_over_r(fps, base, substeps):
    clock = Clock(1, fps, single(base), substeps)
    for rate in UPDATE_RATES:
        updates = list(Schedule(clock, single(rate)).updates(0, 250))
        assert [step for _, step in updates] == found_by_search(fps, base, rate, substeps, 250)
        assert [number for number, _ in updates] == list(range(len(updates)))


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
        (60, 1, "100", 17, 17),  # no more than one a frame
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


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
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


def test_time_is_zero_at_the_start_frame():
    clock = Clock(101, 30, single("1.001"))
    assert clock.step_time(0) == 0.0
    assert clock.first_step(101) == 0
    assert clock.step_time(clock.first_step(131)) == pytest.approx(1.001, abs=1e-12)
    assert clock.step_frame(30) == 131


def test_nothing_is_sampled_before_the_start_frame():
    clock = Clock(10, 24)
    assert clock.first_step(5) == 0
    assert Schedule(clock, 10.0).last_update(-1) == -1
    assert list(Schedule(clock, 10.0).updates(-24, 0)) == [(0, 0)]


def test_substeps_have_frames_with_decimals():
    clock = Clock(1, 24, 1.0, 4)
    assert [clock.step_frame(step) for step in (0, 1, 4, 7)] == [1, 1.25, 2, 2.75]
    assert [clock.frame_and_subframe(step) for step in (0, 1, 4, 7)] == [
        (1, 0.0),
        (1, 0.25),
        (2, 0.0),
        (2, 0.75),
    ]
    assert clock.step_time(96) == 1.0
