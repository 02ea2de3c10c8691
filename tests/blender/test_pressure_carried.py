# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated, not simulated, bodies with a mass: people who sit, stand, walk and lie."""

import math
from typing import Any

import bpy
import numpy as np
import pytest
from pressure_scenes import G, shares

FEET = [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)]
SUM, SHARE = 1e-3, 0.03
CHAIR = [((0.22, 0.22, 0.02), (0, 0, 0))]
CHAIR += [((0.02, 0.02, 0.21), (x, y, -0.23)) for x, y in FEET]
SEAT = 0.01 + 2 * 0.21 + 0.04


def chair_on_pads(physics, simulated, mass=6.0):
    """Add a chair on four pads, its seat SEAT high; return the names of the pads."""
    physics.floor()
    names = [f"leg {number}" for number in range(4)]
    for name, (x, y) in zip(names, FEET, strict=True):
        physics.pad(name, (0.04, 0.04, 0.005), (x, y, 0.005), "PASSIVE")
    at = (0, 0, SEAT - 0.02)
    if simulated:
        physics.compound("chair", CHAIR, at, mass)
    else:
        physics.carried("chair", (), at, mass, parts=CHAIR)
    return names


@pytest.mark.parametrize("simulated", [True, False], ids=["rigid chair", "animated chair"])
@pytest.mark.parametrize("at", [(0, 0), (0.05, 0.03)], ids=["middle", "to a side"])
@pytest.mark.parametrize("sunk", [0.005, 0.05, 0.0, -0.02], ids=lambda s: f"sunk {s}")
def test_a_sitter_on_a_chair(physics, simulated, at, sunk):
    physics.frames(6)
    names = chair_on_pads(physics, simulated)
    physics.carried("Person", (0.15, 0.15, 0.2), (*at, SEAT + 0.2 - sunk), 70.0)
    read = physics.run()
    found = np.array([read[name].known(after=2) for name in names])
    assert found.sum(axis=0) == pytest.approx(76 * G, rel=SUM)
    exact = 6 * G / 4 + shares(at, 70 * G, FEET)
    for force, wanted in zip(found, exact, strict=True):
        assert force == pytest.approx(wanted, rel=SHARE)


def test_a_sitter_on_a_table_that_is_no_body_reaches_only_the_seat(physics):
    """Furniture without physics and without a mass carries the weight itself, and hands none on."""
    physics.frames(6)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad("leg", (0.04, 0.04, 0.005), (0.2, 0.2, 0.005))
    physics.solid("chair", (), (0, 0, SEAT - 0.02), parts=CHAIR)
    physics.pad("seat", (0.2, 0.2, 0.002), (0, 0, SEAT + 0.002))
    physics.carried("Person", (0.15, 0.15, 0.2), (0, 0, SEAT + 0.2), 70.0)
    read = physics.run()
    assert read["leg"].known() == pytest.approx(0.0, abs=1e-9)
    assert read["seat"].known() == pytest.approx(70 * G, rel=SUM)
    assert set(read["seat"].partners) == {"Person"}


@pytest.mark.parametrize("kind", [None, "PASSIVE"])
@pytest.mark.parametrize("fps", [12, 24, 120])
def test_standing_on_a_plate(physics, fps, kind):
    physics.frames(6, fps)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad("plate", (0.3, 0.3, 0.005), kind=kind)
    physics.carried("Person", (0.15, 0.1, 0.85), (0.05, -0.04, 0.86), 70.0)
    plate = physics.read("plate")
    assert plate.known() == pytest.approx(70 * G, rel=SUM)
    assert plate.cop[3] == pytest.approx((0.05, -0.04), abs=2e-3)


def new_shape(person, name):
    """Add a shape key like the basis, off (from Blender 5.2 on, a new one is on)."""
    block = person.shape_key_add(name=name, from_mix=False)
    block.value = 0.0
    return block


