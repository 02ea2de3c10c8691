# SPDX-License-Identifier: GPL-3.0-or-later
"""Without a window, what keeps a pad from its reading is said on standard error."""

import bpy
import pytest


@pytest.fixture
def simulate(world, addon_part, tmp_path, capsys):
    """Simulates the present scene by the command line and gives what it said."""

    def run(*arguments):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
        capsys.readouterr()
        command = addon_part("angen_addon.commands.command_line").run_command
        assert command(["simulate", "--frames", "1:3", *arguments]) == 0
        said = capsys.readouterr().err.splitlines()
        return "\n".join(line for line in said if line.startswith("angen: "))

    return run


def add_body(world, name, mass, kind="ACTIVE", obj=None):
    obj = obj or world.box((0.1, 0.1, 0.1), (0, 0, 0.3), name)
    world.update()
    bpy.context.view_layer.objects.active = obj
    bpy.ops.rigidbody.object_add(type=kind)
    obj.rigid_body.mass = mass
    return obj


def test_a_scene_without_weights(world, simulate):
    world.sensor("PRESSURE", "pad", world.box((1, 1, 0.01), name="pad"))
    assert "'pad': nothing in this scene has a weight" in simulate()


def test_many_pads_are_told_of_once(world, simulate):
    """The kind of problem, how many pads have it, and the first of them."""
    for name in (f"pad {number:02}" for number in range(12)):
        world.sensor("PRESSURE", name, world.box((1, 1, 0.01), name=name))
    world.sensor("PRESSURE", "bare")
    said = simulate().splitlines()
    assert len(said) == 2
    assert "13 pads ('bare', 'pad 00', 'pad 01' and 10 more): nothing in this scene" in said[1]
    assert said[0].startswith("angen: 'bare': it has no surface")
    assert simulate("--quiet") == ""


def test_a_light_active_pad_and_a_short_cache(world, simulate):
    bpy.ops.rigidbody.world_add()
    add_body(world, "box", 5.0)
    pad = world.sensor("PRESSURE", "pad", world.box((1, 1, 0.01), name="pad"))
    assert simulate() == ""
    add_body(world, "", 0.1, obj=pad)
    world.scene.rigidbody_world.point_cache.frame_end = 30
    said = simulate()
    assert "'pad': it is an active rigid body of 0.1 kg: it sinks" in said
    assert "cache ends at frame 30, the scene at 48" in said
    pad.angen_sensor.enabled = False
    world.switch()
    assert "sinks" not in simulate() and "cache" not in simulate("--sensor", "switch")


def test_a_part_of_a_compound_sinks_as_little_as_the_whole(world, addon_part):
    """Its own mass counts for nothing there."""
    sinks = addon_part("angen_addon.advice.sensing").sinks
    bpy.ops.rigidbody.world_add()
    add_body(world, "box", 5.0)
    whole = add_body(world, "whole", 20.0)
    pad = add_body(world, "pad", 0.1)
    assert sinks(pad, world.scene)
    pad.parent = whole
    whole.rigid_body.collision_shape = "COMPOUND"
    assert not sinks(pad, world.scene)
    assert not sinks(whole, world.scene)
