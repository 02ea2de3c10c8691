# SPDX-License-Identifier: GPL-3.0-or-later
"""A file keeps its recording, and what cannot be read of one is told in a line."""

import base64
import sys
from importlib import import_module

import bpy
import pytest
from recorded_home import ADDON, cache, columns, move, named, ops, recorded, save_and_load, stale


@pytest.fixture
def home(world):
    return recorded(world)


def test_a_file_keeps_it(home, tmp_path):
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
    home.update()
    assert "'shelf'" in stale()
    save_and_load(tmp_path / "b.blend")
    assert "'shelf'" in stale() and columns() == before, "stale ones are kept too, and stay so"
    named("shelf").location.x -= 0.5
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
    kept = import_module(f"{ADDON}.angen_addon.recording.stored_recording")
    return lambda: monkeypatch.setattr(kept, "THIS_BLENDER", (9, 9))


def test_in_another_blender_it_holds_where_all_that_both_tell_alike_is_the_same(
    home, tmp_path, newer, monkeypatch
):
    before = columns()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    newer()
    # What a version tells of everything is different in the next one.
    changes = import_module(f"{ADDON}.angen_addon.scene.changes")
    facts_of = changes.facts_of
    monkeypatch.setattr(changes, "facts_of", lambda datablock: [facts_of(datablock), "new"])
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert stale() == "" and columns() == before
    kept = cache().kept(bpy.context.scene)
    assert kept.made_in == bpy.app.version[:2]
    shelf = named("shelf")
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


def test_a_recording_of_an_earlier_version_of_the_extension_is_stale(home, tmp_path):
    """Its digests cannot be compared: they are of other facts."""
    cache().kept(home.scene).facts = 1
    save_and_load(tmp_path / "a.blend")
    assert stale() == "it was made by an earlier Ängen Sensors"


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
    files = import_module(f"{ADDON}.sensor_logic.recording.file")
    scene = bpy.context.scene
    kept = cache().kept(scene)
    kept.fingerprint.portable = {"scene": ""}
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
