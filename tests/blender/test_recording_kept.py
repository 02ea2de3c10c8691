# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording stays as long as the scene is the one that it was made of: through undo, redo, saving
and loading; and it is stale, and says of what, exactly while the scene is another."""

import base64
import sys
from importlib import import_module

import bpy
import pytest

ADDON = "bl_ext.user_default.angen_sensors"
ops = bpy.ops.angen


def cache():
    return import_module(f"{ADDON}.angen_addon.runtime.state").CACHE


def stale():
    """Why the recording is stale; empty where it is fresh, None where there is none."""
    kept = cache().kept(bpy.context.scene)
    return kept.stale if kept is not None else None


def columns():
    recording = cache().kept(bpy.context.scene).recording
    return {
        name: [track.frames, track.times, track.active, track.value]
        for name, track in recording.tracks.items()
    }


@pytest.fixture
def home(world):
    """A door that opens before a switch, a lamp, a skinned flag, nodes; recorded."""
    leaf = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.02), name="door")
    world.key(leaf, "location", {1: (0, 0, -0.02), 13: (1, 0, -0.02)}, "CONSTANT")
    world.switch("Front door")
    shelf = world.box((1, 1, 1), at=(3, 0, 0), name="shelf")
    material = bpy.data.materials.new("paint")
    shelf.data.materials.append(material)
    shelf.modifiers.new("copies", "ARRAY").count = 2
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    math = tree.nodes.new("ShaderNodeMath")
    math.inputs[0].default_value = 0.25
    shelf.modifiers.new("nodes", "NODES").node_group = tree
    shelf.shape_key_add(name="Basis")
    shelf.shape_key_add(name="wide")
    group = shelf.vertex_groups.new(name="top")
    group.add([0, 1], 0.5, "REPLACE")
    lamp = world.link("lamp", bpy.data.lights.new("lamp", "POINT"), (0, 0, 3))
    lamp.parent = shelf
    world.link("camera", bpy.data.cameras.new("camera"))
    hidden = world.box((1, 1, 1), at=(9, 0, 0), name="hidden")
    hidden.hide_set(True)
    world.update()
    assert ops.simulate() == {"FINISHED"}
    assert stale() == ""
    bpy.ops.ed.undo_push(message="recorded")
    return world


def objects():
    return bpy.data.objects


def move(world):
    objects()["shelf"].location.x += 0.5


def move_what_is_animated(world):
    objects()["door"].location.x += 0.5


def move_a_key(world):
    action = objects()["door"].animation_data.action
    curves = world_curves(objects()["door"])
    curves[0].keyframe_points[1].co.x = 20
    curves[0].update()
    action.update_tag()


def world_curves(obj):
    return import_module(f"{ADDON}.angen_addon.animation").curves(obj, {"location"})


def parameter(world):
    objects()["Front door"].angen_sensor.optical_switch.threshold = 0.1


def seed(world):
    world.scene.angen_seed = 5


def mass(world):
    objects()["shelf"].angen_load.mass = 3.0


def frame_rate(world):
    world.scene.render.fps = 30


def start_frame(world):
    world.scene.frame_start = 5


def units(world):
    world.scene.unit_settings.scale_length = 0.5


def vertex(world):
    mesh = objects()["shelf"].data
    mesh.vertices[0].co.x += 1
    mesh.update()


def modifier(world):
    objects()["shelf"].modifiers["copies"].count = 3


def modifier_off(world):
    objects()["shelf"].modifiers["copies"].show_viewport = False


def node(world):
    bpy.data.node_groups["nodes"].nodes[0].inputs[0].default_value = 0.5


def shape_key(world):
    objects()["shelf"].data.shape_keys.key_blocks["wide"].value = 0.5


def weight(world):
    objects()["shelf"].vertex_groups["top"].add([0], 0.9, "REPLACE")
    objects()["shelf"].data.update()


def hide(world):
    objects()["shelf"].hide_set(True)


def show(world):
    objects()["hidden"].hide_set(False)


def disable(world):
    objects()["shelf"].hide_viewport = True


def add(world):
    world.box((1, 1, 1), at=(5, 5, 5), name="new")


def remove(world):
    objects().remove(objects()["shelf"])


def unparent(world):
    objects()["lamp"].parent = None


def rename_sensor(world):
    objects()["Front door"].name = "Back door"


def driver(world):
    objects()["shelf"].driver_add("location", 2).driver.expression = "frame"


def exclude(world):
    inner = bpy.data.collections.new("inner")
    world.scene.collection.children.link(inner)


EDITS = {
    move: "'shelf'",
    move_what_is_animated: "'door'",
    move_a_key: "'door'",
    parameter: "'Front door'",
    seed: "the scene's settings",
    mass: "'shelf'",
    frame_rate: "the scene's settings",
    start_frame: "the scene's settings",
    units: "the scene's settings",
    vertex: "",
    modifier: "'shelf'",
    modifier_off: "'shelf'",
    node: "'nodes'",
    shape_key: "'Key'",
    weight: "'shelf'",
    hide: "what is shown or hidden",
    show: "what is shown or hidden",
    disable: "'shelf'",
    add: "'new' (new)",
    remove: "'shelf' (gone)",
    unparent: "'lamp'",
    rename_sensor: "'Front door' is called 'Back door'",
    driver: "'shelf'",
    exclude: "what is shown or hidden",
}


def test_a_new_sensor_is_named_as_what_changed(home):
    """Nobody touched the scene's settings, nor hid anything."""
    ops.sensor_add(kind="PIR")
    name = bpy.context.object.name
    assert f"'{name}' (new)" in stale()
    assert "settings" not in stale() and "hidden" not in stale()


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit.__name__)
def test_an_edit_makes_it_stale_and_its_undo_fresh(home, edit):
    before = columns()
    edit(home)
    home.update()
    assert "changed since" in stale() and EDITS[edit] in stale()
    for operator in (ops.export_events, ops.export_samples, ops.bake_keyframes):
        with pytest.raises(RuntimeError, match=r"stale.*Simulate again"):
            operator()
    bpy.ops.ed.undo_push(message="edit")
    bpy.ops.ed.undo()
    assert stale() == ""
    assert columns() == before
    track = cache().recording(bpy.context.scene).track_of(objects()["Front door"].session_uid)
    assert track is not None, "sensors are found after undo"
    if edit is move_what_is_animated:
        return  # what keys say is back in place at any evaluation
    bpy.ops.ed.redo()
    assert "changed since" in stale()


