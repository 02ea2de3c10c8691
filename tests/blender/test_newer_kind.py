# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor of a kind that a newer version of the extension knows: left out, told of, and kept."""

import json
from functools import partial

import bpy
import pytest
from commands import module
from tiers import mostly_slow

told_by = partial(module, text=True)


def stored(obj):
    """The group as the file has it."""
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
