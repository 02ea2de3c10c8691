# SPDX-License-Identifier: GPL-3.0-or-later
"""The solver of contact forces: closed forms, and random islands against scipy's solvers."""

from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.sensor_logic.forces.balance import GROUND, Joint, Load, Points, balance
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy import optimize

UP = np.array((0.0, 0.0, 1.0))
SEEDS = st.integers(0, 2**32 - 1)


def points(places, normals=None, a=None, b=None, friction=0.0, stiffness=1.0, slack=0.0):
    places = np.array(places, float).reshape(-1, 3)
    count = len(places)
    return Points(
        places,
        np.broadcast_to(UP if normals is None else normals, (count, 3)).astype(float),
        np.full(count, 0 if a is None else a, np.intp),
        np.full(count, GROUND if b is None else b, np.intp),
        np.broadcast_to(float(friction) if np.isscalar(friction) else friction, count).astype(
            float
        ),
        np.broadcast_to(stiffness, count).astype(float),
        np.broadcast_to(slack, count).astype(float),
    )


def joined(*parts):
    fields = zip(*(vars(part).values() for part in parts), strict=True)
    return Points(*(np.concatenate(field) for field in fields))


def load(weight, centre=(0, 0, 0), size=1.0, force=None, moment=(0, 0, 0)):
    force = (0, 0, weight) if force is None else force
    return Load(np.array(centre, float), np.array((*force, *moment), float), size)


def square(half=1.0, z=0.0):
    return [(x, y, z) for x in (-half, half) for y in (-half, half)]


def residual(loads, found):
    """Return the greatest missing part of a body's load, as a share of the greatest load."""

    def sizes(wrenches):
        return [
            np.linalg.norm(wrench[:3]) + np.linalg.norm(wrench[3:]) / one.size
            for one, wrench in zip(loads, wrenches, strict=True)
        ]

    return max(sizes(found.missing)) / max(*sizes([one.wrench for one in loads]), 1e-9)


def missing_of(loads, where, forces):
    """Return the part of the loads that the forces leave, computed again."""
    left = [one.wrench.copy() for one in loads]
    for place, a, b, force in zip(where.places, where.a, where.b, forces, strict=True):
        for body, sign in ((a, 1.0), (b, -1.0)):
            if body != GROUND:
                arm = place - loads[body].centre
                left[body] -= sign * np.concatenate([force, np.cross(arm, force)])
    return np.array(left)


# Closed forms


@pytest.mark.parametrize("weight", [1e-2, 9.81, 5e3])
def test_four_even_legs(weight):
    found = balance([load(weight, (0, 0, 0.5))], points(square()))
    assert found.settled
    assert found.forces == pytest.approx(np.tile((0, 0, weight / 4), (4, 1)), rel=1e-6)
    assert np.abs(found.missing).max() < 1e-6 * weight


@pytest.mark.parametrize(("x", "y"), [(0.2, 0.1), (0.5, 0.4), (-0.3, 0.6)])
def test_four_legs_share_as_an_elastic_foundation(x, y):
    """f = W/4 · (1 + x·lx + y·ly) for legs at ±1, and no leg pulls."""
    found = balance([load(100.0, (x, y, 0.5))], points(square()))
    exact = 25 * (1 + np.array([lx * x + ly * y for lx, ly, _ in square()]))
    assert found.forces[:, 2] == pytest.approx(exact, rel=1e-6, abs=1e-6)


def test_a_leg_that_would_pull_has_nothing():
    """Far out, the opposite leg lifts; three legs follow from statics alone."""
    found = balance([load(100.0, (0.7, 0.7, 0.5))], points(square()))
    exact = (0.0, 15.0, 15.0, 70.0)
    assert found.forces[:, 2] == pytest.approx(exact, abs=1e-3)


def test_stiffer_legs_carry_more():
    found = balance([load(100.0)], points([(-1, 0, 0), (1, 0, 0), (-1, 0, 0)], stiffness=[1, 3, 2]))
    assert found.forces[:, 2] == pytest.approx((50 / 3, 50, 100 / 3), rel=1e-5)


