# SPDX-License-Identifier: GPL-3.0-or-later
"""Floors carry people, thin pads carry the objects on them, and unexplained weights are errors.

A weight without a contact makes a reading invalid, with the reason and a way out.
"""

import bpy
import numpy as np
import pytest
from pressure_scenes import G, shares
from tiers import mostly_slow

SUM, SHARE = 1e-3, 0.03
SHOES = [((0.05, 0.13, 0.05), (x, 0, 0.05)) for x in (-0.15, 0.15)]
BODY = ((0.2, 0.1, 0.5), (0, 0, 0.6))


def plane(physics, name="floor", size=20.0, z=0.0):
    h = size / 2
    corners = [(-h, -h, z), (h, -h, z), (h, h, z), (-h, h, z)]
    return physics.world.link(name, physics.world.mesh(corners, [(0, 1, 2, 3)]))


def room(physics):
    """Add floor, walls and ceiling as one mesh without thickness."""
    obj = physics.solid("room", (10, 10, 1.25), (0, 0, 1.25))
    obj.data.flip_normals()
    return obj


def finish(physics):
    """Add a millimetre of vinyl on a slab."""
    physics.solid("slab", (10, 10, 0.15), (0, 0, -0.151))
    return physics.solid("finish", (10, 10, 0.0005), (0, 0, -0.0005))


def walls(physics):
    """Add a thin floor with walls, and a step beside it, as one mesh."""
    parts = [((10, 10, 0.001), (0, 0, -0.001)), ((10, 0.05, 1.2), (0, 10, 1.2))]
    return physics.solid("shell", (), parts=[*parts, ((1, 1, 0.1), (3, 3, 0.1))])


def slab(physics):
    return physics.solid("slab", (10, 10, 0.15), (0, 0, -0.15))


FLOORS = [plane, room, finish, walls, slab]


def person(physics, at=(0, 0, 0), name="Person"):
    return physics.carried(name, (), at, 70.0, parts=[*SHOES, BODY])


@pytest.mark.parametrize("passive", mostly_slow([None, "BOX", "CONVEX_HULL", "MESH"], None, "MESH"))
@pytest.mark.parametrize("floor", FLOORS, ids=lambda f: f.__name__)
def test_people_on_a_floor_spoil_no_pad(physics, floor, passive):
    """A crate's pad is valid beside one person, and another half on a mat 6 m away.

    The engine keeps a crate off a mesh by a margin of 4 cm.
    """
    physics.frames(8)
    ground = floor(physics)
    if passive and not (floor in (room, walls) and passive != "MESH"):
        physics.rigid_body(ground, "PASSIVE", shape=passive)
    physics.pad(kind="PASSIVE")
    physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.14 if passive == "MESH" else 0.11), 5.0)
    physics.solid("mat", (0.4, 0.4, 0.004), (6.4, 0, 0.004))
    person(physics, (0.5, 0, 0), "Beside")
    person(physics, (6.0, 0, 0), "Half")
    pad = physics.read()
    assert pad.known(after=2) == pytest.approx(5 * G, rel=SUM)
    assert set(pad.partners) == {"crate"}


@pytest.mark.parametrize("thick", mostly_slow([0.0002, 0.00045, 0.005, 0.02], 0.00045, 0.02))
@pytest.mark.parametrize("floor", FLOORS, ids=lambda f: f.__name__)
def test_one_foot_on_a_pad_on_any_floor(physics, floor, thick):
    physics.frames(6)
    floor(physics)
    physics.pad(half=(0.14, 0.3, thick / 2), at=(0.15, 0, thick / 2))
    person(physics)
    assert physics.read().known() == pytest.approx(35 * G, rel=0.3 if thick > 0.01 else SHARE)


@pytest.mark.parametrize("floor", FLOORS, ids=lambda f: f.__name__)
def test_a_pad_let_into_the_floor(physics, floor):
    """The pad is flush with the floor; a person stands on a step of the same mesh."""
    physics.frames(6)
    floor(physics)
    physics.pad(half=(0.2, 0.2, 0.004), at=(0, 0, -0.004))
    person(physics, (3, 3, 0.2 if floor is walls else 0.0))
    assert physics.read().known() == pytest.approx(0.0, abs=1e-9)


