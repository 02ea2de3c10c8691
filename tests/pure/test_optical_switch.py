# SPDX-License-Identifier: GPL-3.0-or-later
"""The slotted switch: single ray, rays across the aperture, and the comparator's hysteresis."""

import itertools
import math
import random

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.optical_switch import (
    OpticalSwitchParameters,
    SlottedSwitch,
    aperture_offsets,
)


def opened(readings):
    return [int(reading.fields["open"]) for reading in readings]


def flag(edge):
    """A flag in the gap, 3 mm off, that covers the aperture below x = edge (m)."""

    def cast(bundle, origins, directions, length):
        return np.where(origins[:, 0] < edge, 0.003 - 0.001, length)

    return cast


def test_a_single_ray_is_open_at_the_threshold_and_has_no_memory(stage):
    below = math.nextafter(0.05, 0.0)
    parameters = OpticalSwitchParameters(range_min=0.0, threshold=0.05)

    def exactly(distance):
        return lambda bundle, origins, directions, length: np.array([distance])

    worlds = [exactly(d) for d in (0.05, below, 0.05, below, below, 0.5, 0.01)]
    readings = stage.run(SlottedSwitch(), parameters, worlds)
    assert opened(readings) == [1, 0, 1, 0, 0, 1, 0]


def test_range_is_published_within_range_min_and_max(stage):
    parameters = OpticalSwitchParameters(range_min=0.001, range_max=0.5)
    readings = stage.run(SlottedSwitch(), parameters, [0.2, 9.0, 0.0])
    assert [r.fields["range_m"] for r in readings] == pytest.approx([0.2, 0.5, 0.001], abs=1e-12)
    assert [r.value for r in readings] == [r.fields["range_m"] for r in readings]


def test_the_beam_starts_at_range_min_along_minus_z(stage):
    asked = []

    def cast(bundle, origins, directions, length):
        asked.append((origins, directions, length))
        return length

    stage.run(SlottedSwitch(), OpticalSwitchParameters(range_min=0.01, range_max=0.3), [cast])
    ((origins, directions, length),) = asked
    np.testing.assert_allclose(origins, [(0, 0, -0.01)])
    np.testing.assert_allclose(directions, [(0, 0, -1)])
    np.testing.assert_allclose(length, [0.29])


@pytest.mark.parametrize("rays", [1, 2, 3, 9, 17, 33])
def test_light_is_within_half_a_ray_of_the_open_share(rays):
    aperture = 0.001
    offsets = aperture_offsets(OpticalSwitchParameters(aperture_rays=rays, aperture=aperture))
    assert len(offsets) == rays
    assert np.abs(offsets).max() <= aperture / 2
    for edge in np.linspace(-0.6, 0.6, 1201) * aperture:
        analytic = min(1.0, max(0.0, 0.5 - edge / aperture))
        share = float(np.mean(offsets >= edge))
        assert abs(share - analytic) <= 1 / (2 * rays) + 1e-9


def covered(rays, blocked):
    """A caster in which `blocked` of the rays are stopped."""

    def cast(bundle, origins, directions, length):
        ranges = length.copy()
        ranges[:blocked] = 0.002
        return ranges

    return cast


@pytest.mark.parametrize(
    ("rays", "opens_at", "closes_at"),
    # ceil(0.60 k) rays must pass to open; it closes where fewer than 0.45 k do.
    [(5, 3, 2), (20, 12, 8), (100, 60, 44), (9, 6, 4)],
)
def test_opens_at_0_60_and_closes_below_0_45(stage, rays, opens_at, closes_at):
    hysteresis = float(f"{np.float32(0.15):.9g}")  # as Blender stores it
    parameters = OpticalSwitchParameters(aperture_rays=rays, aperture=0.001, hysteresis=hysteresis)

    def run(passing):
        return opened(
            stage.run(SlottedSwitch(), parameters, [covered(rays, rays - n) for n in passing])
        )

    assert run([0, opens_at - 1, opens_at]) == [0, 0, 1]
    assert run([rays, closes_at + 1, closes_at]) == [1, 1, 0]


def test_without_hysteresis_both_levels_are_in_the_middle(stage):
    parameters = OpticalSwitchParameters(aperture_rays=200, aperture=0.001, hysteresis=0.0)
    passing = [0, 104, 105, 104, 105]  # 0.52 and 0.525 of the light
    worlds = [covered(200, 200 - n) for n in passing]
    assert opened(stage.run(SlottedSwitch(), parameters, worlds)) == [0, 0, 1, 0, 1]


def toggles(states):
    return sum(a != b for a, b in itertools.pairwise(states))


def test_a_vibrating_edge_toggles_one_ray_and_not_nine(stage, figure):
    """A flag's edge in the middle of a 1 mm slit, vibrating by ± 0.04 mm."""
    shake = random.Random(1)
    worlds = [flag(shake.uniform(-4e-5, 4e-5)) for _ in range(400)]
    one = OpticalSwitchParameters(aperture_rays=1, aperture=0.001)
    nine = OpticalSwitchParameters(aperture_rays=9, aperture=0.001)
    by_one, by_nine = (
        toggles(opened(stage.run(SlottedSwitch(), given, worlds))) for given in (one, nine)
    )
    figure(f"{by_one} and {by_nine} changes in 400 looks")
    assert by_one > 100
    assert by_nine <= 1, "once, from its start"


def test_a_flag_that_crosses_slowly_switches_once(stage):
    worlds = [flag(edge) for edge in np.linspace(-0.0006, 0.0006, 100)]
    nine = OpticalSwitchParameters(aperture_rays=9, aperture=0.001)
    assert toggles(opened(stage.run(SlottedSwitch(), nine, worlds))) == 1
