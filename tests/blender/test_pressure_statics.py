# SPDX-License-Identifier: GPL-3.0-or-later
"""The force on pads under simulated bodies that rest or slide, against statics in closed form."""

import math

import numpy as np
import pytest
from pressure_scenes import G, shares
from tiers import mostly_slow

EXACT = 1e-3
TABLE = {"rel": 0.01, "abs": 0.3}
PADS = [pytest.param(None, id="virtual"), pytest.param("PASSIVE", id="passive")]


@pytest.mark.parametrize("kind", PADS)
@pytest.mark.parametrize("on_floor", [True, False], ids=["floor", "no floor"])
def test_a_box_at_rest(physics, kind, on_floor):
    """5 kg on a pad; the floor's own share of what is beside the pad is not the pad's."""
    if not on_floor and kind is None:
        pytest.skip("nothing would hold it")
    if on_floor:
        physics.floor()
    thick = 0.01 if kind else 0.0
    # A virtual pad is flush with the floor that holds the box.
    physics.pad(kind=kind, at=(0, 0, thick - 0.005))
    physics.body("box", (0.1, 0.1, 0.1), (0.02, 0, thick + 0.1), 5.0)
    pad = physics.read()
    assert pad.known() == pytest.approx(5 * G, rel=EXACT)
    assert pad.residual.max() < EXACT
    assert set(pad.partners) == {"box"}
    assert pad.cop[5:] == pytest.approx(np.tile((0.02, 0), (25, 1)), abs=1e-3)


def test_the_first_reading_is_an_estimate(physics):
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    pad = physics.read()
    assert pad.frames[0] == 1 and not pad.valid[0]
    assert pad.force[0] == pytest.approx(5 * G, rel=EXACT)


