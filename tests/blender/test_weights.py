# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel says of weights is what the probe weighs."""

import bpy
import pytest


@pytest.fixture
def weights(addon_part):
    return addon_part("angen_addon.advice.sensing")


def person(world):
    """An armature with a body deformed by it, hair on the body, and a hat parented to a bone."""
    rig = world.link("rig", bpy.data.armatures.new("rig"))
    body = world.box((1, 1, 1), name="body")
    body.modifiers.new("armature", "ARMATURE").object = rig
    hair = world.box((1, 1, 1), name="hair")
    hair.parent = body
    hat = world.box((1, 1, 1), name="hat")
    hat.parent = rig
    return rig


def probed(world, addon_part):
    """Names of the surfaces that weigh with each bearer, as the probe has it."""
    depsgraph = world.update()
    probes = addon_part("angen_addon.runtime.probes").Probes(world.scene)
    probes.look(depsgraph, None)
    solids = probes.caster.solids
    bodies = addon_part("angen_addon.scene.contact.bodies").ContactBodies()
    bodies.sync(depsgraph, solids, [])
    return {
        body.original.name: sorted(s.geometry.original.name for s in body.solids)
        for body in bodies.by_key.values()
        if body.animated
    }


def told(world, weights):
    """The same, as a panel has it."""
    layer = bpy.context.view_layer
    found = {
        obj.name: sorted(s.name for s in weights.weighed_with(obj, layer).surfaces)
        for obj in layer.objects
        if weights.has_mass(obj)
    }
    return {name: surfaces for name, surfaces in found.items() if surfaces}


CASES = {
    "none": {},
    "rig": {"rig": 70},
    "body": {"body": 70},
    "rig and body": {"rig": 70, "body": 60},
    "all": {"rig": 1, "body": 2, "hair": 3, "hat": 4},
    "hair and hat": {"hair": 1, "hat": 1},
    "room": {"room": 5, "hat": 1},
}


@pytest.mark.parametrize("masses", CASES.values(), ids=CASES.keys())
@pytest.mark.parametrize("change", ["", "hidden", "ignored"])
def test_panel_and_probe_agree(world, addon_part, weights, masses, change):
    rig = person(world)
    world.box((1, 1, 1), name="stranger")
    rig.parent = world.link("room", None)
    for name, mass in masses.items():
        bpy.data.objects[name].angen_load.mass = mass
    if change == "hidden":
        bpy.data.objects["hair"].hide_viewport = True
    if change == "ignored":
        bpy.data.objects["body"].angen_ignored = True
    expected = probed(world, addon_part)
    assert told(world, weights) == expected
    assert bool(expected) == bool(masses) or change == "ignored"


def test_an_animated_mass_is_a_mass(world, addon_part, weights):
    rig = person(world)
    world.key(rig, "angen_load.mass", {1: 0.0, 10: 70.0})
    world.scene.frame_set(1)
    assert rig.angen_load.mass == 0.0
    assert told(world, weights) == probed(world, addon_part) == {"rig": ["body", "hat"]}


def test_what_would_weigh_is_told_before_there_is_a_mass(world, weights):
    rig = person(world)
    world.update()
    found = weights.weighed_with(rig, bpy.context.view_layer)
    assert sorted(s.name for s in found.surfaces) == ["body", "hat"]
    assert found.apart == []
    bpy.data.objects["body"].angen_load.mass = 60.0
    found = weights.weighed_with(rig, bpy.context.view_layer)
    assert [s.name for s in found.surfaces] == ["hat"]
    assert sorted((s.name, b.name) for s, b in found.apart) == [("body", "body")]
