# SPDX-License-Identifier: GPL-3.0-or-later
"""Lenses: zones in space, tables that people write, and what data sheets say of the parts."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.error import InputError
from angen_sensors.sensor_logic.kinds.pir.lenses import (
    LENS_PRESETS,
    LENSES,
    Zone,
    dual,
    read_table,
    seen_through,
    write_table,
    zone_rays,
)
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import Response, crossing_peak, threshold
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.parameters import specs
from hypothesis import given
from hypothesis import strategies as st

USUAL = Response(1.0, 0.15, 0.3, 8.0)
# Numbers are in saved files: they never change and are never reused.
NUMBERS = {
    "THREE_TIERS": 0,
    "HC_SR501": 1,
    "EKMC1601111": 2,
    "EKMC1603111": 3,
    "EKMC1604111": 4,
    "CEILING": 5,
    "PET_IMMUNE": 6,
    "CURTAIN": 7,
    "SPACETI_WALL": 8,
}
each_lens = pytest.mark.parametrize("name", NUMBERS)
TABLE = """\
azimuth, elevation, width, height, polarity, gain
# left and right
-2.3, 0, 2.3, 4.6, +, 1
2.3, 0, 2.3, 4.6, -   # gain is 1

10, -20.5, 3, 3, 1, 0.5
"""


def degrees(zones, edge):
    return [math.degrees(edge(zone)) for zone in zones]


def test_numbers_of_the_lenses():
    assert {name: lens.number for name, lens in LENSES.items()} == NUMBERS


# Zones in space


def test_a_zone_looks_where_its_angles_say():
    np.testing.assert_allclose(Zone(0, 0, 1, 1, 1).axis, (0, 0, -1), atol=1e-12)
    # Counter-clockwise seen from +Y, −Z goes to −X: as the range scan's rays.
    np.testing.assert_allclose(Zone(math.pi / 2, 0, 1, 1, 1).axis, (-1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(Zone(0, math.pi / 2, 1, 1, 1).axis, (0, 1, 0), atol=1e-12)


@pytest.mark.parametrize("place", [(0, 0), (40, -45), (-170, 80), (0, -89)])
@pytest.mark.parametrize("size", [(2.3, 4.6), (10, 10), (60, 30)])
def test_rays_fill_the_zone_and_weigh_its_solid_angle(place, size):
    azimuth, elevation, width, height = map(math.radians, (*place, *size))
    zone = Zone(azimuth, elevation, width, height, -1, 0.5)
    rays = zone_rays((zone,), 500)
    up = np.cross(zone.right, zone.axis)
    ahead = rays.directions @ zone.axis
    x = rays.directions @ zone.right / ahead / math.tan(width / 2)
    y = rays.directions @ up / ahead / math.tan(height / 2)
    np.testing.assert_allclose(np.linalg.norm(rays.directions, axis=1), 1.0)
    for places in (x, y):
        assert np.abs(places).max() <= 1.0
        # Even: each tenth of the zone has its tenth of the rays, or one or two more or less.
        counts = np.histogram(places, np.linspace(-1, 1, 11))[0]
        assert np.abs(counts - 50).max() <= 2
    assert rays.weights.sum() == pytest.approx(-0.5 * zone.solid_angle)


@pytest.mark.parametrize("size", [(2.3, 4.6), (10, 10), (60, 30)])
def test_solid_angle_of_a_pyramid(size):
    """Against the integral of d²/(1+x²+y²)^(3/2) over its base."""
    width, height = map(math.radians, size)
    n = 400
    x = math.tan(width / 2) * ((np.arange(n) + 0.5) / n * 2 - 1)
    y = math.tan(height / 2) * ((np.arange(n) + 0.5) / n * 2 - 1)
    cell = 4 * math.tan(width / 2) * math.tan(height / 2) / n**2
    expected = (cell / (1 + x[:, None] ** 2 + y**2) ** 1.5).sum()
    assert Zone(0, 0, width, height, 1).solid_angle == pytest.approx(expected, rel=1e-5)


def test_a_lenslet_shows_the_elements_the_other_way_round():
    """Through a lens straight ahead the element on the right sees to the left."""
    left, right = seen_through(0.0, 0.0, dual(25.0))
    assert (left.polarity, right.polarity) == (1, -1)
    assert math.tan(left.azimuth) == pytest.approx(1 / 25)
    assert math.tan(right.azimuth) == pytest.approx(-1 / 25)
    assert math.tan(left.width / 2) == pytest.approx(0.5 / 25)
    assert math.tan(left.height / 2) == pytest.approx(1 / 25)


# Tables


def test_a_table_that_people_write():
    zones = read_table(TABLE)
    assert degrees(zones, lambda z: z.azimuth) == pytest.approx([-2.3, 2.3, 10])
    assert degrees(zones, lambda z: z.elevation) == pytest.approx([0, 0, -20.5])
    assert [z.polarity for z in zones] == [1, -1, 1]
    assert [z.gain for z in zones] == [1, 1, 0.5]
    assert degrees(zones, lambda z: z.height) == pytest.approx([4.6, 4.6, 3])


@each_lens
def test_a_lens_can_be_written_down_and_read(name):
    zones = LENSES[name].zones
    for one, two in zip(read_table(write_table(zones)), zones, strict=True):
        angles = (one.azimuth, one.elevation, one.width, one.height)
        assert angles == pytest.approx(
            (two.azimuth, two.elevation, two.width, two.height), abs=1e-5
        )
        assert (one.polarity, one.gain) == (two.polarity, two.gain)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("1, 2, 3", "row 3 of the lens table has 3 columns: it must have azimuth, elevation"),
        ("1, 2, 3, 4, +, 1, 9", "row 3 of the lens table has 7 columns"),
        ("1, 2, 3, 4, x", "row 3 of the lens table: polarity is 'x': it must be [+] or -"),
        ("1, two, 3, 4, +", "row 3 of the lens table: elevation is 'two': it must be a number"),
        ("1, nan, 3, 4, +", "row 3 of the lens table: elevation is 'nan'"),
        ("200, 0, 3, 4, +", "row 3 of the lens table: azimuth is 200°: it must be from −180°"),
        ("0, -91, 3, 4, +", "row 3 of the lens table: elevation is -91°"),
        ("0, 0, 0, 4, +", "row 3 of the lens table: width is 0°: it must be above 0°"),
        ("0, 0, 3, 91, +", "row 3 of the lens table: height is 91°"),
        ("0, 0, 3, 4, +, 0", "row 3 of the lens table: gain is 0: it must be above 0"),
    ],
)
def test_what_is_wrong_names_the_row(row, told):
    text = f"azimuth,elevation,width,height,polarity\n0,0,3,3,+\n{row}\n"
    with pytest.raises(InputError, match=told):
        read_table(text)
    problems = PirParameters(model="PYROELECTRIC", lens_table=text).problems()
    assert len(problems) == 1 and "row 3" in problems[0]
    assert PirParameters(lens_table=text).problems() == [], "the range scan has no lens"


@given(st.text(alphabet="0123456789,.+-\n #\"'ax", max_size=80))
def test_any_text_is_a_lens_or_is_told(text):
    try:
        zones = read_table(text)
    except InputError as error:
        assert "lens table" in str(error)
    else:
        assert zones and np.isfinite(zone_rays(zones, 3).directions).all()


def test_an_empty_table_is_told():
    for text in ("", "# nothing\n\n", "azimuth,elevation,width,height,polarity,gain\n"):
        with pytest.raises(InputError, match="is empty: give a row"):
            read_table(text)


def test_too_many_rays_are_told():
    parameters = PirParameters(model="PYROELECTRIC", lens="CEILING", zone_rays=1000)
    assert parameters.problems() == [
        "1000 rays in each of 140 zones are more than 100000: take fewer rays a zone"
    ]


# What is published of the parts


@each_lens
def test_both_polarities_see_the_same(name):
    """Elements in opposition: a room that warms up evenly is no movement."""
    zones = LENSES[name].zones
    each = [zone.polarity * zone.gain * zone.solid_angle for zone in zones]
    assert abs(sum(each)) < 1e-3 * sum(map(abs, each))


def width_of(zones):
    """Degrees from the left edge to the right edge of zones that look about level."""
    middle = [z for z in zones if abs(z.elevation) < math.radians(15)]
    return max(degrees(middle, lambda z: z.azimuth + z.width / 2)) - min(
        degrees(middle, lambda z: z.azimuth - z.width / 2)
    )


def upright_of(zones):
    """Degrees of the lower and upper edge of zones about straight ahead."""
    middle = [z for z in zones if abs(z.azimuth) < math.radians(15)]
    return (
        min(degrees(middle, lambda z: z.elevation - z.height / 2)),
        max(degrees(middle, lambda z: z.elevation + z.height / 2)),
    )


@pytest.mark.parametrize(
    ("name", "wide", "low", "high"),
    [
        ("EKMC1601111", 94, -41, 41),
        ("EKMC1603111", 102, -46, 46),
        ("EKMC1604111", 105, -49, 6.6),
        ("CURTAIN", 4.5, None, None),
    ],
)
def test_published_angles(name, wide, low, high):
    zones = LENSES[name].zones
    assert width_of(zones) == pytest.approx(wide, abs=2)
    if low is not None:
        assert upright_of(zones) == pytest.approx((low, high), abs=1)


def test_zones_of_the_wall_type_and_cone_of_the_module():
    assert len(LENSES["EKMC1604111"].zones) == 68
    off_axis = [math.acos(-z.axis[2]) + z.width / 2 for z in LENSES["HC_SR501"].zones]
    assert 100 < 2 * math.degrees(max(off_axis)) < 120


@pytest.mark.parametrize(("first", "last", "metres"), [(0, 9, 12), (9, 14, 6), (14, 17, 3)])
def test_each_step_of_the_wall_type_has_its_distance(first, last, metres):
    zones = LENSES["EKMC1604111"].zones
    whole = threshold(zones, USUAL, 12.0, 4.0)
    part = crossing_peak(zones[4 * first : 4 * last], USUAL, metres, 4.0)
    assert part == pytest.approx(whole, rel=0.02)


SPACETI = ((150, 100, 353), (160, 106, 377), (180, 120, 424), (200, 133, 471), (230, 153, 542))


@pytest.mark.parametrize(("height", "blind", "aim"), SPACETI)
def test_a_real_wall_detector_sees_the_floor_where_its_table_says(height, blind, aim):
    """On the floor before it, its zones begin at `blind`, and their middle is at `aim`."""
    before = [z for z in LENSES["SPACETI_WALL"].zones if abs(z.azimuth) <= math.radians(15.0)]
    low = min(zone.elevation - zone.height / 2 for zone in before)
    high = max(zone.elevation + zone.height / 2 for zone in before)
    for elevation, published in ((low, blind), ((low + high) / 2, aim)):
        down = math.degrees(math.atan2(height, published))
        assert math.degrees(-elevation) == pytest.approx(down, abs=1.0)


def test_presets_set_parameters_that_there_are():
    names = set(specs(PirParameters))
    assert len({preset.identifier for preset in LENS_PRESETS}) == len(LENS_PRESETS)
    for preset in LENS_PRESETS:
        assert set(preset.values) <= names
        parameters = PirParameters(**preset.values)
        assert parameters.problems() == []
        assert preset.source and "Assumed" in preset.source
        assert parameters.range_max == LENSES[parameters.lens].detection_distance
