# SPDX-License-Identifier: GPL-3.0-or-later
"""The distance sensor against closed forms, and the door contact against a hinged door's geometry.

For the distance sensor: ranges by reflectance, zones, echoes and noise.
"""

import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import RAYS, REFLECTANCE
from angen_sensors.sensor_logic.kinds.contact import KIND as CONTACT
from angen_sensors.sensor_logic.kinds.contact import ContactParameters, DoorContact
from angen_sensors.sensor_logic.kinds.distance import (
    KIND,
    DistanceParameters,
    DistanceSensor,
    range_of,
    zone_distances,
    zone_rays,
)
from angen_sensors.sensor_logic.model import Pose, Update
from angen_sensors.sensor_logic.noise import generator

POSE = Pose(np.zeros(3), np.eye(3))
PRESETS = {preset.identifier: preset for preset in KIND.presets}


QUIET = dict.fromkeys(("noise_sigma", "noise_growth", "offset_sigma", "offset_growth"), 0.0)


def part(name, **values):
    return DistanceParameters(**{**PRESETS[name].values, **QUIET, **values})


class Wall:
    """An endless wall across the axis at `distance` m, its left part (x < `edge`) at another."""

    def __init__(self, distance, reflectance=0.88, edge=-math.inf, left=math.inf, of_left=0.88):
        self.distance, self.reflectance = distance, reflectance
        self.edge, self.left, self.of_left = edge, left, of_left

    def _ranges(self, ways, length):
        ahead = -ways[:, 2]
        near = np.minimum(self.distance / ahead, length)
        if not math.isfinite(self.left):
            return near, np.zeros(len(ways), bool)
        beside = self.left / ahead
        on_left = (ways[:, 0] * beside < self.edge) & (beside < near)
        return np.where(on_left, beside, near), on_left

    def ask(self, need, bundle, origins, ways, length):
        ranges, on_left = self._ranges(ways, length)
        if need == RAYS:
            return np.minimum(ranges, length)
        assert need == REFLECTANCE
        return np.where(on_left, self.of_left, self.reflectance)


def read(parameters, wall, sensor=None, number=0, name="tof"):
    update = Update(
        number,
        0.0,
        POSE,
        {need: partial(wall.ask, need) for need in (RAYS, REFLECTANCE)},
        lambda: generator(0, name, number),
        lambda: generator(0, name, -1 & 0xFFFFFFFF),
    )
    return (sensor or DistanceSensor()).update(parameters, update)


@pytest.mark.parametrize("name", PRESETS)
def test_the_range_of_white_and_of_grey_is_the_data_sheets(name):
    parameters = part(name, horizontal_fov=0.0, vertical_fov=0.0, resolution=0.0)
    for reflectance, farthest in ((0.88, parameters.range_max), (0.17, parameters.range_grey)):
        seen = read(parameters, Wall(farthest * 0.999, reflectance))
        assert seen.fields["distance_m"] == pytest.approx(farthest * 0.999)
        gone = read(parameters, Wall(farthest * 1.001, reflectance))
        assert gone.fields["distance_m"] == parameters.range_max
        assert not any(gone.fields["zones_m"].split(";")), "empty: no target"


def test_the_ideal_receivers_range_falls_with_the_root_of_the_reflectance():
    ideal = part("VL53L1X", range_grey=3.6 * math.sqrt(0.17 / 0.88))
    found = range_of(ideal, np.array([0.88, 0.22, 0.055, 0.0]))
    assert found == pytest.approx([3.6, 1.8, 0.9, 0.0])
    assert range_of(part("HC_SR04"), np.array([0.01])) == pytest.approx([4.0]), (
        "sound sees no colour"
    )


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_what_fills_a_part_of_a_zone_is_seen_less_far(share):
    """By the root of its share: white that fills the zone is seen at 3.6 m."""
    parameters = part("VL53L1X", rays=16, resolution=0.0)
    half = math.tan(parameters.horizontal_fov / 2)
    farthest = 3.6 * math.sqrt(share)
    for distance, seen in ((farthest * 0.97, True), (farthest * 1.01, False)):
        edge = (2 * share - 1) * half * distance
        wall = Wall(1e9, 0.88, edge=edge, left=distance)
        assert math.isfinite(float(read(parameters, wall).fields["zones_m"] or "inf")) == seen