def walker(physics, speed=1.0, mass=70.0, last=48):
    """Add a person of boxes who walks along x.

    One shoe stands while the other swings, which is keyed on shape keys of one deformed mesh.
    """
    fps = physics.scene.render.fps
    step = fps // 2
    shoes = [((0.13, 0.05, 0.04), (0, y, 0.04)) for y in (-0.1, 0.1)]
    person = physics.carried(
        "Person", (), (0, 0, 0), mass, parts=[*shoes, ((0.1, 0.15, 0.4), (0, 0, 0.9))]
    )
    new_shape(person, "Basis")
    for number, name in enumerate(("left", "right")):
        block = new_shape(person, name)
        lift = new_shape(person, name + " up")
        block.slider_min, block.slider_max = -10.0, 10.0
        for vertex in range(8 * number, 8 * number + 8):
            block.data[vertex].co.x += 1.0
            lift.data[vertex].co.z += 0.1
    keys = person.data.shape_keys.key_blocks
    body = new_shape(person, "body")
    body.slider_min, body.slider_max = -10.0, 10.0
    for vertex in range(16, 24):
        body.data[vertex].co.x += 1.0
    stride = speed * step / fps
    spots = {"left": -1.5, "right": -1.5}
    for frame in range(1, last + 2):
        number, part = divmod(frame - 1, step)
        swings, stands = ("left", "right") if number % 2 else ("right", "left")
        share = part / step
        if part == 0 and frame > 1:
            spots[stands] += 2 * stride if number > 1 else stride
        reach = 2 * stride if number > 0 else stride
        places = {stands: spots[stands], swings: spots[swings] + reach * share}
        for name in ("left", "right"):
            keys[name].value = places[name]
            keys[name + " up"].value = math.sin(math.pi * share) if name == swings else 0.0
            keys[name].keyframe_insert("value", frame=frame)
            keys[name + " up"].keyframe_insert("value", frame=frame)
        body.value = -1.5 + speed * (frame - 1) / fps
        body.keyframe_insert("value", frame=frame)
    return person


def test_walking_across_a_plate(physics):
    """Feet alternate, and plates side by side carry the weight of the walk together.

    Each plate reads it only while a foot is on it, without spikes as feet come and go.
    """
    physics.frames(60)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    names = []
    for number in range(4):
        names.append(f"plate {number}")
        physics.pad(names[-1], (0.25, 0.5, 0.0005), (-1.25 + 0.5 * number, 0, 0.0005))
    physics.pad("far", (0.25, 0.5, 0.0005), (3, 0, 0.0005))
    walker(physics, last=60)
    read = physics.run()
    assert read["far"].known() == pytest.approx(0.0, abs=1e-9)
    found = np.array([read[name].known() for name in names])
    assert found.max() < 1.5 * 70 * G
    # On these plates from frame 8 until the walker leaves them.
    assert found.sum(axis=0)[:30].mean() == pytest.approx(70 * G, rel=0.03)
    for force in found:
        assert (force > 300).any(), "each was walked on"
        assert (force < 1).any(), "and left"


def test_lying_on_a_bed_with_two_pads(physics):
    """Head and foot of the mattress on a pad each: the weight is below the body."""
    physics.frames(6)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    for name, x in (("head", -0.8), ("foot", 0.8)):
        physics.pad(name, (0.05, 0.4, 0.005), (x, 0, 0.005))
    legs = [((0.03, 0.35, 0.1), (x, 0, -0.2)) for x in (-0.8, 0.8)]
    physics.carried("bed", (), (0, 0, 0.31), 20.0, parts=[((1.0, 0.45, 0.1), (0, 0, 0)), *legs])
    physics.pad("sheet", (1.0, 0.45, 0.001), (0, 0, 0.411))
    physics.carried("Person", (0.5, 0.2, 0.1), (-0.2, 0, 0.51), 70.0)
    read = physics.run()
    assert read["sheet"].known() == pytest.approx(70 * G, rel=SUM)
    assert read["sheet"].cop[3] == pytest.approx((-0.2, 0.0), abs=0.01)
    head, foot = read["head"].known(), read["foot"].known()
    assert head + foot == pytest.approx(90 * G, rel=SUM)
    assert head == pytest.approx(10 * G + 70 * G * (0.5 + 0.2 / 1.6), rel=SHARE)


