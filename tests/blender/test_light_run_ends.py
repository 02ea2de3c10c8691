# SPDX-License-Identifier: GPL-3.0-or-later
"""What ends a run half-way (undo, redo, another file), and how much it keeps meanwhile."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import stage, state
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.sensor_logic.error import AngenError
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from light_stage import lamp, material, plate, sky
from tiers import mostly_slow

UPDATES = 60
# Not images: Blender puts an empty "Render Result" into files that it saves and undoes.
KINDS = (
    "scenes", "objects", "meshes", "materials", "lights", "cameras", "collections", "worlds",
    "actions", "node_groups",
)  # fmt: skip


@pytest.fixture(autouse=True)
def each_frame_is_told(monkeypatch):
    """As of frames that take long."""
    monkeypatch.setattr(stage, "TELL_EVERY", -1.0)


@pytest.fixture
def room(world):
    """With two light sensors that have references; one that undo moves back."""
    box = world.box((4, 4, 4), name="room")
    box.data.materials.append(material(0.7, name="paint"))
    data = lamp(world, "POINT", at=(0, 0, 1), shadow_soft_size=0.1).data
    for frame in (1, 48):
        data.energy = float(frame)
        data.keyframe_insert("energy", frame=frame)
    lamp(world, "SUN")
    plate(world, 0.8, (1, 1, 0), (-1, 0, 0), material(glows=0.2, name="screen"), "screen")
    world.key(bpy.data.objects["screen"], "location", {1: (1, 1, 0), 48: (-1, -1, 0)})
    sky(world, 0.5)
    settings = {"engine": "CYCLES", "samples": 16, "update_rate": 24.0}
    for name, method in (("lux", "ILLUMINANCE"), ("walls", "FOUR_WALL")):
        sensor = world.sensor("LIGHT", name, method=method, **settings)
        sensor.location = (0.3, -1, 0.2)
    world.scene.angen_light_reference = 64
    world.update()
    bpy.ops.ed.undo_push(message="built")
    bpy.context.scene.objects["room"].location.x = 0.25
    world.update()
    bpy.ops.ed.undo_push(message="moved")
    return world


def held():
    return {kind: sorted(d.name for d in getattr(bpy.data, kind)) for kind in KINDS}


def half_way(world):
    """A run after a few frames, with scenes kept; and its recording."""
    recording = Recording()
    run = simulate(world.scene, world.sensors(), 1, 48, recording)
    while recording.frame_end < 3:
        next(run)
    assert len(bpy.data.scenes) == 2
    return run, recording


def test_what_takes_long_is_told_before_and_can_be_left(room):
    """Each picture is a step of its own: whoever asked can stop between two, and nothing stays."""
    before = held()
    doing = [progress.doing for progress in simulate(room.scene, room.sensors(), 1, 2, Recording())]
    told = list(dict.fromkeys(doing))
    assert told[0] == "Cycles takes the scene in" and doing[-1] == ""
    assert any(text.startswith("the light's reference") for text in told)
    # Two methods, for each of which the first frame is traced and then the present one.
    assert doing.count("Cycles takes the scene in") == 1 and len(doing) > 6
    for steps in range(1, len(doing)):
        run = simulate(room.scene, room.sensors(), 1, 2, Recording())
        for _ in range(steps):
            next(run)
        run.close()
        assert held() == before and not state.CACHE.running, steps


def undo(_):
    bpy.ops.ed.undo()


def undo_and_redo(_):
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()


def undo_and_redo_of_a_step_made_amid(_):
    bpy.ops.ed.undo_push(message="amid")
    undo_and_redo(_)


def save_and_open(folder):
    path = str(folder / "half.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=path)


ENDS = (undo, undo_and_redo, undo_and_redo_of_a_step_made_amid, save_and_open)


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("how", mostly_slow(["closed", "gone on with"], "gone on with"))
def test_nothing_is_left_of_a_run(room, ends, how, tmp_path):
    """What was recorded stays; a run that is gone on with says that it cannot."""
    before = held()
    run, recording = half_way(room)
    ends(tmp_path)
    assert held() == before
    if how == "closed":
        run.close()
    else:
        with pytest.raises(AngenError, match="was removed during it"):
            list(run)
    assert held() == before
    assert len(recording.tracks["lux"]) == 3 and not state.CACHE.running
    room.update()
    assert len(room.run(1, 3).tracks["lux"]) == 3
    assert held() == before


def test_nothing_is_left_of_a_run_in_another_file(room):
    run, recording = half_way(room)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    before = held()
    with pytest.raises(AngenError, match="was removed during it"):
        list(run)
    assert held() == before
    assert len(recording.tracks["lux"]) == 3 and not state.CACHE.running


def test_undo_after_a_run_to_a_step_made_amid(room):
    before = held()
    run, _ = half_way(room)
    bpy.ops.ed.undo_push(message="amid")
    run.close()
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert held() == before
    bpy.ops.ed.redo()
    assert held() == before


def test_doors_that_open_views_need_no_further_reference(world):
    """However many of them open and shut, and in whatever order."""
    room = world.box((8, 8, 4), name="room")
    room.data.materials.append(material(0.7, name="paint"))
    lamp(world, "POINT", at=(0, 0, 1), shadow_soft_size=0.1)
    turns = np.random.default_rng(0).random((4, UPDATES)) < 0.5
    for n, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        plate(world, 1.0, (x, y, 0), (x, y, 0), material(0.5, name=f"paint {n}"), f"door {n}")
        places = {k + 1: (x, y, 1.7 * shut) for k, shut in enumerate(turns[n].tolist())}
        world.key(bpy.data.objects[f"door {n}"], "location", places, "CONSTANT")
    settings = {"method": "FOUR_WALL", "engine": "CYCLES", "samples": 8, "update_rate": 24.0}
    sensor = world.sensor("LIGHT", "walls", clip_start=0.3, clip_end=2.0, **settings)
    sensor.rotation_euler = (math.pi / 2, 0, 0)
    world.scene.angen_light_reference = 32
    scenes, frames = [], set()
    for progress in simulate(world.scene, world.sensors(), 1, UPDATES, Recording()):
        scenes.append(len(bpy.data.scenes))
        if "reference" in progress.doing:
            frames.add(progress.frame)
    assert frames == {1} and max(scenes) == 2
