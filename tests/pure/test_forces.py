# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces on a pad in worlds of boxes, inverse dynamics, undersides and centres of mass.

All are compared with closed forms.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.sensor_logic.forces import motion, shapes
from angen_sensors.sensor_logic.forces.balance import Load
from angen_sensors.sensor_logic.forces.covered import Contact, without_covered
from angen_sensors.sensor_logic.forces.pad_forces import pad_forces
from angen_sensors.sensor_logic.forces.patches import contact_patch
from angen_sensors.sensor_logic.forces.shapes import rotation_about
from angen_sensors.sensor_logic.forces.underside import (
    centre_of_mass,
    clustered,
    firmness,
    gathered,
    underside,
)
from angen_sensors.sensor_logic.forces.world import Constraint, Node, RequiredLoad, Support
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import CORNERS, TRIANGLES, at

G = 9.81
PAD = (1,)
GROUND = ()


class Boxes:
    """Boxes at places, by key; those with a mass weigh. It counts the queries of the island."""

    def __init__(self):
        self.up, self.gravity = np.array((0.0, 0.0, 1.0)), G
        self.nodes, self.shapes, self.required = {}, {}, {}
        self.constraints, self.stands, self.asked = [], {}, set()

    def add(self, key, half, place, mass=0.0, acceleration=(0, 0, 0), **node):
        name = "pad" if key == PAD else f"body {key[0]}"
        self.nodes[key] = Node(key, name, mass > 0.0, False, 0.5, objects=frozenset(key))
        self.nodes[key] = replace(self.nodes[key], **node)
        self.shapes[key] = shapes.box(half).placed(at(*place))
        push = mass * (np.array(acceleration, float) + (0, 0, G))
        load = Load(
            np.array(place, float), np.concatenate([push, np.zeros(3)]), np.linalg.norm(half)
        )
        self.required[key] = RequiredLoad(load, np.tile(np.array(place, float), (3, 1)), mass, 0.0)

    def node(self, key):
        return self.nodes.get(key) or Node(key, "", False, False, 0.7)

    def near(self, key):
        self.asked.add(key)
        own = self.shapes[key]
        return [
            other
            for other, shape in self.shapes.items()
            if other != key
            and (own.lo <= shape.hi + 0.05).all()
            and (own.hi >= shape.lo - 0.05).all()
        ]

    def contacts(self, one, two, reach, when):
        patch = contact_patch(self.shapes[one], self.shapes[two], reach)
        return [] if patch is None else [Contact(0, 1, patch, self.shapes[one], self.shapes[two])]

    def supports_of(self, key):
        return self.stands.get(key, [])

    def required_load(self, key):
        return self.required[key]

    def constraints_of(self, key):
        return [link for link in self.constraints if key in (link.one, link.two)]

    def animated_near(self, pad, beside, above):
        return [key for key, node in self.nodes.items() if node.animated]


def on_pad(found):
    return sum(-partner.forces[:, 2].sum() for partner in found.partners)


@pytest.fixture
def boxes():
    world = Boxes()
    world.add(PAD, (0.2, 0.2, 0.01), (0, 0, 0))
    return world