def select(world):
    objects()["shelf"].select_set(True)
    bpy.context.view_layer.objects.active = objects()["shelf"]


def recolour(world):
    bpy.data.materials["paint"].diffuse_color = (1, 0, 0, 1)
    bpy.data.materials["paint"].metallic = 0.5


def move_the_camera(world):
    objects()["camera"].location.x += 1
    objects()["camera"].data.lens = 20


def move_and_come_back(world):
    where = objects()["shelf"].location.copy()
    objects()["shelf"].location.x += 1
    world.update()
    assert stale()
    objects()["shelf"].location = where


def look_into_edit_mode(world):
    select(world)
    bpy.ops.object.mode_set(mode="EDIT")
    world.update()
    assert stale()
    bpy.ops.object.mode_set(mode="OBJECT")


def last_frame(world):
    world.scene.frame_end = 100


def brightness(world):
    objects()["lamp"].data.energy = 1000


def room(world):
    objects()["Front door"].angen_sensor.room = "hall"


def playhead(world):
    for frame in (20, 1, 13, 48):
        world.scene.frame_set(frame)


@pytest.mark.parametrize(
    "act",
    [
        select,
        recolour,
        move_the_camera,
        move_and_come_back,
        look_into_edit_mode,
        last_frame,
        brightness,
        playhead,
        room,
    ],
    ids=lambda act: act.__name__,
)
def test_what_moves_no_reading_keeps_it_fresh(home, act):
    before = columns()
    act(home)
    home.update()
    assert stale() == ""
    bpy.ops.ed.undo_push(message="act")
    bpy.ops.ed.undo()
    assert stale() == "" and columns() == before


