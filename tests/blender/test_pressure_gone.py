# SPDX-License-Identifier: GPL-3.0-or-later
"""Who leaves the home, hidden from one frame to the next, disturbs no pad on the way out."""

from __future__ import annotations

from typing import Any


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
