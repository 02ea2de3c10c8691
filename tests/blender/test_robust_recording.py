# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings in difficult scenes and in files.

They are fresh while no reading can differ, stale as soon as one can, and an error is one line.
"""

import subprocess
import sys
from importlib import import_module

import addon_utils
import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import handlers
from recorded_home import ADDON, columns, move, named, ops, recorded, results, save_and_load, stale

LENS = "azimuth, elevation, width, height, polarity, gain\n0, 0, {}, 5, 1, 1\n"


def save_and_open(path):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))


@pytest.fixture
def home(world):
    """Add a door that opens before a switch, and a box, without a recording."""
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


# Scenes whose settings Blender itself changes from frame to frame, or when it saves and loads


def nodes_with_an_input(world):
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    for name, way, kind in (("In", "INPUT", "Geometry"), ("Size", "INPUT", "Float")):
        tree.interface.new_socket(name, in_out=way, socket_type=f"NodeSocket{kind}")
    tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    box().modifiers.new("nodes", "NODES").node_group = tree


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


def modified(kind, **settings):
    def build(world):
        modifier = box().modifiers.new(kind.lower(), kind)
        for name, value in settings.items():
            setattr(modifier, name, value)

    return build


SCENES = {
    "particles": modified("PARTICLE_SYSTEM"),
    "cloth": modified("CLOTH"),
    # It has a folder for its cache, which Save As writes as a relative path.
    "ocean": modified("OCEAN", resolution=4),
    "mesh cache": modified("MESH_CACHE"),
    "volume": lambda world: world.link("volume", bpy.data.volumes.new("volume")),
    "gravity": lambda world: world.key(world.scene, "gravity", {1: (0, 0, -9), 40: (0, 0, -1)}),
    "nodes with an input": nodes_with_an_input,
    "a strip": animated_by_a_strip,
    "attributes": attributes,
    "image": image,
}


@pytest.mark.parametrize("build", SCENES.values(), ids=SCENES)
def test_what_blender_changes_itself_keeps_it_fresh(home, tmp_path, build):
    build(home)
    simulate(home)
    for frame in (7, 15, 48, 20):
        home.scene.frame_set(frame)
        assert stale() == "", f"at frame {frame}"
    save_and_open(tmp_path / "a.blend")
    assert stale() == "", "in the file"
    (tmp_path / "deeper").mkdir()
    save_and_open(tmp_path / "deeper" / "b.blend")
    assert stale() == "", "in another folder"


# Edits that change a reading; each function returns the edit


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
    # Blender never reports an edit of a text.
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


def test_a_library_that_changed(home, tmp_path):
    library = str(tmp_path / "library.blend")
    bpy.data.libraries.write(library, {box()}, fake_user=True)
    bpy.data.objects.remove(box())
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.objects = ["box"]
    home.scene.collection.objects.link(wanted.objects[0])
    simulate(home)
    save_and_open(tmp_path / "a.blend")
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
    save_and_open(tmp_path / "a.blend")
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


def test_it_survives_that_the_extension_is_switched_off_and_on(kept_home, tmp_path, monkeypatch):
    """An upgrade is a switching off and on."""
    before = columns()
    monkeypatch.setattr(handlers, "_is_without_window", lambda: False)
    path = str(tmp_path / "a.blend")
    addon_utils.disable(ADDON)
    try:
        bpy.ops.wm.save_as_mainfile(filepath=path)
    finally:
        addon_utils.enable(ADDON, default_set=True)
    # Blender calls timers only in a window.
    assert bpy.app.timers.is_registered(handlers._read_open_file)
    handlers._read_open_file()
    assert stale() == "" and columns() == before and not bpy.data.texts
    bpy.ops.wm.open_mainfile(filepath=path)
    assert stale() == "" and columns() == before
    assert not bpy.app.timers.is_registered(handlers._read_open_file)


def test_a_sensor_that_never_was_on(home, tmp_path):
    """Its track is empty."""
    quiet = home.switch("Quiet")
    home.key(quiet, "angen_sensor.enabled", {1: False, 100: True}, "CONSTANT")
    simulate(home)
    save_and_open(tmp_path / "a.blend")
    assert stale() == ""
    assert len(results().recording(bpy.context.scene).tracks["Quiet"]) == 0
    assert ops.bake_keyframes() == {"FINISHED"}
    assert ops.export_report(filepath=str(tmp_path / "report.html")) == {"FINISHED"}


# A file keeps its recording, and an unreadable recording is an error of one line


@pytest.fixture
def kept_home(world):
    return recorded(world)


def test_a_file_keeps_it(kept_home, tmp_path):
    before = columns()
    save_and_load(tmp_path / "a.blend")
    assert stale() == "" and columns() == before and not bpy.data.texts
    sensor = named("Front door")
    bpy.context.scene.angen_live = False
    for frame in (20, 5, 13):
        bpy.context.scene.frame_set(frame)
        assert sensor.angen_sensor.active == (frame >= 13)
    assert ops.export_events(filepath=str(tmp_path / "events.csv")) == {"FINISHED"}
    move(named("shelf"))
    kept_home.update()
    assert "'shelf'" in stale()
    save_and_load(tmp_path / "b.blend")
    assert "'shelf'" in stale() and columns() == before, "stale ones are kept too, and stay so"
    named("shelf").location.x -= 0.5
    kept_home.update()
    assert stale() == ""


def test_a_sample_is_shipped_with_its_recording_and_timelines_at_its_length(kept_home, tmp_path):
    """Its script saves it; live values equal the recorded ones as soon as it is opened."""
    from sample_blends import build_angen

    ops.clear_recording()
    kept_home.scene.frame_end = 400
    build_angen.record_and_save(tmp_path / "sample.blend")
    before = columns()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "sample.blend"), load_ui=True)
    kept = results().kept(bpy.context.scene)
    assert stale() == "" and columns() == before
    assert (kept.recording.frame_start, kept.recording.frame_end) == (1, 400)
    areas = [a for s in bpy.data.screens for a in s.areas if a.type == "DOPESHEET_EDITOR"]
    assert {area.spaces.active.mode for area in areas} >= {"TIMELINE"}
    for area in areas:
        region = next(r for r in area.regions if r.type == "WINDOW")
        left, right = (region.view2d.region_to_view(x, 0)[0] for x in (0, region.width))
        assert -30 <= left <= 1 and 400 <= right <= 460


def test_clear_takes_it_out_of_the_file(kept_home, tmp_path):
    save_and_load(tmp_path / "a.blend")
    assert ops.clear_recording() == {"FINISHED"}
    save_and_load(tmp_path / "a.blend")
    assert stale() is None and not bpy.data.texts
    assert not ops.clear_recording.poll()


def test_every_scene_keeps_its_own(kept_home, tmp_path):
    kept_home.scene.name = "one"
    bpy.ops.scene.new(type="FULL_COPY")
    bpy.context.scene.name = "two"
    bpy.context.scene.frame_end = 10
    kept_home.update()
    assert stale() is None
    ops.simulate()
    save_and_load(tmp_path / "a.blend")
    assert bpy.context.scene.name == "two"
    assert stale() == "" and results().kept(bpy.context.scene).recording.frame_end == 10
    bpy.context.window.scene = bpy.data.scenes["one"]
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(3)
    assert stale() == "" and results().kept(bpy.context.scene).recording.frame_end == 48


def damage(path, change):
    """Save the file with a changed recording text, as Blender without the extension may."""
    store = import_module(f"{ADDON}.angen_addon.recording.store")
    store.put_into_file()
    (text,) = (t for t in bpy.data.texts if t.name.startswith(store.TEXT))
    body = text.as_string()
    results().clear_recording(bpy.context.scene)
    text.from_string(change(body))
    # Saved without the handlers.
    mine = import_module(f"{ADDON}.angen_addon.runtime.handlers")
    mine.unregister()
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
    finally:
        mine.register()
    bpy.ops.wm.open_mainfile(filepath=str(path))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda body: body[:-400], "damaged"),
        (lambda body: body.replace("A", "B"), "damaged"),
        (lambda body: "", "damaged"),
        (lambda body: body.splitlines()[0], "not a recording"),
        (lambda body: "hello", "damaged"),
        (lambda body: body.splitlines()[0] + "\n§§§", "damaged"),
    ],
)
def test_what_cannot_be_read_is_told_and_dropped(kept_home, tmp_path, capfd, change, words):
    damage(tmp_path / "a.blend", change)
    assert stale() is None
    assert not bpy.data.texts
    assert words in results().notice and "Simulate again" in results().notice
    said = capfd.readouterr()
    assert words in said.err and "Traceback" not in said.out + said.err
    ops.simulate()
    assert results().notice == "" and stale() == ""


@pytest.fixture
def newer(monkeypatch):
    """Make this another version of Blender than that of the recording."""

    def become():
        for name in ("followed_scene", "stored_recording"):
            part = import_module(f"{ADDON}.angen_addon.recording.{name}")
            monkeypatch.setattr(part, "THIS_BLENDER", (9, 9))
        # The digests of another version differ.
        fingerprint = import_module(f"{ADDON}.angen_addon.recording.fingerprint")
        facts_of = fingerprint.facts_of
        monkeypatch.setattr(fingerprint, "facts_of", lambda datablock: [facts_of(datablock), "new"])

    return become


def test_in_another_blender_a_fresh_recording_is_shown_and_said_to_be_made_elsewhere(
    kept_home, tmp_path, newer
):
    before, made_in = columns(), ".".join(map(str, bpy.app.version[:2]))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    newer()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert stale() == "" and columns() == before
    shelf = named("shelf")
    shelf.location.x += 0.5
    bpy.context.view_layer.update()
    assert "'shelf'" in stale(), "edits from now on count"
    shelf.location.x -= 0.5
    bpy.context.view_layer.update()
    assert stale() == ""
    save_and_load(tmp_path / "b.blend")
    kept = results().kept(bpy.context.scene)
    assert stale() == "" and ".".join(map(str, kept.made_in)) == made_in


def test_in_another_blender_a_stale_recording_stays_stale(kept_home, tmp_path, newer):
    version = ".".join(map(str, bpy.app.version[:2]))
    kept = results().kept(kept_home.scene)
    kept.fingerprint.digests["Object shelf"] = "another"
    kept.verify(kept_home.scene, bpy.context.evaluated_depsgraph_get())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "stale.blend"))
    newer()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "stale.blend"))
    assert stale() == f"it was made in Blender {version}"


def test_a_recording_of_an_earlier_version_of_the_extension_is_stale(kept_home, tmp_path):
    """Its digests have other inputs, and cannot be compared."""
    results().kept(kept_home.scene).facts = 1
    save_and_load(tmp_path / "a.blend")
    assert stale() == "it was made by an earlier version of Ängen Sensors"


def test_without_the_extension_a_file_has_a_hidden_text_and_nothing_else(kept_home, tmp_path):
    """Another process opens the file, and saves it."""
    import subprocess

    path = tmp_path / "a.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    program = (
        "import bpy, os, sys\n"
        f"bpy.ops.wm.open_mainfile(filepath={str(path)!r})\n"
        "print([t.name for t in bpy.data.texts], [k for k in bpy.context.scene.keys()])\n"
        "bpy.context.scene.frame_set(20)\n"
        f"bpy.ops.wm.save_as_mainfile(filepath={str(path)!r})\n"
        "sys.stdout.flush(); os._exit(0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60
    )
    assert "['.angen_recording']" in done.stdout and "Error" not in done.stdout + done.stderr
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert stale() == ""


def test_the_command_line_keeps_it_in_the_copy_that_it_saves(kept_home, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    ops.clear_recording()
    run = import_module(f"{ADDON}.angen_addon.commands.command_line").run_command
    save, events = str(tmp_path / "b.blend"), str(tmp_path / "b.csv")
    assert run(["simulate", "--quiet", "--bake", "--save", save, "--events", events]) == 0
    bpy.ops.wm.open_mainfile(filepath=save)
    assert stale() == ""
    assert ops.export_events(filepath=str(tmp_path / "again.csv")) == {"FINISHED"}
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