def test_a_renamed_sensor_is_all_that_is_told(home, tmp_path):
    """Its housing and a driver refer to it; after loading the reason is the same."""
    housing = home.box((0.1, 0.1, 0.1), at=(0, 0, 0.1), name="housing")
    housing.parent = objects()["Front door"]
    other = home.switch("Other door")
    other.location.x = 7
    target = objects()["shelf"].driver_add("scale", 2).driver.variables.new().targets[0]
    target.id, target.data_path = objects()["Front door"], "angen_sensor.value"
    home.update()
    ops.simulate()
    assert stale() == ""
    objects()["Front door"].name = "Back door"
    home.update()
    reason = "changed since: 'Front door' is called 'Back door'"
    assert stale() == reason
    save_and_load(tmp_path / "a.blend")
    assert stale() == reason
    objects()["Front door" if "Front door" in objects() else "Back door"].name = "x"
    objects()["Other door"].name = "Front door"
    objects()["x"].name = "Other door"
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(7)
    assert "'Front door' is called 'Other door'" in stale()
    assert "'Other door' is called 'Front door'" in stale() and stale().count(",") == 1
    objects()["Front door"].name = "x"
    objects()["Other door"].name = "Front door"
    objects()["x"].name = "Other door"
    bpy.context.scene.frame_set(8)
    assert stale() == ""


# What only says what is shown and what is done with results.
OF_THE_VIEW = {"angen_cleared", "angen_coverage", "angen_live", "angen_overlay", "angen_timeline"}


def scene_settings():
    return [p for p in bpy.types.Scene.bl_rna.properties if p.identifier.startswith("angen_")]


def change(scene, prop):
    """Another value of a setting."""
    name, value = prop.identifier, getattr(scene, prop.identifier)
    if prop.type == "ENUM":
        value = next(item.identifier for item in prop.enum_items if item.identifier != value)
    elif prop.type == "BOOLEAN":
        value = not value
    else:
        value = value + 1 if prop.type in {"INT", "FLOAT"} else f"{value}x"
    setattr(scene, name, value)


def test_every_setting_of_the_scene_makes_it_stale_or_is_known_not_to(home):
    """A new setting that was forgotten ends up here."""
    bpy.types.Scene.angen_brand_new = bpy.props.FloatProperty()
    try:
        looked_at = {prop.identifier for prop in scene_settings()} - OF_THE_VIEW
        assert {"angen_ambient_temperature", "angen_seed", "angen_brand_new"} <= looked_at
        for prop in scene_settings():
            name = prop.identifier
            if prop.type == "POINTER" or name == "angen_cleared":
                assert name in OF_THE_VIEW, name
                continue
            home.scene.angen_live = True
            ops.simulate()
            assert stale() == "", name
            change(home.scene, prop)
            home.scene.frame_set(home.scene.frame_current + 1)
            assert stale() == (
                "" if name in OF_THE_VIEW else "changed since: the scene's settings"
            ), name
    finally:
        del bpy.types.Scene.angen_brand_new


def test_something_animated_that_was_moved_is_back_at_the_next_frame(home):
    move_what_is_animated(home)
    home.update()
    assert stale()
    home.scene.frame_set(20)
    assert stale() == ""


def test_what_only_light_sensors_see_counts_where_there_is_one(home):
    home.sensor("LIGHT", "lux", method="ILLUMINANCE", engine="DIRECT", update_rate=1.0)
    home.scene.frame_end = 2
    home.update()
    ops.simulate()
    assert stale() == ""
    bpy.data.materials["paint"].diffuse_color = (1, 0, 0, 1)
    home.update()
    assert "'paint'" in stale()
    ops.simulate()
    brightness(home)
    home.update()
    assert "'lamp'" in stale()