def test_zones_are_rows_from_the_upper_left_and_see_along_their_own_axes():
    parameters = part("VL53L5CX", resolution=0.0, rays=1)
    _, ways, _ = zone_rays(parameters, POSE)
    assert ways.shape == (64, 3)
    tangent = math.tan(math.radians(22.5)) * 7 / 8
    assert ways[0] / -ways[0, 2] == pytest.approx([-tangent, tangent, -1.0])
    assert ways[7] / -ways[7, 2] == pytest.approx([tangent, tangent, -1.0])
    zones = [float(text) for text in read(parameters, Wall(1.0)).fields["zones_m"].split(";")]
    assert zones == pytest.approx(1.0 / -ways[:, 2], rel=1e-3), "the slant range to a flat wall"


def test_echoes_of_a_person_before_a_wall():
    """Half of the zone is at 1 m, half at 2 m: the mean weighs them 4 : 1 by 1/r².

    The strongest and the first echo are the near one. A grey one 20 cm before white joins it within
    the separation.
    """
    ranges, both = np.array([[1.0, 1.0, 2.0, 2.0]]), np.full((1, 4), 0.88)
    known = {"range_max": 3.6, "range_grey": 3.6 * math.sqrt(0.17 / 0.88)}
    for echo, expected in (("MEAN", (4 * 1 + 1 * 2) / 5), ("STRONGEST", 1.0), ("FIRST", 1.0)):
        parameters = DistanceParameters(echo=echo, **known)
        assert zone_distances(parameters, ranges, both)[0] == pytest.approx(expected)
    dim = np.array([[0.044, 0.044, 0.88, 0.88]])
    strongest = DistanceParameters(echo="STRONGEST", **known)
    assert zone_distances(strongest, ranges, dim)[0] == pytest.approx(2.0), "4 times 1/20 is less"
    close = np.array([[1.8, 1.8, 2.0, 2.0]])
    weights = np.array([1 / 1.8**2, 1 / 2.0**2])
    mean = (weights * [1.8, 2.0]).sum() / weights.sum()
    assert zone_distances(strongest, close, both)[0] == pytest.approx(mean)
    parameters = DistanceParameters(echo="FIRST", range_max=2.0, range_grey=2.0)
    ranges = np.array([[1.6, 1.7, 1.8, 1.9]])
    # (2/1.6)²/4 = 0.39, with 1.7 m 0.74, with 1.8 m 1.05.
    assert zone_distances(parameters, ranges, np.ones((1, 4)))[0] == pytest.approx(1.8)
    assert zone_distances(parameters, np.full((1, 4), 2.01), np.ones((1, 4)))[0] == math.inf


def test_noise_grows_with_the_distance():
    for distance in (0.2, 1.0, 3.0):
        parameters = part("VL53L5CX", noise_sigma=0.004, noise_growth=0.01, resolution=0.0, rays=1)
        told = []
        for number in range(60):
            zones = read(parameters, Wall(distance), number=number).fields["zones_m"].split(";")
            told.append([float(text) for text in zones])
        spread = np.std(np.array(told), axis=0)
        _, ways, _ = zone_rays(parameters, POSE)
        expected = np.hypot(0.004, 0.01 * distance / -ways[:, 2])
        assert (spread / expected).mean() == pytest.approx(1.0, abs=0.03), "of 3840 samples"


def test_a_device_keeps_its_offset_and_a_still_target_hardly_differs():
    """A VL53L0X before a still target at 76 mm: 2.1 mm from reading to reading were measured."""
    parameters = DistanceParameters(**PRESETS["VL53L0X"].values)
    found = [read(parameters, Wall(0.076), number=n).fields["distance_m"] for n in range(400)]
    assert np.std(np.diff(found)) / math.sqrt(2) == pytest.approx(0.0021, rel=0.1)
    parameters = DistanceParameters(**PRESETS["VL53L1X"].values)
    means, spreads = [], []
    for device in range(60):
        sensor = DistanceSensor()
        told = [
            read(parameters, Wall(1.0), sensor, number, f"tof {device}").fields["distance_m"]
            for number in range(20)
        ]
        means.append(np.mean(told))
        spreads.append(np.std(told))
    # The bound of ±20 mm is three standard deviations.
    assert np.std(means) == pytest.approx(0.02 / 3, rel=0.25)
    assert np.mean(spreads) < 0.0035 and max(abs(np.array(means) - np.mean(means))) < 0.025


