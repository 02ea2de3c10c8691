# SPDX-License-Identifier: GPL-3.0-or-later
"""Which contacts are hidden by nearer ones: areas and moments known by hand."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.contact import shapes
from angen_sensors.sensor_logic.contact.covered import Contact, without_covered
from angen_sensors.sensor_logic.contact.patches import contact_patch

BODY, PAD, FLOOR = range(3)


def at(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scene(body, pad, thickness=0.1):
    floor = shapes.box((5, 5, thickness / 2)).placed(at(0, 0, -thickness / 2))
    parts = (body, pad, floor)
    contacts = []
    for i, j in ((BODY, PAD), (FLOOR, BODY)):  # the body is once a, once b
        patch = contact_patch(parts[i], parts[j], 0.002)
        if patch is not None:
            contacts.append(Contact(i, j, patch, parts[i], parts[j]))
    return contacts


def kept(contacts, preferred=(), movable=(True, False, False)):
    left = without_covered(contacts, movable, preferred)
    return {next(iter({c.a, c.b} - {BODY})): c.patch for c in left}


def second_moment(patch):
    return float(patch.areas @ patch.points[:, 0] ** 2)


@pytest.mark.parametrize("sunk", [0.0, 0.0003, 0.001, 0.005, 0.009])
@pytest.mark.parametrize("thick", [0.00045, 0.001])
def test_thin_pad_hides_the_floor_below_it_alone(thick, sunk):
    box = shapes.box((0.2, 0.15, 0.3)).placed(at(0, 0, 0.3 + thick - sunk))
    pad = shapes.box((0.05, 0.04, thick / 2)).placed(at(0.02, 0, thick / 2))
    left = kept(scene(box, pad))
    assert left[PAD].areas.sum() == pytest.approx(0.1 * 0.08)
    assert left[PAD].gaps == pytest.approx(-sunk)
    floor = left[FLOOR]
    assert floor.areas.sum() == pytest.approx(0.4 * 0.3 - 0.1 * 0.08)
    assert floor.areas @ floor.points[:, 0] == pytest.approx(-0.02 * 0.1 * 0.08)
    hole = 0.08 * (0.07**3 + 0.03**3) / 3
    assert second_moment(floor) == pytest.approx(0.3 * 2 * 0.2**3 / 3 - hole)
    assert floor.gaps == pytest.approx(thick - sunk)


def test_pad_as_wide_as_the_box_hides_all_the_floor():
    box = shapes.box((0.05, 0.05, 0.1)).placed(at(0, 0, 0.10045))
    pad = shapes.box((0.05, 0.05, 0.000225)).placed(at(0, 0, 0.000225))
    assert set(kept(scene(box, pad))) == {PAD}


def test_round_pad_hides_its_area():
    box = shapes.box((0.05, 0.05, 0.1)).placed(at(0, 0, 0.10045))
    pad = shapes.cylinder(0.00635, 0.000225).placed(at(0, 0, 0.000225))
    left = kept(scene(box, pad))
    assert left[PAD].areas.sum() == pytest.approx(math.pi * 0.00635**2, rel=0.003)
    assert left[FLOOR].areas.sum() == pytest.approx(0.01 - left[PAD].areas.sum(), rel=1e-9)


def test_neither_of_equals_is_hidden_but_a_preferred_one_wins():
    box = shapes.box((0.2, 0.2, 0.3)).placed(at(0, 0, 0.3))
    flush = scene(box, shapes.box((0.05, 0.05, 0.005)).placed(at(0, 0, -0.005)))
    assert kept(flush)[FLOOR].areas.sum() == pytest.approx(0.16)
    left = kept(flush, preferred=(PAD,))
    assert left[FLOOR].areas.sum() == pytest.approx(0.15)
    assert left[PAD].areas.sum() == pytest.approx(0.01)
    lower = scene(box, shapes.box((0.05, 0.05, 0.005)).placed(at(0, 0, -0.0055)))
    left = kept(lower, preferred=(PAD,))
    assert set(left) == {FLOOR} and left[FLOOR].areas.sum() == pytest.approx(0.16)


def test_line_contact_is_cut():
    roll = shapes.cylinder(0.2, 0.3).placed(
        at(0, 0, 0.2005) @ np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1.0]])
    )
    pad = shapes.box((0.05, 0.05, 0.00025)).placed(at(0.1, 0, 0.00025))
    contacts = scene(roll, pad)
    whole = next(c.patch for c in contacts if FLOOR in (c.a, c.b))
    floor = kept(contacts)[FLOOR]
    assert floor.areas.sum() == pytest.approx(whole.areas.sum() * 5 / 6)
    share = whole.areas.sum() / 0.6
    expected = share * (2 * 0.3**3 - (0.15**3 - 0.05**3)) / 3
    assert second_moment(floor) == pytest.approx(expected)


def test_points_in_other_directions_and_fixed_bodies_stay():
    box = shapes.box((0.2, 0.2, 0.3)).placed(at(0, 0, 0.301))
    wall = shapes.box((0.05, 1, 1)).placed(at(0.25, 0, 0))
    contacts = scene(box, wall)
    assert [c.patch for c in without_covered(contacts, (True, False, False))] == [
        c.patch for c in contacts
    ]
    pad = shapes.box((0.05, 0.05, 0.0005)).placed(at(0, 0, 0.0005))
    contacts = scene(box, pad)
    assert kept(contacts, movable=(False,) * 3)[FLOOR].areas.sum() == pytest.approx(0.16)


def test_a_shelf_above_does_not_hide_the_floor():
    """Two parts of one body: one on the floor, one on a shelf that hangs over the first."""
    foot = shapes.box((0.2, 0.2, 0.05)).placed(at(0, 0, 0.05))
    arm = shapes.box((0.2, 0.2, 0.05)).placed(at(0, 0, 0.5495))
    shelf = shapes.box((0.1, 0.1, 0.05)).placed(at(0, 0, 0.45))
    floor = shapes.box((5, 5, 0.05)).placed(at(0, 0, -0.05))
    contacts = [
        Contact(BODY, PAD, contact_patch(arm, shelf, 0.002), arm, shelf),
        Contact(BODY, FLOOR, contact_patch(foot, floor, 0.002), foot, floor),
    ]
    assert len(without_covered(contacts, (True, False, False))) == 2
    assert kept(contacts)[FLOOR].areas.sum() == pytest.approx(0.16)
