# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise: the same bits for the same seed and name, and as strong as asked for."""

import math

import numpy as np
from angen_sensors.sensor_logic.kinds.optical_switch import OpticalSwitchParameters, SlottedSwitch
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan
from angen_sensors.sensor_logic.noise import generator

COUNT = 1500


def switch_ranges(stage, sigma=0.01, count=COUNT):
    parameters = OpticalSwitchParameters(noise_sigma=sigma)
    readings = stage.run(SlottedSwitch(), parameters, [0.25] * count)
    return np.array([reading.fields["range_m"] for reading in readings])


def test_mean_and_standard_deviation(stage):
    ranges = switch_ranges(stage)
    assert abs(ranges.mean() - 0.25) < 4 * 0.01 / math.sqrt(COUNT)
    assert abs(ranges.std() - 0.01) < 4 * 0.01 / math.sqrt(2 * COUNT)


def test_gaussian_and_unrelated_from_update_to_update(stage):
    z = (switch_ranges(stage) - 0.25) / 0.01
    assert abs((z**3).mean()) < 4 * math.sqrt(15 / COUNT)
    assert abs((z**4).mean() - 3) < 4 * math.sqrt(96 / COUNT)
    assert abs((z[1:] * z[:-1]).mean()) < 4 / math.sqrt(COUNT)


def test_same_seed_same_bits(stage):
    first, second = switch_ranges(stage, count=50), switch_ranges(stage, count=50)
    assert first.tobytes() == second.tobytes()


def test_another_seed_or_name_is_other_noise(stage):
    plain = switch_ranges(stage, count=50)
    stage.seed = 1
    assert not np.isin(switch_ranges(stage, count=50), plain).any()
    stage.seed, stage.sensor = 0, "sensor.001"
    assert not np.isin(switch_ranges(stage, count=50), plain).any()


def test_names_that_are_not_ascii(stage):
    assert generator(0, "Ängen PIR", 0).normal() != generator(0, "Angen PIR", 0).normal()


def test_the_bits_are_the_same_everywhere():
    """Taken down once, so that a new numpy or another machine cannot change logs unnoticed."""
    drawn = generator(7, "Hall PIR", 3).normal(0.0, 1.0, 3)
    assert [float(x).hex() for x in drawn] == [
        "0x1.db617d4aa8336p-2",
        "-0x1.2ec22c1afd32fp+1",
        "-0x1.1a6dee15df500p+0",
    ]


def test_every_ray_of_a_pir_gets_its_own_noise(stage):
    """The largest of many independent differences: at 0.01 m, 120 rays nearly always differ by
    more than 0.02 m somewhere, and never by 0.08 m (5.7 sigma of a difference)."""
    seen = {}
    for threshold in (0.02, 0.08):
        parameters = PirParameters(noise_sigma=0.01, threshold=threshold, vertical_fov=0.0)
        readings = stage.run(RangeScan(), parameters, [2.0] * 100)
        seen[threshold] = sum(reading.fields["moved"] for reading in readings)
    assert seen == {0.02: 99, 0.08: 0}


def test_without_noise_nothing_is_drawn(stage):
    stage.noise = lambda number: None  # to call what it gives would raise
    assert len(set(switch_ranges(stage, sigma=0.0, count=3))) == 1
