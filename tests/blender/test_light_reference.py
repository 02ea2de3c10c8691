# SPDX-License-Identifier: GPL-3.0-or-later
"""A reference takes noise out of the readings of a run, and adds no error of its own."""

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from light_stage import facing, lamp, material, measure, part, plate, request, sky

FEW, MANY = 256, 2048
# Of the readings in this room, most of it where the screen has come close to a sensor.
NOISE = 0.08


@pytest.fixture
def room(world):
    """A room with all that shines; a screen goes through it."""
    box = world.box((4, 4, 4), name="room")
    box.data.materials.append(material(0.7, name="paint"))
    lamp(world, "POINT", at=(0, 0, 1), shadow_soft_size=0.1)
    lamp(world, "AREA", at=(1, 0, 1.9), size=0.5)
    plate(world, 0.8, (1, 1, 0), (-1, 0, 0), material(glows=0.2, name="screen"), "screen")
    world.key(objects("screen"), "location", {1: (1, 1, 0), 48: (-1, -1, 0)})
    sky(world, 0.5)
    world.update()
    return world


@pytest.fixture
def scenes():
    found = part("light_kept").KeptScenes(MANY)
    yield found
    found.close()


def objects(name):
    return bpy.data.objects[name]


def sensors(samples, method="ILLUMINANCE"):
    poses = [((0, 1, 0), (0.3, -1, 0.2)), ((1, 0, 0), (-0.7, 1, 0)), ((0, 0, -1), (1, -1, 1))]
    return [
        request(f"at {n}", facing(*pose), method=method, samples=samples, exposure=0.5)
        for n, pose in enumerate(poses)
    ]


def numbers(found):
    return np.array([s.illuminance_lux or s.luminance_percent for s in found.values()])


def in_a_run(kept, method="ILLUMINANCE"):
    scene, layer = bpy.context.scene, bpy.context.view_layer
    return numbers(part("light").measure(scene, layer, sensors(FEW, method), 1.0, kept))


def plain(samples, method="ILLUMINANCE"):
    return numbers(measure(*sensors(samples, method)))


@pytest.mark.parametrize("method", ["ILLUMINANCE", "FOUR_WALL"])
def test_the_first_frame_is_read_as_by_many_paths(room, scenes, method):
    bpy.context.scene.frame_set(1)
    many, few = plain(MANY, method), plain(FEW, method)
    # A count of the 8-bit pixels of four walls may fall to either side.
    assert in_a_run(scenes, method) == pytest.approx(many, rel=1e-5, abs=0.1)
    assert np.abs(few / many - 1).max() > 0.005


def test_lamps_that_change_are_read_as_by_many_paths(room, scenes):
    data = objects("point").data
    for frame, energy, colour in (
        (1, 1.0, (1, 1, 1)),
        (5, 4.0, (1, 0.2, 0.1)),
        (9, 0.0, (1, 1, 1)),
    ):
        data.energy, data.color = energy, colour
        data.keyframe_insert("energy", frame=frame)
        data.keyframe_insert("color", frame=frame)
    variable = objects("area").data.driver_add("energy").driver.variables.new()
    variable.targets[0].id_type = "LIGHT"
    variable.targets[0].id, variable.targets[0].data_path = data, "energy"
    variable.id_data.animation_data.drivers[0].driver.expression = f"3 - {variable.name} / 2"
    objects("screen").animation_data_clear()
    for frame in (1, 5, 7, 9, 5):
        bpy.context.scene.frame_set(frame)
        assert in_a_run(scenes) == pytest.approx(plain(MANY), rel=1e-5)


def key_lamp(frames=(1, 5), energies=(1.0, 3.0)):
    for frame, energy in zip(frames, energies, strict=True):
        objects("point").data.energy = energy
        objects("point").data.keyframe_insert("energy", frame=frame)


def add_rigid_body():
    with bpy.context.temp_override(object=objects("screen"), active_object=objects("screen")):
        bpy.ops.rigidbody.object_add()


