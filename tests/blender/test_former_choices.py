# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of earlier versions with the light engine DIRECT: Cycles takes its place, and this is told
once. tests/data/direct_engine.blend was saved by such a version, with Blender 4.2."""

import json
from pathlib import Path

import bpy
import pytest
from commands import module

FILE = Path(__file__).resolve().parent.parent / "data" / "direct_engine.blend"
TOLD = "'lux', 'other lux': engine DIRECT no longer exists and was replaced by CYCLES"


def engines():
    return {
        obj.name: obj.angen_sensor.light.engine
        for obj in bpy.data.objects
        if obj.angen_sensor.kind == "LIGHT"
    }


def test_a_blend_file_opens_with_cycles_and_says_so_once(world, addon_part, capfd, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(FILE))
    assert engines() == {
        "lux": "CYCLES", "other lux": "CYCLES", "cycles": "CYCLES", "gpu": "EEVEE"
    }  # fmt: skip
    assert capfd.readouterr().err.count(TOLD) == 1
    cache = addon_part("angen_addon.runtime.state").CACHE
    assert cache.notice == TOLD
    tracks = world.run(1, 1).tracks
    assert tracks["lux"].value[0] > 100.0
    assert tracks["lux"].value == tracks["cycles"].value
    again = tmp_path / "again.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(again))
    bpy.ops.wm.open_mainfile(filepath=str(again))
    assert engines()["lux"] == "CYCLES" and cache.notice == ""
    assert "DIRECT" not in capfd.readouterr().err


def test_a_linked_sensor_does_too(world, capfd, tmp_path):
    with bpy.data.libraries.load(str(FILE), link=True) as (_, data):
        data.objects = ["lux"]
    world.scene.collection.objects.link(data.objects[0])
    home = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    capfd.readouterr()
    bpy.ops.wm.open_mainfile(filepath=str(home))
    assert engines()["lux"] == "CYCLES"
    assert capfd.readouterr().err.count("'lux': engine DIRECT no longer exists") == 1


@pytest.mark.parametrize("way", ["keys", "strip"])
def test_keys_of_it_set_cycles(world, addon_part, capfd, tmp_path, way):
    lux = world.sensor("LIGHT", "lux")
    number = {"EEVEE": 1, "DIRECT": 2}
    world.key(lux, "angen_sensor.light.engine", {1: "CYCLES", 5: "EEVEE"})
    (curve,) = addon_part("angen_addon.scene.animation").played_curves(lux)
    first, second = curve.keyframe_points
    first.co.y, second.co.y = number["DIRECT"], number["EEVEE"]
    if way == "strip":
        animation = lux.animation_data
        strip = animation.nla_tracks.new().strips.new("engine", 1, animation.action)
        if hasattr(strip, "action_slot"):
            strip.action_slot = animation.action_slot
        animation.action = None
    home = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    bpy.ops.wm.open_mainfile(filepath=str(home))
    assert capfd.readouterr().err.count("'lux': engine DIRECT no longer exists") == 1
    found = {}
    for frame in (1, 5):
        bpy.context.scene.frame_set(frame)
        found[frame] = engines()["lux"]
    assert found == {1: "CYCLES", 5: "EEVEE"}
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(home))
    assert "DIRECT" not in capfd.readouterr().err


def test_a_driver_of_it_is_refused(world, addon_part):
    lux = world.sensor("LIGHT", "lux")
    lux.driver_add("angen_sensor.light.engine").driver.expression = "2"
    error = addon_part("sensor_logic.error").AngenError
    with pytest.raises(error, match=r"'lux': engine is none of its choices; .* driver"):
        world.run(1, 1)


@pytest.mark.parametrize("link", [False, True])
def test_a_sensor_that_comes_into_a_session(world, addon_part, capfd, link):
    with bpy.data.libraries.load(str(FILE), link=link) as (_, data):
        data.objects = ["lux"]
    world.scene.collection.objects.link(data.objects[0])
    if bpy.app.version >= (4, 3):
        assert engines()["lux"] == "CYCLES"
        assert capfd.readouterr().err.count("'lux': engine DIRECT no longer exists") == 1
        assert "'lux': engine DIRECT" in addon_part("angen_addon.runtime.state").CACHE.notice
        return
    error = addon_part("sensor_logic.error").AngenError
    with pytest.raises(error, match="'lux': engine is none of its choices; an old file"):
        world.run(1, 1)


@pytest.mark.slow
def test_so_does_the_command_line(tmp_path):
    done = module("list", FILE, "--json", text=True)
    assert done.returncode == 0 and done.stderr.count(TOLD) == 1, done.stderr
    found = {sensor["name"]: sensor["parameters"]["engine"] for sensor in json.loads(done.stdout)}
    assert found["lux"] == found["cycles"] == "CYCLES"


def layout(tmp_path):
    path = tmp_path / "sensors.json"
    names = "lux", "walls"
    settings = {"kind": "LIGHT", "location": [0, 0, 0], "parameters": {"engine": "DIRECT"}}
    given = [{"name": name, **settings} for name in names]
    path.write_text(json.dumps(given))
    return path


def test_a_layout_is_applied_with_cycles(world, addon_part, tmp_path):
    apply = addon_part("angen_addon.layout.apply").apply_layout
    done = apply(layout(tmp_path))
    assert engines() == {"lux": "CYCLES", "walls": "CYCLES"}
    assert done.text == (
        "2 added, 0 changed, 0 as they were; "
        "'lux', 'walls': engine DIRECT no longer exists and was replaced by CYCLES"
    )
    assert apply(layout(tmp_path)).unchanged == ["lux", "walls"]


def test_a_script_that_sets_it_is_warned(world, addon_part):
    world.sensor("LIGHT", "lux", engine="EEVEE")
    world.update()
    home = addon_part("angen_addon.api.home").Home.open(Path("home.blend"))
    with pytest.warns(UserWarning, match="'lux': engine DIRECT no longer exists"):
        home.sensor("lux").engine = "DIRECT"
    assert engines() == {"lux": "CYCLES"}