def test_slack_is_an_indentation():
    """A point with a gap of the mean indentation carries that much less."""
    found = balance([load(100.0)], points(square() + [(0, 0, 0)], slack=[0, 0, 0, 0, 1e3]))
    assert found.forces[4] == pytest.approx(0.0, abs=1e-6)
    assert found.forces[:4, 2] == pytest.approx(25.0, rel=1e-6)


def test_what_nothing_holds_is_missing():
    found = balance([load(100.0, (3.0, 0, 0.5))], points(square()))
    assert residual([load(100.0, (3.0, 0, 0.5))], found) > 0.5
    assert (found.forces[:, 2] >= 0).all()


def test_no_points_at_all():
    found = balance([load(100.0)], points([]))
    assert found.forces.shape == (0, 3)
    assert found.missing[0] == pytest.approx((0, 0, 100, 0, 0, 0))


def test_nothing_needed_is_nothing_given():
    found = balance([load(0.0)], points(square(), friction=0.5))
    assert found.forces == pytest.approx(np.zeros((4, 3)), abs=1e-9)


def test_stack():
    """Two bodies on the ground: the lower contact carries both."""
    where = joined(points(square(z=0)), points(square(z=1), a=1, b=0))
    loads = [load(40.0, (0, 0, 0.5)), load(20.0, (0, 0, 1.5))]
    found = balance(loads, where)
    assert found.forces[:4, 2] == pytest.approx(15.0, rel=1e-6)
    assert found.forces[4:, 2] == pytest.approx(5.0, rel=1e-6)


@pytest.mark.parametrize("slope", [0.1, 0.4])
def test_friction_holds_on_a_slope(slope):
    """The normal force is W·cos, the friction W·sin, up the slope."""
    normal = np.array((np.sin(slope), 0, np.cos(slope)))
    along = np.array((np.cos(slope), 0, -np.sin(slope)))
    places = [x * along + y * np.array((0, 1, 0)) for x in (-1, 1) for y in (-1, 1)]
    found = balance([load(10.0, 0.1 * normal)], points(places, normal, friction=0.6))
    total = found.forces.sum(axis=0)
    assert total @ normal == pytest.approx(10 * np.cos(slope), rel=1e-6)
    assert total @ along == pytest.approx(-10 * np.sin(slope), rel=1e-6)
    assert np.abs(found.missing).max() < 1e-6


def test_friction_is_not_enough_on_a_steep_slope():
    normal = np.array((np.sin(0.5), 0, np.cos(0.5)))
    found = balance([load(10.0, (0, 0, 0))], points([(0, 0, 0)], normal, friction=0.2))
    assert found.missing[0, :3] @ normal == pytest.approx(0.0, abs=0.7)
    rub = np.linalg.norm(found.forces[0] - (found.forces[0] @ normal) * normal)
    assert rub <= 0.2 * (found.forces[0] @ normal) * (1 + 1e-9)
    assert np.linalg.norm(found.missing) > 1.0


def test_sliding_uses_all_the_friction():
    """The load of a sliding body is on the edge of the cone, and can be carried."""
    need = np.array((-3.0, 0, 10.0))
    loads = [load(0, (0, 0, 0.1), force=need, moment=(0, 0.3, 0))]
    found = balance(loads, points(square(0.5), friction=0.3))
    assert residual(loads, found) < 1e-3
    assert found.forces.sum(axis=0) == pytest.approx(need, abs=0.02)
    assert found.steps < 60


# Joints


def test_a_fixed_joint_makes_one_body_of_two():
    """Bodies of different size: the joint's moment is equal and opposite."""
    loads = [load(50.0, (0, 0, 0), size=0.15), load(10.0, (0.16, 0, 0.02), size=0.07)]
    joint = Joint(0, 1, np.array((0.1, 0, 0.0)), np.eye(3), np.eye(3), 1.0)
    where = points(square(0.1, -0.05), friction=0.5)
    found = balance(loads, where, [joint])
    assert found.forces[:, 2].sum() == pytest.approx(60.0, rel=1e-6)
    centre = found.forces[:, 2] @ where.places[:, 0] / 60.0
    assert centre == pytest.approx(10 * 0.16 / 60.0, rel=1e-4)