def test_a_stack_and_what_is_elsewhere(boxes):
    """Only the island is read: other objects on the floor are not queried."""
    nothing = pad_forces(PAD, boxes)
    assert nothing.usable and not nothing.problem and not nothing.partners
    boxes.add((9,), (5, 5, 0.5), (0, 0, -0.51))
    for number in range(3):
        boxes.add((2 + number,), (0.1, 0.1, 0.1), (0.03, 0, 0.11 + 0.2 * number), 2.0)
    for number in range(50):
        boxes.add((100 + number,), (0.1, 0.1, 0.1), (1 + number % 7, 1 + number // 7, 0.09), 1.0)
    boxes.asked.clear()
    found = pad_forces(PAD, boxes)
    assert on_pad(found) == pytest.approx(6 * G, rel=1e-6)
    assert found.residual < 1e-6 and not found.problem and found.bodies == 3
    assert boxes.asked == {PAD, (2,), (3,), (4,)}
    (partner,) = found.partners
    assert partner.name == "body 2" and partner.objects == {2}
    middle = partner.forces[:, 2] @ partner.places / partner.forces[:, 2].sum()
    assert middle == pytest.approx((0.03, 0, 0.01), abs=1e-6)


def test_someone_who_stands_on_a_pad_and_a_pair_that_is_joined(boxes):
    boxes.add((2,), (0.1, 0.1, 0.8), (0, 0, 0.82), 70.0, animated=True)
    places = np.array([(x, y, 0.01) for x in (-0.1, 0.1) for y in (-0.05, 0.05)])
    boxes.stands[(2,)] = [Support(PAD, places, np.full(4, 0.005))]
    found = pad_forces(PAD, boxes)
    assert on_pad(found) == pytest.approx(70 * G, rel=1e-6) and not found.problem
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    boxes.stands.clear()
    boxes.add((3,), (0.05, 0.05, 0.02), (0.16, 0, 0.15), 1.0)
    glue = Constraint("glue", (2,), (3,), np.array((0.1, 0, 0.15)), np.eye(3), np.eye(3))
    boxes.constraints = [glue]
    found = pad_forces(PAD, boxes)
    assert on_pad(found) == pytest.approx(5 * G, rel=1e-4) and not found.problem
    (partner,) = found.partners
    middle = partner.forces[:, 2] @ partner.places[:, 0] / partner.forces[:, 2].sum()
    assert middle == pytest.approx(0.16 / 5, abs=1e-4)


def unexplained(boxes):
    """Add a person whose foot is at the edge: it should tip, but stands."""
    boxes.add((2,), (0.3, 0.1, 0.1), (0.45, 0, 0.11), 4.0)


def unknown(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    boxes.required[(2,)] = replace(boxes.required[(2,)], problem="'body 2' has just appeared")


def hovering(boxes):
    boxes.add((2,), (0.1, 0.1, 0.8), (0, 0, 1.0), 70.0, animated=True)


def joined_to_the_ground(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    glue = Constraint("glue", (2,), None, np.array((0, 0, 0.2)), np.eye(3), np.eye(3))
    boxes.constraints = [glue]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (unexplained, ["body 2", "explain"]),
        (unknown, ["'body 2' has just appeared"]),
        (hovering, ["nothing supports 'body 2'"]),
        (joined_to_the_ground, ["'glue'"]),
    ],
)
def test_forces_that_are_not_known_are_told(boxes, make, words):
    make(boxes)
    found = pad_forces(PAD, boxes)
    assert not found.usable and all(word in found.problem for word in words)


# Inverse dynamics from three poses

DT = 1 / 24
GRAVITY = np.array((0.0, 0.0, -9.81))
UNIT = np.array((1.0, 1.0, 1.0))


def pose(place=(0, 0, 0), axis=(0, 0, 1), angle=0.0, scale=1.0):
    return at(*place, axis, angle, scale)


def three(place, angle=lambda t: 0.0, axis=(0, 0, 1), dt=DT):
    return [pose(place(t), axis, angle(t)) for t in (-dt, 0.0, dt)]


@pytest.mark.parametrize(
    ("place", "velocity", "acceleration"),
    [
        (lambda t: (0, 0, -t - 9.81 * t * t / 2), (0, 0, -1), GRAVITY),
        (lambda t: (1, 2, 3), (0, 0, 0), (0, 0, 0)),
        (lambda t: (3 * t + t * t, 0, 4 * t * t), (3, 0, 0), (2, 0, 8)),
    ],
    ids=["free fall", "rest", "accelerated"],
)
def test_force_is_mass_times_acceleration_against_gravity(place, velocity, acceleration):
    moved = motion.motion(*three(place), DT, 0.1)
    assert moved.acceleration == pytest.approx(acceleration)
    assert moved.velocity == pytest.approx(velocity)
    need = motion.wrench(moved, pose(place(0.0)), 5.0, UNIT, GRAVITY)
    assert need[:3] == pytest.approx(5.0 * (np.array(acceleration) - GRAVITY), abs=1e-9)
    assert need[3:] == pytest.approx((0, 0, 0), abs=1e-9)


@pytest.mark.parametrize("damping", [0.0, 0.04, 0.5, 0.9])
def test_damping_is_the_engines(damping):
    """v(t + dt) = v·(1 − d)^dt: with this decay no contact force is needed."""
    rate = -math.log(1 - damping)
    dt = 1e-3
    moved = motion.motion(
        *three(lambda t: (2 * (1 - math.exp(-rate * t)) / rate if rate else 2 * t, 0, 0), dt=dt),
        dt,
        0.1,
    )
    need = motion.wrench(moved, pose(), 3.0, UNIT, np.zeros(3), damping)
    assert need[:3] == pytest.approx((0, 0, 0), abs=1e-4)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (1, 2, -1)])
def test_turning(axis):
    """θ = 2t + 3t²/2 about an axis: spin 2, its change 3."""
    moved = motion.motion(*three(lambda t: (0, 0, 0), lambda t: 2 * t + 1.5 * t * t, axis), DT, 1.0)
    unit = np.array(axis) / np.linalg.norm(axis)
    assert moved.spin == pytest.approx(2 * unit)
    assert moved.spin_change == pytest.approx(3 * unit)
    inertia = np.array((0.1, 0.2, 0.3))
    need = motion.wrench(moved, pose(), 1.0, inertia, np.zeros(3))
    gyroscopic = np.cross(2 * unit, inertia * 2 * unit)
    assert need[3:] == pytest.approx(inertia * 3 * unit + gyroscopic)


