# SPDX-License-Identifier: GPL-3.0-or-later
"""Pads under rigid bodies of every collision shape, scaled, mirrored, parented and instanced."""

import math

import numpy as np
import pytest
from pressure_scenes import G
from tiers import mostly_slow

SHAPES = ["BOX", "SPHERE", "CAPSULE", "CYLINDER", "CONE", "CONVEX_HULL", "MESH"]
# Meshes and cones stand off by the engine's margin.
MARGIN = {"CONE": 0.04, "MESH": 0.04}


def shaped(physics, shape, at, mass=5.0, **place):
    """A body of 0.2 units across, and as high, of a collision shape."""
    if shape in ("BOX", "CONVEX_HULL", "MESH"):
        obj = physics.solid("body", (0.1, 0.1, 0.1), at)
    else:
        obj = physics.round(shape, at, 0.05 if shape == "CAPSULE" else 0.1, 0.1)
    for key, value in place.items():
        setattr(obj, key, value)
    return physics.rigid_body(obj, shape=shape, mass=mass)


def assert_at_rest(pad, shape):
    if shape == "MESH":
        # It hops now and then, and the reading is not valid then.
        late = pad.frames > 20
        assert pad.force[late & pad.valid] == pytest.approx(5 * G, rel=0.025)
        assert (late & pad.valid).sum() > 5
        assert all("lets it hop" in reason for reason in pad.problems)
    else:
        assert pad.known(after=6) == pytest.approx(5 * G, rel=0.01)


@pytest.mark.parametrize("kind", [None, "PASSIVE"])
@pytest.mark.parametrize("ground", mostly_slow(["BOX", "CONVEX_HULL", "MESH"], "MESH"))
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_at_rest(physics, shape, ground, kind):
    """1 %, on a virtual pad flush with a floor of each shape and on a rigid pad on it."""
    if shape == "MESH" and ground == "MESH":
        pytest.skip("the engine never lets an active mesh rest on a mesh")
    # Active meshes hop before they rest, so that the pad is wide.
    physics.frames(40 if shape == "MESH" else 16)
    physics.floor(shape=ground)
    thick = 0.01 if kind else 0.0
    physics.pad(half=(0.5, 0.5, 0.005), kind=kind, at=(0, 0, thick - 0.005))
    lift = MARGIN.get(shape, 0.0)
    if ground == "MESH":
        lift += 0.04 - thick
    shaped(physics, shape, (0.01, 0, thick + lift + 0.1))
    pad = physics.read()
    assert_at_rest(pad, shape)


@pytest.mark.parametrize("margin", [0.01, 0.1])
@pytest.mark.parametrize("kind", [None, "PASSIVE"])
def test_hulls_with_a_margin_of_their_own(physics, kind, margin):
    """They stand off by it, which must not be a silent zero."""
    physics.on_floor(14)
    thick = 0.01 if kind else 0.0
    physics.pad(half=(0.5, 0.5, 0.005), kind=kind, at=(0, 0, thick - 0.005))
    settings = {"shape": "CONVEX_HULL", "use_margin": True, "collision_margin": margin}
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, thick + margin + 0.1), 5.0, **settings)
    assert physics.read().known(after=6) == pytest.approx(5 * G, rel=0.01)


@pytest.mark.slow
def test_two_meshes_and_a_hull_on_a_rough_mesh_floor(physics):
    """A floor of many triangles, not flat: the sum of two pads under a plank is its weight."""
    physics.frames(40)
    points, faces = [], []
    rng = np.random.default_rng(1)
    for i in range(9):
        for j in range(9):
            points.append((i / 4 - 1, j / 4 - 1, rng.uniform(-0.02, 0)))
    for i in range(8):
        for j in range(8):
            a = 9 * i + j
            faces += [(a, a + 9, a + 10), (a, a + 10, a + 1)]
    ground = physics.world.link("ground", physics.world.mesh(points, faces))
    physics.rigid_body(ground, "PASSIVE", shape="MESH")
    for name, x in (("left", -0.5), ("right", 0.5)):
        physics.pad(name, (0.1, 0.2, 0.02), (x, 0, 0.02), "PASSIVE")
    physics.body("plank", (0.7, 0.1, 0.03), (0.1, 0, 0.07), 8.0, shape="CONVEX_HULL")
    read = physics.run()
    left, right = read["left"].known(after=20), read["right"].known(after=20)
    assert left + right == pytest.approx(8 * G, rel=1e-2)
    assert left.mean() == pytest.approx(8 * G * 0.4, rel=0.02)