def test_a_stale_recording_is_not_shown(home):
    home.scene.angen_live = False
    home.scene.frame_set(20)
    assert objects()["Front door"].angen_sensor.active
    move(home)
    home.update()
    home.scene.frame_set(5)
    assert objects()["Front door"].angen_sensor.active, "live is off: the value stands"
    bpy.ops.ed.undo_push(message="move")
    bpy.ops.ed.undo()
    bpy.context.scene.frame_set(6)
    assert not objects()["Front door"].angen_sensor.active


def save_and_load(path, meanwhile=None):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert not bpy.data.texts, "it is a part of files alone"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert stale() is None
    if meanwhile is not None:
        meanwhile()
    bpy.ops.wm.open_mainfile(filepath=str(path))


def test_a_file_keeps_it(home, tmp_path):
    before = columns()
    save_and_load(tmp_path / "a.blend")
    assert stale() == "" and columns() == before and not bpy.data.texts
    sensor = objects()["Front door"]
    bpy.context.scene.angen_live = False
    for frame in (20, 5, 13):
        bpy.context.scene.frame_set(frame)
        assert sensor.angen_sensor.active == (frame >= 13)
    assert ops.export_events(filepath=str(tmp_path / "events.csv")) == {"FINISHED"}
    move(home)
    home.update()
    assert "'shelf'" in stale()
    save_and_load(tmp_path / "b.blend")
    assert "'shelf'" in stale() and columns() == before, "stale ones are kept too, and stay so"
    objects()["shelf"].location.x -= 0.5
    home.update()
    assert stale() == ""


def test_a_sample_is_shipped_with_its_recording_and_timelines_at_its_length(home, tmp_path):
    """As its script saves it; live values are recorded ones as soon as it is opened."""
    from sample_blends import build_angen

    ops.clear_recording()
    home.scene.frame_end = 400
    build_angen.record_and_save(tmp_path / "sample.blend")
    before = columns()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "sample.blend"), load_ui=True)
    kept = cache().kept(bpy.context.scene)
    assert stale() == "" and columns() == before
    assert (kept.recording.frame_start, kept.recording.frame_end) == (1, 400)
    areas = [a for s in bpy.data.screens for a in s.areas if a.type == "DOPESHEET_EDITOR"]
    assert {area.spaces.active.mode for area in areas} >= {"TIMELINE"}
    for area in areas:
        region = next(r for r in area.regions if r.type == "WINDOW")
        left, right = (region.view2d.region_to_view(x, 0)[0] for x in (0, region.width))
        assert -30 <= left <= 1 and 400 <= right <= 460


def test_it_is_encoded_once(home, tmp_path, monkeypatch):
    store = import_module(f"{ADDON}.angen_addon.recording.store")
    count, encode = [], store._encoded
    monkeypatch.setattr(store, "_encoded", lambda kept: count.append(1) or encode(kept))
    for name in "ab":
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / name))
    save_and_load(tmp_path / "c.blend")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "d.blend"))
    assert count == [1]


def test_clear_takes_it_out_of_the_file(home, tmp_path):
    save_and_load(tmp_path / "a.blend")
    assert ops.clear_recording() == {"FINISHED"}
    save_and_load(tmp_path / "a.blend")
    assert stale() is None and not bpy.data.texts
    assert not ops.clear_recording.poll()


def test_every_scene_keeps_its_own(home, tmp_path):
    home.scene.name = "one"
    bpy.ops.scene.new(type="FULL_COPY")
    bpy.context.scene.name = "two"
    bpy.context.scene.frame_end = 10
    home.update()
    assert stale() is None
    ops.simulate()
    save_and_load(tmp_path / "a.blend")
    assert bpy.context.scene.name == "two"
    assert stale() == "" and cache().kept(bpy.context.scene).recording.frame_end == 10
    bpy.context.window.scene = bpy.data.scenes["one"]
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(3)
    assert stale() == "" and cache().kept(bpy.context.scene).recording.frame_end == 48


