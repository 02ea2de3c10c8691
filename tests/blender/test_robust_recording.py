# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings in awkward scenes: fresh while no reading can differ, stale as soon as one can."""

import subprocess
import sys
from importlib import import_module

import addon_utils
import bpy
import pytest
from recorded_home import ADDON, cache, ops, stale

LENS = "azimuth, elevation, width, height, polarity, gain\n0, 0, {}, 5, 1, 1\n"


def save_and_load(path):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))


@pytest.fixture
def home(world):
    """A door that opens before a switch, and a box; not yet recorded."""
    world.door(13)
    world.switch("Front door")
    world.box((1, 1, 1), at=(4, 0, 0), name="box")
    return world


def simulate(world):
    world.update()
    assert ops.simulate() == {"FINISHED"}
    assert stale() == ""


def box():
    return bpy.data.objects["box"]


# Scenes whose settings Blender itself changes from frame to frame, or as it saves and loads


def particles(world):
    box().modifiers.new("particles", "PARTICLE_SYSTEM")


def cloth(world):
    box().modifiers.new("cloth", "CLOTH")


def ocean(world):
    """Has a folder for its cache, which Save As writes as a relative path."""
    box().modifiers.new("ocean", "OCEAN").resolution = 4


def mesh_cache(world):
    box().modifiers.new("cache", "MESH_CACHE")


def volume(world):
    world.link("volume", bpy.data.volumes.new("volume"))


def nodes_with_an_input(world):
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    for name, way, kind in (("In", "INPUT", "Geometry"), ("Size", "INPUT", "Float")):
        tree.interface.new_socket(name, in_out=way, socket_type=f"NodeSocket{kind}")
    tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    box().modifiers.new("nodes", "NODES").node_group = tree


def animated_gravity(world):
    world.key(world.scene, "gravity", {1: (0, 0, -9), 40: (0, 0, -1)})


def animated_visibility(world):
    world.key(box(), "hide_viewport", {1: True, 10: False, 20: True}, "CONSTANT")


def animated_by_a_strip(world):
    world.key(box(), "hide_viewport", {1: True, 20: False}, "CONSTANT")
    data = box().animation_data
    data.nla_tracks.new().strips.new("strip", 1, data.action)
    data.action = None


def attributes(world):
    mesh = box().data
    mesh.uv_layers.new()
    for kind in ("STRING", "QUATERNION", "INT8", "BOOLEAN", "BYTE_COLOR"):
        mesh.attributes.new(kind, kind, "POINT")


def image(world):
    made = bpy.data.images.new("image", 4, 4)
    made.filepath_raw = f"{bpy.app.tempdir}image.png"
    made.save()
    paint = bpy.data.materials.new("paint")
    if not paint.node_tree:
        paint.use_nodes = True
    paint.node_tree.nodes.new("ShaderNodeTexImage").image = made
    box().data.materials.append(paint)
    world.sensor("LIGHT", "Light", samples=16)


SCENES = (
    particles, cloth, ocean, mesh_cache, volume, nodes_with_an_input, animated_gravity,
    animated_visibility, animated_by_a_strip, attributes, image,
)  # fmt: skip


@pytest.mark.parametrize("build", SCENES, ids=lambda build: build.__name__)
def test_what_blender_changes_itself_keeps_it_fresh(home, tmp_path, build):
    build(home)
    simulate(home)
    for frame in (7, 15, 48, 20):
        home.scene.frame_set(frame)
        assert stale() == "", f"at frame {frame}"
    save_and_load(tmp_path / "a.blend")
    assert stale() == "", "in the file"
    (tmp_path / "deeper").mkdir()
    save_and_load(tmp_path / "deeper" / "b.blend")
    assert stale() == "", "in another folder"


# Edits that a sensor can tell; each gives the edit itself


def disabled_then_enabled(world):
    box().hide_viewport = True
    return lambda: setattr(box(), "hide_viewport", False)


def warm_material(world):
    material = bpy.data.materials.new("skin")
    box().data.materials.append(material)
    world.pir("PIR", model="PYROELECTRIC")
    return lambda: setattr(material.angen_warmth, "use_temperature", True)


def own_lens(world):
    text = bpy.data.texts.new("lens")
    text.from_string(LENS.format(5))
    world.pir("PIR", model="PYROELECTRIC", lens_table=text)
    return lambda: text.from_string(LENS.format(9))


def partners(world):
    group = bpy.data.collections.new("partners")
    world.sensor("PRESSURE", "pad", world.box((1, 1, 0.1), name="pad"), partner_collection=group)
    return lambda: group.objects.link(box())


def other_image(world):
    image(world)
    other = bpy.data.images.new("other", 32, 4)
    other.filepath_raw = f"{bpy.app.tempdir}other.png"
    other.save()
    return lambda: setattr(bpy.data.images["image"], "filepath", f"{bpy.app.tempdir}other.png")