def hide(datablock, what):
    for frame, on in ((1, False), (5, True)):
        setattr(datablock, what, on)
        datablock.keyframe_insert(what, frame=frame)


def move(datablock, what, values):
    for frame, value in zip((1, 5), values, strict=True):
        setattr(datablock, what, value)
        datablock.keyframe_insert(what, frame=frame)


def brighten(tree, name):
    socket = next(n for n in tree.nodes if name in n.inputs).inputs[name]
    move(socket, "default_value", (socket.default_value, socket.default_value * 2))


CHANGES = {
    "nothing but the screen": lambda: None,
    "a lamp's power": key_lamp,
    "a lamp's place": lambda: move(objects("point"), "location", ((0, 0, 1), (1, -1, 0))),
    "a lamp's size": lambda: move(objects("area").data, "size", (0.5, 1.5)),
    "a lamp that is hidden": lambda: hide(objects("point"), "hide_viewport"),
    "a lamp hidden in renders": lambda: hide(objects("point"), "hide_render"),
    "a screen's glow": lambda: brighten(bpy.data.materials["screen"].node_tree, "Strength"),
    "what physics moves": add_rigid_body,
    "a simulation": lambda: objects("screen").modifiers.new("cloth", "CLOTH"),
}


@pytest.mark.parametrize("what", CHANGES)
def test_no_change_makes_a_reading_wrong(room, scenes, what):
    """Against so many paths that they hardly err, and against a reading without a reference."""
    CHANGES[what]()
    engine, errors, without = part("light_engine"), [], []
    for frame in range(1, 10):
        bpy.context.scene.frame_set(frame)
        if frame in (6, 9):
            found, alone = in_a_run(scenes), plain(FEW)
            engine.SEED = 77
            try:
                true = plain(4 * MANY)
            finally:
                engine.SEED = 0
            errors += list(found / true - 1)
            without += list(alone / true - 1)
    assert rms(errors) < min(NOISE, 1.3 * rms(without))
    assert abs(np.mean(errors)) < NOISE / 2


def rms(errors):
    return np.sqrt(np.square(errors).mean())


def test_a_reading_is_the_same_whatever_was_read_before(room, scenes):
    key_lamp(frames=(1, 40), energies=(1.0, 9.0))
    bpy.context.scene.frame_set(30)
    alone = in_a_run(scenes)
    other = part("light_kept").KeptScenes(MANY)
    for frame in (1, 7, 40, 30):
        bpy.context.scene.frame_set(frame)
        again = in_a_run(other)
    other.close()
    assert (again == alone).all()


def test_other_sensors_do_not_count(room, scenes):
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.frame_set(20)
    first = sensors(FEW)[:1]
    alone = numbers(part("light").measure(scene, layer, first, 1.0, scenes))
    assert in_a_run(scenes)[0] == alone[0]


def test_without_more_paths_than_its_own_a_reading_is_as_it_was(room):
    kept = part("light_kept").KeptScenes(FEW)
    bpy.context.scene.frame_set(9)
    assert (in_a_run(kept) == plain(FEW)).all()
    kept.close()


def test_light_that_is_no_number_spoils_no_other_lamp_state(room, scenes):
    scene = bpy.context.scene
    scene.frame_set(3)
    before = in_a_run(scenes)
    objects("area").data.energy = float("nan")
    in_a_run(scenes)
    objects("area").data.energy = 1.0
    scene.frame_set(3)
    assert (in_a_run(scenes) == before).all()


def test_nothing_is_left_and_the_scene_is_as_it_was(room, scenes):
    key_lamp()
    names = ("scenes", "objects", "lights", "meshes", "materials", "cameras", "images", "actions")
    before = [len(getattr(bpy.data, name)) for name in names]
    for frame in (1, 5, 7):
        bpy.context.scene.frame_set(frame)
        in_a_run(scenes)
    assert bpy.context.scene.frame_current == 7
    assert objects("point").data.energy == pytest.approx(3.0)
    scenes.close()
    assert before == [len(getattr(bpy.data, name)) for name in names]
