# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun of a home with a place on Earth follows date and hour, and is given back."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import date
from itertools import pairwise
from typing import Any

import bpy
import pytest
from mathutils import Vector

NOON = 1 + 10 * 12 * 3600


def test_sun_and_sky_follow_the_hour(world: Any, addon_part: Callable[[str], Any]) -> None:
    daylight = addon_part("residents.blender.daylight")
    world.sensor("LIGHT", "lux")
    sun = world.link("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (math.radians(60), 0, 0)
    sky = bpy.data.worlds.new("Sky")
    sky.use_nodes, world.scene.world = True, sky
    strength = sky.node_tree.nodes["Background"].inputs["Strength"]
    world.update()

    def at(frame: int) -> tuple[float, float, Vector]:
        world.scene.frame_set(frame)
        return (
            sun.data.energy,
            strength.default_value,
            sun.matrix_world.to_3x3() @ Vector((0, 0, 1)),
        )

    # Where its place is not told, it stays.
    with daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)):
        assert at(1)[:2] == (2.0, 1.0)
    assert daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)).changes() == []
    site = world.scene.angen_site
    site.latitude, site.longitude, site.utc_offset = math.radians(59.33), math.radians(18.07), 1
    # Up from 2:31 to 21:08 by winter time, it goes on every ten minutes.
    changes = daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)).changes()
    assert (changes[0], changes[-1]) == pytest.approx((2.5 * 3600, 21.2 * 3600), abs=600)
    assert {b - a for a, b in pairwise(changes)} == {600.0}
    with daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)):
        energy, sky_now, way = at(NOON)
        # At the solstice it is 54.1° high at noon, in the south: more than at the file's 30°.
        assert math.degrees(math.asin(way.z)) == pytest.approx(54.1, abs=0.3)
        assert way.y < -0.5 and abs(way.x) < 0.1
        assert energy > 2.0 and sky_now > 1.0
        dark = at(1)
        assert dark[0] == 0.0 and 0.0 < dark[1] < 0.01
    with daylight.Daylight(world.scene, world.sensors(), date(2026, 12, 21)):
        low = at(NOON)
        assert math.degrees(math.asin(low[2].z)) == pytest.approx(7.3, abs=0.3)
        assert 0.0 < low[0] < energy and low[1] < sky_now
    assert at(1)[:2] == (2.0, 1.0) and sun.rotation_mode == "XYZ"
    assert sun.rotation_euler.x == pytest.approx(math.radians(60))
    assert not bpy.data.actions
