# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings and weights in panels agree with the contact probe and with standard error."""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import (
    run_command as command,
)
from bl_ext.user_default.angen_sensors.angen_addon.runtime.probes import Probes
from bl_ext.user_default.angen_sensors.angen_addon.scene.forces.bodies import ContactBodies
from panel_layout import activate, drawn, pad, pad_under_a_box, panel_of

ops = bpy.ops.angen


@pytest.fixture
def physics(world):
    return pad_under_a_box(world)


# Warnings


def test_what_has_no_surface_is_told(world):
    for obj in (world.link("empty", None), world.link("lines", world.mesh([(0, 0, 0)], []))):
        activate(world, obj).angen_sensor.kind = "PRESSURE"
        assert "to press on" in drawn("ANGEN_PT_physics").text
    activate(world, world.box((1, 1, 1))).angen_sensor.kind = "PRESSURE"
    assert "to press on" not in drawn("ANGEN_PT_physics").text


def test_a_light_active_pad_is_warned_of(physics):
    assert "sinks" not in drawn("ANGEN_PT_physics").text
    bpy.ops.rigidbody.object_add(type="ACTIVE")
    pad().rigid_body.mass = 0.2
    layout = drawn("ANGEN_PT_physics")
    assert "of 0.2 kg: it sinks under heavier bodies, such as 'box' (5 kg)" in layout.text
    assert "type" in layout.props, "the way out is at hand"
    pad().rigid_body.type = "PASSIVE"
    assert "sinks" not in drawn("ANGEN_PT_physics").text
    pad().rigid_body.type = "ACTIVE"
    pad().rigid_body.mass = 6.0
    assert "sinks" not in drawn("ANGEN_PT_physics").text
    pad().rigid_body.mass = 1.0
    pad().rigid_body.kinematic = True
    assert "sinks" not in drawn("ANGEN_PT_physics").text


def test_a_scene_without_weights_is_told(physics):
    weightless = "Nothing in this scene has a weight"
    assert weightless not in drawn("ANGEN_PT_physics").text
    box = bpy.data.objects["box"]
    box.rigid_body.type = "PASSIVE"
    assert weightless in drawn("ANGEN_PT_physics").text
    box.angen_load.mass = 70.0
    assert weightless not in drawn("ANGEN_PT_physics").text
    box.angen_load.mass = 0.0
    physics.key(box, "angen_load.mass", {1: 0.0})
    assert weightless not in drawn("ANGEN_PT_physics").text
    box.animation_data_clear()
    bpy.ops.rigidbody.object_add(type="ACTIVE")
    assert weightless in drawn("ANGEN_PT_physics").text, "the pad itself does not count"


def test_a_cache_that_ends_before_the_scene_is_told(physics):
    cache = physics.scene.rigidbody_world.point_cache
    cache.frame_end = 48
    assert "cache ends" not in drawn("ANGEN_PT_physics").text
    cache.frame_end = 30
    layout = drawn("ANGEN_PT_physics")
    assert "ends at frame 30, the scene at 48" in layout.text
    assert "frame_end" in layout.props, "the way out is at hand"
    bpy.data.objects["box"].rigid_body.type = "PASSIVE"
    assert "cache ends" not in drawn("ANGEN_PT_physics").text, "nothing is simulated"


def test_an_outdated_cache_is_told(physics):
    for frame in range(1, 12):
        physics.scene.frame_set(frame)
    assert "out of date" not in drawn("ANGEN_PT_physics").text
    bpy.data.objects["box"].location.x += 0.01
    physics.update()
    assert physics.scene.rigidbody_world.point_cache.is_outdated
    assert "Play from frame 1" in drawn("ANGEN_PT_physics").text
    ops.simulate()
    assert "out of date" not in drawn("ANGEN_PT_physics").text


# Weights


def test_the_weight_panel_is_for_what_can_weigh(world):
    shown = []
    rig = world.link("rig", bpy.data.armatures.new("rig"))
    lamp = world.link("lamp", bpy.data.lights.new("lamp", "POINT"))
    for obj in (world.box((1, 1, 1)), rig, lamp):
        activate(world, obj)
        shown.append(panel_of("ANGEN_PT_physics_weight").poll(bpy.context))
    assert shown == [True, True, False]


