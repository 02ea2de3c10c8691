# SPDX-License-Identifier: GPL-3.0-or-later
"""Explanations as the operator, the panel and the command line show them."""

import bpy
import pytest


def operators(world):
    box = world.box((1, 1, 1), at=(9, 0, -2.0), name="Box")
    world.key(box, "location", {1: (9, 0, -2.0), 10: (0, 0, -2.0), 20: (9, 0, -2)}, "CONSTANT")
    obj = world.pir(rays=1)
    bpy.context.view_layer.objects.active = obj
    return obj


def kept(world, addon_part, obj):
    """What the panel shows at the playhead."""
    recording = addon_part("angen_addon.runtime.state").CACHE.recording(world.scene)
    if recording is None:
        return None
    scene, event_at = world.scene, addon_part("operators.explain").event_at
    index = event_at(recording.tracks[obj.name], scene.frame_current)
    return addon_part("angen_addon.explain.explain").MEMORY.recall(
        recording, obj.session_uid, index
    )


def test_it_is_shown_until_the_playhead_leaves_or_the_scene_changes(world, addon_part):
    obj = operators(world)
    world.update()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    world.scene.frame_set(10)
    assert kept(world, addon_part, obj) is None
    assert bpy.ops.angen.explain() == {"FINISHED"}
    world.update()
    assert world.scene.frame_current == 10
    found = kept(world, addon_part, obj)
    assert found is not None, "the recording was lost"
    assert "'Box' came in" in found.headline
    assert "Box" in found.as_text()
    world.scene.frame_set(11)
    assert kept(world, addon_part, obj) is None
    world.scene.frame_set(10)
    assert kept(world, addon_part, obj) is found
    world.link("new", bpy.data.objects["Box"].data, (0, 0, -0.5))
    world.update()
    assert kept(world, addon_part, obj) is None


def test_what_the_operator_needs(world):
    def why():
        with pytest.raises(RuntimeError) as error:
            bpy.ops.angen.explain()
        return str(error.value)

    obj = operators(world)
    bpy.context.view_layer.objects.active = bpy.data.objects["Box"]
    world.update()
    assert "active" in why()
    bpy.context.view_layer.objects.active = obj
    assert "Simulate first" in why()


def test_the_command_line_tells_the_same(world, addon_part, tmp_path, capsys):
    run_command = addon_part("angen_addon.commands.command_line").run_command
    operators(world)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    capsys.readouterr()

    def explain(*arguments):
        status = run_command(["explain", *arguments])
        told = capsys.readouterr()
        return status, told.out, told.err

    status, out, _ = explain("--sensor", "pir", "--time", "0.375", "--quiet")
    assert status == 0
    assert out.splitlines()[0] == "pir, frame 10 (0.375 s)"
    assert "'Box' came in" in out
    status, out, _ = explain("--sensor", "pir", "--time", "0.37", "--quiet")
    assert (status, "first scan" in out) == (0, True)
    status, out, error = explain("--sensor", "pr", "--time", "0.37")
    assert (status, out, "did you mean pir?" in error) == (2, "", True)
    assert explain("--sensor", "pir")[0] == 2
    assert explain("--sensor", "pir", "--time", "-1")[0] == 2
    bpy.data.objects["pir"].angen_sensor.enabled = False
    status, _, error = explain("--sensor", "pir", "--time", "1")
    assert (status, "switched off" in error) == (1, True)
