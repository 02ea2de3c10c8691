# SPDX-License-Identifier: GPL-3.0-or-later
"""Floors carry whoever stands on them, however thin; what lies on a pad without a mass does not."""

import pytest
from pressure_scenes import G
from tiers import mostly_slow

SUM, SHARE = 1e-3, 0.03
SHOES = [((0.05, 0.13, 0.05), (x, 0, 0.05)) for x in (-0.15, 0.15)]
BODY = ((0.2, 0.1, 0.5), (0, 0, 0.6))


def plane(physics, name="floor", size=20.0, z=0.0):
    h = size / 2
    corners = [(-h, -h, z), (h, -h, z), (h, h, z), (-h, h, z)]
    return physics.world.link(name, physics.world.mesh(corners, [(0, 1, 2, 3)]))


def room(physics):
    """Floor, walls and ceiling, one mesh without thickness."""
    obj = physics.solid("room", (10, 10, 1.25), (0, 0, 1.25))
    obj.data.flip_normals()
    return obj


def finish(physics):
    """A millimetre of vinyl on a slab."""
    physics.solid("slab", (10, 10, 0.15), (0, 0, -0.151))
    return physics.solid("finish", (10, 10, 0.0005), (0, 0, -0.0005))


def walls(physics):
    """A thin floor with walls, and a step beside: one mesh."""
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
    """A crate's pad; somebody beside it, somebody half on another mat 6 m away. The engine keeps a
    crate off a mesh by a margin of 4 cm."""
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
    """Flush with it; somebody stands on a step of the same mesh."""
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
    """Its weight and that of who is on it would be the pad's: told, with the way out."""
    physics.frames(6)
    floor(physics)
    physics.pad(kind=kind)
    lid = COVERS[cover](physics)
    top = lid.location.z + max(v.co.z for v in lid.data.vertices)
    physics.carried("Person", (0.1, 0.1, 0.4), (0, 0, top + 0.4), 70.0)
    physics.read().never_valid("'Person' ends in 'cover'", "no mass")
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
    physics.read().never_valid("'Person' ends in 'carpet'")


@pytest.mark.parametrize("shape", mostly_slow(["BOX", "CONVEX_HULL", "CYLINDER"], "BOX"))
@pytest.mark.parametrize("flipped", [True, False], ids=["inwards", "outwards"])
def test_a_room_that_is_one_mesh_is_hollow(physics, flipped, shape):
    """A plank with one end on a pad, the other on the room's floor; the pad's edge at −0.3, the
    plank's own at 0.5. The engine keeps it 4 cm off the room."""
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
