# SPDX-License-Identifier: GPL-3.0-or-later
"""The forces on a pad, in worlds of boxes made by hand: no Blender is needed."""

from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.sensor_logic.contact import shapes
from angen_sensors.sensor_logic.contact.balance import Load
from angen_sensors.sensor_logic.contact.covered import Contact
from angen_sensors.sensor_logic.contact.pad_forces import pad_forces
from angen_sensors.sensor_logic.contact.patches import contact_patch
from angen_sensors.sensor_logic.contact.world import Constraint, Node, RequiredLoad, Support

G = 9.81
PAD = (1,)
GROUND = ()


def at(place):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


class Boxes:
    """Boxes at places, by key; those with a mass weigh. Counts what the island asked for."""

    def __init__(self):
        self.up, self.gravity = np.array((0.0, 0.0, 1.0)), G
        self.nodes, self.shapes, self.required = {}, {}, {}
        self.constraints, self.stands, self.asked = [], {}, set()

    def add(self, key, half, place, mass=0.0, acceleration=(0, 0, 0), **node):
        name = "pad" if key == PAD else f"body {key[0]}"
        self.nodes[key] = Node(key, name, mass > 0.0, False, 0.5, objects=frozenset(key))
        self.nodes[key] = replace(self.nodes[key], **node)
        self.shapes[key] = shapes.box(half).placed(at(place))
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


def test_alone(boxes):
    found = pad_forces(PAD, boxes)
    assert found.usable and not found.problem and not found.partners


def test_a_box(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0.03, 0, 0.11), 5.0)
    found = pad_forces(PAD, boxes)
    assert on_pad(found) == pytest.approx(5 * G, rel=1e-6)
    assert found.residual < 1e-6 and not found.problem and found.bodies == 1
    (partner,) = found.partners
    assert partner.name == "body 2" and partner.objects == {2}
    middle = partner.forces[:, 2] @ partner.places / partner.forces[:, 2].sum()
    assert middle == pytest.approx((0.03, 0, 0.01), abs=1e-6)


def test_an_accelerated_box(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0, acceleration=(0, 0, 3.0))
    assert on_pad(pad_forces(PAD, boxes)) == pytest.approx(5 * (G + 3.0), rel=1e-6)


def test_a_stack_and_what_is_elsewhere(boxes):
    """Only the island is looked at: what stands elsewhere on the floor is not asked for."""
    boxes.add((9,), (5, 5, 0.5), (0, 0, -0.51))
    for number in range(3):
        boxes.add((2 + number,), (0.1, 0.1, 0.1), (0, 0, 0.11 + 0.2 * number), 2.0)
    for number in range(50):
        boxes.add((100 + number,), (0.1, 0.1, 0.1), (1 + number % 7, 1 + number // 7, 0.09), 1.0)
    found = pad_forces(PAD, boxes)
    assert on_pad(found) == pytest.approx(6 * G, rel=1e-6)
    assert found.bodies == 3
    assert boxes.asked == {PAD, (2,), (3,), (4,)}


def test_a_box_with_a_foot_on_the_floor(boxes):
    """The floor as high as the pad takes its share by area."""
    boxes.add((9,), (5, 5, 0.5), (5.2, 0, -0.49))
    boxes.add((2,), (0.1, 0.1, 0.1), (0.2, 0, 0.11), 4.0)
    assert on_pad(pad_forces(PAD, boxes)) == pytest.approx(2 * G, rel=1e-3)


def test_the_floor_under_a_thin_pad_carries_nothing(boxes):
    boxes.add((9,), (5, 5, 0.5), (0, 0, -0.5 + 0.0096))
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    assert on_pad(pad_forces(PAD, boxes)) == pytest.approx(4 * G, rel=1e-6)


@pytest.mark.parametrize("gap", [0.0, 1e-4, -1e-3])
def test_a_small_gap_is_contact(boxes, gap):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11 + gap), 4.0)
    assert on_pad(pad_forces(PAD, boxes)) == pytest.approx(4 * G, rel=1e-6)


def test_weight_that_no_contact_explains_is_told(boxes):
    """Its foot is at the edge: it should tip, yet it is said to stand."""
    boxes.add((2,), (0.3, 0.1, 0.1), (0.45, 0, 0.11), 4.0)
    found = pad_forces(PAD, boxes)
    assert found.residual > 0.02 and not found.usable
    assert "body 2" in found.problem and "explain" in found.problem


def test_an_unknown_need_is_told(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    boxes.required[(2,)] = replace(boxes.required[(2,)], problem="'body 2' has just appeared")
    found = pad_forces(PAD, boxes)
    assert found.problem == "'body 2' has just appeared" and not found.usable


def test_someone_who_stands_on_a_pad(boxes):
    boxes.add((2,), (0.1, 0.1, 0.8), (0, 0, 0.82), 70.0, animated=True)
    places = np.array([(x, y, 0.01) for x in (-0.1, 0.1) for y in (-0.05, 0.05)])
    boxes.stands[(2,)] = [Support(PAD, places, np.full(4, 0.005))]
    found = pad_forces(PAD, boxes)
    assert on_pad(found) == pytest.approx(70 * G, rel=1e-6)
    assert not found.problem


def test_someone_who_hovers_is_told(boxes):
    boxes.add((2,), (0.1, 0.1, 0.8), (0, 0, 1.0), 70.0, animated=True)
    found = pad_forces(PAD, boxes)
    assert "nothing holds the weight of 'body 2'" in found.problem and not found.usable


def test_a_joint_to_the_ground_makes_it_unknown(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    boxes.constraints = [
        Constraint("glue", (2,), None, np.array((0, 0, 0.2)), np.eye(3), np.eye(3))
    ]
    found = pad_forces(PAD, boxes)
    assert "'glue'" in found.problem and not found.usable


def test_a_joint_between_two_bodies_of_the_island_is_known(boxes):
    boxes.add((2,), (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    boxes.add((3,), (0.05, 0.05, 0.02), (0.16, 0, 0.15), 1.0)
    boxes.constraints = [
        Constraint("glue", (2,), (3,), np.array((0.1, 0, 0.15)), np.eye(3), np.eye(3))
    ]
    found = pad_forces(PAD, boxes)
    assert not found.problem
    assert on_pad(found) == pytest.approx(5 * G, rel=1e-4)
    (partner,) = found.partners
    middle = partner.forces[:, 2] @ partner.places[:, 0] / partner.forces[:, 2].sum()
    assert middle == pytest.approx(0.16 / 5, abs=1e-4)


def test_order_of_bodies_does_not_matter(boxes):
    rng = np.random.default_rng(0)
    places = [(x, y, 0.06) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    found = []
    for order in (range(4), rng.permutation(4)):
        world = Boxes()
        world.add(PAD, (0.2, 0.2, 0.01), (0, 0, 0))
        for number in order:
            world.add((2 + int(number),), (0.05, 0.05, 0.05), places[number], 1.0)
        world.add((8,), (0.2, 0.2, 0.02), (0.03, 0.01, 0.13), 7.0)
        result = pad_forces(PAD, world)
        found.append({p.name: p.forces[:, 2].sum() for p in result.partners})
    assert found[0] == pytest.approx(found[1], rel=1e-6)
    assert sum(found[0].values()) == pytest.approx(-11 * G, rel=1e-6)