def test_a_hinge_and_a_prop():
    """A beam from a hinge at x = 0 to a prop at x = 1: half each; one is no contact."""
    beam = load(100.0, (0.5, 0, 0), size=0.5)
    hinge = Joint(0, GROUND, np.zeros(3), np.eye(3), np.eye(3)[[0, 2]], 1.0)
    found = balance([beam], points([(1, 0, 0)]), [hinge])
    assert found.forces[0, 2] == pytest.approx(50.0, rel=1e-6)
    assert np.abs(found.missing).max() < 1e-6 * 100


# Random islands


def island(seed, feasible=True):
    """Return a few bodies, with random points between them and the ground.

    If feasible, the loads are those of random forces in their cones.
    """
    rng = np.random.default_rng(seed)
    bodies = int(rng.integers(1, 5))
    count = int(rng.integers(1, 25))
    a = rng.integers(0, bodies, count)
    b = np.where(rng.random(count) < 0.5, GROUND, rng.integers(0, bodies, count))
    b = np.where(a == b, GROUND, b)
    normals = rng.normal(size=(count, 3)) * 0.3 + UP
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    where = Points(
        rng.uniform(-1, 1, (count, 3)),
        normals,
        a.astype(np.intp),
        b.astype(np.intp),
        rng.choice([0.0, 0.1, 0.5, 1.0], count),
        10.0 ** rng.uniform(-3, 0, count),
        np.zeros(count),
    )
    scale = 10.0 ** rng.uniform(-2, 4)
    centres, sizes = rng.uniform(-1, 1, (bodies, 3)), rng.uniform(0.1, 2.0, bodies)
    wrenches = rng.normal(size=(bodies, 6)) * scale
    if feasible:
        press = rng.exponential(size=count) * scale * (rng.random(count) < 0.7)
        rub = np.cross(normals, rng.normal(size=(count, 3)))
        rub /= np.linalg.norm(rub, axis=1)[:, None]
        share = where.friction * rng.uniform(0, 0.95, count)
        forces = press[:, None] * (normals + share[:, None] * rub)
        blank = [Load(c, np.zeros(6), s) for c, s in zip(centres, sizes, strict=True)]
        wrenches = -missing_of(blank, where, forces)
    loads = [Load(c, w, s) for c, w, s in zip(centres, wrenches, sizes, strict=True)]
    return loads, where


def rough_island(seed, feasible):
    """Return up to six bodies that depend on each other, of 1 cm to 3 m.

    Their masses and stiffnesses differ by up to 1000. If feasible, the loads are those of random
    forces in their cones, some on the cone's edge.
    """
    rng = np.random.default_rng((int(feasible), seed))
    bodies = int(rng.integers(1, 7))
    sizes = 10.0 ** rng.uniform(-2, 0.5, bodies)
    weights = 9.81 * 10.0 ** rng.uniform(-1.5, 1.5, bodies)
    centres = np.zeros((bodies, 3))
    parts = []
    for body in range(bodies):
        under, towards = GROUND, -UP
        if body:
            under = int(rng.integers(0, body))
            towards = rng.normal(size=3)
            towards /= np.linalg.norm(towards)
            centres[body] = centres[under] - towards * (sizes[body] + sizes[under])
        for other, way in [(under, towards), (GROUND, -UP)][: int(rng.integers(1, 3))]:
            count = int(rng.integers(1, 9))
            reach = 0.5 * min(sizes[body], sizes[other] if other != GROUND else np.inf)
            spread = rng.uniform(-reach, reach, (count, 3))
            flat = rng.random() < 0.5
            if flat:
                spread -= np.outer(spread @ way, way)
            normals = -way + (0.0 if flat else 0.3) * rng.normal(size=(count, 3))
            normals /= np.linalg.norm(normals, axis=1)[:, None]
            places = centres[body] + way * sizes[body] + spread
            parts.append(points(places, normals, a=body, b=other))
    where = joined(*parts)
    count = len(where.places)
    friction = rng.choice([0.0, 0.01, 0.1, 0.5, 1.0, 2.0], count)
    slack = np.zeros(count)
    if rng.random() < 0.3:
        slack = np.where(rng.random(count) < 0.2, 10.0 ** rng.uniform(-2, 4, count), 0.0)
    spring = 10.0 ** rng.uniform(-rng.choice([0, 3]), 0, count)
    where = replace(where, friction=friction, stiffness=spring, slack=slack)
    wrenches = rng.normal(size=(bodies, 6)) * weights[:, None]
    wrenches[:, 3:] *= sizes[:, None]
    if feasible:
        press = rng.exponential(size=count) * weights[where.a] * (rng.random(count) < 0.7)
        rub = np.cross(where.normals, rng.normal(size=(count, 3)))
        rub /= np.linalg.norm(rub, axis=1)[:, None]
        share = friction * rng.choice([rng.uniform(), 1.0], count)
        forces = press[:, None] * (where.normals + share[:, None] * rub)
        blank = [Load(c, np.zeros(6), s) for c, s in zip(centres, sizes, strict=True)]
        wrenches = -missing_of(blank, where, forces)
    return [Load(c, w, s) for c, w, s in zip(centres, wrenches, sizes, strict=True)], where


