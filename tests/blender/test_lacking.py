# SPDX-License-Identifier: GPL-3.0-or-later
"""Missing parts of a home are named on standard error, in the report and in the panel.

A check of such a home fails. Data of other versions of the extension are named too.
"""

import json
from functools import partial
from pathlib import Path

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.advice import lacking
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from commands import module
from tiers import mostly_slow

told_by = partial(module, text=True)


def told(done):
    return [line for line in done.stderr.splitlines() if line.startswith("angen: ")]


@pytest.fixture
def open_again(tmp_path):
    def save_and_open(name="home.blend"):
        path = tmp_path / name
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        bpy.ops.wm.open_mainfile(filepath=str(path))
        return path

    return save_and_open


@pytest.fixture
def panel():
    """Return the sidebar's texts on missing parts."""
    return lambda: " ".join(lacking.found)


@pytest.fixture
def driven(world, open_again):
    """Add a wall before a switch, with a driver in Python that needs the user's permission."""
    curve = world.wall(0.02).driver_add("location", 0)
    curve.driver.type = "SCRIPTED"
    curve.driver.expression = "noise.random() * 0 + frame / 12 - 1"
    world.switch()
    return open_again()


def test_blocked_drivers(driven, tmp_path, panel):
    log, page = tmp_path / "log.csv", tmp_path / "report.html"
    done = told_by("simulate", driven, "--events", log, "--report", page, "--quiet")
    assert done.returncode == 0
    (line,) = told(done)
    assert "blocked" in line and "--enable-autoexec" in line
    assert line.count("'wall (location)'") == 1
    assert len(log.read_text().splitlines()) == 2, "the wall stood still"
    assert "Blender blocked Python drivers" in page.read_text(encoding="utf-8")
    assert "Blender blocked Python drivers" in panel()
    failed = told_by("check", driven, log)
    assert failed.returncode == 1 and "the check fails" in failed.stderr


@pytest.mark.slow
def test_drivers_that_the_user_allows(driven, tmp_path):
    log = tmp_path / "log.csv"
    done = told_by("simulate", driven, "--events", log, "--quiet", "--enable-autoexec")
    assert (done.returncode, done.stderr) == (0, "")
    frames = [row.split(",")[1] for row in log.read_text().splitlines()[1:]]
    assert frames == ["1", "6", "19"]
    assert told_by("check", driven, log, "--enable-autoexec").returncode == 0
    assert told_by("check", driven, log).returncode == 1


@pytest.mark.slow
def test_drivers_that_fail_half_way(world, open_again):
    """The driver fails at frame 30; then Blender keeps its last value."""
    curve = world.wall(0.02).driver_add("location", 0)
    curve.driver.type = "SCRIPTED"
    curve.driver.expression = "0 * round(1 / (30 - frame), 3)"
    world.switch()
    done = told_by("simulate", open_again(), "--quiet")
    assert done.returncode == 0
    (line,) = told(done)
    assert "drivers fail" in line and "'wall (location)'" in line


@pytest.fixture
def linked(world, tmp_path, open_again):
    """Link a door from another file, before a switch."""
    door = world.wall(0.02, "door")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "door.blend"), copy=True)
    bpy.data.objects.remove(door)
    with bpy.data.libraries.load(str(tmp_path / "door.blend"), link=True) as (_, target):
        target.objects = ["door"]
    world.scene.collection.objects.link(target.objects[0])
    world.switch()
    return open_again()


@pytest.mark.slow
def test_a_missing_library(linked, tmp_path, panel):
    log = tmp_path / "log.csv"
    assert told_by("simulate", linked, "--events", log, "--quiet").stderr == ""
    assert panel() == ""
    assert told_by("check", linked, log).returncode == 0
    (tmp_path / "door.blend").rename(tmp_path / "elsewhere.blend")
    done = told_by("simulate", linked, "--quiet")
    assert done.returncode == 0 and len(told(done)) == 1
    assert "'door.blend' is missing" in told(done)[0] and str(tmp_path) in told(done)[0]
    assert done.stdout.splitlines()[0] == "time_s,frame,sensor,kind,field,value"
    # The events happen to be the same as before, which proves nothing.
    (tmp_path / "log.csv").write_text(done.stdout, newline="")
    assert told_by("check", linked, log).returncode == 1
    bpy.ops.wm.open_mainfile(filepath=str(linked))
    assert "'door.blend' is missing" in panel()
    (tmp_path / "elsewhere.blend").rename(tmp_path / "door.blend")
    bpy.ops.wm.revert_mainfile()
    assert panel() == ""


@pytest.mark.slow
def test_something_that_is_gone_from_a_library(linked, tmp_path, panel):
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "door.blend"))
    bpy.data.objects.remove(bpy.data.objects["door"])
    bpy.ops.wm.save_mainfile()
    done = told_by("list", linked)
    assert done.returncode == 0
    (line,) = told(done)
    assert "'door.blend' no longer contains 'door'" in line
    bpy.ops.wm.open_mainfile(filepath=str(linked))
    assert "no longer contains" in panel()