COVERS = {
    "rug": lambda p: p.solid("cover", (1, 1, 0.005), (0, 0, 0.015)),
    "mattress": lambda p: p.solid("cover", (1, 0.5, 0.1), (0, 0, 0.11)),
    "seat": lambda p: p.solid("cover", (0.2, 0.2, 0.02), (0, 0, 0.03)),
    "in a mattress": lambda p: p.solid("cover", (1, 0.5, 0.07), (0, 0, 0.04)),
}


@pytest.mark.parametrize("kind", [None, "PASSIVE"])
@pytest.mark.parametrize("cover", COVERS)
@pytest.mark.parametrize("floor", [plane, slab], ids=lambda f: f.__name__)
def test_what_lies_on_the_pad_without_a_mass(physics, floor, cover, kind):
    """It passes on the weight of the person on it, and a mass of its own is added."""
    physics.frames(6)
    floor(physics)
    physics.pad(kind=kind)
    lid = COVERS[cover](physics)
    top = lid.location.z + max(v.co.z for v in lid.data.vertices)
    physics.carried("Person", (0.1, 0.1, 0.4), (0, 0, top + 0.4), 70.0)
    pad = physics.read()
    assert pad.known() == pytest.approx(70 * G, rel=SUM)
    assert set(pad.partners) == {"Person"}
    if cover != "in a mattress":
        lid.angen_load.mass, lid.angen_load.tolerance = 2.0, 0.001
        assert physics.read().known() == pytest.approx(72 * G, rel=SUM)


def test_a_carpet_over_a_pad_is_stood_on_elsewhere(physics):
    """It lies on the floor around the pad, which is under it."""
    physics.frames(6)
    slab(physics)
    physics.pad(half=(0.15, 0.15, 0.001))
    physics.solid("carpet", (3, 3, 0.005), (0, 0, 0.005))
    someone = person(physics, (2, 0, 0.01))
    assert physics.read().known() == pytest.approx(0.0, abs=1e-9)
    someone.location.x = 0.15
    assert physics.read().known() == pytest.approx(35 * G, rel=SUM)


def test_a_bed_of_layers(physics):
    """A duvet without thickness hovers over a mattress, below which are a pad and a slatted frame.

    The person lies on the duvet, with half of the body beyond the pad.
    """
    physics.frames(6)
    slab(physics)
    physics.solid("slats", (1, 0.5, 0.01), (0, 0, 0.29))
    physics.pad(half=(0.5, 0.5, 0.005), at=(0.5, 0, 0.305))
    physics.solid("mattress", (1, 0.5, 0.1), (0, 0, 0.41))
    physics.world.link("duvet", physics.mesh([((0.8, 0.5, 0), (0, 0, 0))]), (0, 0, 0.55))
    physics.carried("Person", (0.6, 0.2, 0.1), (0, 0, 0.66), 70.0)
    assert physics.read().known() == pytest.approx(35 * G, rel=SUM)


def test_a_blanket_on_a_cushion(physics):
    """The blanket has no mass, the cushion below it has one, and lies on the pad."""
    physics.frames(6)
    slab(physics)
    physics.pad()
    physics.carried("cushion", (0.2, 0.2, 0.05), (0, 0, 0.06), 2.0, tolerance=0.005)
    physics.solid("blanket", (0.4, 0.4, 0.002), (0, 0, 0.112))
    physics.carried("Person", (0.1, 0.1, 0.4), (0, 0, 0.514), 70.0)
    assert physics.read().known() == pytest.approx(72 * G, rel=SUM)


