# SPDX-License-Identifier: GPL-3.0-or-later
"""People of several parts that come as an instanced collection weigh once each, as when they are
appended."""

import bpy
import pytest

G = 9.81
MASS = 60.0


def person(world, bearer):
    """Two legs, and a body that they hang on: an empty, or a mesh that stands on its own foot."""
    source = bpy.data.collections.new("person")
    if bearer == "MESH":
        body = world.box((0.1, 0.1, 1.0), (0, 0, 0.52), "body")
    else:
        body = world.link("body", None)
    parts = [body]
    body.angen_load.mass = MASS
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
        made = world.link(f"person {number}", None, (x, 0, 0))
        made.instance_type, made.instance_collection = "COLLECTION", source
    recording = world.run(1, 6)
    for name in ("pad 0", "pad 1"):
        assert world.series(recording, name, "force_n")[1:] == pytest.approx([MASS * G] * 5, 1e-3)
        assert all(world.series(recording, name, "valid")[1:])