def test_half_a_box_on_the_pad(physics):
    """A box over the edge of the pad, held by another pad of the same height."""
    physics.pad(kind="PASSIVE", half=(0.1, 0.1, 0.005), at=(-0.1, 0, 0.005))
    physics.pad("other", (0.1, 0.1, 0.005), (0.1, 0, 0.005), "PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    read = physics.run()
    for name, side in (("pad", 0.05), ("other", -0.05)):
        assert read[name].known() == pytest.approx(2 * G, rel=EXACT)
        assert read[name].cop[5:, 0] == pytest.approx(side, abs=1e-3)


def test_a_stack_passes_its_weight_on(physics):
    physics.floor()
    physics.pad(kind="PASSIVE")
    height = 0.01
    for number, mass in enumerate((4.0, 2.0, 1.0)):
        physics.body(f"box {number}", (0.1, 0.1, 0.05), (0.005 * number, 0, height + 0.05), mass)
        height += 0.1
    pad = physics.read()
    assert pad.known() == pytest.approx(7 * G, rel=EXACT)
    assert set(pad.partners) == {"box 0"}


def test_two_bodies_on_one_pad_are_both_named(physics):
    physics.floor()
    physics.pad(kind="PASSIVE")
    physics.body("left", (0.05, 0.05, 0.05), (-0.08, 0, 0.06), 3.0)
    physics.body("right", (0.05, 0.05, 0.05), (0.08, 0, 0.06), 1.0)
    pad = physics.read()
    assert pad.known() == pytest.approx(4 * G, rel=EXACT)
    assert set(pad.partners) == {"left;right"}
    assert pad.cop[5:, 0] == pytest.approx(-0.04, abs=1e-3)


def test_a_semicolon_in_a_name_does_not_make_two_partners(physics):
    physics.on_floor(4)
    physics.pad(kind="PASSIVE")
    physics.body("left;right", (0.05, 0.05, 0.05), (0, 0, 0.06), 3.0)
    assert set(physics.read().partners) == {"left\\;right"}


@pytest.mark.parametrize(
    ("chosen", "mass", "names"),
    [("object", 3.0, {"left"}), ("collection", 1.0, {"right"}), ("both", 4.0, {"left;right"})],
)
def test_only_a_chosen_partner_counts(physics, chosen, mass, names):
    physics.floor()
    pad = physics.pad(kind="PASSIVE")
    left = physics.body("left", (0.05, 0.05, 0.05), (-0.08, 0, 0.06), 3.0)
    right = physics.body("right", (0.05, 0.05, 0.05), (0.08, 0, 0.06), 1.0)
    settings = pad.angen_sensor.pressure
    group = physics.bpy.data.collections.new("group")
    physics.scene.collection.children.link(group)
    group.objects.link(right)
    if chosen in ("object", "both"):
        settings.partner_object = left
    if chosen in ("collection", "both"):
        settings.partner_collection = group
    found = physics.read()
    assert found.known() == pytest.approx(mass * G, rel=EXACT)
    assert set(found.partners) == names


def test_a_partner_that_is_not_there_reads_nothing(physics):
    physics.floor()
    pad = physics.pad(kind="PASSIVE")
    physics.body("box", (0.05, 0.05, 0.05), (0, 0, 0.06), 3.0)
    pad.angen_sensor.pressure.partner_object = physics.body("far", (0.1,) * 3, (2, 0, 0.1), 3.0)
    found = physics.read()
    assert found.known() == pytest.approx(0.0, abs=1e-6)
    assert set(found.partners) == {""}


@pytest.mark.parametrize("subtract", [True, False])
@pytest.mark.parametrize("kind", ["PASSIVE", "ACTIVE"])
def test_own_weight(physics, kind, subtract):
    """The pad's own 0.5 kg count only where they are asked for."""
    physics.floor()
    settings = {"mass": 0.5}
    pad = physics.pad(kind=kind, body=settings)
    pad.angen_sensor.pressure.subtract_own_weight = subtract
    physics.body("box", (0.1, 0.1, 0.05), (0, 0, 0.06), 2.0)
    own = 0.0 if subtract else 0.5
    assert physics.read().known() == pytest.approx((2.0 + own) * G, rel=EXACT)


def test_own_weight_of_a_pad_under_a_chosen_floor(physics):
    """What holds the pad up, chosen as its partner, feels the pad's load without the pad."""
    floor = physics.floor()
    pad = physics.pad(kind="ACTIVE", body={"mass": 0.5})
    pad.angen_sensor.pressure.partner_object = floor
    physics.body("box", (0.1, 0.1, 0.05), (0, 0, 0.06), 2.0)
    assert physics.read().known() == pytest.approx(2.0 * G, rel=EXACT)


def test_a_pad_on_the_chair_that_it_is_a_part_of(physics):
    """A virtual pad on the seat of a simulated stool, and one under each of its feet."""
    physics.floor()
    feet = [((0.02, 0.02, 0.2), (x, y, -0.22)) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    stool = physics.compound("stool", [((0.22, 0.22, 0.02), (0, 0, 0)), *feet], (0, 0, 0.42), 5.0)
    seat = physics.pad("seat", (0.1, 0.1, 0.002), (0, 0, 0.018))
    seat.parent = stool
    seat.location.z = 0.018
    physics.body("box", (0.05, 0.05, 0.05), (0.05, 0, 0.49), 3.0)
    pad = physics.read("seat")
    assert pad.known() == pytest.approx(3 * G, rel=EXACT)
    assert set(pad.partners) == {"box"}


def test_a_pad_glued_below_a_leg(physics):
    """A virtual pad that is part of the leg: it feels what stands below."""
    floor = physics.floor()
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.1), 5.0)
    down = {"rotation_euler": (math.pi, 0, 0)}
    pad = physics.pad("pad", (0.09, 0.09, 0.001), (0, 0, -0.1), place=down)
    pad.parent = box
    found = physics.read()
    assert found.known() == pytest.approx(5 * G, rel=EXACT)
    assert set(found.partners) == {floor.name}


# Tables


@pytest.mark.parametrize(
    "load",
    mostly_slow([(0, 0), (0.25, 0.15), (0.4, 0.25)], (0.4, 0.25), tuples=False),
    ids=["middle", "between", "near a leg"],
)
def test_a_table_with_four_legs(physics, load):
    names = physics.table(load)
    read = physics.run()
    exact = 20 * G / 4 + shares(load, 10 * G)
    found = np.array([read[name].known(after=5) for name in names])
    for force, wanted in zip(found, exact, strict=True):
        assert force == pytest.approx(np.full(len(force), wanted), **TABLE)
    assert found.sum(axis=0) == pytest.approx(30 * G, rel=EXACT)


def test_the_reading_rises_strictly_as_the_load_nears_the_leg(physics):
    """The load stands at seven places, a run each."""
    means = []
    names = physics.table((0, 0))
    load = physics.bpy.data.objects["load"]
    physics.frames(6)
    for step in np.linspace(0, 1, 7):
        load.location.x, load.location.y = 0.5 * step, 0.3 * step
        means.append(physics.run()[names[3]].known(after=4).mean())
    assert (np.diff(means) > 1.0).all(), means
    assert means[0] == pytest.approx(30 * G / 4, rel=0.01)
    assert means[-1] == pytest.approx(5 * G + shares((0.5, 0.3), 10 * G)[3], rel=0.01)


