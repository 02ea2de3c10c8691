# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m angen_addon` as a CI job calls it: output, exit status, and every wrong input.

A process with Blender in it takes a second to start; these cases run the same command function in
this process, on the open file. test_command_processes.py has the others.
"""

import csv
import importlib
import sys
from pathlib import Path

import bpy
import pytest
from commands import DOOR_LOG, HEADER, door_home, listing, one_line, save
from panel_layout import Layout, drawn


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
    assert (
        one_line(err) == "angen: frames -5:1: those before the scene's start, frame 1, are left out"
    )
    last = bpy.context.scene.frame_end
    status, out, err = command("simulate", "--quiet", "--frames", f"{last}:{last + 9}")
    assert status == 0
    assert one_line(err) == (
        f"angen: frames {last}:{last + 9}: those after the scene's end, frame {last}, are "
        "simulated too"
    )


@pytest.mark.parametrize(
    ("options", "names"),
    [
        (["--sensor", "PIR *[dl]"], {"PIR bed", "PIR hall"}),
        (["--sensor", "PIR bed", "--sensor", "L*"], {"PIR bed", "Lux"}),
        (["--kind", "LIGHT", "--kind", "pressure"], {"Pad", "Lux"}),
        (["--no-light"], {"Pad", "PIR bed", "PIR hall", "PIR [1]"}),
        (["--sensor", "P*", "--kind", "PIR", "--no-light"], {"PIR bed", "PIR hall", "PIR [1]"}),
        # A name with characters of a pattern also matches itself.
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
    expected.write_text(out, encoding="utf-8", newline="")
    assert command("check", expected, "--quiet", *options)[0] == 0


def test_progress_is_quiet_when_asked(home, command):
    assert command("simulate", "--quiet")[2] == ""
    assert "times real time" in command("simulate")[2]


def test_a_pad_that_is_often_not_valid_is_told_with_the_reason(home, world, command):
    """Two metres above the floor, a person; then on the floor, which the first update knows not."""
    world.box((4, 4, 0.2), (0, 0, -0.1), "Floor")
    pad = world.box((1, 1, 0.01), (0, 0, 0.005), "Pad")
    pad.angen_sensor.kind, pad.angen_sensor.update_rate = "PRESSURE", 4.0
    person = world.box((0.3, 0.3, 1.7), (0, 0, 1.5), "Person")
    person.angen_load.mass = 70.0
    world.update()
    assert one_line(command("simulate", "--quiet")[2]) == (
        "angen: 'Pad' was not valid in 100 % of its updates: nothing supports 'Person', so its "
        "weight cannot be computed"
    )
    person.location.z = 0.86
    world.update()
    assert command("simulate", "--quiet")[2] == ""


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


@pytest.mark.parametrize("options", [["--json"], []])
def test_list_writes_the_file_that_windows_powershell_would_write_in_utf_16(
    home, command, tmp_path, options
):
    file = tmp_path / "sensors"
    printed = command("list", *options)[1]
    assert "Dörr" in printed
    assert command("list", *options, "--out", file)[:2] == (0, "")
    assert file.read_bytes().decode() == printed
    assert command("list", *options, "--out", bpy.data.filepath)[0] == 2


@pytest.fixture
def expected(tmp_path):
    path = tmp_path / "expected.csv"
    path.write_text(DOOR_LOG, encoding="utf-8", newline="")
    return path


def edit(path, old, new):
    text = path.read_bytes().decode()
    assert old in text
    path.write_bytes(text.replace(old, new).encode())


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
        (["simulate", "--frames", "a:b"], ["a:b", "1:240"]),
        (["simulate", "--frames", "7"], ["'7'"]),
        (["simulate", "--frames", "1.5:3"], ["1.5:3"]),
        (["simulate", "--frames", "1:99999999999"], ["99999999999", "frames are"]),
        (["simulate", "--nonsense"], ["--nonsense"]),
        (["xyz"], ["list", "doctor", "study"]),
        (["convert", "a.csv"], ["without Blender", "python -m angen_addon convert"]),
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
        (["simulate", "--sensor", "Hal*PRI"], ["no sensor matches 'Hal*PRI'", "mean Hall, PIR?"]),
        (["simulate", "--sensor", "D*", "--kind", "PIR"], ["no sensor matches", "Dörr"]),
        (["simulate", "--kind", "PRI"], ["--kind", "'PRI'", "'PIR'"]),
        (
            ["day", "--sensor", "X*", "--routine", "a", "--start", "2026-03-02", "--out", "b"],
            ["no sensor matches 'X*'"],
        ),
        (
            ["explain", "--sensor", "*", "--time", "1"],
            ["needs one sensor", "--sensor NAME", "Dörr"],
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


def test_a_file_whose_sensors_are_elsewhere(world, command, tmp_path):
    layer, sensor = world.bpy.context.view_layer, world.pir()
    drafts = world.aside("drafts", sensor)
    world.scene.collection.children.link(drafts)
    layer.layer_collection.children["drafts"].exclude = True
    save(tmp_path, "bare.blend")
    assert "tick the collections of 'pir' in the Outliner" in one_line(command("simulate")[2])
    world.scene.collection.children.unlink(drafts)
    world.bpy.data.scenes.new("Flat").collection.children.link(drafts)
    save(tmp_path, "bare.blend")
    assert "its scene 'Flat' has sensors: save the file with" in one_line(command("simulate")[2])


def test_no_file_at_all(world, command):
    world.switch()
    status, _, err = command("simulate")
    assert status == 2 and "no blend file is open" in one_line(err)


def test_a_run_that_fails_half_way_writes_nothing(home, world, command, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    sensor = bpy.data.objects["Dörr"]
    world.key(sensor, "scale", {1: (1, 1, 1), 30: (0, 0, 0)}, "CONSTANT")
    arguments = ["--events", out / "a.csv", "--samples", out / "s", "--save", out / "b.blend"]
    status, _, err = command("simulate", *arguments)
    assert status == 1 and "'Dörr'" in one_line(err)
    assert list(out.iterdir()) == []


def test_samples_of_names_that_collide(home, world, command, tmp_path):
    world.switch("a/b")
    world.switch("a_b")
    world.update()
    assert command("simulate", "--samples", tmp_path / "s")[0] == 0
    names = sorted(path.name for path in (tmp_path / "s").iterdir())
    assert names == ["Dörr.csv", "Hall, PIR.csv", "a_b-2.csv", "a_b.csv"]


@pytest.mark.skipif(sys.platform == "win32", reason="has no limits of this kind")
def test_a_full_disk_leaves_nothing_behind(home, command, tmp_path):
    """A limit on file sizes replaces the full disk: it is too small for the samples."""
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
    assert status == 2 and "'noon' is not a date and time in ISO 8601" in told


# Simulating part of the frames, and the choices of exports


ops = bpy.ops.angen


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


@pytest.fixture
def two_switches(world):
    """Add two switches that read 24 times a second for two seconds."""
    world.wall(0.2)
    world.switch("Front")
    world.switch("Back")
    world.update()
    return world


def test_simulate_heeds_the_preview_range(two_switches, tmp_path):
    scene = two_switches.scene
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 13, 20
    ops.simulate()
    ops.export_samples(directory=str(tmp_path))
    rows = read(tmp_path / "Front.csv")[1:]
    assert [row[1] for row in rows] == [str(frame) for frame in range(13, 21)]
    assert rows[0][0] == "0.500000", "time begins where the scene does"
    scene.use_preview_range = False
    ops.simulate()
    ops.export_samples(directory=str(tmp_path))
    assert len(read(tmp_path / "Front.csv")) == 1 + 48


def test_frames_before_the_scene_are_refused(two_switches):
    two_switches.scene.frame_start = 20
    with pytest.raises(RuntimeError, match=r"frames 1:5 end before the scene's start, frame 20"):
        ops.simulate(frame_start=1, frame_end=5)


def test_samples_get_a_folder_of_their_own(two_switches, tmp_path):
    ops.simulate()
    for name in ("home samples", "home samples 2"):
        assert ops.export_samples(directory=str(tmp_path), folder="home samples") == {"FINISHED"}
        assert sorted(p.name for p in (tmp_path / name).iterdir()) == ["Back.csv", "Front.csv"]
    assert len(list(tmp_path.iterdir())) == 2
    for bad in ("a/b", ".."):
        with pytest.raises(RuntimeError, match="not the name of a folder"):
            ops.export_samples(directory=str(tmp_path), folder=bad)


def test_only_selected_sensors(two_switches, tmp_path):
    ops.simulate()
    path = tmp_path / "events.csv"
    with pytest.raises(RuntimeError, match="No recorded sensor is selected"):
        ops.export_events(filepath=str(path), selected_only=True)
    assert not path.exists()
    bpy.data.objects["Back"].select_set(True)
    ops.export_events(filepath=str(path), selected_only=True)
    assert {row[2] for row in read(path)[1:]} == {"Back"}
    page = tmp_path / "report.html"
    ops.export_report(filepath=str(page), selected_only=True)
    text = page.read_text(encoding="utf-8")
    assert "Back" in text and "Front" not in text
    ops.export_samples(directory=str(tmp_path), folder="one", selected_only=True)
    assert [p.name for p in (tmp_path / "one").iterdir()] == ["Back.csv"]


def test_the_time_of_day(two_switches, tmp_path):
    ops.simulate()
    path, page = tmp_path / "events.csv", tmp_path / "report.html"
    ops.export_events(filepath=str(path), start="2026-03-01T23:59:59.5")
    rows = read(path)
    assert rows[0] == ["time_s", "frame", "sensor", "kind", "field", "value", "time"]
    assert rows[1][-1] == "2026-03-01T23:59:59.500"
    ops.export_samples(directory=str(tmp_path), folder="one", start="2026-03-01T23:59:59.5")
    samples = read(tmp_path / "one" / "Front.csv")
    assert (samples[0][-1], samples[13][-1]) == ("time", "2026-03-02T00:00:00.000")
    ops.export_report(filepath=str(page), start="2026-03-01T08:00")
    assert "2026-03-01 08:00:00" in page.read_text(encoding="utf-8")
    with pytest.raises(RuntimeError, match=r"Start Time: 'noon' is not a date and time"):
        ops.export_events(filepath=str(path), start="noon")


def start_drawn(scene):
    """Return what the file browser says about the start for the format casas."""
    layout = Layout()
    options = importlib.import_module("bl_ext.user_default.angen_sensors.operators.export_options")
    options.draw_start(layout, scene, "casas")
    return layout.text


def test_the_scenes_start_is_that_of_all_exports(two_switches, tmp_path):
    ops.simulate()
    scene, path, page = bpy.context.scene, tmp_path / "events.csv", tmp_path / "report.html"
    with pytest.raises(RuntimeError, match=r"Start Time is empty, and casas writes dates: set it"):
        ops.export_format(filepath=str(tmp_path / "home"), format="casas")
    assert not list(tmp_path.glob("home*"))
    assert "casas writes dates" in start_drawn(scene)
    scene.angen_start = "2026-03-01T08:00"
    assert "writes dates" not in start_drawn(scene)
    ops.export_events(filepath=str(path))
    assert read(path)[1][-1] == "2026-03-01T08:00:00.000"
    ops.export_samples(directory=str(tmp_path), folder="one")
    assert read(tmp_path / "one" / "Front.csv")[1][-1] == "2026-03-01T08:00:00.000"
    ops.export_report(filepath=str(page))
    assert "2026-03-01 08:00:00" in page.read_text(encoding="utf-8")
    ops.export_format(filepath=str(tmp_path / "all.lp"), format="influx")
    assert "1772352000000000000" in (tmp_path / "all.lp").read_text(encoding="utf-8")
    # The recording stays fresh, and panels show the time of day.
    bpy.context.view_layer.objects.active = bpy.data.objects["Front"]
    assert "08:00:00.0: " in drawn("ANGEN_PT_events").text
    scene.angen_start = "noon"
    with pytest.raises(RuntimeError, match=r"Start Time: 'noon' is not a date and time"):
        ops.export_events(filepath=str(path))
    assert "'noon' is not a date and time" in drawn("ANGEN_PT_simulation").text


def test_events_for_other_tools(two_switches, tmp_path):
    ops.simulate()
    path = tmp_path / "home"
    start = "2026-03-01T08:00"
    ops.export_format(filepath=str(path), format="casas-csv", start=start)
    assert (tmp_path / "home.csv").read_text(
        encoding="utf-8"
    ) == ""  # nothing changes in these seconds
    names = [row[1] for row in read(tmp_path / "home.csv.sensors.csv")[1:]]
    assert names == ["Back", "Front"]
    bpy.data.objects["Back"].select_set(True)
    ops.export_format(
        filepath=str(tmp_path / "back.lp"), format="influx", start=start, selected_only=True
    )
    (line,) = (tmp_path / "back.lp").read_text(encoding="utf-8").splitlines()
    assert line == "optical_switch,sensor=Back open=true 1772352000000000000"
    ops.export_format(filepath=str(tmp_path / "folder"), format="pyadlml", start=start)
    assert (tmp_path / "folder" / "devices.csv").exists()
    with pytest.raises(RuntimeError, match="does not exist"):
        ops.export_format(filepath=str(tmp_path / "none" / "x"), format="xes", start=start)