def damage(path, change):
    """Saves the file with the text of its recording changed, as a Blender without the extension
    could."""
    store = import_module(f"{ADDON}.angen_addon.recording.store")
    store.put_into_file()
    (text,) = (t for t in bpy.data.texts if t.name.startswith(store.TEXT))
    body = text.as_string()
    cache().clear_recording(bpy.context.scene)
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
        (lambda body: body[:-900], "damaged"),
        (lambda body: body.replace("A", "B"), "damaged"),
        (lambda body: "", "damaged"),
        (lambda body: body.splitlines()[0], "not a recording"),
        (lambda body: "hello", "damaged"),
        (lambda body: body.splitlines()[0] + "\n§§§", "damaged"),
    ],
)
def test_what_cannot_be_read_is_told_and_dropped(home, tmp_path, capfd, change, words):
    damage(tmp_path / "a.blend", change)
    assert stale() is None
    assert not bpy.data.texts
    assert words in cache().notice and "Simulate again" in cache().notice
    said = capfd.readouterr()
    assert words in said.err and "Traceback" not in said.out + said.err
    ops.simulate()
    assert cache().notice == "" and stale() == ""


@pytest.fixture
def newer(monkeypatch):
    """From now on this is another Blender than that which made what was recorded before."""
    kept = import_module(f"{ADDON}.angen_addon.recording.kept")
    return lambda: monkeypatch.setattr(kept, "HERE", (9, 9))


def test_in_another_blender_it_holds_where_all_that_both_tell_alike_is_the_same(
    home, tmp_path, newer, monkeypatch
):
    before = columns()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    newer()
    # What a version tells of everything is different in the next one.
    fingerprint = import_module(f"{ADDON}.angen_addon.recording.fingerprint")
    facts_of = fingerprint.facts_of
    monkeypatch.setattr(fingerprint, "facts_of", lambda datablock: [facts_of(datablock), "new"])
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert stale() == "" and columns() == before
    kept = cache().kept(bpy.context.scene)
    assert kept.made_in == bpy.app.version[:2]
    shelf = objects()["shelf"]
    shelf.location.x += 0.5
    bpy.context.view_layer.update()
    assert "'shelf'" in stale(), "from now on all counts, as of one that was made here"
    shelf.location.x -= 0.5
    bpy.context.view_layer.update()
    assert stale() == ""
    save_and_load(tmp_path / "b.blend")
    assert stale() == "" and cache().kept(bpy.context.scene).made_in == bpy.app.version[:2]


def test_in_another_blender_it_is_stale_where_something_moved_or_it_was_stale(
    home, tmp_path, newer
):
    """A Blender without the extension saves a file with its recording, whatever was changed."""
    version = ".".join(map(str, bpy.app.version[:2]))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    digests = dict(cache().kept(home.scene).fingerprint.portable)
    assert {"scene", "shown", "Object shelf"} <= digests.keys()
    kept = cache().kept(home.scene)
    kept.fingerprint.portable["Object shelf"], kept.stored = "another", ""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "moved.blend"))
    kept.fingerprint.portable, kept.stored = digests, ""
    kept.fingerprint.digests["Object shelf"] = "another"
    kept.verify(home.scene, bpy.context.evaluated_depsgraph_get())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "stale.blend"))
    newer()
    for name, wanted in (("a", ""), ("moved", "made in"), ("stale", "made in")):
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / f"{name}.blend"))
        assert stale() == (f"it was {wanted} Blender {version}" if wanted else "")


def test_without_the_extension_a_file_has_a_hidden_text_and_nothing_else(home, tmp_path):
    """Another process opens it, and saves it."""
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


