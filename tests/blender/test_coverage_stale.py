# SPDX-License-Identifier: GPL-3.0-or-later
"""A coverage map is looked at beside a recording: it does not make it stale."""

from importlib import import_module
from pathlib import Path

import bpy
import pytest

HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"


def test_a_map_of_a_small_room_leaves_a_recording_fresh(world):
    state = import_module("bl_ext.user_default.angen_sensors.angen_addon.runtime.state")
    scene = world.scene
    world.hall(3, 2, 2.5)
    world.pir(update_rate=10.0).location = (0.1, 1.0, 1.5)
    world.box((0.4, 0.4, 0.4), (2, 1, 0.2), "Sofa")
    assert bpy.ops.angen.simulate(frame_start=1, frame_end=12) == {"FINISHED"}
    scene.angen_coverage.motion, scene.angen_coverage.cell = "ARM", 0.5
    bpy.ops.angen.coverage()
    world.update()
    assert any(obj.name.startswith("Coverage") for obj in scene.objects)
    assert state.CACHE.kept(scene).stale == ""
    bpy.ops.ed.undo_push(message="a map")
    scene.objects["Sofa"].location.x += 0.1
    world.update()
    assert "Sofa" in state.CACHE.kept(scene).stale


@pytest.mark.slow
def test_a_map_and_a_proposal_leave_a_recording_fresh(addon):
    state = import_module("bl_ext.user_default.angen_sensors.angen_addon.runtime.state")
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    for obj in scene.objects:
        if obj.angen_sensor.kind == "LIGHT":
            obj.angen_sensor.enabled = False
    scene.angen_live = False
    bpy.ops.angen.simulate(frame_start=1, frame_end=2)
    assert state.CACHE.recording(scene) is not None
    scene.angen_coverage.motion, scene.angen_coverage.cell = "ARM", 2.0
    bpy.ops.angen.coverage()
    bpy.context.view_layer.update()
    assert any(obj.name.startswith("Coverage") for obj in scene.objects)
    assert state.CACHE.kept(scene).stale == ""
    bpy.ops.ed.undo_push(message="a map")
    scene.objects["Sofa"].location.x += 0.1
    bpy.context.view_layer.update()
    assert "Sofa" in state.CACHE.kept(scene).stale
    scene.objects["Sofa"].location.x -= 0.1
    bpy.context.view_layer.update()
    bpy.ops.angen.coverage_clear()
    bpy.context.view_layer.update()
    kept = state.CACHE.kept(scene)
    kept.verify(scene, bpy.context.evaluated_depsgraph_get())
    assert kept.stale == ""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