@pytest.mark.parametrize("mirrored", mostly_slow([False, True], True), ids=["", "mirrored"])
@pytest.mark.parametrize("shape", SHAPES)
def test_scaled_bodies(physics, shape, mirrored):
    """Scaled on the object, evenly for round shapes; mirrored too."""
    physics.on_floor(40 if shape == "MESH" else 16)
    physics.pad(half=(0.6, 0.6, 0.005), kind="PASSIVE")
    even = shape in ("SPHERE", "CAPSULE", "CYLINDER", "CONE")
    scale = np.array((1.5, 1.5, 1.5) if even else (2.0, 0.7, 1.5))
    if mirrored:
        scale[0] *= -1
    lift = MARGIN.get(shape, 0.0)
    shaped(physics, shape, (0, 0, 0.01 + lift + 0.15), scale=scale)
    pad = physics.read()
    assert_at_rest(pad, shape)


@pytest.mark.parametrize(
    "scale",
    mostly_slow(
        [(2, 1, 1), (0.5, 0.5, 3), (-1, 1, 1), (1, 1, -1)], (0.5, 0.5, 3), (1, 1, -1), tuples=False
    ),
)
@pytest.mark.parametrize("kind", [None, "PASSIVE"])
def test_scaled_and_mirrored_pads(physics, kind, scale):
    """A pad that is mirrored upside down still lies under the body; its side is its +Z."""
    physics.frames(10)
    physics.floor(height=0.0 if kind else 0.005 * abs(scale[2]))
    physics.pad(kind=kind, at=(0, 0, 0.005 * abs(scale[2]) if kind else 0), place={"scale": scale})
    top = 0.01 * abs(scale[2]) if kind else 0.005 * abs(scale[2])
    physics.body("box", (0.05, 0.05, 0.05), (0, 0, top + 0.05), 5.0)
    read = physics.read()
    if scale[2] > 0:
        assert read.known() == pytest.approx(5 * G, rel=0.01)
    else:
        read.never_valid("back")


def test_a_parented_scaled_body(physics):
    """Parent and child both scaled and turned; the engine sees the product."""
    physics.on_floor(20)
    physics.pad(half=(0.4, 0.4, 0.005), kind="PASSIVE")
    parent = physics.world.link("parent", None)
    parent.scale, parent.rotation_euler = (2, 2, 2), (0, 0, 0.5)
    obj = physics.solid("box", (0.1, 0.05, 0.05), (0, 0, 0), parent=parent, scale=(0.5, 1, 1))
    obj.location = (0.05, 0, (0.01 + 0.1) / 2)
    physics.world.update()
    physics.rigid_body(obj, mass=5.0)
    assert physics.read().known() == pytest.approx(5 * G, rel=1e-3)


def test_a_pad_parented_to_something_that_is_scaled_and_turned(physics):
    physics.on_floor(10)
    parent = physics.world.link("parent", None)
    parent.scale, parent.rotation_euler = (2, 2, 2), (0, 0, 0.5)
    pad = physics.pad(half=(0.1, 0.1, 0.0025), at=(0, 0, -0.0025))
    pad.parent = parent
    physics.body("box", (0.1, 0.1, 0.1), (0.05, 0.02, 0.1), 5.0)
    found = physics.read()
    assert found.known() == pytest.approx(5 * G, rel=1e-3)
    turn = np.array(((math.cos(0.5), math.sin(0.5)), (-math.sin(0.5), math.cos(0.5))))
    assert found.cop[5] == pytest.approx(turn @ (0.05, 0.02), abs=2e-3)


# Compounds


@pytest.mark.parametrize("mirrored", [False, True], ids=["", "mirrored"])
@pytest.mark.parametrize("scale", mostly_slow([1.0, 1.5], 1.5))
def test_compounds(physics, scale, mirrored):
    """A stool whose three feet are a box, a cylinder and a sphere: it stands in balance."""
    physics.frames(16)
    spots = [(-0.2, -0.15), (0.2, -0.15), (0.0, 0.25)]
    sign = -1.0 if mirrored else 1.0
    physics.floor()
    for number, (x, y) in enumerate(spots):
        at = (sign * x * scale, y * scale, 0.005)
        physics.pad(f"leg {number}", (0.08, 0.08, 0.005), at, "PASSIVE")
    stool = physics.solid("stool", (0.3, 0.3, 0.02), (0, 0, 0.01 + 0.12 * scale))
    stool.scale = (sign * scale, scale, scale)
    physics.rigid_body(stool, mass=6.0, shape="COMPOUND")
    top = physics.solid("top", (0.3, 0.3, 0.02), (0, 0, 0), parent=stool)
    physics.rigid_body(top, shape="BOX")
    feet = [physics.solid("foot", (0.03, 0.03, 0.05), (*spots[0], -0.07), parent=stool)]
    feet.append(physics.round("CYLINDER", (0, 0, 0), 0.03, 0.05))
    feet.append(physics.round("SPHERE", (0, 0, 0), 0.05))
    for foot, spot, shape in zip(feet, spots, ("BOX", "CYLINDER", "SPHERE"), strict=True):
        foot.parent, foot.location = stool, (*spot, -0.07)
        physics.rigid_body(foot, shape=shape)
    read = physics.run()
    found = [read[f"leg {number}"] for number in range(3)]
    total = sum(pad.known(after=8) for pad in found)
    assert total == pytest.approx(6 * G, rel=1e-3)
    for axis in range(2):
        moment = sum(
            pad.known(after=8) * (pad.cop[pad.frames > 8, axis] + spot[axis] * size * scale)
            for pad, spot, size in zip(found, spots, 3 * [(sign, 1)[axis]], strict=True)
        )
        assert moment == pytest.approx(0.0, abs=0.01 * 6 * G * 0.2 * scale)
    # Statics give the sphere's foot 3/8; the other two are up to 0.06 wide.
    assert found[2].known(after=8) == pytest.approx(6 * G * 3 / 8, rel=0.1)


