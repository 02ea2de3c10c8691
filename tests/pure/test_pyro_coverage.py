# SPDX-License-Identifier: GPL-3.0-or-later
"""Many walks without a scene: coverage is what the detector itself would say."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage.detectors import Walker
from angen_sensors.sensor_logic.kind import WARMTH
from angen_sensors.sensor_logic.kinds.pir.lenses import zone_rays
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import (
    PyroelectricDetector,
    response_of,
    threshold_of,
    zones_of,
)
from angen_sensors.sensor_logic.model import Emission, Pose, Update
from pyro_bodies import DOWN, ZERO, level_at, peak, pyro, walk
from walks import peak_signals


def cylinder_seen(walker, feet, ambient):
    """The same walker for the detector itself, by another formula: a prism of 90 sides."""
    angles = np.linspace(0, 2 * math.pi, 91)[:-1]
    normals = np.stack([np.cos(angles), np.sin(angles), np.zeros(90)], axis=1)
    normals = np.concatenate([normals, [[0, 0, 1], [0, 0, -1]]])
    middle = np.array(feet) + (0, 0, walker.height / 2)
    apart = np.concatenate([np.full(90, walker.radius), [walker.height / 2] * 2])

    def warmth(bundle, origins, directions, length):
        rate = directions @ normals.T
        gap = apart - (origins - middle) @ normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / rate
        enter = np.where(rate < 0, t, -np.inf).max(axis=1)
        leave = np.where(rate > 0, t, np.inf).min(axis=1)
        hit = (enter <= leave) & (enter > 0)
        return Emission(
            np.where(hit, walker.celsius + ZERO, ambient + ZERO),
            np.where(hit, walker.emissivity, 1.0),
            ambient + ZERO,
        )

    return warmth


@pytest.mark.parametrize(
    ("lens", "pose"),
    [
        ("THREE_TIERS", level_at(2.1)),
        pytest.param("CEILING", Pose(np.array([0.0, 0.0, 2.5]), DOWN), marks=pytest.mark.slow),
    ],
)
def test_coverage_is_what_the_detector_itself_would_say(lens, pose):
    parameters = pyro(lens=lens, zone_rays=12)
    walker, rate = Walker(), 24
    random = np.random.default_rng(5)
    starts = np.concatenate([random.uniform(-4, 4, (6, 2)), np.zeros((6, 1))], axis=1)
    ends = starts + np.concatenate([random.uniform(-1, 1, (6, 2)), np.zeros((6, 1))], axis=1)
    zones, response = zones_of(parameters), response_of(parameters)
    found = peak_signals(zones, response, pose, starts, ends, walker) / threshold_of(parameters)
    for start, end, signal in zip(starts, ends, found, strict=True):
        detector = PyroelectricDetector()
        places = walk(start, end, walker.speed, rate, before=0.0, after=1.0)
        readings = [
            detector.update(
                parameters,
                Update(k, k / rate, pose, {WARMTH: cylinder_seen(walker, feet, 20.0)}),
            )
            for k, feet in enumerate(places)
        ]
        # A prism of 90 sides has 0.1 % less silhouette; a ray more or less is 2 % of a zone.
        assert signal == pytest.approx(peak(readings), rel=0.05, abs=0.1)
    assert found.max() > 1.0


def test_coverage_ends_at_walls():
    parameters = pyro(zone_rays=12)
    zones, response, pose = zones_of(parameters), response_of(parameters), level_at(1.2)
    starts, ends = np.array([[-1.0, 4, 0]]), np.array([[1.0, 4, 0]])
    rays = len(zone_rays(zones, 12).directions)

    def found(metres):
        free = np.full(rays, metres)
        return peak_signals(zones, response, pose, starts, ends, Walker(), free=free)[0]

    assert found(3.0) == 0.0
    assert found(9.0) == peak_signals(zones, response, pose, starts, ends, Walker())[0] > 0.0
