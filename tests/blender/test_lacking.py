# SPDX-License-Identifier: GPL-3.0-or-later
"""What the home needs and does not have is named: on standard error, in the report, in the panel;
and a check of such a home fails."""

from functools import partial

import bpy
import pytest
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
def panel(addon_part):
    """What the sidebar tells of it."""
    return lambda: " ".join(addon_part("angen_addon.runtime.state").CACHE.lacks)


@pytest.fixture
def driven(world, open_again):
    """A wall that a driver of Python moves before a switch, which Blender does not run unasked."""
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
    assert "Blender blocked drivers" in page.read_text(encoding="utf-8")
    assert "Blender blocked drivers" in panel()
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
    """At frame 30; Blender lets it stand still from there on."""
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
    """A door that is linked from another file, before a switch."""
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
    # The same events as before, as it happens, are no proof.
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
    assert "'door.blend' no longer holds 'door'" in line
    bpy.ops.wm.open_mainfile(filepath=str(linked))
    assert "no longer holds" in panel()


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


def test_the_doctor_names_it_with_the_way_to_mend_it(driven, addon_part):
    context = bpy.context
    depsgraph = context.evaluated_depsgraph_get()
    examine = addon_part("angen_addon.doctor").examine
    (found,) = (f for f in examine(context.scene, context.view_layer, depsgraph) if f[0] == "files")
    assert found.text.startswith("Blender blocked drivers")
    assert "--enable-autoexec" in found.mend
