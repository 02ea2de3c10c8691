# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies held by rigid-body constraints: what statics decide is read, the rest is told."""

import numpy as np
import pytest
from pressure_scenes import G


def joint(physics, kind, at, one, two, rotation=(0, 0, 0), **settings):
    """A constraint at a place between two bodies, or one and the world."""
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
    """Something that does not move, for a joint: a constraint needs two rigid bodies."""
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
    """It hangs in the air beside the pad; all of its weight is felt."""
    physics.on_floor(12)
    physics.pad(kind="PASSIVE")
    one = physics.body("one", (0.1, 0.1, 0.05), (0, 0, 0.06), 5.0)
    two = physics.body("two", (0.05, 0.05, 0.02), (0.16, 0, 0.08), 1.0)
    joint(physics, "FIXED", (0.1, 0, 0.07), one, two)
    pad = physics.read()
    assert pad.known(after=3) == pytest.approx(6 * G, rel=2e-3)
    assert pad.cop[8, 0] == pytest.approx(0.16 / 6, abs=3e-3)


def test_a_box_also_held_by_the_wall_is_not_known(physics):
    """Fixed to the wall it could hang there, or stand on the pad, or anything between."""
    physics.on_floor(8)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    joint(physics, "FIXED", (-0.1, 0, 0.11), box, wall(physics, (-0.2, 0, 0.11)))
    physics.read().never_valid("statics cannot tell", "fixed")


def test_a_lid_on_a_hinge(physics):
    """A lid of 4 kg with its hinge at one end and a pad below the other: the lever decides."""
    physics.on_floor(12)
    physics.pad(kind="PASSIVE", half=(0.004, 0.2, 0.05), at=(0.396, 0, 0.05))
    lid = physics.body("lid", (0.4, 0.2, 0.01), (0, 0, 0.11), 4.0)
    joint(
        physics,
        "HINGE",
        (-0.4, 0, 0.11),
        lid,
        wall(physics, (-0.5, 0, 0.11)),
        rotation=(np.pi / 2, 0, 0),
    )
    pad = physics.read()
    exact = 4 * G * 0.4 / 0.796
    assert pad.known(after=3) == pytest.approx(exact, rel=0.02)


def test_a_point_joint_is_a_ball(physics):
    """A beam on a ball joint at one end, on a pad at the other."""
    physics.on_floor(12)
    physics.pad(kind="PASSIVE", half=(0.004, 0.2, 0.05), at=(0.396, 0, 0.05))
    beam = physics.body("beam", (0.4, 0.05, 0.01), (0, 0, 0.11), 4.0)
    joint(physics, "POINT", (-0.4, 0, 0.11), beam, wall(physics, (-0.5, 0, 0.11)))
    assert physics.read().known(after=3) == pytest.approx(4 * G * 0.4 / 0.796, rel=0.02)


def test_a_vertical_slider_leaves_the_weight_to_the_pad(physics):
    """It guides a weight along z, and holds nothing of it."""
    physics.on_floor(12)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.05, 0.05, 0.1), (0, 0, 0.11), 5.0)
    post = wall(physics, (0.3, 0, 0.11))
    upright = (0, -np.pi / 2, 0)
    joint(physics, "SLIDER", (0, 0, 0.11), box, post, upright, use_limit_lin_x=False)
    assert physics.read().known(after=3) == pytest.approx(5 * G, rel=5e-3)


def test_a_hanging_weight_presses_on_nothing(physics):
    """It hangs over the pad from a point; the pad has nothing, and knows it."""
    physics.on_floor(12)
    physics.pad(kind="PASSIVE")
    weight = physics.body("weight", (0.05, 0.05, 0.05), (0, 0, 0.2), 5.0)
    joint(physics, "POINT", (0, 0, 0.3), weight, wall(physics, (0, 0, 0.32)))
    assert physics.read().known(after=3) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("end", ["nothing", "no body"])
def test_a_joint_with_one_end_holds_nothing(physics, end):
    """Blender makes no constraint of it: the box falls on the pad."""
    physics.on_floor(20)
    physics.pad(kind="PASSIVE")
    weight = physics.body("weight", (0.05, 0.05, 0.05), (0, 0, 0.1), 5.0)
    other = physics.solid("cloud", (0.1, 0.1, 0.1), (0, 0, 1)) if end == "no body" else None
    joint(physics, "POINT", (0, 0, 0.3), weight, other)
    assert physics.read().known(after=15) == pytest.approx(5 * G, rel=1e-3)


def test_a_disabled_joint_holds_nothing(physics):
    physics.on_floor(8)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    joint(physics, "FIXED", (-0.1, 0, 0.11), box, wall(physics, (-0.2, 0, 0.11)), enabled=False)
    assert physics.read().known() == pytest.approx(5 * G, rel=1e-3)


def test_a_spring_from_above_is_not_known(physics):
    physics.on_floor(8)
    physics.pad(kind="PASSIVE")
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    joint(
        physics, "GENERIC_SPRING", (0, 0, 0.11), box, wall(physics, (0, 0, 0.5)), use_spring_z=True
    )
    physics.read().never_valid("statics cannot tell")


def test_a_joint_elsewhere_is_no_matter(physics):
    physics.on_floor(8)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    far = physics.body("far", (0.1, 0.1, 0.1), (2, 0, 0.1), 5.0)
    joint(physics, "FIXED", (2.1, 0, 0.1), far, wall(physics, (2.2, 0, 0.1)))
    assert physics.read().known() == pytest.approx(5 * G, rel=1e-3)