def test_the_weight_panel_says_what_is_weighed(world):
    rig = world.link("rig", bpy.data.armatures.new("rig"))
    skin, hair = world.box((1, 1, 1), name="skin"), world.box((1, 1, 1), name="hair")
    skin.parent = hair.parent = rig
    activate(world, rig)
    layout = drawn("ANGEN_PT_sidebar_weight")
    assert layout.props == ["mass", "tolerance"]
    assert "No weight" in layout.text and "'hair', 'skin'" in layout.text
    rig.angen_load.mass = 70.0
    layout = drawn("ANGEN_PT_sidebar_weight")
    assert "70 kg" in layout.labels
    assert "The weight presses" in layout.text and "'hair', 'skin'" in layout.text
    assert "ERROR" not in layout.icons
    activate(world, skin)
    assert "Its weight is part of 'rig' (70 kg)" in drawn("ANGEN_PT_sidebar_weight").text
    skin.angen_load.mass = 60.0
    assert "Counted twice? 'rig'" in drawn("ANGEN_PT_sidebar_weight").text
    rig.angen_load.mass = 0.0
    activate(world, rig)
    assert "'skin' on it has a mass already" in drawn("ANGEN_PT_sidebar_weight").text
    rig.angen_load.mass = 70.0
    activate(world, rig)
    layout = drawn("ANGEN_PT_sidebar_weight")
    assert "below: 'hair'" in layout.text and "Counted twice? 'skin'" in layout.text
    hair.angen_ignored = True
    layout = drawn("ANGEN_PT_sidebar_weight")
    assert "This mass weighs on nothing" in layout.text and "Counted twice" not in layout.text
    activate(world, skin)
    assert "Counted twice" not in drawn("ANGEN_PT_sidebar_weight").text, "only its own counts"


def test_the_weight_panel_knows_simulated_bodies(physics):
    box = activate(physics, bpy.data.objects["box"])
    layout = drawn("ANGEN_PT_physics_weight")
    assert "weighs 5 kg already" in layout.text and "ERROR" not in layout.icons
    box.angen_load.mass = 5.0
    layout = drawn("ANGEN_PT_physics_weight")
    assert "counts as animated, not simulated" in layout.text and "ERROR" in layout.icons
    activate(physics, bpy.data.objects["floor"])
    assert "rigid body" not in drawn("ANGEN_PT_physics_weight").text, "a passive one has no weight"


# Weights in the panel are those of the contact probe


@pytest.fixture
def weights(addon_part):
    return addon_part("angen_addon.advice.sensing")


def person(world):
    """Add an armature with a deformed body, hair on the body, and a hat parented to a bone."""
    rig = world.link("rig", bpy.data.armatures.new("rig"))
    body = world.box((1, 1, 1), name="body")
    body.modifiers.new("armature", "ARMATURE").object = rig
    hair = world.box((1, 1, 1), name="hair")
    hair.parent = body
    hat = world.box((1, 1, 1), name="hat")
    hat.parent = rig
    return rig


def probed(world):
    """Return the names of the surfaces that weigh with each bearer, by the contact probe."""
    depsgraph = world.update()
    probes = Probes(world.scene)
    probes.look(depsgraph)
    solids = probes.caster.solids
    bodies = ContactBodies()
    bodies.sync(depsgraph, solids, [])
    return {
        body.original.name: sorted(s.geometry.original.name for s in body.solids)
        for body in bodies.by_key.values()
        if body.animated
    }


def told(world, weights):
    """Return the names of the surfaces that weigh with each bearer, by the panel."""
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
def test_panel_and_probe_agree(world, weights, masses, change):
    rig = person(world)
    world.box((1, 1, 1), name="stranger")
    rig.parent = world.link("room", None)
    for name, mass in masses.items():
        bpy.data.objects[name].angen_load.mass = mass
    if change == "hidden":
        bpy.data.objects["hair"].hide_viewport = True
    if change == "ignored":
        bpy.data.objects["body"].angen_ignored = True
    expected = probed(world)
    assert told(world, weights) == expected
    assert bool(expected) == bool(masses) or change == "ignored"


def test_an_animated_mass_is_a_mass(world, weights):
    rig = person(world)
    world.key(rig, "angen_load.mass", {1: 0.0, 10: 70.0})
    world.scene.frame_set(1)
    assert rig.angen_load.mass == 0.0
    assert told(world, weights) == probed(world) == {"rig": ["body", "hat"]}


# Without a window, standard error says what keeps a pad from its reading


@pytest.fixture
def simulate(world, tmp_path, capsys):
    """Simulate the present scene by the command line; return standard error."""

    def run(*arguments):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
        capsys.readouterr()
        assert command(["simulate", "--frames", "1:3", *arguments]) == 0
        said = capsys.readouterr().err.splitlines()
        return "\n".join(line for line in said if line.startswith("angen: "))

    return run


def test_many_pads_are_told_of_once(world, simulate):
    """The kind of problem, how many pads have it, and the first of them."""
    for name in (f"pad {number:02}" for number in range(12)):
        world.sensor("PRESSURE", name, world.box((1, 1, 0.01), name=name))
    world.sensor("PRESSURE", "bare")
    said = simulate().splitlines()
    assert len(said) == 3
    assert said[2].startswith("angen: 'bare' was not valid in 100 % of its updates")
    assert "13 pads ('bare', 'pad 00', 'pad 01' and 10 more): nothing in this scene" in said[1]
    assert said[0].startswith("angen: 'bare': it has no surface")
    # What a run could not read is no advice.
    assert simulate("--quiet") == said[2]