def test_a_chair_without_a_mass_whose_legs_stand_on_the_pad(physics):
    """What passes weights straight down has no way through its legs: an error, with the way out."""
    physics.frames(6)
    slab(physics)
    physics.pad(half=(0.5, 0.5, 0.005), at=(0, 0, 0.005))
    legs = [((0.02, 0.02, 0.2), (x, y, -0.22)) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    parts = [((0.22, 0.22, 0.02), (0, 0, 0)), *legs]
    chair = physics.solid("chair", (), (0, 0, 0.43), parts=parts)
    physics.carried("Person", (0.15, 0.15, 0.4), (0, 0, 0.85), 70.0)
    physics.read().never_valid("'Person' stands on 'chair'", "no mass")
    chair.angen_load.mass = 5.0
    assert physics.read().known() == pytest.approx(75 * G, rel=SUM)


@pytest.mark.parametrize("shape", mostly_slow(["BOX", "CONVEX_HULL", "CYLINDER"], "BOX"))
@pytest.mark.parametrize("flipped", [True, False], ids=["inwards", "outwards"])
def test_a_room_that_is_one_mesh_is_hollow(physics, flipped, shape):
    """A plank has one end on a pad, the other on the room's floor.

    The pad's edge is at −0.3, the plank's at 0.5. The engine keeps it 4 cm off the room.
    """
    physics.frames(60)
    shell = room(physics)
    if not flipped:
        shell.data.flip_normals()
    physics.rigid_body(shell, "PASSIVE", shape="MESH")
    physics.pad(half=(0.1, 0.3, 0.01), at=(-0.4, 0, 0.01), kind="PASSIVE")
    physics.body("plank", (0.5, 0.1, 0.05), (0, 0, 0.12), 6.0, shape=shape)
    pad = physics.read()
    assert pad.valid[-12:].all(), pad.problems
    assert pad.force[-12:] == pytest.approx(6 * G * 0.5 / 0.8, rel=0.005)


# Pads thinner than any other object in the scene, under objects larger than they are


MARGIN = 0.04  # of a mesh, which the engine keeps others off
EXACT = 1e-3
PLACES = [(0, 0, 0), (3.3, -7.7, 2.5), (40.7, 12.3, 28.2), (1000.3, -700.7, 5.1)]


def box_on_pad(physics, thick, half=0.3, kind="PASSIVE", floor="BOX", at=(0, 0, 0)):
    """Add 5 kg on a pad of 0.2 × 0.2 m, a little aside, on a floor."""
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
    """A hundredth of a millimetre is neither level with the floor nor above it: an error."""
    box_on_pad(physics, thick)
    physics.read().never_valid("'pad' and 'floor' differ in height by", "'box'", after=0)


def test_level_with_the_floor_it_carries_its_share_of_the_area(physics):
    physics.on_floor(8)
    physics.pad(half=(0.1, 0.1, 0.005), at=(0, 0, -0.005))
    physics.body("box", (0.3, 0.3, 0.1), (0, 0, 0.1), 9.0)
    assert physics.read().known() == pytest.approx(1 * G, rel=0.02)


def test_a_box_that_leans_over_the_pads_edge(physics):
    """Its centre is beside the pad: it tips, and its far edge stands on the floor."""
    physics.on_floor(40)
    physics.pad(half=(0.1, 0.3, 0.00225), at=(-0.25, 0, 0.00225), kind="PASSIVE")
    physics.body("box", (0.3, 0.3, 0.1), (0, 0, 0.1045), 6.0)
    # The pad's inner edge at −0.15, the box's at 0.3.
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
    """Chair and sitter are not simulated; the other legs stand on the floor."""
    physics.frames(4)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad("fsr", (0.009, 0.009, 0.000225), (0.2, 0.2, 0.000225))
    spots = [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)]
    legs = [((0.02, 0.02, 0.21), (x, y, -0.23)) for x, y in spots]
    parts = [((0.22, 0.22, 0.02), (0, 0, 0)), *legs]
    physics.carried("chair", (), (0, 0, 0.44), 6.0, parts=parts)
    physics.carried("Person", (0.15, 0.15, 0.2), (0, 0, 0.66), 70.0)
    assert physics.read("fsr").known() == pytest.approx(76 * G / 4, rel=0.05)


# Weights without a contact


@pytest.fixture
def crate(physics):
    """Add 5 kg on a pad."""
    physics.on_floor(8)
    physics.pad(kind="PASSIVE")
    return physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)


