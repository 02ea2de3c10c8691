# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays and moving bodies in closed form, the detectors' models on them, and what a map tells."""

import csv
import io
import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage import picture
from angen_sensors.sensor_logic.coverage.detect import RangeView, WarmView
from angen_sensors.sensor_logic.coverage.detectors import Walker
from angen_sensors.sensor_logic.coverage.grid import Cells, CoverageMap, map_csv, table
from angen_sensors.sensor_logic.coverage.motions import HEADINGS, INCH, MOTIONS, Rays, Start, hits
from angen_sensors.sensor_logic.error import AngenError
from angen_sensors.sensor_logic.kinds.pir.lenses import LENSES, zone_rays
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import STEFAN_BOLTZMANN, Response
from angen_sensors.sensor_logic.model import Pose
from angen_sensors.sensor_logic.wording import ZERO_CELSIUS
from hypothesis import given
from hypothesis import strategies as st
from walks import peak_signals

STEP, ARM = MOTIONS["STEP"], MOTIONS["ARM"]
ORIGIN = np.array([0.0, 0.0, 2.0])


def one(x, y, heading=0.0, length=1.0):
    return Start(np.array([[x, y, 0.0]]), np.array([heading]), np.array([length]))


def towards(*point):
    way = np.array(point, float) - ORIGIN
    return (way / np.linalg.norm(way))[None]


def rays(directions, free=20.0):
    return Rays(ORIGIN, directions, np.full(len(directions), free))


def test_a_cylinder_is_met_at_its_side_and_its_top():
    met = hits(STEP, one(3.0, 0.0), 0.0, rays(towards(2.8, 0.0, 1.0)))
    assert met.enter == pytest.approx([math.hypot(2.8, 1.0)])
    # It comes down on the top, 1.7 m high, in the middle.
    met = hits(STEP, one(3.0, 0.0), 0.0, rays(towards(3.0, 0.0, 1.7)))
    assert met.enter == pytest.approx([math.hypot(3.0, 0.3)])
    assert not len(hits(STEP, one(3.0, 0.0), 0.0, rays(towards(3.0, 0.0, 2.0))).ray)
    assert not len(hits(STEP, one(3.0, 0.0), 0.0, rays(towards(-3.0, 0.0, 1.0))).ray), "behind"


def test_straight_down_meets_what_stands_below():
    down = np.array([[0.0, 0.0, -1.0]])
    met = hits(STEP, one(0.1, 0.0), 0.0, rays(down))
    assert met.enter == pytest.approx([0.3]) and met.leave == pytest.approx([2.0])
    assert not len(hits(STEP, one(0.3, 0.0), 0.0, rays(down)).ray)


def test_a_body_walks_as_far_as_it_may_and_an_arm_turns():
    ahead = towards(3.0 - 0.2 + 0.5, 0.0, 1.0)
    met = hits(STEP, one(3.0, 0.0, length=0.5), 100.0, rays(ahead))
    assert met.enter == pytest.approx([math.hypot(3.3, 1.0)])
    # After a second the arm points along +Y: its end, 15 in from the middle, is there.
    end = (1.0, 15 * INCH - 1e-6, 36 * INCH)
    assert len(hits(ARM, one(1.0, 0.0, length=math.pi / 2), 1.0, rays(towards(*end))).ray) == 1
    assert not len(hits(ARM, one(1.0, 0.0, length=math.pi / 2), 0.0, rays(towards(*end))).ray)


def inside(motion, start, time, points):
    """Which points (n, 3) lie in the only body; by its definition."""
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
    # Of rays that end, nothing is left out that they meet on their way.
    ended = Rays(ORIGIN, directions, rng.uniform(0.2, 4.0, len(directions)))
    before_its_end = met.enter < ended.free[met.ray]
    found = hits(motion, start, time, ended)
    assert set(met.ray[before_its_end]) <= set(found.ray) <= set(met.ray)
    if before_its_end.any():
        assert ended.may_meet(motion, start).all()


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
    # A single ray, which meets the body where it starts and nothing when it is gone.
    looking = view(towards(2.8, 0.0, 1.0)[None], period=10.0)
    found = looking.strengths(STEP, one(3.0, 0.0, math.pi / 2))
    assert found == pytest.approx([(5.0 - math.hypot(2.8, 1.0)) / 0.05])
    # Towards the sensor step by step: each scan is compared with the one before.
    level = np.array([[[1.0, 0.0, -0.2]]]) / math.hypot(1.0, 0.2)
    found = view(level, period=0.1).strengths(STEP, one(3.0, 0.0, math.pi, 0.6096))
    assert found == pytest.approx([0.1 * STEP.speed * math.hypot(1.0, 0.2) / 0.05], rel=1e-6)


def test_what_is_behind_the_free_range_is_not_seen_and_what_is_beyond_reach_neither():
    hidden = view(towards(2.8, 0.0, 1.0)[None], free=2.0)
    assert hidden.strengths(STEP, one(3.0, 0.0, math.pi / 2)) == pytest.approx([0.0])
    seen = view(towards(2.8, 0.0, 1.0)[None])
    assert seen.strengths(STEP, one(8.0, 0.0, math.pi / 2)) == pytest.approx([0.0])