def test_a_chosen_part_of_a_compound_is_its_body(physics):
    physics.on_floor(8)
    pad = physics.pad(kind="PASSIVE", half=(0.3, 0.3, 0.005))
    parts = [((0.2, 0.2, 0.02), (0, 0, 0)), ((0.02, 0.2, 0.1), (0, 0, -0.12))]
    physics.compound("stool", parts, (0, 0, 0.23), 6.0)
    pad.angen_sensor.pressure.partner_object = physics.bpy.data.objects["stool 1"]
    assert physics.read().known() == pytest.approx(6 * G, rel=1e-3)


# Instances


def test_instanced_collections(physics):
    """A person in a collection that an empty instances twice stands on two plates."""
    physics.frames(6)
    bpy = physics.bpy
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    group = bpy.data.collections.new("people")
    person = physics.carried("Person", (0.15, 0.1, 0.85), (0, 0, 0.85), 70.0)
    physics.scene.collection.objects.unlink(person)
    group.objects.link(person)
    for x in (-1.0, 1.0):
        physics.pad(f"plate {x:g}", (0.3, 0.3, 0.005), (x, 0, 0.005))
        empty = physics.world.link("instance", None, (x, 0, 0.01))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
    physics.pad("nobody", (0.3, 0.3, 0.005), (0, 0, 0.005))
    read = physics.run()
    for name in ("plate -1", "plate 1"):
        assert read[name].known() == pytest.approx(70 * G, rel=1e-3)
    assert read["nobody"].known() == pytest.approx(0.0, abs=1e-9)


def test_instanced_furniture_is_stood_on(physics):
    """A stool that exists as an instance only holds the sitter up: nothing hovers."""
    physics.frames(6)
    bpy = physics.bpy
    physics.pad("plate", (0.3, 0.3, 0.005), (0, 0, 0.005))
    group = bpy.data.collections.new("furniture")
    stool = physics.solid("stool", (0.2, 0.2, 0.2), (0, 0, 0.21))
    physics.scene.collection.objects.unlink(stool)
    group.objects.link(stool)
    stool.angen_load.mass = 5.0
    empty = physics.world.link("instance", None, (0, 0, 0))
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    physics.carried("Person", (0.15, 0.1, 0.4), (0, 0, 0.81), 70.0)
    assert physics.read("plate").known() == pytest.approx(75 * G, rel=1e-3)


def test_meshes_made_by_modifiers(physics):
    """The evaluated mesh counts: the hull of an array of three, off its origin."""
    physics.on_floor(20)
    physics.pad("left", (0.1, 0.2, 0.005), (-0.2, 0, 0.005), "PASSIVE")
    physics.pad("right", (0.1, 0.2, 0.005), (0.2, 0, 0.005), "PASSIVE")
    plank = physics.solid("plank", (0.1, 0.1, 0.02), (-0.2, 0, 0.03))
    array = plank.modifiers.new("array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (1, 0, 0)
    physics.rigid_body(plank, mass=5.0, shape="CONVEX_HULL")
    read = physics.run()
    # The engine's centre of mass is the object's origin, in the left part.
    left, right = read["left"], read["right"]
    assert left.known(after=4) + right.known(after=4) == pytest.approx(5 * G, rel=1e-3)
    assert right.force.min() > 0.01 * 5 * G, "it reaches there"
    late = left.frames > 4
    moment = left.force * (left.cop[:, 0] - 0.2) + right.force * (right.cop[:, 0] + 0.2)
    assert moment[late] / (5 * G) == pytest.approx(-0.2, abs=2e-3)