def test_readings_are_multiples_of_the_resolution_within_the_range_and_near_has_a_hysteresis():
    parameters = part("HC_SR04", resolution=0.01, rays=1)
    assert read(parameters, Wall(1.2345)).fields["distance_m"] == pytest.approx(1.23)
    assert read(parameters, Wall(0.005)).fields["distance_m"] == pytest.approx(0.02)
    parameters = part("VL53L1X", threshold=1.0, hysteresis=0.2, resolution=0.0, rays=1)
    sensor = DistanceSensor()
    places = (1.1, 0.9, 1.1, 1.19, 1.21, 1.1)
    near = [read(parameters, Wall(place), sensor).active for place in places]
    assert near == [False, True, True, True, False, False]


@pytest.mark.parametrize(("threshold", "hysteresis"), [(3.4, 0.3), (4.0, 0.0)])
def test_what_no_zone_detects_is_not_near(threshold, hysteresis):
    """The reading without a target, 3.6 m, is below the threshold with hysteresis."""
    parameters = part("VL53L1X", threshold=threshold, hysteresis=hysteresis)
    sensor = DistanceSensor()
    near = [read(parameters, Wall(place), sensor).active for place in (9.0, 1.0, 9.0)]
    assert near == [False, True, False]
    assert parameters.unreachable()


WALLS = {"nothing": Wall(math.inf), "touching": Wall(0.0), "black": Wall(1.0, 0.0)}


@pytest.mark.parametrize("wall", WALLS.values(), ids=WALLS)
def test_hard_cases_read_a_number(wall):
    """Nothing in the way, a target at the lens, a target that reflects nothing."""
    seen = read(part("VL53L5CX"), wall)
    assert 0.02 <= seen.value <= 3.5 and math.isfinite(seen.value)


# The door contact

PARTS = [ContactParameters(magnet="m", **preset.values) for preset in CONTACT.presets]


def at(distance):
    return Pose(np.array([distance, 0.0, 0.0]), np.eye(3))


def states(parameters, magnets):
    contact, found = DoorContact(), []
    for magnet in magnets:
        update = SimpleNamespace(pose=at(0.0), ask=lambda need, name, magnet=magnet: magnet)
        found.append(contact.update(parameters, update))
    return found


@pytest.mark.parametrize("parameters", PARTS, ids=[preset.identifier for preset in CONTACT.presets])
def test_it_closes_and_opens_at_two_distances(parameters):
    closes, opens = parameters.close_distance, parameters.open_distance
    assert 0.0 < closes < opens < 0.05
    between, h = (closes + opens) / 2, 1e-6
    way = (opens + h, between, closes + h, closes - h, between, opens - h, opens + h, between)
    found = [reading.active for reading in states(parameters, map(at, way))]
    assert found == [True, True, True, False, False, False, True, True]


def test_a_door_opens_at_the_angle_of_the_chord():
    """A magnet 0.8 m from the hinge moves by 2·0.8·sin(φ/2): to 20 mm at 1.4325°."""
    parameters = ContactParameters(magnet="m", close_distance=0.015, open_distance=0.02)
    angles = np.radians(np.arange(0.0, 5.0, 0.001))
    hinge = np.array([0.8, 0.0, 0.0])
    turned = [hinge - 0.8 * np.array([math.cos(a), math.sin(a), 0.0]) for a in angles]
    opening = [r.active for r in states(parameters, (Pose(p, np.eye(3)) for p in turned))]
    first = math.degrees(angles[opening.index(True)])
    assert first == pytest.approx(math.degrees(2 * math.asin(0.02 / 1.6)), abs=2e-3)
    back = [r.active for r in states(parameters, (Pose(p, np.eye(3)) for p in turned[::-1]))]
    last = math.degrees(angles[::-1][back.index(False)])
    assert last == pytest.approx(math.degrees(2 * math.asin(0.015 / 1.6)), abs=2e-3)


def test_without_a_magnet_it_is_open():
    (reading,) = states(ContactParameters(), [None])
    assert reading.active and reading.fields == {"open": True, "distance_m": math.inf}