def assert_possible(loads, where, found):
    """Assert no NaN, no pulling, friction in its cone, and a correct `missing`."""
    assert np.isfinite(found.forces).all() and np.isfinite(found.missing).all()
    scale = max(np.abs(found.forces).max(initial=0.0), 1e-12)
    press = np.einsum("ij,ij->i", found.forces, where.normals)
    rub = np.linalg.norm(found.forces - press[:, None] * where.normals, axis=1)
    assert press.min(initial=0.0) >= -1e-9 * scale
    assert (rub <= where.friction * press + 1e-7 * scale).all()
    wanted = missing_of(loads, where, found.forces)
    needs = max(np.abs([one.wrench for one in loads]).max(), scale)
    assert found.missing == pytest.approx(wanted, abs=1e-6 * needs)


@settings(max_examples=120, deadline=None, derandomize=True)
@given(SEEDS)
def test_feasible_islands_are_met(seed):
    loads, where = island(seed)
    found = balance(loads, where)
    assert_possible(loads, where, found)
    assert found.settled, found.steps
    assert residual(loads, found) < 0.01


@settings(max_examples=120, deadline=None, derandomize=True)
@given(SEEDS)
def test_islands_that_cannot_be_met_are_told(seed):
    loads, where = island(seed, feasible=False)
    found = balance(loads, where)
    assert_possible(loads, where, found)
    assert found.settled, found.steps


@pytest.mark.parametrize(
    "count",
    [
        40,
        pytest.param(150, marks=pytest.mark.slow),
        pytest.param(10_000, marks=pytest.mark.measured),
    ],
    ids=["few", "some", "20000"],
)
def test_every_island_settles(count, figure):
    """Feasible or not."""
    most = 0
    for feasible in (True, False):
        for seed in range(count):
            loads, where = rough_island(seed, feasible)
            found = balance(loads, where)
            assert found.settled, (seed, feasible)
            assert_possible(loads, where, found)
            most = max(most, found.steps)
    figure(f"0 of {2 * count} not settled, at most {most} steps")


def test_a_cone_whose_apex_newton_circles():
    """Newton's method alone found no end in 150 steps."""
    for seed, feasible in ((507, True), (33, True), (90, False), (1_014_826_219, False)):
        loads, where = island(seed, feasible)
        found = balance(loads, where)
        assert found.settled
        assert_possible(loads, where, found)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS)