def test_inertia_turns_with_the_body():
    """A rod along its own x that lies along y is easy to turn about y."""
    moved = motion.RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3), np.array((0, 1.0, 0)), 0.0)
    lying = pose(axis=(0, 0, 1), angle=math.pi / 2)
    need = motion.wrench(moved, lying, 1.0, np.array((0.01, 1.0, 1.0)), np.zeros(3))
    assert need[3:] == pytest.approx((0, 0.01, 0), abs=1e-12)


@pytest.mark.parametrize(("speed", "rests"), [(0.0005, True), (0.009, True), (0.02, False)])
def test_the_engines_jitter_is_rest_and_what_is_faster_is_motion(speed, rests):
    places = [(0, 0, 0), (0, 0, speed * DT), (0, 0, 0)]
    moved = motion.motion(*(pose(place) for place in places), DT, 0.1)
    assert moved.velocity.any() is np.False_
    assert moved.acceleration[2] == pytest.approx(0.0 if rests else -2 * speed / DT)


@pytest.mark.parametrize("scale", [1.0, 0.01, -1.0, -2.5])
def test_rotation_of_scaled_and_mirrored_poses(scale):
    turned = pose(axis=(1, 2, 3), angle=0.7, scale=scale)
    assert motion.rotation_of(turned) == pytest.approx(pose(axis=(1, 2, 3), angle=0.7)[:3, :3])
    moved = motion.motion(turned, turned, turned, DT, 0.1)
    assert not moved.spin.any() and not moved.acceleration.any()


UP = np.array((0.0, 0.0, 1.0))
FAR = np.full(3, 1e9)


# Undersides and centres of mass


def box(half, at=(0, 0, 0)):
    return (CORNERS * half + at)[TRIANGLES]


def below(triangles, closed=True, up=UP, lo=-FAR, hi=FAR):
    return underside(triangles, closed, up, lo, hi)


TETRAHEDRON = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
SQUARE = np.array([[(0, 0, 0), (2, 0, 0), (2, 1, 0)], [(0, 0, 0), (2, 1, 0), (0, 1, 0.0)]])
CENTRES = {
    "box": (box((1, 2, 3), (5, 6, 7)), True, (5, 6, 7)),
    "two boxes": (np.concatenate([box((1, 1, 1)), box((1, 1, 3), (4, 0, 0))]), True, (3, 0, 0)),
    "tetrahedron": (
        TETRAHEDRON[[(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]],
        True,
        (0.25, 0.25, 0.25),
    ),
    "open": (SQUARE, False, (1, 0.5, 0)),
    "inside out, far": (box((0.2, 0.1, 0.9), (2000, -1000, 3))[:, ::-1], True, (2000, -1000, 3)),
}


@pytest.mark.parametrize(("triangles", "closed", "centre"), CENTRES.values(), ids=CENTRES)
def test_centres_of_mass(triangles, closed, centre):
    assert centre_of_mass(triangles, closed) == pytest.approx(centre, abs=1e-6)


@pytest.mark.parametrize("inside_out", [False, True])
def test_underside_of_a_box_is_its_foot(inside_out):
    triangles = box((0.2, 0.1, 0.5))
    found = below(triangles[:, ::-1] if inside_out else triangles)
    assert found.areas.sum() == pytest.approx(0.08)
    assert found.points[:, 2] == pytest.approx(-0.5)
    assert found.areas @ found.points[:, :2] == pytest.approx((0, 0), abs=1e-9)


def test_both_sides_of_an_open_surface_count():
    sheet = np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0.0)]])
    for one in (sheet, sheet[:, ::-1]):
        assert below(one, closed=False).areas.sum() == pytest.approx(0.5)


def test_the_box_that_is_looked_into_limits_it():
    lo, hi = np.array((-0.05, -1, -1)), np.array((0.05, 1, 1))
    found = below(box((0.2, 0.1, 0.5)), lo=lo, hi=hi)
    assert (np.abs(found.points[:, 0]) <= 0.05).all()
    assert found.areas.sum() == pytest.approx(0.02, rel=0.25)
    nothing = below(box((0.2, 0.1, 0.5)), lo=np.full(3, 5.0))
    assert nothing.points.shape == (0, 3) and nothing.areas.shape == (0,)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1), st.floats(0, 6)
)
def test_area_seen_from_below_is_the_shadow(axis, angle):
    """Of a convex body at any turn: half of Σ |n·up|·A; steep faces are left out."""
    turn = rotation_about(np.array(axis) / np.linalg.norm(axis), angle)
    found = below(box((0.2, 0.1, 0.5)) @ turn.T)
    sizes = 4 * np.array((0.1 * 0.5, 0.2 * 0.5, 0.2 * 0.1))
    cosines = np.abs(turn[2])
    assert found.areas.sum() == pytest.approx((sizes * cosines)[cosines > 0.1].sum(), rel=1e-6)


