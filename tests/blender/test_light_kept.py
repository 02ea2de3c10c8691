# SPDX-License-Identifier: GPL-3.0-or-later
"""A light scene that is kept from update to update gives the same bits as a new one."""

import sys
from pathlib import Path

import bpy
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from light_stage import facing, lamp, measure, part, plate, request
from test_light_signature import STEPS, objects, room, step

__all__ = ["room"]
FRAMES = (1, 4, 5, 6, 2, 5)


def asked():
    """One among the lamps, one that looks at the screen through open air, and a lux meter."""
    return [
        request("a", facing((0, 1, 0), (0.3, -1, 0.2)), method="FOUR_WALL", samples=16),
        request("b", facing((1, 0, 0), (-0.7, 1, 0)), method="FOUR_WALL", samples=16, clip_end=1.9),
        request("c", facing((0, 1, 0), (0.3, -1, 0.2)), samples=16),
    ]


@pytest.fixture
def kept(room):
    scenes = part("light_kept").KeptScenes()
    yield scenes
    scenes.close()


def at(frame, kept):
    """What both read at a frame, with and without what was kept."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.frame_set(frame)
    with_kept = part("light").measure(scene, layer, asked(), 1.0, kept)
    alone = measure(*asked())
    assert dict(with_kept) == alone, frame
    return tuple(s.luminance_percent or s.illuminance_lux for s in alone.values())


@pytest.mark.parametrize("what", STEPS)
def test_each_change_of_the_scene_is_taken_over(room, kept, what):
    STEPS[what]()
    found = [at(frame, kept) for frame in FRAMES]
    assert found[0] == found[1] == found[4]
    assert found[2] == found[3] == found[5]


def test_all_of_them_at_once(room, kept):
    for what in STEPS:
        STEPS[what]()
    found = [at(frame, kept) for frame in FRAMES]
    assert found[0] != found[2]


def test_drivers_people_and_sub_frames(room, kept):
    source = room.link("source", None)
    room.key(source, "location", {1: (0, 0, 0), 10: (9, 0, 0)})
    driver = objects("point").data.driver_add("energy").driver
    variable = driver.variables.new()
    variable.targets[0].id = source
    variable.targets[0].data_path = "location.x"
    driver.expression = f"1 + {variable.name}"
    walker = plate(room, 0.8, (0, 0, 0), (0, -1, 0), objects("room").data.materials[0], "walker")
    walker.shape_key_add(name="Basis")
    bent = walker.shape_key_add(name="bent")
    bent.data[0].co.z += 0.5
    room.key(walker.data.shape_keys, 'key_blocks["bent"].value', {1: 0.0, 8: 1.0})
    room.key(walker, "location", {1: (0, 0, 0), 8: (0.4, 0.8, 0)})
    found = [at(frame, kept) for frame in (1, 2, 5, 8, 3)]
    assert len(set(found)) == 5
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.frame_set(3, subframe=0.5)
    assert dict(part("light").measure(scene, layer, asked(), 1.0, kept)) == measure(*asked())


def test_a_wall_that_opens_the_view_to_its_far_end(room, kept):
    step(objects("screen"), "location", (1, 1, 0), (1, -1.5, 0))
    found = [at(frame, kept) for frame in FRAMES]
    assert found[0][1] != found[2][1]


def test_things_added_removed_or_moved_by_physics_between(room, kept):
    before = at(1, kept)
    added = lamp(room, "POINT", at=(0.5, 0.5, 0.5), energy=30.0)
    assert at(1, kept) != before
    bpy.data.objects.remove(added)
    assert at(1, kept) == before
    with bpy.context.temp_override(object=objects("screen"), active_object=objects("screen")):
        bpy.ops.rigidbody.object_add()
    assert len({at(frame, kept) for frame in range(1, 13)}) > 1


def test_nothing_is_left(room, kept):
    scene, layer = bpy.context.scene, bpy.context.view_layer
    names = ("scenes", "objects", "meshes", "materials", "cameras", "images", "worlds")
    before = [len(getattr(bpy.data, name)) for name in names]
    for frame in (1, 5, 7):
        scene.frame_set(frame)
        part("light").measure(scene, layer, asked(), 1.0, kept)
    kept.close()
    assert before == [len(getattr(bpy.data, name)) for name in names]