def test_an_armature_with_a_deformed_mesh(physics):
    """The armature has the mass, its mesh the contacts: it bends, sits down and gets up."""
    physics.frames(30)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.solid("stool", (0.2, 0.2, 0.2), (0, 0, 0.2))
    physics.pad("seat", (0.2, 0.2, 0.001), (0, 0, 0.401))
    rig = physics.world.rig("hips", (0, 0, 0.5))
    parts = [
        ((0.15, 0.15, 0.3), (0, 0, 0.3)),
        *(((0.04, 0.1, 0.2), (0.4, y, 0.0)) for y in (-0.12, 0.12)),
    ]
    mesh = physics.solid("body", (), parts=parts, parent=rig)
    group = mesh.vertex_groups.new(name="hips")
    group.add(list(range(24)), 1.0, "REPLACE")
    mesh.modifiers.new("rig", "ARMATURE").object = rig
    rig.angen_load.mass = 70.0
    rig.location = (0.0, 0, 0.402)
    pose = rig.pose.bones["hips"]
    # The bone's y is the world's z: seated, up on the feet 0.35 m before the stool, seated.
    for frame, y in ((1, 0.0), (10, 0.0), (14, 0.6), (20, 0.6), (24, 0.0)):
        pose.location = (0, y, 0)
        pose.keyframe_insert("location", frame=frame)
    physics.solid("step", (0.2, 0.4, 0.1), (0.4, 0, 0.101))
    seat = physics.read("seat")
    seated = (seat.frames > 1) & (seat.frames < 9)
    assert seat.valid[seated].all(), seat.problems
    assert 0 < seat.force[seated].max() < 71 * G
    assert set(np.array(seat.partners)[seated]) == {"rig"}
    up = (seat.frames > 15) & (seat.frames < 19)
    assert not seat.valid[up].any(), "nothing holds it up there"
    assert seat.valid[-4:].all()
    assert seat.force[-4:] == pytest.approx(seat.force[4], rel=1e-3)


def test_mass_of_a_parent_object(physics):
    physics.frames(6)
    physics.pad("plate", (0.3, 0.3, 0.005), kind="PASSIVE")
    root = physics.world.link("root", None)
    root.angen_load.mass = 50.0
    body = physics.solid("body", (0.1, 0.1, 0.5), (0, 0, 0.51), parent=root)
    physics.solid("hat", (0.1, 0.1, 0.05), (0, 0, 0.55), parent=body)
    plate = physics.read("plate")
    assert plate.known() == pytest.approx(50 * G, rel=SUM)
    assert set(plate.partners) == {"root"}


def test_a_carried_body_on_another_on_a_rigid_one(physics):
    """The weight is handed down through all of them."""
    physics.on_floor(10)
    physics.pad("plate", (0.3, 0.3, 0.005), kind="PASSIVE")
    physics.body("crate", (0.2, 0.2, 0.1), (0, 0, 0.11), 8.0)
    physics.carried("cushion", (0.2, 0.2, 0.05), (0, 0, 0.26), 2.0)
    physics.carried("cat", (0.1, 0.05, 0.1), (0, 0, 0.40), 4.0)
    assert physics.read("plate").known(after=2) == pytest.approx(14 * G, rel=SUM)


# Unknown forces


@pytest.mark.parametrize("height", [0.05, 0.5])
def test_hovering_is_not_a_silent_zero(physics, figure, height):
    physics.frames(6)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad("plate", (0.3, 0.3, 0.005))
    physics.carried("Person", (0.15, 0.1, 0.85), (0, 0, 0.86 + height), 70.0)
    plate = physics.read("plate")
    figure(plate.valid.sum(), "valid updates")
    plate.never_valid("nothing supports", "Person", after=0)


def test_the_tolerance_is_the_users(physics):
    """Four centimetres above: held with 5 cm of tolerance, not with 3."""
    physics.frames(6)
    physics.pad("plate", (0.3, 0.3, 0.005), kind="PASSIVE")
    person = physics.carried("Person", (0.15, 0.1, 0.85), (0, 0, 0.90), 70.0, tolerance=0.05)
    assert physics.read("plate").known() == pytest.approx(70 * G, rel=SUM)
    person.angen_load.tolerance = 0.03
    physics.read("plate").never_valid("nothing supports", "Person")


def test_someone_who_stands_elsewhere_is_no_problem(physics):
    physics.frames(6)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.pad("plate", (0.3, 0.3, 0.005))
    physics.carried("Person", (0.15, 0.1, 0.85), (0.6, 0, 0.85), 70.0)
    assert physics.read("plate").known() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("far", [1.0, 30.0])
def test_a_teleport_is_no_spike(physics, figure, far):
    """From the plate to far away and back, in a frame each, without an impact."""
    physics.frames(40)
    physics.solid("floor", (50, 50, 0.5), (0, 0, -0.5))
    physics.pad("plate", (0.3, 0.3, 0.005))
    person = physics.carried("Person", (0.15, 0.1, 0.85), (0, 0, 0.86), 70.0)
    places = {1: (0, 0, 0.86), 15: (far, 0, 0.86), 28: (0, 0, 0.86)}
    physics.world.key(person, "location", places, "CONSTANT")
    plate = physics.read("plate")
    figure(plate.force.max() / (70 * G) - 1, "of the weight above it")
    assert plate.force.max() < 70 * G * 1.01
    here = (plate.frames < 15) | (plate.frames >= 28)
    assert plate.force[plate.valid & here] == pytest.approx(70 * G, rel=SUM)
    assert plate.force[plate.valid & ~here] == pytest.approx(0.0, abs=1e-6)
    assert plate.valid.sum() > 33
    assert not plate.valid[plate.frames == 14].any() and not plate.valid[plate.frames == 28].any()