def test_gathering_keeps_areas_and_their_centre_and_firmness():
    rng = np.random.default_rng(0)
    points, areas = rng.uniform(-1, 1, (500, 3)), rng.uniform(0, 1, 500)
    for places, total in (gathered(points, areas, 0.5), clustered(points, areas)):
        assert len(places) < 400
        assert total.sum() == pytest.approx(areas.sum())
        assert total @ places == pytest.approx(areas @ points)
    # 1 where it just touches, 0 at the tolerance; proportional in between and below the surface.
    found = firmness([0.0, 0.015, 0.03, 0.1, -0.03], 0.03)
    assert found == pytest.approx((1, 0.5, 0, 0, 2))


# Contacts hidden by nearer ones: areas and moments known by hand

BODY, THIN, FLOOR = range(3)


def kept(body, pad, preferred=(), movable=(True, False, False)):
    """Return the remaining patches between a body and a pad, and between it and the floor."""
    parts = (body, pad, shapes.box((5, 5, 0.05)).placed(at(z=-0.05)))
    contacts = []
    for i, j in ((BODY, THIN), (FLOOR, BODY)):  # the body is once a, once b
        patch = contact_patch(parts[i], parts[j], 0.002)
        if patch is not None:
            contacts.append(Contact(i, j, patch, parts[i], parts[j]))
    left = without_covered(contacts, movable, preferred)
    return {next(iter({c.a, c.b} - {BODY})): c.patch for c in left}


@pytest.mark.parametrize("sunk", [0.0, 0.001, 0.009])
@pytest.mark.parametrize("thick", [0.00045, 0.001])
def test_thin_pad_hides_the_floor_below_it_alone(thick, sunk):
    box = shapes.box((0.2, 0.15, 0.3)).placed(at(0, 0, 0.3 + thick - sunk))
    pad = shapes.box((0.05, 0.04, thick / 2)).placed(at(0.02, 0, thick / 2))
    left = kept(box, pad)
    assert left[THIN].areas.sum() == pytest.approx(0.1 * 0.08)
    assert left[THIN].gaps == pytest.approx(-sunk)
    floor = left[FLOOR]
    assert floor.areas.sum() == pytest.approx(0.4 * 0.3 - 0.1 * 0.08)
    assert floor.areas @ floor.points[:, 0] == pytest.approx(-0.02 * 0.1 * 0.08)
    hole = 0.08 * (0.07**3 + 0.03**3) / 3
    second = floor.areas @ floor.points[:, 0] ** 2
    assert second == pytest.approx(0.3 * 2 * 0.2**3 / 3 - hole)
    assert floor.gaps == pytest.approx(thick - sunk)
    assert kept(box, pad, movable=(False,) * 3)[FLOOR].areas.sum() == pytest.approx(0.12)


def test_neither_of_equals_is_hidden_but_a_preferred_one_wins():
    box = shapes.box((0.2, 0.2, 0.3)).placed(at(0, 0, 0.3))
    flush = shapes.box((0.05, 0.05, 0.005)).placed(at(0, 0, -0.005))
    assert kept(box, flush)[FLOOR].areas.sum() == pytest.approx(0.16)
    left = kept(box, flush, preferred=(THIN,))
    assert left[FLOOR].areas.sum() == pytest.approx(0.15)
    assert left[THIN].areas.sum() == pytest.approx(0.01)


def test_line_contact_is_cut():
    roll = shapes.cylinder(0.2, 0.3).placed(at(z=0.2005, axis=(0, 1, 0), angle=math.pi / 2))
    none = shapes.box((0.05, 0.05, 0.00025)).placed(at(9, 0, 0.00025))
    pad = shapes.box((0.05, 0.05, 0.00025)).placed(at(0.1, 0, 0.00025))
    whole, floor = kept(roll, none)[FLOOR].areas.sum(), kept(roll, pad)[FLOOR]
    assert floor.areas.sum() == pytest.approx(whole * 5 / 6)
    expected = whole / 0.6 * (2 * 0.3**3 - (0.15**3 - 0.05**3)) / 3
    assert floor.areas @ floor.points[:, 0] ** 2 == pytest.approx(expected)
