# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m angen_addon` as a CI job calls it: output, exit status, and everything that can be
wrong with what it is given.

A process with Blender in it takes a second to start; these cases run the same command function in
this process, on the open file. test_command_processes.py has the others.
"""

import importlib
import json
import sys
from pathlib import Path

import bpy
import pytest
from commands import DOOR_LOG, HEADER, door_home, listing, one_line, save


@pytest.fixture
def home(world, tmp_path):
    return door_home(world, tmp_path)


def test_two_runs_give_the_same_bytes(home, command):
    assert command("simulate")[:2] == command("simulate")[:2] == (0, DOOR_LOG)


def test_a_part_of_the_frames(home, command):
    status, out, _ = command("simulate", "--frames", "20:40")
    assert status == 0
    assert [line.split(",")[1] for line in out.splitlines()[1:]] == ["20", "20", "37"]
    status, out, err = command("simulate", "--quiet", "--frames", "-5:1")
    assert (status, len(out.splitlines())) == (0, 3)
    assert one_line(err) == "angen: frames -5:1: time begins at frame 1, and none before it is run"
    last = bpy.context.scene.frame_end
    status, out, err = command("simulate", "--quiet", "--frames", f"{last}:{last + 9}")
    assert status == 0
    assert one_line(err) == (
        f"angen: frames {last}:{last + 9}: the scene ends at frame {last}, and those after it are "
        "run too"
    )


def test_only_the_sensor_that_is_named(home, command):
    status, out, _ = command("simulate", "--sensor", "Dörr")
    assert status == 0
    assert out == "\r\n".join(row for row in DOOR_LOG.split("\r\n") if "PIR" not in row)


@pytest.mark.parametrize(
    ("options", "names"),
    [
        (["--sensor", "PIR *[dl]"], {"PIR bed", "PIR hall"}),
        (["--sensor", "PIR bed", "--sensor", "L*"], {"PIR bed", "Lux"}),
        (["--kind", "LIGHT", "--kind", "pressure"], {"Pad", "Lux"}),
        (["--no-light"], {"Pad", "PIR bed", "PIR hall", "PIR [1]"}),
        (["--sensor", "P*", "--kind", "PIR", "--no-light"], {"PIR bed", "PIR hall", "PIR [1]"}),
        # A name with the signs of a pattern is itself.
        (["--sensor", "PIR [1]"], {"PIR [1]"}),
    ],
)  # fmt: skip
def test_sensors_are_chosen_by_patterns_and_kinds(world, command, tmp_path, options, names):
    for name in ("PIR bed", "PIR hall", "PIR [1]"):
        world.pir(name)
    world.sensor("PRESSURE", "Pad")
    world.sensor("LIGHT", "Lux")
    world.scene.frame_end = 2
    save(tmp_path)
    status, out, _ = command("simulate", "--quiet", *options)
    assert status == 0
    assert {row.split(",")[2] for row in out.splitlines()[1:]} == names
    expected = tmp_path / "expected.csv"
    expected.write_text(out, encoding="utf-8")
    assert command("check", expected, "--quiet", *options)[0] == 0


def test_progress_is_quiet_when_asked(home, command):
    assert command("simulate", "--quiet")[2] == ""
    assert "times real time" in command("simulate")[2]


def test_sensors_that_are_off_are_named(home, world, command):
    world.switch("off", enabled=False)
    world.sensor("LIGHT", "dark", enabled=False)
    world.update()
    status, out, err = command("simulate", "--quiet")
    assert (status, out) == (0, DOOR_LOG)
    assert "switched off: dark, off" in one_line(err)
    assert [line.endswith("  off") for line in command("list")[1].splitlines()] == [
        *(False, False),  # Dörr; Hall, PIR
        *(True, True),  # dark; off
    ]


def test_list(home, command):
    status, out, _ = command("list")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == ["Dörr", "Hall,"]
    status, out, _ = command("list", "--json")
    first, second = json.loads(out)
    assert first["name"] == "Dörr" and first["kind"] == "OPTICAL_SWITCH"
    assert first["room"] == "Hall" and first["update_rate"] == 24.0
    assert first["simulated"] and second["simulated"]
    assert first["parameters"]["range_max"] == 0.5
    assert second["parameters"]["threshold"] == 0.05
    assert second["parameters"]["sweep"] == "SAWTOOTH"
    assert second["location"] == [100, 0, 0]


@pytest.fixture
def expected(tmp_path):
    path = tmp_path / "expected.csv"
    path.write_text(DOOR_LOG, encoding="utf-8", newline="")
    return path


def edit(path, old, new):
    text = path.read_bytes().decode()
    assert old in text
    path.write_bytes(text.replace(old, new).encode())


def test_check_of_the_same_events(home, command, expected):
    status, out, err = command("check", expected)
    assert (status, out) == (0, "")
    assert "4 events as expected" in err


@pytest.mark.parametrize(
    ("old", "new", "verdict"),
    [
        ("0.500000,13,Dörr,OPTICAL_SWITCH,open,1\r\n", "", "unexpected"),
        ("0.500000,13,Dörr", "0.458333,12,Dörr", "missing"),
        ("moved,0", "moved,1", "different"),
        (HEADER, HEADER + "\r\n0.1,3,Ghost,PIR,moved,1", "missing"),
    ],
)
def test_check_tells_what_differs(home, command, expected, old, new, verdict):
    edit(expected, old, new)
    status, out, _ = command("check", expected)
    assert status == 1
    assert out.startswith(f"{verdict}: ")


def test_check_honours_its_tolerances(home, command, expected):
    edit(expected, "0.500000,13,Dörr", "0.458333,12,Dörr")
    assert command("check", expected, "--time-tolerance", "0.03")[0] == 1
    assert command("check", expected, "--time-tolerance", "0.05")[0] == 0
    edit(expected, "moved,0", "moved,0.4")
    assert command("check", expected, "--time-tolerance", "0.05")[0] == 1
    assert command("check", expected, "--time-tolerance", "0.05", "--tolerance", "0.5")[0] == 0


def test_check_of_one_sensor_ignores_the_others(home, command, expected):
    edit(expected, "moved,0", "moved,1")
    assert command("check", expected, "--sensor", "Dörr")[0] == 0
    assert command("check", expected, "--sensor", "Hall, PIR")[0] == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["simulate", "--frames", "20:10"], ["20:10", "did you mean 10:20"]),
        (["simulate", "--frames", "a:b"], ["a:b", "1:240"]),
        (["simulate", "--frames", "7"], ["'7'"]),
        (["simulate", "--frames", "1:"], ["'1:'"]),
        (["simulate", "--frames", "1.5:3"], ["1.5:3"]),
        (["simulate", "--frames", "1:99999999999"], ["99999999999", "frames are"]),
        (["simulate", "--nonsense"], ["--nonsense"]),
        (["dance"], ["dance"]),
        (["simul"], ["'simul'", "did you mean simulate?"]),
        (["xyz"], ["list", "doctor", "study"]),
        (["convert", "a.csv"], ["without Blender", "python -m angen_addon convert"]),
        (["apply", "layout.json"], ["--save", "would be lost"]),
        ([], ["required"]),
        (["check"], ["EXPECTED.csv"]),
        (["check", "x.csv", "--tolerance", "much"], ["much"]),
        (["check", "x.csv", "--tolerance", "-1"], ["-1"]),
        (["check", "x.csv", "--time-tolerance", "nan"], ["nan"]),
    ],
)
def test_bad_arguments(home, command, arguments, words):
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    assert err.startswith("angen: ") and err.count("\n") == 1
    for word in words:
        assert word in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["simulate", "--sensor", "Dorr"], ["'Dorr'", "did you mean Dörr"]),
        (["simulate", "--sensor", "???"], ["'???'", "Hall, PIR"]),
        (["simulate", "--sensor", "Hal*PRI"], ["no sensor fits 'Hal*PRI'", "mean Hall, PIR?"]),
        (["simulate", "--sensor", "D*", "--kind", "PIR"], ["no sensor is left", "Dörr"]),
        (["simulate", "--kind", "PRI"], ["--kind", "'PRI'", "'PIR'"]),
        (
            ["day", "--sensor", "X*", "--routine", "a", "--start", "2026-03-02", "--out", "b"],
            ["no sensor fits 'X*'"],
        ),
        (
            ["explain", "--sensor", "*", "--time", "1"],
            ["about one sensor", "these are 2", "Dörr"],
        ),
        (["simulate", "--frames=-9:-1"], ["-9:-1", "frame 1"]),
        (["simulate", "--bake"], ["--save"]),
        (["simulate", "--events", "{}/missing/a.csv"], ["--events", "missing", "does not exist"]),
        (["simulate", "--events", "{}"], ["--events", "folder"]),
        (["simulate", "--samples", "{}/file"], ["--samples", "not a folder"]),
        (["simulate", "--samples", "{}/missing/dir"], ["--samples", "does not exist"]),
        (["simulate", "--save", "{}/missing/a.blend"], ["--save", "does not exist"]),
        (["simulate", "--events", "/proc/events.csv"], ["--events", "/proc"]),
        (["simulate", "--samples", "/proc/samples"], ["--samples", "/proc"]),
        (["check", "{}/missing.csv"], ["missing.csv", "No such file"]),
        (["check", "{}"], ["Is a directory"]),
        (["check", "{}/file"], ["file", "line 1"]),
    ],
)
def test_input_that_cannot_be_used(home, command, tmp_path, arguments, words):
    if any("/proc" in argument for argument in arguments) and not Path("/proc").exists():
        pytest.skip("has no folder that nobody can write into")
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "file").write_text("kept")
    before = listing(tmp_path)
    status, out, err = command(*(argument.format(folder) for argument in arguments))
    line = one_line(err)
    assert (status, out) == (2, "")
    for word in words:
        assert word in line
    assert listing(tmp_path) == before


def test_a_file_without_sensors(world, command, tmp_path):
    world.box((1, 1, 1))
    save(tmp_path, "bare.blend")
    for arguments in (["simulate"], ["list"], ["check", tmp_path / "bare.blend1"]):
        status, out, err = command(*arguments)
        assert (status, out) == (2, "")
        one_line(err)
    assert "bare.blend has no sensors" in command("simulate")[2]


def test_an_empty_scene(world, command, tmp_path):
    save(tmp_path, "empty.blend")
    assert command("simulate")[0] == 2
    assert "empty.blend has no sensors" in one_line(command("simulate")[2])


def test_no_file_at_all(world, command):
    world.switch()
    status, _, err = command("simulate")
    assert status == 2 and "no blend file is open" in one_line(err)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"range_min": 0.6}, ["Dörr", "range_min", "range_max"]),
        ({"update_rate": 0.0}, ["Dörr", "update_rate"]),
        ({"hysteresis": 2.0}, ["Dörr", "hysteresis"]),
    ],
)
def test_bad_parameters_fail_the_run(home, world, command, tmp_path, change, words):
    world.sensor("OPTICAL_SWITCH", "", bpy.data.objects["Dörr"], **change)
    status, out, err = command("simulate", "--events", tmp_path / "events.csv")
    line = one_line(err)
    assert (status, out) == (1, "")
    for word in words:
        assert word in line
    assert not (tmp_path / "events.csv").exists()


@pytest.mark.parametrize("scale", [0.0, float("nan")])
def test_a_sensor_without_a_direction_fails_the_run(home, command, tmp_path, scale):
    bpy.data.objects["Dörr"].scale = (scale, scale, scale)
    bpy.context.view_layer.update()
    status, _, err = command("simulate", "--events", tmp_path / "events.csv")
    assert status == 1 and "'Dörr'" in one_line(err)
    assert not (tmp_path / "events.csv").exists()


def test_a_run_that_fails_half_way_writes_nothing(home, world, command, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    sensor = bpy.data.objects["Dörr"]
    world.key(sensor, "scale", {1: (1, 1, 1), 30: (0, 0, 0)}, "CONSTANT")
    arguments = ["--events", out / "a.csv", "--samples", out / "s", "--save", out / "b.blend"]
    status, _, err = command("simulate", *arguments)
    assert status == 1 and "'Dörr'" in one_line(err)
    assert list(out.iterdir()) == []


def test_two_sensors_of_one_name_after_linking(home, world, command, tmp_path):
    save(tmp_path, "both.blend")
    with bpy.data.libraries.load(str(home), link=True) as (_, target):
        target.objects = ["Dörr"]
    world.scene.collection.objects.link(target.objects[0])
    bpy.context.view_layer.update()
    status, out, err = command("simulate")
    line = one_line(err)
    assert (status, out) == (1, "")
    for word in ("2 sensors", "'Dörr'", "home.blend", "rename"):
        assert word in line


def test_samples_of_names_that_collide(home, world, command, tmp_path):
    world.switch("a/b")
    world.switch("a_b")
    world.update()
    assert command("simulate", "--samples", tmp_path / "s")[0] == 0
    names = sorted(path.name for path in (tmp_path / "s").iterdir())
    assert names == ["Dörr.csv", "Hall, PIR.csv", "a_b-2.csv", "a_b.csv"]


@pytest.mark.skipif(sys.platform == "win32", reason="has no limits of this kind")
def test_a_full_disk_leaves_nothing_behind(home, command, tmp_path):
    """A limit of the size of files stands in for the disk: too small for the samples."""
    resource = importlib.import_module("resource")
    out = tmp_path / "out"
    out.mkdir()
    (out / "a.csv").write_text("of before")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (600, before[1]))
    try:
        status, _, err = command(
            "simulate", "--quiet", "--events", out / "a.csv", "--samples", out / "s"
        )
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert status == 1 and "cannot write" in one_line(err)
    assert listing(out) == {Path("a.csv"): b"of before"}
    assert [path.name for path in out.iterdir()] == ["a.csv"], "no empty folder either"


def test_the_open_file_is_not_changed_by_a_save(home, command, tmp_path):
    before = home.read_bytes()
    assert command("simulate", "--bake", "--save", tmp_path / "copy.blend")[0] == 0
    assert bpy.data.filepath == str(home)
    assert home.read_bytes() == before
    assert {p.name for p in tmp_path.iterdir()} == {"copy.blend", "files"}


def test_logs_tell_the_time_of_day_where_the_start_is_given(home, command):
    status, text, _ = command("simulate", "--start", "2026-03-01T08:00", "--quiet")
    rows = [line.split(",") for line in text.splitlines()]
    assert status == 0 and rows[0][-1] == "time"
    assert [row[-1] for row in rows[1:] if row[1] == "13"] == ["2026-03-01T08:00:00.500"]
    status, _, told = command("simulate", "--start", "noon")
    assert status == 2 and "'noon' is no date and time in ISO 8601" in told