IDLE = {
    "animated": (
        lambda physics, crate: setattr(crate.rigid_body, "kinematic", True),
        "it is Animated: untick",
    ),
    "not dynamic": (
        lambda physics, crate: setattr(crate.rigid_body, "enabled", False),
        "it is not Dynamic: tick",
    ),
    "world off": (
        lambda physics, crate: setattr(physics.rigid, "enabled", False),
        "the rigid-body world is off: switch it on",
    ),
}


@pytest.mark.parametrize(("spoil", "words"), IDLE.values(), ids=IDLE)
def test_an_active_body_that_physics_does_not_move(physics, crate, spoil, words):
    spoil(physics, crate)
    physics.read().never_valid("'crate'", words, "Weight on Sensors")
    crate.angen_load.mass = 5.0
    assert physics.read().known() == pytest.approx(5.0 * G, abs=1e-4)


def test_in_an_instance_it_is_named_too(physics, crate):
    made = physics.world.aside("furniture", crate)
    physics.world.instance("holder", made)
    physics.read().never_valid("'crate'", "instances")


def test_animated_on_top_of_a_simulated_one(physics, crate):
    top = physics.body("top", (0.1, 0.1, 0.1), (0, 0, 0.31), 2.0, kinematic=True)
    physics.read().never_valid("'top'", "it is Animated")
    top.rigid_body.type = "PASSIVE"
    assert physics.read().known() == pytest.approx(5.0 * G, abs=1e-4)


def test_until_it_is_let_go(physics, crate):
    keys = {1: True, 5: False}
    physics.world.key(crate, "rigid_body.kinematic", keys, "CONSTANT")
    crate.keyframe_insert("location", frame=1)
    found = physics.read()
    assert not found.valid[:4].any() and "it is Animated" in found.problem[2]
    assert found.known(after=6) == pytest.approx(5.0 * G, abs=1e-4)


def test_what_is_elsewhere_does_not_matter(physics, crate):
    for name, at in (("beside", (0.5, 0, 0.1)), ("above", (0, 0, 1.5))):
        physics.body(name, (0.1, 0.1, 0.1), at, 2.0, kinematic=True)
    assert physics.read().known() == pytest.approx(5.0 * G, abs=1e-4)


@pytest.fixture
def wind(physics, crate):
    bpy.ops.object.effector_add(type="WIND", location=(0, 0, 2), rotation=(3.1416, 0, 0))
    field = bpy.context.object
    field.name, field.field.strength = "Draught", 100.0
    return field


def test_a_force_field_that_pushes_a_body(physics, wind):
    physics.read().never_valid("force field 'Draught' may push 'crate'", "Field Weights")


CALM = {
    "no weight": lambda physics, wind: setattr(physics.rigid.effector_weights, "wind", 0.0),
    "other collection": lambda physics, wind: setattr(
        physics.rigid.effector_weights, "collection", bpy.data.collections.new("fields")
    ),
    "disabled": lambda physics, wind: setattr(wind, "hide_viewport", True),
    "no strength": lambda physics, wind: setattr(wind.field, "strength", 0.0),
}


@pytest.mark.parametrize("calm", CALM.values(), ids=CALM)
def test_a_force_field_that_pushes_nothing(physics, wind, calm):
    calm(physics, wind)
    assert physics.read().known() == pytest.approx(5.0 * G, abs=1e-4)


@pytest.mark.parametrize("drop", [0.041, 0.1, 0.2])
def test_an_active_mesh_that_hops_at_its_margin(physics, drop):
    """98.1 N, held 3 cm above the pad; invalid where it hops, as in Blender 4.5."""
    physics.on_floor(60)
    physics.pad(half=(0.5, 0.5, 0.005), kind="PASSIVE")
    physics.body("crate", (0.1, 0.1, 0.1), (0, 0, 0.11 + drop), 10.0, shape="MESH")
    found = physics.read()
    late = found.frames > 10
    assert found.force[late & found.valid] == pytest.approx(10.0 * G, rel=0.025)
    assert (late & found.valid).sum() > 10
    why = set(np.array(found.problem)[late & ~found.valid])
    assert all(
        "collision margin of 40 mm keeps the active mesh 'crate' off" in one or "explain" in one
        for one in why
    )