def test_crouching_changes_the_weight_for_a_moment(physics):
    """The centre of mass goes down and up: m(g + a), and the weight on average."""
    physics.frames(48)
    physics.pad("plate", (0.4, 0.4, 0.005), kind="PASSIVE")
    shoe, body = ((0.15, 0.13, 0.02), (0, 0, 0.02)), ((0.15, 0.1, 0.5), (0, 0, 0.6))
    person = physics.carried("Person", (), (0, 0, 0.01), 70.0, parts=[shoe, body])
    new_shape(person, "Basis")
    down = new_shape(person, "down")
    for vertex in range(8, 16):
        down.data[vertex].co.z -= 0.2
    for frame in range(1, 50):
        down.value = 0.5 * (1 - math.cos(2 * math.pi * (frame - 1) / 24))
        down.keyframe_insert("value", frame=frame)
    force = physics.read("plate").known()
    share = body[0][0] * body[0][1] * body[0][2]
    share /= share + shoe[0][0] * shoe[0][1] * shoe[0][2]
    swing = 70 * share * 0.1 * (2 * math.pi) ** 2
    exact = 70 * G - swing * np.cos(2 * math.pi * np.arange(1, 48) / 24)
    assert force == pytest.approx(exact, rel=0.02)


def test_partner_of_a_carried_person_may_be_its_armature_or_its_mesh(physics):
    physics.frames(6)
    plate = physics.pad("plate", (0.5, 0.3, 0.005), kind="PASSIVE")
    root = physics.world.link("root", None)
    root.angen_load.mass = 50.0
    body = physics.solid("body", (0.1, 0.1, 0.5), (-0.2, 0, 0.51), parent=root)
    physics.carried("other", (0.1, 0.1, 0.5), (0.2, 0, 0.51), 20.0)
    for chosen in (root, body):
        plate.angen_sensor.pressure.partner_object = chosen
        assert physics.read("plate").known() == pytest.approx(50 * G, rel=SUM)


# A person on a sofa's cushion, which lies on a pad, with the feet on the floor


MASS, CUSHION, TOLERANCE = 70.0, 2.5, 0.03
TOP = 0.47  # of the cushion, in m
# Estimated by eye: how deep the seat is in the cushion, and the shoes in the floor, in m.
SEAT_SUNK, SHOES_SUNK = 0.02, 0.01
SITTER = ((0.17, 0.225, 0.07), (0, 0.235, TOP - SEAT_SUNK + 0.07))
SHOES = [((0.05, 0.13, 0.04), (x, -0.2, 0.04 - SHOES_SUNK)) for x in (-0.1, 0.1)]
SHINS = [((0.05, 0.05, 0.17), (x, -0.15, 0.25)) for x in (-0.1, 0.1)]


def person_of(trunk):
    """Return half sizes and centres of boxes; the sofa's back is at +y, the trunk at `trunk`."""
    return [SITTER, ((0.17, 0.11, 0.3), (0, trunk, 0.89)), *SHINS, *SHOES]


PAD, LYING = ((0.31, 0.26, 0.006), (0, 0.385, 0.306)), ((0.385, 0.345, 0.079), (0, 0.35, 0.391))


def sofa(physics):
    """Add the sofa of the sample home: a pad on a frame, and a cushion of 2.5 kg on the pad."""
    physics.frames(4)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.solid("frame", (0.9, 0.4, 0.1), (0, 0.4, 0.2))
    physics.pad(half=PAD[0], at=PAD[1])
    physics.carried("cushion", *LYING, CUSHION, tolerance=0.005)


def layer(boxes, sunk):
    """Return the first moments (3,) over y of an elastic layer below boxes, pressed in as posed."""
    found = np.zeros(3)
    for half, (_, y, _) in boxes:
        stiff = 4.0 * half[0] * half[1] * (1.0 + sunk / TOLERANCE)
        found += stiff * np.array([1.0, y, y**2 + half[1] ** 2 / 3.0])
    return found