def test_the_command_line_keeps_it_in_the_copy_that_it_saves(home, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    ops.clear_recording()
    run = import_module(f"{ADDON}.angen_addon.commands.command_line").run_command
    save, events = str(tmp_path / "b.blend"), str(tmp_path / "b.csv")
    assert run(["simulate", "--quiet", "--bake", "--save", save, "--events", events]) == 0
    bpy.ops.wm.open_mainfile(filepath=save)
    assert stale() == ""
    assert ops.export_events(filepath=str(tmp_path / "again.csv")) == {"FINISHED"}
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


@pytest.mark.parametrize(
    "facts",
    [
        {"blender": None},
        {"blender": ["4", "5"]},
        {"view_layer": 7},
        {"digests": {"a": {"b": []}}},
        {"digests": [["a", "b"]]},
        {"light": None},
    ],
)
def test_facts_of_a_stranger_are_refused_in_a_line(home, tmp_path, capsys, facts):
    """Opening such a file goes on without the recording, and says so."""
    store = import_module(f"{ADDON}.angen_addon.recording.store")
    files = import_module(f"{ADDON}.sensor_logic.recording_file")
    scene = bpy.context.scene
    kept = cache().kept(scene)
    true = {"blender": [4, 5], "view_layer": "ViewLayer", "light": False, "digests": {}}
    kept.stored = "\n".join(
        [store.TITLE, base64.b64encode(files.to_bytes(kept.recording, {**true, **facts})).decode()]
    )
    path = tmp_path / "strange.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    capsys.readouterr()
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert cache().kept(bpy.context.scene) is None
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "could not be read: it is damaged. Simulate again" in told
    assert "could not be read" in cache().notice


def test_what_is_told_of_a_large_mesh_is_short_and_tells_any_change(world, addon_part):
    """Its text took 300 bytes a triangle, which for millions was more than all else."""
    facts_of = addon_part("angen_addon.recording.digests").facts_of
    points = [(x, y, 0.0) for x in range(100) for y in range(100)]
    faces = [(i, i + 1, i + 101, i + 100) for i in range(9899) if i % 100 < 99]
    mesh = world.mesh(points, faces)
    told = [repr(facts_of(mesh))]
    mesh.vertices[5000].co.z = 1e-6
    told.append(repr(facts_of(mesh)))
    mesh.polygons[7].material_index = 1
    told.append(repr(facts_of(mesh)))
    mesh.polygons[7].use_smooth = not mesh.polygons[7].use_smooth
    told.append(repr(facts_of(mesh)))
    assert len(set(told)) == 4 and max(map(len, told)) < 1000


BEFORE_A_FRAME = {
    "hidden": lambda world: objects()["shelf"].hide_set(True),
    "disabled": lambda world: objects()["shelf"].__setattr__("hide_viewport", True),
    "gone": lambda world: objects().remove(objects()["shelf"]),
    "new": lambda world: world.link("more", bpy.data.meshes.new("more")),
    "renamed": lambda world: objects()["Front door"].__setattr__("name", "Back door"),
    "gravity": lambda world: world.scene.__setattr__("gravity", (0, 0, 1)),
    "a property": lambda world: world.scene.__setitem__("angle", 3.0),
}


@pytest.mark.parametrize("change", BEFORE_A_FRAME.values(), ids=BEFORE_A_FRAME)
def test_what_a_script_changes_just_before_a_frame_makes_it_stale(home, change):
    """Blender tells of no edit then: the change of frame does."""
    home.scene.frame_set(2)
    home.scene.frame_set(3)
    assert stale() == ""
    change(home)
    home.scene.frame_set(4)
    assert "changed since" in stale()


def test_while_it_plays_what_is_shown_is_not_looked_at_again(home, monkeypatch):
    home.scene.frame_set(2)
    home.scene.frame_set(3)
    looked = []
    for name in ("recording.kept.what_is_shown", "runtime.state.all_sensors"):
        module, _, function = name.rpartition(".")
        part = import_module(f"{ADDON}.angen_addon.{module}")
        known = getattr(part, function)
        monkeypatch.setattr(part, function, lambda *a, f=known: looked.append(1) or f(*a))
    for frame in range(4, 13):
        home.scene.frame_set(frame)
    assert looked == []
    objects()["shelf"].hide_set(True)
    home.scene.frame_set(13)
    assert len(looked) == 2
