# SPDX-License-Identifier: GPL-3.0-or-later
"""The range scan: which scans are compared, what counts as movement, and the output's timing."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan

DEGREE = math.pi / 180
ONE_TILT = {"rays": 5, "vertical_fov": 10 * DEGREE, "vertical_step": 10 * DEGREE}
THREE_TILTS = {"rays": 5, "vertical_fov": 30 * DEGREE, "vertical_step": 10 * DEGREE}


def moved(readings):
    return [int(reading.fields["moved"]) for reading in readings]


def degrees(readings):
    return [round(reading.fields["angle_rad"] / DEGREE) for reading in readings]


def test_sawtooth_scans_the_tilts_in_turn(stage):
    readings = stage.run(RangeScan(), PirParameters(), [2.0] * 20)
    assert degrees(readings) == [*range(0, 90, 10), *range(0, 90, 10), 0, 10]


def test_the_rays_of_an_update_belong_to_one_tilt(stage):
    steepest = []

    def cast(bundle, origins, directions, length):
        steepest.append((bundle, round(math.degrees(math.asin(-directions[:, 1].min())))))
        return length

    stage.run(RangeScan(), PirParameters(**THREE_TILTS), [cast] * 4)
    assert steepest == [(0, 0), (1, 10), (2, 20), (0, 0)]


def test_a_scan_is_compared_with_the_previous_one_at_the_same_tilt(stage):
    """Different ranges at different tilts are no movement; a change since the last turn is."""
    worlds = [1.0, 2.0, 3.0] * 2 + [1.0, 2.5, 3.0] + [1.0, 2.5, 3.0]
    readings = stage.run(RangeScan(), PirParameters(**THREE_TILTS), worlds)
    assert moved(readings) == [0] * 7 + [1] + [0] * 4


def test_something_that_comes_and_goes_between_two_scans_at_a_tilt_is_missed(stage):
    worlds = [3.0] * 3 + [1.0, 3.0, 3.0] + [3.0] * 3
    readings = stage.run(RangeScan(), PirParameters(**THREE_TILTS), worlds)
    assert moved(readings) == [0, 0, 0, 1, 0, 0, 1, 0, 0]
    readings = stage.run(RangeScan(), PirParameters(**THREE_TILTS), [3, 3, 3, 3, 1, 3, 3, 3, 3])
    assert moved(readings) == [0, 0, 0, 0, 1, 0, 0, 1, 0]


def test_first_scans_are_no_movement(stage):
    assert moved(stage.run(RangeScan(), PirParameters(**THREE_TILTS), [1, 2, 3])) == [0, 0, 0]


def test_all_tilts_sweep_scans_every_tilt_and_tells_where_it_moved(stage):
    def only_second_tilt(distance):
        def cast(bundle, origins, directions, length):
            assert len(directions) == 15
            ranges = np.full(15, 3.0)
            ranges[7] = distance
            return ranges

        return cast

    parameters = PirParameters(sweep="ALL", **THREE_TILTS)
    worlds = [only_second_tilt(d) for d in (2.0, 2.0, 1.0, 1.0)]
    readings = stage.run(RangeScan(), parameters, worlds)
    assert moved(readings) == [0, 0, 1, 0]
    assert degrees(readings) == [0, 0, 10, 0]


def test_a_ray_that_meets_nothing_reads_range_max(stage):
    """Something 0.04 m inside the range goes away: no change above 0.05; 0.06 m is one."""
    parameters = PirParameters(range_max=4.0, **ONE_TILT)
    assert moved(stage.run(RangeScan(), parameters, [3.96, 1e9])) == [0, 0]
    assert moved(stage.run(RangeScan(), parameters, [3.94, 1e9])) == [0, 1]
    assert moved(stage.run(RangeScan(), parameters, [5.0, 1e9])) == [0, 0]


def test_nearer_than_range_min_is_not_seen(stage):
    """Rays start at range_min: what is nearer is not met, and ranges never read less."""
    parameters = PirParameters(range_min=0.5, range_max=4.0, **ONE_TILT)

    def cast(bundle, origins, directions, length):
        np.testing.assert_allclose(np.linalg.norm(origins, axis=1), 0.5)
        return length

    assert moved(stage.run(RangeScan(), parameters, [cast, cast])) == [0, 0]
    noisy = PirParameters(range_min=0.5, range_max=0.56, noise_sigma=10.0, **ONE_TILT)
    # However strong the noise, ranges stay within range_min … range_max: they change 0.06 at most.
    assert any(moved(stage.run(RangeScan(), noisy, [9] * 20)))
    within = PirParameters(range_min=0.5, range_max=0.545, noise_sigma=10.0, **ONE_TILT)
    assert not any(moved(stage.run(RangeScan(), within, [9] * 20)))


def test_the_threshold_must_be_exceeded(stage):
    # Powers of two, so that the change is exactly the threshold.
    parameters = PirParameters(range_min=0.0, threshold=0.25, **ONE_TILT)
    assert moved(stage.run(RangeScan(), parameters, [2.0, 1.75, 2.0])) == [0, 0, 0]
    above = 1.75 - 2**-20
    assert moved(stage.run(RangeScan(), parameters, [2.0, above])) == [0, 1]


def test_one_ray_is_enough(stage):
    def cast(change):
        return lambda bundle, o, d, length: np.array([3, 3, 3, 3, 3 - change])

    parameters = PirParameters(**ONE_TILT)
    assert moved(stage.run(RangeScan(), parameters, [cast(0.0), cast(0.06)])) == [0, 1]


def outputs(stage, triggers, **timing):
    """The output at 10 Hz where something moves at the updates marked 1."""
    distance, worlds = 3.0, [3.0]
    for trigger in triggers[1:]:
        distance = 4.0 - distance if trigger == "1" else distance
        worlds.append(distance)
    parameters = PirParameters(**ONE_TILT, **timing)
    return "".join(map(str, moved(stage.run(RangeScan(), parameters, worlds))))


def test_without_timing_the_output_is_the_trigger(stage):
    assert outputs(stage, "0110100010") == "0110100010"


def test_hold_time_starts_anew_at_each_trigger(stage):
    # On for 0.5 s after the last trigger: five updates, the trigger's own among them.
    assert outputs(stage, "0100000000", hold_time=0.5) == "0111110000"
    assert outputs(stage, "0101000000", hold_time=0.5) == "0111111100"
    assert outputs(stage, "0100001000", hold_time=0.5) == "0111111111"
    assert outputs(stage, "0100000100", hold_time=0.5) == "0111110111"


def test_blocking_time_ignores_triggers_after_the_output_fell(stage):
    # Falls at update 2; triggers before update 5 (0.3 s later) are lost.
    assert outputs(stage, "0101100000", blocking_time=0.3) == "0100000000"
    assert outputs(stage, "0101110000", blocking_time=0.3) == "0100010000"
    assert outputs(stage, "0111110000", blocking_time=0.3) == "0111110000"


def test_warm_up_keeps_the_output_off(stage):
    assert outputs(stage, "0111111000", warm_up_time=0.4) == "0000111000"
    assert outputs(stage, "0110000000", warm_up_time=0.4, hold_time=5.0) == "0000000000"


def test_hold_then_blocking(stage):
    # On for 0.2 s, off at update 3, blocked until 6.
    assert outputs(stage, "0101111000", hold_time=0.2, blocking_time=0.3) == "0111111100"
    assert outputs(stage, "0100111000", hold_time=0.2, blocking_time=0.3) == "0110001100"


@pytest.mark.parametrize("frames", [7, 24, 240])
def test_hold_time_is_exact_at_any_frame_rate(stage, frames):
    """A hold of n updates lasts n updates, though k/rate is rounded."""
    stage.rate = 24.0
    triggers = "01" + "0" * (frames + 3)
    expected = "0" + "1" * frames + "0" * 4
    assert outputs(stage, triggers, hold_time=frames / 24.0) == expected


@pytest.mark.parametrize("sweep", ["SAWTOOTH", "ALL"])
@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_an_array_handed_out_again_reads_as_one_that_is_equal(stage, sweep, noise):
    """What a caster that says "nothing changed" saves must not be seen in the readings."""
    parameters = PirParameters(sweep=sweep, noise_sigma=noise, **THREE_TILTS)
    random = np.random.default_rng(1)
    rays = 15 if sweep == "ALL" else 5
    kept = [random.uniform(0.1, 5.0, rays) for _ in range(3)]
    for array in kept:
        array.flags.writeable = False
    order = [0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 1, 0, 0, 0, 0, 0, 0, 2, 2, 2, 2]

    def same(which):
        return lambda bundle, origins, directions, length: kept[which]

    def equal(which):
        return lambda bundle, origins, directions, length: kept[which].copy()

    first = stage.run(RangeScan(), parameters, [same(which) for which in order])
    second = stage.run(RangeScan(), parameters, [equal(which) for which in order])
    assert first == second
    assert 3 <= sum(moved(first)) < len(order)


def test_an_array_that_is_written_to_is_looked_at_again(stage):
    ranges = np.full(5, 2.0)

    def cast(change):
        def written(bundle, origins, directions, length):
            ranges[:] += change
            return ranges

        return written

    casts = [cast(change) for change in (0.0, 0.0, 0.5, 0.0)]
    assert moved(stage.run(RangeScan(), PirParameters(**ONE_TILT), casts)) == [0, 0, 1, 0]