def test_without_friction_as_scipys_nnls(seed):
    """The least remainder with forces ≥ 0, feasible or not."""
    loads, where = island(seed, feasible=bool(seed % 2))
    where = Points(*(vars(where) | {"friction": np.zeros(len(where.places))}).values())
    found = balance(loads, where)
    columns = []
    for index in range(len(where.places)):
        forces = np.zeros((len(where.places), 3))
        forces[index] = where.normals[index]
        blank = [Load(one.centre, np.zeros(6), one.size) for one in loads]
        columns.append(-missing_of(blank, where, forces))
    unit = np.array([[1, 1, 1, *([1 / one.size] * 3)] for one in loads])
    matrix = np.array([(column * unit).ravel() for column in columns]).T
    target = (np.array([one.wrench for one in loads]) * unit).ravel()
    # Each body's balance counts by its own load: a light one is not sacrificed to a heavy
    # neighbour.
    share = np.abs(target).reshape(-1, 6).sum(axis=1) / (np.abs(target).sum() or 1.0)
    weight = np.repeat(np.maximum(share, 1e-6) ** -0.5, 6)
    _, least = optimize.nnls(matrix * weight[:, None], target * weight)
    left = np.linalg.norm((found.missing * unit).ravel() * weight)
    assert left <= least + 5e-3 * np.linalg.norm(target * weight)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([1e-3, 1.0, 1e4]))
def test_forces_scale_with_the_needs(seed, factor):
    loads, where = island(seed)
    scaled = [Load(one.centre, one.wrench * factor, one.size) for one in loads]
    one, two = balance(loads, where), balance(scaled, where)
    size = np.abs(one.forces).max()
    assert two.forces / factor == pytest.approx(one.forces, abs=1e-4 * size)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS)
def test_order_and_place_do_not_matter(seed):
    """Points shuffled; everything 2 km from the origin."""
    loads, where = island(seed)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(where.places))
    shuffled = Points(*(values[order] for values in vars(where).values()))
    far = np.array((2000.0, -500.0, 3.0))
    moved = Points(*(vars(shuffled) | {"places": shuffled.places + far}).values())
    there = [Load(one.centre + far, one.wrench, one.size) for one in loads]
    one, two = balance(loads, where), balance(there, moved)
    size = np.abs(one.forces).max()
    assert two.forces == pytest.approx(one.forces[order], abs=1e-3 * size)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.floats(1e-8, 1e-3))
@example(1, 1e-8)
def test_three_feet_of_very_different_area(seed, smallest):
    """Statics decide; even a foot that touches in a point has its share."""
    rng = np.random.default_rng(seed)
    feet = np.array([(-0.2, -0.15, 0.0), (0.2, -0.15, 0.0), (0.0, 0.25, 0.0)])
    stiffness = np.array((3.6e-3, 2.8e-3, smallest))
    patch = 0.03 * rng.uniform(-1, 1, (2, 6, 2))
    places = [
        *(feet[0] + np.pad(patch[0], ((0, 0), (0, 1)))),
        *(feet[1] + np.pad(patch[1], ((0, 0), (0, 1)))),
        feet[2],
    ]
    shares = np.repeat(stiffness / (6, 6, 1), (6, 6, 1))
    middle = np.median(shares)
    loads = [load(60.0, (0, 0, 0.12), size=0.4)]
    found = balance(
        loads, points(places, friction=0.25, stiffness=np.clip(shares, middle / 1e3, None))
    )
    assert found.settled
    assert residual(loads, found) < 1e-4
    assert found.forces[-1, 2] == pytest.approx(60 * 0.15 / 0.4, rel=0.25)


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e3])
def test_mass_ratios(ratio):
    """A pile of three whose masses differ by up to a million."""
    where = joined(
        points(square(0.1, 0), friction=0.25),
        points(square(0.1, 1), a=1, b=0, friction=0.25),
        points(square(0.1, 2), a=2, b=1, friction=0.25),
    )
    weights = 10.0 * np.array((1.0, ratio, ratio**2))
    loads = [load(w, (0, 0, z), 0.5) for w, z in zip(weights, (0.5, 1.5, 2.5), strict=True)]
    found = balance(loads, where)
    for number in range(3):
        carried = found.forces[4 * number : 4 * number + 4, 2].sum()
        assert carried == pytest.approx(weights[number:].sum(), rel=1e-3)