@pytest.mark.parametrize("light", mostly_slow([True, False], True))
def test_images_count_where_a_light_sensor_would_see_them(
    world, tmp_path, open_again, panel, light
):
    image = bpy.data.images.new("wallpaper", 4, 4)
    image.filepath_raw = str(tmp_path / "wallpaper.png")
    image.file_format = "PNG"
    image.save()
    bpy.data.images.remove(image)
    paint = bpy.data.materials.new("paint")
    if not paint.node_tree:
        paint.use_nodes = True
    node = paint.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(str(tmp_path / "wallpaper.png"))
    world.wall(0.02).data.materials.append(paint)
    world.switch()
    if light:
        world.sensor("LIGHT", "light")
    home = open_again()
    assert panel() == ""
    (tmp_path / "wallpaper.png").unlink()
    done = told_by("list", home)
    assert [("wallpaper.png" in line and "missing" in line) for line in told(done)] == (
        [True] if light else []
    )
    bpy.ops.wm.open_mainfile(filepath=str(home))
    assert ("wallpaper.png" in panel()) is light
    assert bpy.ops.angen.look_for_lacking() == {"FINISHED"}
    assert ("wallpaper.png" in panel()) is light


def test_a_mesh_cache(world, open_again, tmp_path):
    modifier = world.wall(0.02).modifiers.new("cache", "MESH_CACHE")
    modifier.filepath = str(tmp_path / "walk.mdd")
    world.switch()
    (line,) = told(told_by("list", open_again()))
    assert "mesh cache of 'wall' is missing" in line


# A sensor of a kind that a newer version of the extension knows


def stored(obj):
    """Return the property group as the file stores it."""
    if hasattr(obj, "bl_system_properties_get"):
        return obj.bl_system_properties_get()["angen_sensor"]
    return obj["angen_sensor"]


@pytest.fixture
def home(world, tmp_path):
    world.wall(0.02)
    world.switch("known")
    stored(world.switch("newer"))["kind"] = 99
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return path


@pytest.mark.parametrize(("verb", "option"), mostly_slow(
    [("simulate", "--quiet"), ("list", "--json")], ("simulate", "--quiet")))  # fmt: skip
def test_it_is_skipped_and_named_and_standard_output_is_pure(home, verb, option):
    done = told_by(verb, home, option)
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if line]
    assert len(told) == 1 and "'newer'" in told[0] and "number 99" in told[0], done.stderr
    assert "update the extension" in told[0]
    if verb == "simulate":
        rows = done.stdout.splitlines()
        assert rows[0] == "time_s,frame,sensor,kind,field,value"
        assert {row.split(",")[2] for row in rows[1:]} == {"known"}
    else:
        assert [sensor["name"] for sensor in json.loads(done.stdout)] == ["known"]


@pytest.mark.slow
def test_a_home_of_such_sensors_alone_says_so(home, world, tmp_path):
    bpy.data.objects.remove(bpy.data.objects["known"])
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    done = told_by("simulate", home)
    assert (done.returncode, done.stdout) == (2, "")
    assert "number 99" in done.stderr and "Traceback" not in done.stderr


def test_the_window_shows_the_scene_without_it_and_keeps_it(home, world, tmp_path):
    sensor = bpy.data.objects["newer"]
    assert sensor.angen_sensor.kind == "NONE"
    assert [found.name for found in world.sensors()] == ["known"]
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    world.scene.frame_set(3)
    again = tmp_path / "again.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(again))
    bpy.ops.wm.open_mainfile(filepath=str(again))
    assert stored(bpy.data.objects["newer"])["kind"] == 99
    bpy.data.objects["newer"].angen_sensor.kind = "PIR"
    assert stored(bpy.data.objects["newer"])["kind"] == 1
    assert [found.name for found in world.sensors()] == ["known", "newer"]


# Files of earlier versions with the light engine DIRECT


FILE = Path(__file__).resolve().parent.parent / "data" / "direct_engine.blend"
TOLD = "'lux', 'other lux': engine DIRECT no longer exists and was replaced by CYCLES"


def engines():
    return {
        obj.name: obj.angen_sensor.light.engine
        for obj in bpy.data.objects
        if obj.angen_sensor.kind == "LIGHT"
    }


def test_a_blend_file_opens_with_cycles_and_says_so_once(world, capfd, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(FILE))
    assert engines() == {
        "lux": "CYCLES", "other lux": "CYCLES", "cycles": "CYCLES", "gpu": "EEVEE"
    }  # fmt: skip
    assert capfd.readouterr().err.count(TOLD) == 1
    assert RESULTS.notice == TOLD
    tracks = world.run(1, 1).tracks
    assert tracks["lux"].value[0] > 100.0
    assert tracks["lux"].value == tracks["cycles"].value
    again = tmp_path / "again.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(again))
    bpy.ops.wm.open_mainfile(filepath=str(again))
    assert engines()["lux"] == "CYCLES" and RESULTS.notice == ""
    assert "DIRECT" not in capfd.readouterr().err
