# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the pyroelectric detector: lenses, element and amplifier.

Lenses are compared with tables and data sheets, element and amplifier with SciPy and closed forms.
"""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.pir.lenses import (
    LENSES,
    Zone,
    dual,
    lenslet_zones,
    read_table,
    write_table,
    zone_rays,
)
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import (
    Chain,
    Response,
    crossing_peak,
    expm,
    filtered,
    step,
    threshold,
)
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.logs.error import InputError
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import linalg, signal

USUAL = Response(1.0, 0.15, 0.3, 8.0)
# Numbers are in saved files: they never change and are never reused.
NUMBERS = ["THREE_TIERS", "HC_SR501", "EKMC1601111", "EKMC1603111", "EKMC1604111", "CEILING"]
NUMBERS += ["PET_IMMUNE", "CURTAIN", "SPACETI_WALL"]
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


def test_numbers_of_the_lenses_and_too_many_rays():
    assert sorted(LENSES, key=lambda name: LENSES[name].number) == NUMBERS
    assert [lens.number for lens in LENSES.values()] == list(range(len(NUMBERS)))
    parameters = PirParameters(model="PYROELECTRIC", lens="CEILING", zone_rays=1000)
    assert parameters.problems() == [
        "1000 rays in each of 140 zones are more than 100000: set fewer rays per zone"
    ]


# Zones in space


def test_a_zone_looks_where_its_angles_say():
    np.testing.assert_allclose(Zone(0, 0, 1, 1, 1).axis, (0, 0, -1), atol=1e-12)
    # Counter-clockwise seen from +Y, −Z goes to −X: as the range scan's rays.
    np.testing.assert_allclose(Zone(math.pi / 2, 0, 1, 1, 1).axis, (-1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(Zone(0, math.pi / 2, 1, 1, 1).axis, (0, 1, 0), atol=1e-12)


@pytest.mark.parametrize("place", [(0, 0), (40, -45), (-170, 80), (0, -89)])
@pytest.mark.parametrize("size", [(2.3, 4.6), (10, 10), (60, 30)])
def test_rays_fill_the_zone_and_weigh_its_solid_angle(place, size):
    """Against the integral of d²/(1+x²+y²)^(3/2) over the base of the pyramid."""
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
        # Even: each tenth of the zone has its tenth of the rays, give or take two.
        counts = np.histogram(places, np.linspace(-1, 1, 11))[0]
        assert np.abs(counts - 50).max() <= 2
    middles = (np.arange(400) + 0.5) / 200 - 1
    x, y = math.tan(width / 2) * middles, math.tan(height / 2) * middles
    cell = 4 * math.tan(width / 2) * math.tan(height / 2) / 400**2
    expected = (cell / (1 + x[:, None] ** 2 + y**2) ** 1.5).sum()
    assert rays.weights.sum() == pytest.approx(-0.5 * expected, rel=1e-5)


def test_a_lenslet_shows_the_elements_the_other_way_round():
    """Through a lens straight ahead the element on the right sees to the left."""
    left, right = lenslet_zones(0.0, 0.0, dual(25.0))
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
@example("")
@example("# nothing\n\n")
@example("azimuth,elevation,width,height,polarity,gain\n")
def test_any_text_is_a_lens_or_is_told(text):
    try:
        zones = read_table(text)
    except InputError as error:
        assert "lens table" in str(error)
    else:
        assert zones and np.isfinite(zone_rays(zones, 3).directions).all()


# Published figures of the parts


@each_lens
def test_both_polarities_see_the_same(name):
    """Elements in opposition: a room that warms up evenly is no movement."""
    zones = LENSES[name].zones
    each = [zone.polarity * zone.gain * zone.solid_angle for zone in zones]
    assert abs(sum(each)) < 1e-3 * sum(map(abs, each))


def width_of(zones):
    """Return the degrees from the left edge to the right edge of about level zones."""
    middle = [z for z in zones if abs(z.elevation) < math.radians(15)]
    return max(degrees(middle, lambda z: z.azimuth + z.width / 2)) - min(
        degrees(middle, lambda z: z.azimuth - z.width / 2)
    )


def upright_of(zones):
    """Return the degrees of the lower and upper edge of zones about straight ahead."""
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
    # A person's trunk at 75° beside the axis, 1 m away, reaches from 60° to 90°.
    off_axis = [math.acos(-z.axis[2]) + z.width / 2 for z in LENSES["HC_SR501"].zones]
    assert 65 < math.degrees(max(off_axis)) < 75


@pytest.mark.parametrize("blur", [0.3, 1.0, 4.0])
@pytest.mark.parametrize(("width", "height"), [(5.0, 10.0), (1.0, 40.0)])
def test_a_blurred_zone_is_the_sharp_one_under_a_gaussian(blur, width, height):
    """Against a numerical convolution, by the shares of the rays up to each place."""
    zone = Zone(0.3, -0.2, math.radians(width), math.radians(height), -1, 0.5)
    sharp, rays = (zone_rays((zone,), 2000, math.radians(b)) for b in (0.0, blur))
    assert rays.weights.sum() == pytest.approx(sharp.weights.sum(), rel=1e-12)
    ahead = rays.directions @ zone.axis
    up = np.cross(zone.right, zone.axis)
    for axis, size in ((zone.right, width), (up, height)):
        found = np.sort(rays.directions @ axis / ahead)
        half, sigma = math.tan(math.radians(size / 2)), math.tan(math.radians(blur))
        x = np.linspace(-half - 6 * sigma, half + 6 * sigma, 4001)
        kernel = np.exp(-((x / sigma) ** 2) / 2)
        density = np.convolve((np.abs(x) <= half) * 1.0, kernel, mode="same")
        share = np.cumsum(density) / density.sum()
        np.testing.assert_allclose(np.searchsorted(found, x) / len(found), share, atol=0.01)


def test_blur_hides_what_is_small_against_a_zone():
    """A hand that passes between two zones of opposite polarity, against a person who passes."""
    zones = lenslet_zones(0.0, 0.0, dual(25.0))
    person = [crossing_peak(zones, USUAL, 5.0, 4.0, "PERSON", math.radians(b)) for b in (0, 2, 4)]
    plate = [crossing_peak(zones, USUAL, 5.0, 4.0, "PLATE", math.radians(b)) for b in (0, 2, 4)]
    assert person[0] > person[1] > person[2] and plate[0] > plate[1] > plate[2]
    # The plate, which is narrower than a zone, loses more.
    assert plate[2] / plate[0] < person[2] / person[0]


@pytest.mark.parametrize(("first", "last", "metres"), [(0, 9, 12), (9, 14, 6), (14, 17, 3)])
def test_each_step_of_the_wall_type_has_its_distance(first, last, metres):
    zones = LENSES["EKMC1604111"].zones
    whole = threshold(zones, USUAL, 12.0, 4.0)
    part = crossing_peak(zones[4 * first : 4 * last], USUAL, metres, 4.0)
    assert part == pytest.approx(whole, rel=0.02)


SPACETI = ((150, 100, 353), (160, 106, 377), (180, 120, 424), (200, 133, 471), (230, 153, 542))


@pytest.mark.parametrize(("height", "blind", "aim"), SPACETI)
def test_a_real_wall_detector_sees_the_floor_where_its_table_says(height, blind, aim):
    """On the floor before it, its zones begin at `blind`, and their centre is at `aim`."""
    before = [z for z in LENSES["SPACETI_WALL"].zones if abs(z.azimuth) <= math.radians(15.0)]
    low = min(zone.elevation - zone.height / 2 for zone in before)
    high = max(zone.elevation + zone.height / 2 for zone in before)
    for elevation, published in ((low, blind), ((low + high) / 2, aim)):
        down = math.degrees(math.atan2(height, published))
        assert math.degrees(-elevation) == pytest.approx(down, abs=1.0)


# Element and amplifier

OTHER = Response(electrical=4.0, thermal=0.02, low_cut=0.1, high_cut=10.0)


def polynomials(r):
    """Return numerator and denominator of V/P, multiplied out from its factors."""
    low, high = 2 * math.pi * r.low_cut, 2 * math.pi * r.high_cut
    above = [r.electrical, 0.0, 0.0]  # sτE · s
    below = np.polymul([r.electrical, 1.0], [r.thermal, 1.0])
    below = np.polymul(below, [1.0, low])
    below = np.polymul(below, np.polymul([1 / high, 1.0], [1 / high, 1.0]))
    return above, below


@pytest.mark.parametrize("scale", [0.0, 1e-6, 0.3, 5.3, 5.4, 40.0, 700.0])
@pytest.mark.parametrize("seed", range(5))
def test_the_exponential_is_scipys(scale, seed):
    a = np.random.default_rng(seed).normal(size=(7, 7))
    a *= scale / np.abs(a).sum(axis=0).max()
    expected = linalg.expm(a)
    # Both lose digits in squaring, in proportion to the norm.
    np.testing.assert_allclose(
        expm(a), expected, atol=1e-13 * max(1.0, scale) * abs(expected).max()
    )


@pytest.mark.parametrize("response", [USUAL, OTHER])
@pytest.mark.parametrize("rate", [1, 10, 24, 25, 30, 60, 120, 240])
def test_piecewise_linear_power_gives_what_lsim_gives(response, rate):
    dt, n = 1.0 / rate, 200
    power = np.random.default_rng(1).normal(size=n).cumsum()
    power[0] = 0.0
    system = signal.lti(*polynomials(response))
    times = np.arange(n) * dt
    _, expected, _ = signal.lsim(system, power, times, interp=True)
    found = filtered(response, power, dt)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("rate", [1, 7, 10, 24, 60, 240])
def test_the_chain_ends_each_step_where_lsim_does_and_misses_no_peak(rate):
    """`advance` gives the largest signal within the step: that of a much finer lsim."""
    dt, n, fine = 1.0 / rate, 40, 600
    power = np.random.default_rng(2).normal(size=n)
    power[0] = 0.0
    chain = Chain(USUAL)
    peaks = chain.advance(power, np.full(n, dt))
    times = np.arange((n - 1) * fine + 1) * (dt / fine)
    between = np.interp(times, np.arange(n) * dt, power)
    _, exact, _ = signal.lsim(signal.lti(*polynomials(USUAL)), between, times)
    assert peaks[0] == 0.0
    largest = np.abs(exact).max()
    for k in range(1, n):
        part = exact[(k - 1) * fine + 1 : k * fine + 1]
        assert abs(peaks[k]) <= np.abs(part).max() + 1e-9 * largest
        assert abs(peaks[k]) >= abs(part[-1]) - 1e-9 * largest
    # Sampled every 20 ms: between two samples a peak may be slightly higher.
    assert max(map(abs, peaks)) == pytest.approx(largest, rel=0.02)


def test_the_chain_moves_on_from_long_rests_as_lsim_does():
    dt, draw = 0.02, np.random.default_rng(3).normal
    levels = [0.0, 2.5, 2.5, -0.7]
    power = np.concatenate([np.append(draw(size=30), np.full(3000, level)) for level in levels])
    power[0] = 0.0
    system = signal.lti(*polynomials(USUAL))
    _, expected, _ = signal.lsim(system, power, np.arange(len(power)) * dt)
    # Another interval in the middle of a rest.
    at, extra = 2000, 7.0
    chain = Chain(USUAL)
    peaks = chain.advance(np.insert(power, at, 0.0), np.insert(np.full(len(power), dt), at, extra))
    assert np.abs(np.delete(peaks, at) - expected).max() < 1e-9 * np.abs(expected).max()


def test_rest_is_rest_and_a_step_of_any_length_is_stable():
    chain = Chain(USUAL)
    peaks = chain.advance(np.full(100, 447.3), np.full(100, 0.1))
    assert peaks == pytest.approx(np.zeros(100), abs=1e-9)
    assert np.abs(filtered(USUAL, np.full(100, -3.0), 0.04)).max() < 1e-12
    chain = Chain(USUAL)
    chain.advance(np.zeros(1), np.zeros(1))
    peaks = chain.advance(np.arange(100) % 2.0, np.full(100, 10.0))
    assert np.abs(peaks).max() < 1.0
    assert np.abs(np.linalg.eigvals(step(USUAL, 10.0).carry)).max() < 1.0
