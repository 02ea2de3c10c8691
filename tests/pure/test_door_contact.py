# SPDX-License-Identifier: GPL-3.0-or-later
"""The door contact against the geometry of a door that turns about its hinge."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.contact import KIND, ContactParameters, DoorContact
from angen_sensors.sensor_logic.model import Pose

PARTS = [ContactParameters(magnet="m", **preset.values) for preset in KIND.presets]


def at(distance):
    return Pose(np.array([distance, 0.0, 0.0]), np.eye(3))


def states(parameters, magnets):
    contact, found = DoorContact(), []
    for magnet in magnets:
        update = SimpleNamespace(pose=at(0.0), ask=lambda need, name, magnet=magnet: magnet)
        found.append(contact.update(parameters, update))
    return found


@pytest.mark.parametrize("parameters", PARTS, ids=[preset.identifier for preset in KIND.presets])
def test_it_closes_and_opens_at_two_distances(parameters):
    closes, opens = parameters.close_distance, parameters.open_distance
    assert 0.0 < closes < opens < 0.05
    between, h = (closes + opens) / 2, 1e-6
    way = (opens + h, between, closes + h, closes - h, between, opens - h, opens + h, between)
    found = [reading.active for reading in states(parameters, map(at, way))]
    assert found == [True, True, True, False, False, False, True, True]


def test_a_door_opens_at_the_angle_of_the_chord():
    """A magnet 0.8 m from the hinge is 2·0.8·sin(φ/2) from where it was: to 20 mm at 1.4325°."""
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


def test_a_release_nearer_than_the_operate_distance_is_told():
    told = ContactParameters(close_distance=0.02, open_distance=0.01).problems()
    assert told == ["open_distance (0.01 m) must be at least close_distance (0.02 m)"]