def test_a_threshold_of_zero_notices_every_change_and_no_rest():
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


def test_pyroelectric_steps_are_those_of_the_detectors_own_walks():
    """Two programs: the walks of `walks`."""
    zones = next(iter(LENSES.values())).zones
    local = zone_rays(zones, 12)
    axes = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    pose = Pose(ORIGIN, axes)
    response = Response(1.0, 0.15, 0.3, 8.0)
    walker = Walker(STEP.top, STEP.radius, STEP.speed)
    kelvin = walker.celsius + ZERO_CELSIUS
    ambient = 20.0 + ZERO_CELSIUS
    warm = STEFAN_BOLTZMANN * walker.emissivity * (kelvin**4 - ambient**4)
    looking = WarmView(
        ORIGIN,
        local.directions @ axes.T,
        local.weights,
        np.full(len(local.weights), 9.0),
        np.zeros(len(local.weights)),
        warm,
        0.05,
        response,
        1.0,
        0.02,
    )
    cells = np.array([(x, y, 0.0) for x in (1.5, 3.0, 4.5) for y in (-1.0, 0.2, 1.3)])
    for heading in HEADINGS[:4].tolist():
        start = Start(cells, np.full(len(cells), heading), np.full(len(cells), 0.9))
        ends = cells + 0.9 * np.array([math.cos(heading), math.sin(heading), 0.0])
        free = np.full(len(local.weights), 9.0)
        other = peak_signals(
            zones, response, pose, cells, ends, walker, free=free, interval=0.02, rays=12
        )
        mine = looking.strengths(STEP, start)
        assert mine == pytest.approx(other, rel=0.02, abs=0.01 * other.max())


def test_lengths_end_at_what_stands_in_the_way():
    clearance = np.array([[2.0, 0.9, 0.45, 0.2, 2.0, 2.0, 2.0, 2.0]])
    found = STEP.lengths(clearance)[0]
    assert found[:4] == pytest.approx([0.9144, 0.7, 0.0, 0.0])
    # An arm needs its length in the directions from which and to which it turns.
    turned = ARM.lengths(np.array([[0.4, 0.4, 0.4, 0.3, 0.4, 0.4, 0.4, 0.4]]))[0] > 0.0
    assert turned.tolist() == [True, False, False, False, True, True, True, True]


def test_heights():
    assert STEP.at_height(1.2).top == 1.2 and STEP.at_height(1.2).bottom == 0.0
    chest = MOTIONS["CHEST"].at_height(1.0)
    assert (chest.bottom, chest.top) == pytest.approx((0.775, 1.225))
    with pytest.raises(AngenError, match="must be above 0"):
        STEP.at_height(9.0)
    with pytest.raises(AngenError, match="must be above 0"):
        ARM.at_height(0.01)


@pytest.fixture
def small():
    """Four cells in two rooms, two detectors; the last cell has one direction only."""
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


def test_a_map_counts_cells_by_what_is_noticed_in_half_of_the_directions(small):
    assert small.count.tolist() == [2, 0, 0, 1]
    assert small.best == pytest.approx([1.0, 0.375, 0.0, 1.0])
    den, hall = small.rooms()
    assert (den.name, den.cells, den.dead, den.once, den.overlap) == ("den", 2, 1, 0, 1)
    assert (hall.dead, hall.once, hall.share) == (1, 1, 0.5)
    assert small.total().share == 0.5
    assert picture.levels(small).tolist() == [3, 1, 0, 2]
    assert "den" in table(small) and "50.0 %" in table(small)


def test_the_csv_has_a_row_a_cell(small):
    rows = list(csv.DictReader(io.StringIO(map_csv(small))))
    assert len(rows) == 4
    assert rows[3]["room"] == "hall" and rows[3]["directions"] == "1"
    assert [row["covered_by"] for row in rows] == ["2", "0", "0", "1"]
    assert float(rows[1]["two"]) == 0.375 and float(rows[1]["one"]) == 0.0
    assert float(rows[0]["margin"]) == 5.0


def test_colours_get_lighter_with_what_is_noticed():
    light = picture.linear(picture.VIRIDIS) @ np.array([0.2126, 0.7152, 0.0722])
    # Each step is told apart in grey (contrast by WCAG).
    assert ((light[1:] + 0.05) / (light[:-1] + 0.05) > 1.5).all()


def test_the_picture_is_xml_and_escapes_names(small):
    from dataclasses import replace
    from xml.etree import ElementTree

    from angen_sensors.sensor_logic.report.facts import PlanStorey, SensorInPlan

    named = replace(small, sensors=("<one>", "two & a half"))
    placed = tuple(SensorInPlan(n, np.zeros(2), np.array([1.0, 0.0]), 2.0) for n in named.sensors)
    storey = PlanStorey(0.0, 1.1, np.array([[0.0, 0.0], [4.0, 1.0]]), (), placed)
    text = picture.svg(named, [storey], "A <title>")
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert "&lt;one&gt;" in text and "two &amp; a half" in text
    for level in (0, 1, 2, 3):
        assert f'fill="{picture.css(level)}" d="' in text