def test_a_table_with_three_legs(physics):
    """Statics alone decide; no foundation is needed."""
    physics.floor()
    legs = np.array([(-0.4, -0.3), (0.4, -0.3), (0.0, 0.4)])
    for number, (x, y) in enumerate(legs):
        physics.pad(f"leg {number}", (0.05, 0.05, 0.005), (x, y, 0.005), "PASSIVE")
    feet = [((0.02, 0.02, 0.2), (x, y, -0.22)) for x, y in legs]
    physics.compound("table", [((0.5, 0.5, 0.02), (0, 0, 0)), *feet], (0, 0, 0.43), 8.0)
    physics.body("load", (0.05, 0.05, 0.05), (0.1, -0.1, 0.5), 4.0)
    read = physics.run()
    ones = np.vstack([np.ones(3), legs.T])
    exact = np.linalg.solve(ones, np.array((12.0, 0.4, -0.4)) * G)
    for number, wanted in enumerate(exact):
        assert read[f"leg {number}"].known(after=5) == pytest.approx(wanted, rel=0.01)


# Friction


def on_slope(physics, degrees, friction):
    """A box of 3 kg on a long pad that is a slope; and the place, its way down and its normal."""
    slope = math.radians(degrees)
    turned = {"rotation_euler": (0, slope, 0)}
    physics.pad(
        half=(2, 1, 0.01), at=(0, 0, 0), kind="PASSIVE", place=turned, body={"friction": 1.0}
    )
    normal = np.array((math.sin(slope), 0, math.cos(slope)))
    down = np.array((math.cos(slope), 0, -math.sin(slope)))
    at = 0.06 * normal - 1.5 * down
    box = physics.body(
        "box", (0.2, 0.2, 0.05), at, 3.0, turned, friction=friction, linear_damping=0.0
    )
    return box, at, down, 3 * G * math.cos(slope)


@pytest.mark.parametrize("friction", [0.3, 0.2])
def test_sliding_down_a_slope(physics, friction):
    """m·g·cos 20°, while it slides as it should. The engine's own force trembles by 1 %."""
    physics.frames(20)
    physics.scene.angen_live = False
    box, at, down, exact = on_slope(physics, 20, friction)
    force = physics.read().known(after=3)
    assert force.mean() == pytest.approx(exact, rel=2e-3)
    assert force == pytest.approx(exact, rel=0.02)
    physics.scene.frame_set(20)
    way = (physics.place_of(box) - at) @ down
    slope = math.radians(20)
    rate = G * (math.sin(slope) - friction * math.cos(slope))
    assert way == pytest.approx(0.5 * rate * (19 / 24) ** 2, rel=0.05)


def test_at_rest_on_a_slope(physics):
    _, _, _, exact = on_slope(physics, 15, 0.9)
    assert physics.read().known(after=3) == pytest.approx(exact, rel=EXACT)


def test_a_leaning_ladder(physics):
    """Against a smooth wall: it holds the moment of the weight about the foot, the floor all of it.

    The engine's friction lets the foot creep: after 8 frames the wall holds 0.6 % more.
    """
    physics.frames(8)
    angle = math.radians(65)
    physics.floor(friction=1.0)
    physics.pad("foot", (0.2, 0.2, 0.005), (0, 0, 0.005), "PASSIVE", body={"friction": 1.0})
    long, thick = 1.0, 0.02
    along = np.array((math.cos(angle), 0, math.sin(angle)))
    across = np.array((math.sin(angle), 0, -math.cos(angle)))
    # Its lower corner stands on the foot's pad; its upper corner touches the wall's.
    foot = -long * along + thick * across
    head = long * along + thick * across
    middle = np.array((0, 0, 0.01)) - foot
    wall_x = (middle + head)[0]
    physics.pad(
        "wall",
        (0.3, 0.3, 0.005),
        (wall_x + 0.005, 0, (middle + head)[2]),
        "PASSIVE",
        place={"rotation_euler": (0, -math.pi / 2, 0)},
        body={"friction": 0.0},
    )
    physics.body(
        "ladder",
        (thick, 0.15, long),
        middle,
        10.0,
        friction=1.0,
        place={"rotation_euler": (0, math.pi / 2 - angle, 0)},
    )
    read = physics.run()
    wall = 10 * G * (middle[0] - 0.0) / ((middle + head)[2] - 0.01)
    assert read["foot"].known(after=3) == pytest.approx(10 * G, rel=0.01)
    assert read["wall"].known(after=3) == pytest.approx(wall, rel=0.01)
