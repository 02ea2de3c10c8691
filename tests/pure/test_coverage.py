# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays and moving bodies, detectors' models on them, maps, and the choice of detectors.

The choice is compared with the best of all choices, tried one by one.
"""

import csv
import io
import itertools
import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage import picture
from angen_sensors.sensor_logic.coverage.grid import Cells, CoverageMap, choose, map_csv, table
from angen_sensors.sensor_logic.coverage.motions import MOTIONS, Rays, Start, Walker, hits
from angen_sensors.sensor_logic.kinds.pir.coverage import RangeView, WarmView
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import (
    rays_of,
    response_of,
    threshold_of,
)
from angen_sensors.sensor_logic.logs.error import AngenError
from angen_sensors.sensor_logic.model import Emission, Pose
from angen_sensors.sensor_logic.physics import STEFAN_BOLTZMANN
from angen_sensors.sensor_logic.report.facts import PlanStorey, SensorInPlan
from hypothesis import given, settings
from hypothesis import strategies as st
from pyro_bodies import DOWN, ZERO, level_at, peak, pyro, updated, walk

STEP, ARM = MOTIONS["STEP"], MOTIONS["ARM"]
ORIGIN = np.array([0.0, 0.0, 2.0])


def one(x, y, heading=0.0, length=1.0):
    return Start(np.array([[x, y, 0.0]]), np.array([heading]), np.array([length]))


def towards(*point):
    way = np.array(point, float) - ORIGIN
    return (way / np.linalg.norm(way))[None]


def rays(directions, free=20.0):
    return Rays(ORIGIN, directions, np.full(len(directions), free))


def inside(motion, start, time, points):
    """Return which points (n, 3) lie in the only body, by its definition."""
    gone = min(motion.speed * time, start.length[0])
    angle = start.heading[0] + (0.0 if motion.walks else gone)
    ahead = np.array([math.cos(angle), math.sin(angle)])
    middle = start.feet[0, :2] + ahead * (gone if motion.walks else motion.length / 2)
    off = points[:, :2] - middle
    level = (points[:, 2] >= motion.bottom) & (points[:, 2] <= motion.top)
    if motion.radius:
        return level & (np.hypot(*off.T) <= motion.radius)
    along, across = off @ ahead, off @ np.array([-ahead[1], ahead[0]])
    return level & (abs(along) <= motion.length / 2) & (abs(across) <= motion.width / 2)


@settings(deadline=None)
@given(
    st.sampled_from(sorted(MOTIONS)),
    st.floats(-2, 2),
    st.floats(-2, 2),
    st.floats(0, 6),
    st.floats(0, 2),
    st.integers(0, 2**31),
)
def test_a_ray_is_in_a_body_where_points_along_it_are(name, x, y, heading, time, seed):
    motion, start = MOTIONS[name], one(x, y, heading, 0.7)
    rng = np.random.default_rng(seed)
    aims = np.array([x, y, 0.5]) + rng.uniform(-0.6, 0.6, (20, 3))
    ways = aims - ORIGIN
    directions = ways / np.linalg.norm(ways, axis=1)[:, None]
    met = hits(motion, start, time, rays(directions))
    along = np.linspace(0.005, 6.0, 1200)
    step = along[1] - along[0]
    for ray in range(len(directions)):
        held = along[inside(motion, start, time, ORIGIN + along[:, None] * directions[ray])]
        which = np.flatnonzero(met.ray == ray)
        if len(held):
            (i,) = which
            assert met.enter[i] == pytest.approx(held[0], abs=step * 1.01 + 1e-9) or held[0] < 0.01
            assert met.leave[i] == pytest.approx(held[-1], abs=step * 1.01 + 1e-9)
        elif len(which):
            assert met.leave[which[0]] - max(met.enter[which[0]], 0.0) <= step * 1.01
    # Rays that end within reach still report all bodies that they pass.
    ended = Rays(ORIGIN, directions, rng.uniform(0.2, 4.0, len(directions)))
    before_its_end = met.enter < ended.free[met.ray]
    found = hits(motion, start, time, ended)
    assert set(met.ray[before_its_end]) <= set(found.ray) <= set(met.ray)
    if before_its_end.any():
        assert ended.may_hit(motion, start).all()


def view(directions, free=5.0, threshold=0.05, period=0.1, offsets=None):
    tilts = len(directions)
    ranges = np.full(directions.shape[:2], free)
    return RangeView(
        ORIGIN,
        directions,
        ranges,
        0.05,
        5.0,
        threshold,
        period,
        np.zeros(tilts) if offsets is None else offsets,
    )


def test_the_strength_is_the_largest_change_against_the_threshold():
    # A single ray that hits the body at its start, and nothing once it has left.
    looking = view(towards(2.8, 0.0, 1.0)[None], period=10.0)
    found = looking.strengths(STEP, one(3.0, 0.0, math.pi / 2))
    assert found == pytest.approx([(5.0 - math.hypot(2.8, 1.0)) / 0.05])
    # Towards the sensor step by step: each scan is compared with the one before.
    level = np.array([[[1.0, 0.0, -0.2]]]) / math.hypot(1.0, 0.2)
    found = view(level, period=0.1).strengths(STEP, one(3.0, 0.0, math.pi, 0.6096))
    assert found == pytest.approx([0.1 * STEP.speed * math.hypot(1.0, 0.2) / 0.05], rel=1e-6)
    hidden = view(towards(2.8, 0.0, 1.0)[None], free=2.0)
    assert hidden.strengths(STEP, one(3.0, 0.0, math.pi / 2)) == pytest.approx([0.0])
    seen = view(towards(2.8, 0.0, 1.0)[None])
    assert seen.strengths(STEP, one(8.0, 0.0, math.pi / 2)) == pytest.approx([0.0])
    looking = view(np.stack([towards(2.8, 0.0, 1.0)]), threshold=0.0, period=10.0)
    assert looking.strengths(STEP, one(3.0, 0.0, math.pi / 2)) == pytest.approx([np.inf])
    assert looking.strengths(STEP, one(1.0, 3.0, math.pi / 2)) == pytest.approx([0.0])


def test_the_saw_tooth_looks_at_each_tilt_at_its_own_time():
    # Before and after the body is off the ray of the second tilt, which scans once on its way.
    ray = towards(2.8, 0.0, 1.0)
    both = np.stack([towards(0.0, -3.0, 1.0), ray])
    looking = view(both, period=10.0, offsets=np.array([0.0, 0.5]))
    assert looking.strengths(STEP, one(3.0, -0.6, math.pi / 2, 0.9144))[0] > 1.0
    missed = view(both, period=10.0, offsets=np.array([0.0, 0.02]))
    assert missed.strengths(STEP, one(3.0, -0.45, math.pi / 2, 0.9)) == pytest.approx([0.0])


def prism(walker, feet, ambient):
    """Return the warmth of a walker by another formula: a prism of 90 sides."""
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
        kelvin = np.where(hit, walker.celsius, ambient) + ZERO
        return Emission(kelvin, np.where(hit, walker.emissivity, 1.0), ambient + ZERO)

    return warmth


def warm_view(parameters, pose, free=50.0):
    local, walker = rays_of(parameters), Walker()
    warm = STEFAN_BOLTZMANN * walker.emissivity * ((walker.celsius + ZERO) ** 4 - (20 + ZERO) ** 4)
    n = len(local.weights)
    return WarmView(
        pose.origin, local.directions @ pose.axes.T, local.weights, np.full(n, free), np.zeros(n),
        warm, parameters.range_min, response_of(parameters), threshold_of(parameters), 1 / 24,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("lens", "pose", "blur"),
    [
        ("THREE_TIERS", level_at(2.1), 2.0),
        pytest.param("CEILING", Pose(np.array([0.0, 0.0, 2.5]), DOWN), 0.0, marks=pytest.mark.slow),
    ],
)
def test_coverage_is_what_the_detector_itself_would_say(lens, pose, blur):
    parameters = pyro(lens=lens, zone_rays=12, lens_blur=math.radians(blur))
    random = np.random.default_rng(5)
    starts = np.column_stack([random.uniform(-4, 4, (8, 2)), np.zeros(8)])
    headings, lengths = random.uniform(0, 2 * math.pi, 8), random.uniform(0.3, 1.0, 8)
    found = warm_view(parameters, pose).strengths(STEP, Start(starts, headings, lengths))
    ways = np.column_stack([np.cos(headings), np.sin(headings), np.zeros(8)])
    walker = Walker(STEP.top, STEP.radius, STEP.speed)
    for start, end, signal in zip(starts, starts + lengths[:, None] * ways, found, strict=True):
        places = walk(start, end, STEP.speed, 24, before=0.0, after=1.0)
        readings = updated(parameters, [prism(walker, feet, 20.0) for feet in places], pose, 24)
        # A prism of 90 sides has 0.1 % less silhouette; one ray is 2 % of a zone.
        assert signal == pytest.approx(peak(readings), rel=0.05, abs=0.1)
    assert found.max() > 1.0


def test_coverage_ends_at_walls():
    start = Start(np.array([[-0.5, 4.0, 0.0]]), np.zeros(1), np.ones(1))
    signals = [
        warm_view(pyro(), level_at(1.2), free).strengths(STEP, start)[0] for free in (3.0, 9.0)
    ]
    assert signals[0] == 0.0 and signals[1] > 0.0


def test_no_motion_detector_notices_who_only_breathes():
    still = MOTIONS["STILL"]
    lengths = still.lengths(np.full((1, 8), 0.25))
    assert (lengths > 0.0).all() and (still.lengths(np.full((1, 8), 0.15)) == 0.0).all()
    start = one(0.0, 1.0, length=float(lengths[0, 0]))
    assert still.seconds(start) == 0.0
    for looking in (view(towards(0.0, 0.8, 1.0)[None]), warm_view(pyro(), level_at(1.0))):
        assert not looking.may_notice(still, start).any()
        assert (looking.strengths(still, start) == 0.0).all()


def test_lengths_end_at_what_stands_in_the_way_and_heights_are_checked():
    chest = MOTIONS["CHEST"].at_height(1.0)
    assert (chest.bottom, chest.top) == pytest.approx((0.775, 1.225))
    with pytest.raises(AngenError, match="must be above 0"):
        ARM.at_height(0.01)
    clearance = np.array([[2.0, 0.9, 0.45, 0.2, 2.0, 2.0, 2.0, 2.0]])
    found = STEP.lengths(clearance)[0]
    assert found[:4] == pytest.approx([0.9144, 0.7, 0.0, 0.0])
    # An arm needs its length in the directions from which and to which it turns.
    turned = ARM.lengths(np.array([[0.4, 0.4, 0.4, 0.3, 0.4, 0.4, 0.4, 0.4]]))[0] > 0.0
    assert turned.tolist() == [True, False, False, False, True, True, True, True]


@pytest.fixture
def small():
    """Return four cells in two rooms, and two detectors; the last cell has only one direction."""
    at = np.array([(0.5, 0.5, 0), (1.5, 0.5, 0), (2.5, 0.5, 0), (3.5, 0.5, 0)], float)
    lengths = np.full((4, 8), 0.9)
    lengths[3, 1:] = 0.0
    cells = Cells(1.0, at, ("den", "den", "hall", "hall"), np.zeros(4, int), lengths)
    strength = np.zeros((2, 4, 8), np.float32)
    strength[0, 0] = 5.0
    strength[1, 0, :4] = 2.0
    strength[1, 1, :3] = 2.0
    strength[1, 3, 0] = 1.5
    return CoverageMap(STEP, cells, ("one", "two"), strength)


def test_a_map_counts_cells_and_its_picture_is_xml_that_gets_lighter(small):
    assert small.count.tolist() == [2, 0, 0, 1]
    assert small.best == pytest.approx([1.0, 0.375, 0.0, 1.0])
    den, hall = small.rooms()
    assert (den.name, den.cells, den.dead, den.once, den.overlap) == ("den", 2, 1, 0, 1)
    assert (hall.dead, hall.once, hall.share) == (1, 1, 0.5)
    assert small.total().share == 0.5
    assert picture.levels(small).tolist() == [3, 1, 0, 2]
    rows = list(csv.DictReader(io.StringIO(map_csv(small))))
    assert [(row["room"], row["covered_by"]) for row in rows[1:3]] == [("den", "0"), ("hall", "0")]
    assert float(rows[1]["two"]) == 0.375 and float(rows[0]["margin"]) == 5.0
    assert "den" in table(small) and "50.0 %" in table(small)
    light = picture.linear(picture.VIRIDIS) @ np.array([0.2126, 0.7152, 0.0722])
    # Each step differs in grey (contrast by WCAG).
    assert ((light[1:] + 0.05) / (light[:-1] + 0.05) > 1.5).all()
    named = replace(small, sensors=("<one>", "two & a half"))
    placed = tuple(SensorInPlan(n, np.zeros(2), np.array([1.0, 0.0]), 2.0) for n in named.sensors)
    storey = PlanStorey(0.0, 1.1, np.array([[0.0, 0.0], [4.0, 1.0]]), (), placed)
    text = picture.svg(named, [storey], "A <title>", dict.fromkeys(named.sensors, "PIR"))
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert "&lt;one&gt;" in text and "two &amp; a half" in text
    assert all(f'fill="{picture.css(level)}" d="' in text for level in range(4))


# The choice of detectors


@st.composite
def instances(draw):
    m, n = draw(st.integers(1, 9)), draw(st.integers(1, 14))
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    sets = rng.random((m, n)) < draw(st.floats(0.05, 0.7))
    weights = rng.integers(0, 5, n).astype(float)
    return sets, draw(st.integers(1, 4)), weights


def best_of_all(sets, count, weights):
    choices = itertools.combinations(range(len(sets)), min(count, len(sets)))
    return max(weights[sets[list(chosen)].any(axis=0)].sum() for chosen in choices)


@given(instances(), st.integers(0, 5))
def test_greedy_swaps_and_bounds_against_the_best(instance, seed):
    sets, count, weights = instance
    best = best_of_all(sets, count, weights)
    found = choose(sets, count, weights, seed)
    assert found.covered == weights[sets[list(found.chosen)].any(axis=0)].sum()
    assert found.greedy >= (1 - 1 / math.e) * best - 1e-9
    assert found.covered >= found.greedy, "a swap never makes it worse"
    assert found.covered <= best + 1e-9 <= found.bound + 2e-9
    assert found.assured <= found.covered / best + 1e-9 if best else found.assured == 1.0
    assert len(set(found.chosen)) == len(found.chosen) <= count
    assert found == choose(sets, count, weights, seed), "the same again"


def test_a_swap_finds_what_greed_misses():
    # A greedy choice takes the large middle first, and then needs a third detector to cover all.
    sets = np.array(
        [
            [1, 1, 1, 0, 0, 0],
            [0, 0, 0, 1, 1, 1],
            [0, 1, 1, 1, 1, 0],
        ],
        bool,
    )
    found = choose(sets, 2)
    assert found.greedy == 5 and found.covered == 6 and found.swaps == 1
    assert sorted(found.chosen) == [0, 1] and found.assured == 1.0


def test_nothing_is_chosen_that_adds_nothing():
    found = choose(np.array([[1, 1], [1, 0], [0, 0]], bool), 3)
    assert found.chosen == (0,) and found.covered == found.bound == 2
    none = choose(np.zeros((2, 3), bool), 1)
    assert none.chosen == () and none.assured == 1.0
    apart = choose(np.eye(6, dtype=bool), 3)
    assert apart.covered == 3 and apart.bound == 3


def test_what_makes_no_sense_is_told():
    with pytest.raises(ValueError, match="at least 1"):
        choose(np.ones((2, 2), bool), 0)
    with pytest.raises(ValueError, match="weights"):
        choose(np.ones((2, 2), bool), 1, np.array([1.0, -1.0]))
