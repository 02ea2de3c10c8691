# SPDX-License-Identifier: GPL-3.0-or-later
"""Electrical properties of materials at radar frequencies against published numbers."""

import math

import pytest
from angen_sensors.sensor_logic.parameters import specs
from angen_sensors.sensor_logic.radio.properties import THICKNESS, RadarSubstance, is_textile
from angen_sensors.sensor_logic.radio.substances import (
    OPAQUE,
    SUBSTANCES,
    VACUUM_PERMITTIVITY,
    attenuation,
    permittivity,
    reflectance,
)


def conductivity(substance, frequency):
    omega = math.tau * frequency * 1e9
    return -permittivity(substance, frequency).imag * omega * VACUUM_PERMITTIVITY


@pytest.mark.parametrize(
    ("substance", "frequency", "real", "sigma"),
    [
        # IFAC-CNR, Dielectric properties of body tissues: dry skin.
        ("BODY", 60.0, 7.98, 36.4),
        ("BODY", 10.0, 31.29, 8.014),
        ("BODY", 2.45, 38.007, 1.4641),
        # MathWorks, buildingMaterialPermittivity at 9 GHz, of what no edition has changed.
        ("GLASS", 9.0, 6.31, 0.0036 * 9**1.3394),
        ("WOOD", 9.0, 1.99, 0.049528),
        ("METAL", 9.0, 1.0, 1e7),
        ("PLYWOOD", 24.0, 2.71, 0.33),
    ],
)
def test_permittivity_is_that_of_the_tables(substance, frequency, real, sigma):
    assert permittivity(substance, frequency).real == pytest.approx(real, rel=2e-3)
    assert conductivity(substance, frequency) == pytest.approx(sigma, rel=2e-3)


@pytest.mark.parametrize("frequency", [24.125, 60.0])
@pytest.mark.parametrize("name", sorted(SUBSTANCES.keys() - {"METAL", "BODY"}))
def test_a_dielectric_absorbs_1636_sigma_by_root_epsilon(name, frequency):
    one, two = attenuation(name, 0.001, frequency), attenuation(name, 0.011, frequency)
    root = math.sqrt(permittivity(name, frequency).real)
    expected = 1636.0 * conductivity(name, frequency) / root
    assert (two - one) / 0.01 == pytest.approx(expected, rel=0.01)


def test_both_faces_reflect():
    share = ((1.0 - math.sqrt(6.31)) / (1.0 + math.sqrt(6.31))) ** 2
    assert reflectance("GLASS", 24.0) == pytest.approx(share, rel=1e-3)
    thin = attenuation("GLASS", 1e-9, 24.0)
    assert thin == pytest.approx(-20.0 * math.log10(1.0 - share), rel=1e-3)


def test_what_stops_the_waves_and_what_does_not():
    assert reflectance("METAL", 24.0) > 0.998
    assert attenuation("METAL", 0.001, 24.0) == OPAQUE
    # A person reflects about half of the power at 24 GHz and a third at 60 GHz.
    assert 0.4 < reflectance("BODY", 24.125) < 0.6 and 0.3 < reflectance("BODY", 60.0) < 0.5
    # Two boards of plasterboard pass, 0.2 m of concrete does not.
    assert attenuation("PLASTERBOARD", 0.026, 24.125) < 5.0
    assert attenuation("CONCRETE", 0.2, 24.125) > 60.0
    assert attenuation("WOOD", 0.04, 24.125) < attenuation("WOOD", 0.04, 60.0)


def test_cloth_loses_less_than_a_decibel_and_clothes_less_than_three_up_to_300_ghz():
    assert attenuation("TEXTILE", THICKNESS["TEXTILE"], 24.125) < 0.5
    assert attenuation("TEXTILE", THICKNESS["TEXTILE"], 60.0) < 1.0
    # Bjarnason et al. 2004.
    assert attenuation("TEXTILE", 0.001, 300.0) < 3.0


def test_choices_keep_their_numbers():
    """Blend files store the numbers."""
    names = ["AUTO", "CONCRETE", "BRICK", "PLASTERBOARD", "WOOD", "GLASS", "CHIPBOARD", "PLYWOOD"]
    names += ["METAL", "BODY", "TEXTILE"]
    choices = specs(RadarSubstance)["substance"].choices
    assert [(one.identifier, one.number) for one in choices] == [
        *zip(names, range(11), strict=True)
    ]


@pytest.mark.parametrize("name", SUBSTANCES)
def test_no_thickness_loses_nothing_and_more_never_loses_less(name):
    assert attenuation(name, 0.0, 24.0) == 0.0
    losses = [attenuation(name, t, 24.0) for t in (1e-4, 1e-3, 0.01, 0.1, 1.0)]
    assert losses == sorted(losses) and all(0.0 < one <= OPAQUE for one in losses)
    assert 0.0 < reflectance(name, 24.0) <= 1.0


@pytest.mark.parametrize(
    "name", ["Curtain", "Wall curtain", "Duvet.001", "box_cushion", "Carpet flooring", "DoorTowel"]
)
def test_names_of_cloth(name):
    assert is_textile(name, []) and is_textile("Plane", [name, "Cotton"])


@pytest.mark.parametrize(
    "name",
    [
        "Curtain wall", "Blanket cupboard", "Linen closet door", "Towel radiator.002",
        "CurtainRails_left", "Clothes rack", "Vorhang", "couette", "",
    ],
)  # fmt: skip
def test_names_of_what_cloth_hangs_or_lies_on_are_none_of_cloth(name):
    assert not is_textile(name, [])


def test_a_wall_with_a_paint_of_the_colour_of_linen_is_no_cloth():
    assert not is_textile("Wall north", ["Linen white"])
    assert not is_textile("Plane", ["Linen white", "Oak"]) and not is_textile("Plane", [])
