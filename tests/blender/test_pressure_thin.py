# SPDX-License-Identifier: GPL-3.0-or-later
"""Pads thinner than anything else in the scene, under what is larger than they are."""

import pytest
from pressure_scenes import G, shares
from tiers import mostly_slow

MARGIN = 0.04  # of a mesh, which the engine keeps others off
EXACT = 1e-3
PLACES = [(0, 0, 0), (3.3, -7.7, 2.5), (40.7, 12.3, 28.2), (1000.3, -700.7, 5.1)]


def box_on_pad(physics, thick, half=0.3, kind="PASSIVE", floor="BOX", at=(0, 0, 0)):
    """5 kg on a pad of 0.2 × 0.2 m, a little aside, on a floor."""
    physics.frames(8)
    x, y, z = at
    ground = physics.solid("floor", (5, 5, 0.5), (x, y, z - 0.5))
    physics.rigid_body(ground, "PASSIVE", shape=floor)
    physics.pad(half=(0.1, 0.1, thick / 2), at=(x + 0.02, y + 0.03, z + thick / 2), kind=kind)
    lifted = MARGIN if floor == "MESH" else thick if kind else 0.0
    return physics.body("box", (half, half, 0.1), (x, y, z + lifted + 0.1), 5.0)


@pytest.mark.parametrize("kind", [None, "PASSIVE"])
@pytest.mark.parametrize("floor", ["BOX", "MESH"])
@pytest.mark.parametrize(
    "thick", mostly_slow([1e-4, 2e-4, 4.5e-4, 1e-3, 2e-3, 5e-3, 0.02], 1e-4, 4.5e-4, 0.02)
)
@pytest.mark.parametrize("half", mostly_slow([0.05, 0.15, 0.3, 0.6], 0.05, 0.6))
def test_a_thin_pad_carries_all_that_lies_on_it(physics, thick, half, kind, floor):
    box_on_pad(physics, thick, half, kind, floor)
    assert physics.read().known() == pytest.approx(5 * G, rel=EXACT)


@pytest.mark.parametrize("thick", [1e-4, 4.5e-4])
@pytest.mark.parametrize("at", PLACES)
def test_wherever_the_home_is(physics, thick, at):
    box_on_pad(physics, thick, at=at)
    assert physics.read().known() == pytest.approx(5 * G, rel=EXACT)


@pytest.mark.parametrize("thick", [1.5e-5, 2.5e-5])
def test_too_thin_to_be_told_from_the_floor(physics, thick):
    """A hundredth of a millimetre is neither level with the floor nor above it: told."""
    box_on_pad(physics, thick)
    physics.read().never_valid("'pad' and 'floor' differ in height by", "'box'", after=0)


def test_level_with_the_floor_it_carries_its_share_of_the_area(physics):
    physics.on_floor(8)
    physics.pad(half=(0.1, 0.1, 0.005), at=(0, 0, -0.005))
    physics.body("box", (0.3, 0.3, 0.1), (0, 0, 0.1), 9.0)
    assert physics.read().known() == pytest.approx(1 * G, rel=0.02)


def test_a_box_that_leans_over_the_pads_edge(physics):
    """Its middle is beside the pad: it tips, and its far edge stands on the floor."""
    physics.on_floor(40)
    physics.pad(half=(0.1, 0.3, 0.00225), at=(-0.25, 0, 0.00225), kind="PASSIVE")
    physics.body("box", (0.3, 0.3, 0.1), (0, 0, 0.1045), 6.0)
    # The pad's inner edge at −0.15, the box's own at 0.3.
    assert physics.read().force[-8:] == pytest.approx(6 * G * 0.3 / 0.45, rel=0.02)


@pytest.mark.parametrize("thick", [1e-4, 4.5e-4, 2e-3])
def test_a_table_whose_feet_are_larger_than_the_pads(physics, thick):
    """Four FSRs, 18 mm wide, under feet of 80 mm."""
    physics.on_floor(8)
    spots = [(-0.5, -0.3), (0.5, -0.3), (-0.5, 0.3), (0.5, 0.3)]
    for number, (x, y) in enumerate(spots):
        physics.pad(f"leg {number}", (0.009, 0.009, thick / 2), (x, y, thick / 2), "PASSIVE")
    feet = [((0.04, 0.04, 0.35), (x, y, -0.375)) for x, y in spots]
    height = thick + 0.725
    physics.compound("table", [((0.6, 0.4, 0.025), (0, 0, 0)), *feet], (0, 0, height), 20.0)
    physics.body("load", (0.05, 0.05, 0.05), (0.25, 0.15, height + 0.075), 10.0)
    read = physics.run()
    exact = 20 * G / 4 + shares((0.25, 0.15), 10 * G, spots)
    for number, wanted in enumerate(exact):
        assert read[f"leg {number}"].known() == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize("thick", [4.5e-4, 5e-3])
@pytest.mark.parametrize("kind", [None, "PASSIVE"])
def test_a_crate_that_is_not_simulated_is_as_stiff_as_its_tolerance(physics, thick, kind):
    physics.frames(4)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad(half=(0.1, 0.1, thick / 2), kind=kind)
    at = (0.02, 0.01, thick + 0.2)
    crate = physics.carried("crate", (0.3, 0.3, 0.2), at, 30.0, tolerance=thick / 2)
    assert physics.read().known() == pytest.approx(30 * G, rel=EXACT)
    crate.angen_load.tolerance = 100 * thick
    assert physics.read().known().max() < 0.2 * 30 * G


def test_one_leg_of_a_chair_on_a_sensor_of_18_mm(physics):
    """The chair and who sits on it are not simulated; the other legs stand on the floor."""
    physics.frames(4)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad("fsr", (0.009, 0.009, 0.000225), (0.2, 0.2, 0.000225))
    spots = [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)]
    legs = [((0.02, 0.02, 0.21), (x, y, -0.23)) for x, y in spots]
    parts = [((0.22, 0.22, 0.02), (0, 0, 0)), *legs]
    physics.carried("chair", (), (0, 0, 0.44), 6.0, parts=parts)
    physics.carried("Person", (0.15, 0.15, 0.2), (0, 0, 0.66), 70.0)
    assert physics.read("fsr").known() == pytest.approx(76 * G / 4, rel=0.05)