def gravity(world):
    return lambda: world.scene.gravity.__setitem__(2, -3.0)


EDITS = (disabled_then_enabled, warm_material, own_lens, partners, other_image, gravity)


@pytest.mark.parametrize("prepare", EDITS, ids=lambda prepare: prepare.__name__)
def test_what_a_sensor_can_tell_makes_it_stale(home, prepare):
    edit = prepare(home)
    simulate(home)
    edit()
    home.update()
    # Of an edit in a text Blender tells at no time.
    home.scene.frame_set(20)
    assert stale()


def test_an_edit_in_another_scene_of_what_both_have(home):
    simulate(home)
    first, other = home.scene, bpy.data.scenes.new("other")
    other.collection.objects.link(box())
    bpy.context.window.scene = other
    home.update()
    box().location.x = 9
    home.update()
    bpy.context.window.scene = first
    assert stale()
    first.frame_set(5)
    assert stale() == "changed since: 'box'"
    box().location.x = 4
    home.update()
    assert stale() == ""


def test_an_edit_in_another_scene_of_its_own(home):
    simulate(home)
    first, other = home.scene, bpy.data.scenes.new("other")
    own = bpy.data.objects.new("own", None)
    other.collection.objects.link(own)
    bpy.context.window.scene = other
    own.location.x = 9
    home.update()
    bpy.context.window.scene = first
    assert stale() == ""


def test_a_library_that_changed(home, tmp_path):
    library = str(tmp_path / "library.blend")
    bpy.data.libraries.write(library, {box()}, fake_user=True)
    bpy.data.objects.remove(box())
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.objects = ["box"]
    home.scene.collection.objects.link(wanted.objects[0])
    simulate(home)
    save_and_load(tmp_path / "a.blend")
    assert stale() == ""
    move = (
        f"import bpy, os; bpy.ops.wm.open_mainfile(filepath={library!r});"
        "bpy.data.objects['box'].location.x = 7; bpy.ops.wm.save_mainfile(); os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", move], capture_output=True, check=True)
    bpy.data.libraries[0].reload()
    bpy.context.view_layer.update()
    assert "'box [library.blend]'" in stale()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert "'box [library.blend]'" in stale()


def test_texts_of_the_user_that_are_called_the_same(home, tmp_path):
    simulate(home)
    for name in (".angen_recording", ".angen_recording_notes"):
        bpy.data.texts.new(name).write("mine")
    save_and_load(tmp_path / "a.blend")
    bpy.ops.wm.save_mainfile()
    assert [text.as_string() for text in bpy.data.texts] == ["mine", "mine"]
    assert stale() == ""


def test_a_file_opened_before_the_extension_was_switched_on(home, tmp_path):
    simulate(home)
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    addon_utils.disable(ADDON)
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
    finally:
        addon_utils.enable(ADDON, default_set=True)
    for _ in range(2):
        bpy.ops.wm.save_mainfile()
    assert not bpy.data.texts
    bpy.ops.wm.open_mainfile(filepath=path)
    assert stale() == ""


def test_a_storm_of_undo_and_redo(home):
    simulate(home)
    bpy.ops.ed.undo_push(message="recorded")
    for count in range(12):
        box().location.x = 5 + count
        bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message=str(count))
    for step, expected in ((bpy.ops.ed.undo, ""), (bpy.ops.ed.redo, "changed since: 'box'")) * 2:
        for _ in range(12):
            step()
        assert stale() == expected


def test_a_sensor_that_never_was_on(home, tmp_path):
    """Its track is empty."""
    quiet = home.switch("Quiet")
    home.key(quiet, "angen_sensor.enabled", {1: False, 100: True}, "CONSTANT")
    simulate(home)
    save_and_load(tmp_path / "a.blend")
    assert stale() == ""
    assert len(cache().recording(bpy.context.scene).tracks["Quiet"]) == 0
    assert ops.bake_keyframes() == {"FINISHED"}
    assert ops.export_report(filepath=str(tmp_path / "report.html")) == {"FINISHED"}


@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"])
def test_a_sensor_whose_place_is_no_number_says_what_to_look_at(home, kind):
    sensor = home.sensor(kind, "lost", home.box((1, 1, 0.1), name="lost"), update_rate=12.0)
    home.key(sensor, "location", {1: (0, 0, 0), 11: (0, 0, 0)}, "CONSTANT")
    curves = import_module(f"{ADDON}.angen_addon.scene.animation").curves(sensor, {"location"})
    curves[0].keyframe_points[1].co.y = float("nan")
    with pytest.raises(RuntimeError, match=r"'lost': its transform is not a number.* keys"):
        ops.simulate()
    assert cache().recording(home.scene).frame_end < 11
