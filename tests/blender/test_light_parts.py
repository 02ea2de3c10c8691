# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in parts, as a day is whose sun goes on, has a reference for each."""

import bpy
import numpy as np
import pytest
from light_stage import lit_room, objects, part
from test_light_reference import MANY, in_a_run, move, plain


@pytest.fixture
def room(world):
    return lit_room(world)


def test_where_parts_have_references_far_from_the_first_one_theirs_counts(room, fcurves):
    """In the part from frame 5 on the screen hangs elsewhere, and the point lamp too."""
    tell = part("light.scene").tell_begins
    for name in ("screen", "point"):
        objects(name).animation_data_clear()
        move(objects(name), "location", ((1, 1, 0), (-1, -1, 0.5)))
        for curve in fcurves(objects(name)):
            for key in curve.keyframe_points:
                key.interpolation = "CONSTANT"
    bpy.context.scene.frame_set(7)
    # More than a closer look has.
    many = plain(8 * MANY)
    other = part("light.cycles").CyclesLight(8 * MANY)
    try:
        assert (np.abs(in_a_run(other) / many - 1) > 1e-3).any()
        tell(bpy.context.scene, [1, 5])
        for frame in (1, 8, 3, 7):
            bpy.context.scene.frame_set(frame)
            found = in_a_run(other)
        assert {key[2] for key in other._references} == {1, 5}
    finally:
        other.close()
        part("light.scene").take_begins(bpy.context.scene)
    assert found == pytest.approx(many, rel=1e-5)
