# SPDX-License-Identifier: GPL-3.0-or-later
"""The force on pads under bodies that rest, slide or are held by joints, against statics.

Also the sample of the pressure sensor.
"""

import math
from importlib import import_module
from pathlib import Path

import bpy
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
    """5 kg on a pad; the floor carries the part beside the pad."""
    if not on_floor and kind is None:
        pytest.skip("nothing would hold it")
    if on_floor:
        physics.floor()
    thick = 0.01 if kind else 0.0
    # A virtual pad is flush with the floor that carries the box.
    physics.pad(kind=kind, at=(0, 0, thick - 0.005))
    physics.body("box", (0.1, 0.1, 0.1), (0.02, 0, thick + 0.1), 5.0)
    pad = physics.read()
    assert pad.known() == pytest.approx(5 * G, rel=EXACT)
    assert pad.residual.max() < EXACT
    assert set(pad.partners) == {"box"}
    assert pad.cop[5:] == pytest.approx(np.tile((0.02, 0), (25, 1)), abs=1e-3)


def test_half_a_box_on_the_pad(physics):
    """A box over the edge of the pad, on another pad of the same height."""
    physics.pad(kind="PASSIVE", half=(0.1, 0.1, 0.005), at=(-0.1, 0, 0.005))
    physics.pad("other", (0.1, 0.1, 0.005), (0.1, 0, 0.005), "PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 4.0)
    read = physics.run()
    for name, side in (("pad", 0.05), ("other", -0.05)):
        assert read[name].known() == pytest.approx(2 * G, rel=EXACT)
        assert read[name].cop[5:, 0] == pytest.approx(side, abs=1e-3)


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
    """The pad's own 0.5 kg count only where the user includes them."""
    physics.floor()
    settings = {"mass": 0.5}
    pad = physics.pad(kind=kind, body=settings)
    pad.angen_sensor.pressure.subtract_own_weight = subtract
    physics.body("box", (0.1, 0.1, 0.05), (0, 0, 0.06), 2.0)
    own = 0.0 if subtract else 0.5
    assert physics.read().known() == pytest.approx((2.0 + own) * G, rel=EXACT)


def test_own_weight_of_a_pad_under_a_chosen_floor(physics):
    """The support of the pad, chosen as its partner, carries the pad's load without the pad."""
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
    """A virtual pad that is part of the leg reads the force from below."""
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


def test_a_table_with_three_legs(physics):
    """Statics are enough; no elastic foundation is needed."""
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
    """Add a box of 3 kg on a long sloping pad; return it with its direction down and its normal."""
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
    """m·g·cos 20°, while it slides. The engine's own force has a noise of 1 %."""
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
    """A smooth wall carries the moment of the weight about the foot, the floor all of the weight.

    The engine's friction lets the foot creep: after 8 frames the wall carries 0.6 % more.
    """
    physics.frames(8)
    angle = math.radians(65)
    physics.floor(friction=1.0)
    physics.pad("foot", (0.2, 0.2, 0.005), (0, 0, 0.005), "PASSIVE", body={"friction": 1.0})
    long, thick = 1.0, 0.02
    along = np.array((math.cos(angle), 0, math.sin(angle)))
    across = np.array((math.sin(angle), 0, -math.cos(angle)))
    # Its lower corner stands on the foot's pad; its upper corner touches the wall's pad.
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


# Bodies held by rigid-body constraints


def joint(physics, kind, at, one, two, rotation=(0, 0, 0), **settings):
    """Add a constraint at a place between two bodies, or a body and the world."""
    obj = physics.world.link(kind.lower(), None, at)
    obj.rotation_euler = rotation
    assert physics.rigid
    physics.world.update()
    physics.bpy.context.view_layer.objects.active = obj
    physics.bpy.ops.rigidbody.constraint_add(type=kind)
    made = obj.rigid_body_constraint
    made.object1, made.object2 = one, two
    for key, value in settings.items():
        setattr(made, key, value)
    return obj


def wall(physics, at):
    """Add a still body for a joint, because a constraint needs two rigid bodies."""
    block = physics.solid("wall", (0.02, 0.02, 0.02), at)
    return physics.rigid_body(block, "PASSIVE")


def test_a_fixed_pair_is_one_body(physics):
    """A beam of two halves on two pads: each half alone would tip."""
    physics.on_floor(12)
    for name, x in (("left", -0.45), ("right", 0.25)):
        physics.pad(name, (0.05, 0.2, 0.005), (x, 0, 0.005), "PASSIVE")
    one = physics.body("one", (0.25, 0.05, 0.02), (-0.25, 0, 0.03), 2.0)
    two = physics.body("two", (0.25, 0.05, 0.02), (0.25, 0, 0.03), 6.0)
    joint(physics, "FIXED", (0, 0, 0.03), one, two)
    read = physics.run()
    found = [read[name].known(after=3) for name in ("left", "right")]
    assert found[0] + found[1] == pytest.approx(8 * G, rel=1e-3)
    # The centre of mass is at x = 0.125; the pads are 0.1 wide.
    exact = 8 * G * (0.25 - 0.125) / 0.7
    assert found[0] == pytest.approx(exact, rel=0.05)


def test_a_load_fixed_to_the_side_of_a_body(physics):
    """It hangs in the air beside the pad; all of its weight counts."""
    physics.on_floor(12)
    physics.pad(kind="PASSIVE")
    one = physics.body("one", (0.1, 0.1, 0.05), (0, 0, 0.06), 5.0)
    two = physics.body("two", (0.05, 0.05, 0.02), (0.16, 0, 0.08), 1.0)
    joint(physics, "FIXED", (0.1, 0, 0.07), one, two)
    pad = physics.read()
    assert pad.known(after=3) == pytest.approx(6 * G, rel=2e-3)
    assert pad.cop[8, 0] == pytest.approx(0.16 / 6, abs=3e-3)


UPRIGHT, LEVER = (0, -np.pi / 2, 0), 0.4 / 0.796
BOX, LID, BEAM = (0.1, 0.1, 0.1), (0.4, 0.2, 0.01), (0.4, 0.05, 0.01)
# The pad's half size and centre; half the body's size, its height and mass; the joint, its place
# and that of the wall at its other end; its settings; and the force. A lid on a hinge, and a beam
# on a ball joint, lie on the pad with their other end. A slider guides along z and carries nothing.
UNDER, AT_THE_END = ((0.15, 0.15, 0.005), None), ((0.004, 0.2, 0.05), (0.396, 0, 0.05))
HELD = {
    "a lid on a hinge": (
        AT_THE_END, (LID, 0.11, 4.0), ("HINGE", (-0.4, 0, 0.11), (-0.5, 0, 0.11)),
        {"rotation": (np.pi / 2, 0, 0)}, 4 * G * LEVER,
    ),
    "a beam on a ball": (
        AT_THE_END, (BEAM, 0.11, 4.0), ("POINT", (-0.4, 0, 0.11), (-0.5, 0, 0.11)), {},
        4 * G * LEVER,
    ),
    "a slider": (
        UNDER, ((0.05, 0.05, 0.1), 0.11, 5.0), ("SLIDER", (0, 0, 0.11), (0.3, 0, 0.11)),
        {"rotation": UPRIGHT, "use_limit_lin_x": False}, 5 * G,
    ),
    "a weight that hangs": (
        UNDER, ((0.05, 0.05, 0.05), 0.2, 5.0), ("POINT", (0, 0, 0.3), (0, 0, 0.32)), {}, 0.0,
    ),
    "disabled": (
        UNDER, (BOX, 0.11, 5.0), ("FIXED", (-0.1, 0, 0.11), (-0.2, 0, 0.11)), {"enabled": False},
        5 * G,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", HELD)
def test_what_a_joint_leaves_to_the_pad(physics, name):
    (half, at), (size, height, mass), (kind, place, end), settings, force = HELD[name]
    physics.on_floor(12)
    physics.pad(kind="PASSIVE", half=half, at=at)
    body = physics.body("body", size, (0, 0, height), mass)
    joint(physics, kind, place, body, wall(physics, end), **settings)
    assert physics.read().known(after=3) == pytest.approx(force, rel=0.02, abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "place", "end", "settings"),
    [
        ("FIXED", (-0.1, 0, 0.11), (-0.2, 0, 0.11), {}),
        ("GENERIC_SPRING", (0, 0, 0.11), (0, 0, 0.5), {"use_spring_z": True}),
    ],
)
def test_what_a_joint_may_hold_is_not_known(physics, kind, place, end, settings):
    """The body may hang there, or stand on the pad, or anything in between."""
    physics.on_floor(8)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", BOX, (0, 0, 0.11), 5.0)
    joint(physics, kind, place, box, wall(physics, end), **settings)
    physics.read().never_valid("the share of the weight that the rigid-body constraints carry")


@pytest.mark.parametrize("end", ["nothing", "no body"])
def test_a_joint_with_one_end_holds_nothing(physics, end):
    """Blender ignores such a constraint: the box falls on the pad. Nor does one elsewhere count."""
    physics.on_floor(20)
    physics.pad(kind="PASSIVE")
    weight = physics.body("weight", (0.05, 0.05, 0.05), (0, 0, 0.1), 5.0)
    other = physics.solid("cloud", (0.1, 0.1, 0.1), (0, 0, 1)) if end == "no body" else None
    joint(physics, "POINT", (0, 0, 0.3), weight, other)
    far = physics.body("far", BOX, (2, 0, 0.1), 5.0)
    joint(physics, "FIXED", (2.1, 0, 0.1), far, wall(physics, (2.2, 0, 0.1)))
    assert physics.read().known(after=15) == pytest.approx(5 * G, rel=1e-3)


# The sample of the pressure sensor


SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "pressure.blend"
ADDON = "bl_ext.user_default.angen_sensors"
LEGS = ("front left", "front right", "back left", "back right")
TABLE_WEIGHT, WEIGHT, DROPPED = 12.0 * G, 8.0 * G, 2.0 * G
# Newtons: the legs are stiff, and rest on areas, not on points.
LEG_TOLERANCE = 0.1


@pytest.fixture(scope="module")
def readings():
    """Return the readings of every pad as columns (frames,), and the weight's place (frames, 3)."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE), load_ui=False)
    scene = bpy.context.scene
    recording = import_module(f"{ADDON}.sensor_logic.recording.tracks").Recording()
    simulation = import_module(f"{ADDON}.angen_addon.runtime.simulation")
    found = import_module(f"{ADDON}.angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
    for _ in simulation.simulate(scene, found, scene.frame_start, scene.frame_end, recording):
        pass
    # Only the places are needed now.
    scene.angen_live = False
    weight = bpy.data.objects["Weight"]
    places = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        places.append(tuple(weight.matrix_world.translation))
    pads = {
        name.removeprefix("Pad "): {key: np.array(column) for key, column in track.columns.items()}
        for name, track in recording.tracks.items()
    }
    return pads, np.array(places)


def test_every_update_is_valid_but_the_first(readings):
    pads, places = readings
    assert set(pads) == {*LEGS, "stack", "drop"}
    for columns in pads.values():
        assert len(columns["valid"]) == len(places) == 240
        assert not columns["valid"][0] and columns["valid"][1:].all()


def test_the_four_legs_follow_statics(readings):
    """Four equal springs under a stiff table: a leg has ¼ W (1 + x·X/X² + y·Y/Y²)."""
    pads, places = readings
    for leg in LEGS:
        at = bpy.data.objects[f"Pad {leg}"].location
        share = (1.0 + places[:, 0] / at.x + places[:, 1] / at.y) / 4.0
        exact = TABLE_WEIGHT / 4.0 + WEIGHT * share
        assert np.ptp(exact) > 30.0
        assert np.abs(pads[leg]["force_n"] - exact).max() < LEG_TOLERANCE


def test_the_stack_weighs_its_boxes(readings):
    pads, _ = readings
    assert pads["stack"]["force_n"] == pytest.approx(7.0 * G, rel=1e-4)
    assert set(pads["stack"]["partners"]) == {"Box 4 kg"}


def test_the_drop_gives_the_impulse_of_its_fall(readings):
    """From the release at frame 25, between two readings, to rest at the end."""
    pads, _ = readings
    force, dt = pads["drop"]["force_n"], 1.0 / 24.0
    assert not force[:25].any()
    assert (force > 0.0).sum() > 100 and force.max() > 5.0 * DROPPED
    released = 24
    seconds = (len(force) - released) * dt
    assert force.sum() * dt == pytest.approx(DROPPED * seconds, rel=0.005)
    assert force[-1] == pytest.approx(DROPPED, rel=1e-4)


def test_no_path_of_the_builder_is_in_the_file():
    assert not [image.filepath for image in bpy.data.images if image.filepath]
    assert not bpy.data.libraries
    assert SAMPLE.stat().st_size < 300_000