def on_seat(person):
    """Return the part of the person's weight on the seat, in N.

    Person and cushion sink by p + q·y and r + s·y into the layers below shoes, seat and cushion,
    until forces and moments are in balance.
    """
    volumes = np.array([8.0 * np.prod(half) for half, _ in person])
    centre = volumes @ np.array([middle[1] for _, middle in person]) / volumes.sum()
    shoes, seat, pad = (
        np.array([[k, ky], [ky, kyy]])
        for k, ky, kyy in (layer(SHOES, SHOES_SUNK), layer([SITTER], SEAT_SUNK), layer([PAD], 0.0))
    )
    weights = G * np.array([MASS, MASS * centre, CUSHION, CUSHION * LYING[1][1]])
    person_down, cushion_down = np.linalg.solve(
        np.block([[shoes + seat, -seat], [-seat, seat + pad]]), weights
    ).reshape(2, 2)
    for (half, (_, y, _)), down in (
        (SHOES[0], person_down), (SITTER, person_down - cushion_down), (PAD, cushion_down),
    ):  # fmt: skip
        assert min(down @ [1.0, y - half[1]], down @ [1.0, y + half[1]]) > 0, "all of it is pressed"
    return float((seat @ (person_down - cushion_down))[0])


@pytest.mark.parametrize("trunk", [0.2, 0.17, 0.14], ids=["back", "upright", "forward"])
def test_the_pad_under_a_seat_and_the_feet_on_the_floor(physics, figure, trunk):
    person = person_of(trunk)
    sofa(physics)
    physics.carried("Person", (), (0, 0, 0), MASS, TOLERANCE, parts=person)
    wanted = on_seat(person)
    pad = physics.read()
    figure(wanted / (MASS * G), "of the weight is on the seat")
    assert pad.known() == pytest.approx(wanted + CUSHION * G, rel=0.01)
    assert set(pad.partners) == {"cushion"}


# A resident who leaves the home, hidden from one frame to the next, disturbs no pad


def test_a_body_that_goes_away_from_a_pad_ends_no_run(world: Any) -> None:
    pad = world.box((1, 1, 0.1), (0, 0, 0.05), "pad")
    world.sensor("PRESSURE", "pad", pad, update_rate=24.0)
    body = world.box((0.4, 0.4, 1.7), (0, 0, 0.95), "body")
    body.angen_load.mass = 70.0
    world.box((0.3, 0.3, 0.3), (0.2, 0.2, 3.0), "ball")
    bpy = world.bpy
    bpy.context.view_layer.objects.active = pad
    bpy.ops.rigidbody.object_add(type="PASSIVE")
    world.key(body, "location", {1: (0, 0, 0.95), 10: (0, 0, 0.95), 11: (9, 0, 0.95)}, "CONSTANT")
    world.key(body, "hide_viewport", {1: False, 11: True, 30: False}, "CONSTANT")
    force = world.series(world.run(1, 40), "pad", "force_n")
    assert max(force[:8]) > 600.0
    assert not any(force[11:])


# People of several parts in an instanced collection weigh once each


GUEST = 60.0


def person(world, bearer):
    """Add two legs, and a body as their parent: an empty, or a mesh that stands on its own foot."""
    source = bpy.data.collections.new("person")
    if bearer == "MESH":
        body = world.box((0.1, 0.1, 1.0), (0, 0, 0.52), "body")
    else:
        body = world.link("body", None)
    parts = [body]
    body.angen_load.mass = GUEST
    for x in (-0.2, 0.2):
        leg = world.box((0.1, 0.1, 1.0), (x, 0, 0 if bearer == "MESH" else 0.52), "leg")
        leg.parent = body
        parts.append(leg)
    for part in parts:
        world.scene.collection.objects.unlink(part)
        source.objects.link(part)
    return source


@pytest.mark.parametrize("bearer", ["EMPTY", "MESH"])
@pytest.mark.parametrize("nested", [False, True])
def test_a_person_in_an_instance_weighs_once(world, bearer, nested):
    source = person(world, bearer)
    if nested:
        outer = bpy.data.collections.new("outer")
        inner = bpy.data.objects.new("inner", None)
        inner.instance_type, inner.instance_collection = "COLLECTION", source
        outer.objects.link(inner)
        source = outer
    world.box((8, 4, 0.3), (0, 0, -0.15), "floor")
    for number, x in enumerate((-2.0, 2.0)):
        pad = world.box((1, 1, 0.02), (x, 0, 0.01), f"pad {number}")
        world.sensor("PRESSURE", f"pad {number}", pad, update_rate=24.0)
        world.instance(f"person {number}", source, (x, 0, 0))
    recording = world.run(1, 6)
    for name in ("pad 0", "pad 1"):
        assert world.series(recording, name, "force_n")[1:] == pytest.approx([GUEST * G] * 5, 1e-3)
        assert all(world.series(recording, name, "valid")[1:])
