# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen simulate --format NAME --out PATH` writes runs in the formats of other tools.

Its report is the same from the command line and from Blender.
"""

import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import bpy
import pytest

START = "2026-03-02T07:00:00"


@pytest.fixture
def home(world, tmp_path):
    """Add a switch in a room, whose wall comes near at frame 13."""
    wall = world.wall(0.2)
    for frame, z in ((1, -0.2), (12, -0.2), (13, -0.02)):
        wall.location.z = z
        wall.keyframe_insert("location", frame=frame)
    world.switch("Front door", update_rate=24.0)
    bpy.data.objects["Front door"].angen_sensor.room = "hall"
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_a_run_is_written_in_several_formats_at_once(home, command, tmp_path) -> None:
    status, out, _ = command(
        "simulate", "--quiet", "--start", START,
        "--format", "casas-csv", "--out", tmp_path / "log.csv",
        "--format", "influx", "--out", tmp_path / "log.lp",
        "--format", "pyadlml", "--out", tmp_path / "folder",
    )  # fmt: skip
    assert status == 0
    assert out.startswith("time_s,frame,sensor")
    assert (tmp_path / "log.csv").read_text() == "2026-03-02,07:00:00.500000,FrontDoor,CLOSE\n"
    assert (tmp_path / "log.lp").read_text().splitlines() == [
        r"optical_switch,sensor=Front\ door,room=hall open=true 1772434800000000000",
        r"optical_switch,sensor=Front\ door,room=hall open=false 1772434800500000000",
    ]
    assert "Front door" in (tmp_path / "folder" / "device_map.csv").read_text()


def test_faults_of_a_run_are_those_of_its_log(home, command, tmp_path) -> None:
    (tmp_path / "faults.toml").write_text('[[fault]]\nsensors = "Front*"\nclock_offset = 2\n')
    faults = ["--faults", tmp_path / "faults.toml", "--truth", tmp_path / "truth.csv"]
    clean = command("simulate", "--quiet")[1].splitlines()
    status, out, _ = command(
        "simulate", "--quiet", *faults, "--format", "casas", "--out", tmp_path / "log.txt"
    )
    assert status == 0
    assert out.splitlines() == [*clean[:2], clean[2].replace("0.500000", "2.500000")]
    assert (tmp_path / "log.txt").read_text() == "1970-01-01 00:00:02.500000 D001 CLOSE\n"
    told = (tmp_path / "truth.csv").read_text().splitlines()
    assert told[-1] == f"clock,2,2,{clean[2]}"


def test_versions_and_seed_go_with_the_log(home, command, tmp_path) -> None:
    assert command("simulate", "--quiet", "--format", "xes", "--out", tmp_path / "log.xes")[0] == 0
    text = (tmp_path / "log.xes").read_text(encoding="utf-8")
    assert 'key="angen:home" value="home.blend"' in text
    assert 'key="angen:seed" value="0"' in text
    assert f'key="angen:versions.blender" value="{bpy.app.version_string}' in text


def test_without_out_or_where_it_cannot_be_written_nothing_runs(home, command, tmp_path) -> None:
    (tmp_path / "f.toml").write_text('[[fault]]\nsensors = "Back*"\nlost = 1\n')
    before = sorted(p.name for p in tmp_path.iterdir())
    for arguments, words in (
        (["--format", "xes"], ["1 --format", "0 --out"]),
        (["--format", "word", "--out", "x"], ["word", "casas"]),
        (["--format", "xes", "--out", tmp_path / "no" / "x"], ["does not exist"]),
        (["--format", "xes", "--out", home], ["open file"]),
        (["--format", "xes", "--out", "x", "--format", "ocel", "--out", "x"], ["both name x"]),
        (["--format", "xes", "--out", "x", "--events", "x"], ["both name x"]),
        (["--format", "pyadlml", "--out", home], ["is a file"]),
        (["--truth", "x"], ["--faults"]),
        (["--faults", tmp_path / "f.toml"], ["--truth"]),
        (["--faults", tmp_path / "no.toml", "--truth", "x"], ["no.toml"]),
        (["--faults", tmp_path / "f.toml", "--truth", "x"], ["f.toml", "line 2", "Back"]),
        (["--faults", tmp_path / "f.toml", "--truth", tmp_path / "f.toml"], ["line 2"]),
    ):
        status, out, err = command("simulate", "--quiet", *arguments)
        assert (status, out) == (2, ""), arguments
        assert err.count("\n") == 1, err
        assert all(word in err for word in words), err
    assert sorted(p.name for p in tmp_path.iterdir()) == before
    assert not Path("x").exists()


@pytest.mark.parametrize(
    ("name", "start"), [("mcap", "2038-01-19T03:14:07"), ("mcap", "1950-01-01"), ("influx", "2263")]
)
def test_a_date_that_a_format_cannot_hold_is_told_before_the_run(
    home, command, tmp_path, name, start
) -> None:
    start = start if "-" in start else f"{start}-01-01"
    events, out = tmp_path / "events.csv", tmp_path / "out"
    options = ["--start", start, "--events", events, "--format", name, "--out", out]
    status, _, err = command("simulate", *options)
    assert status == 2
    assert err.count("\n") == 1 and f"{name} holds dates from " in err, err
    assert not events.exists() and not out.exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--start", "2038-01-19", "--format", "mcap"], "mcap holds dates from 1970-01-01"),
        (["--start", "2300-01-01", "--format", "influx"], "influx holds dates from 1677-09-21"),
        (["--start", "9999-12-31"], "between the years 1 and 9999"),
    ],
)
def test_days_whose_dates_cannot_be_are_told_before_there_is_a_folder(
    home, command, tmp_path, more, words
) -> None:
    out = tmp_path / "days"
    status, _, err = command("day", "--routine", "r.toml", "--days", "2", "--out", out, *more)
    assert status == 2 and words in err and err.count("\n") == 1, err
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (["--speed", "2"], 2, ["--speed needs --mqtt"]),
        (["--mqtt", "localhost", "--faults", "FAULTS", "--truth", "t"], 2, ["replay"]),
        (["--mqtt", "localhost"], 1, ['pip install ".[mqtt]"']),
    ],
)
def test_what_cannot_be_sent_is_told_before_the_run(
    home, command, tmp_path, monkeypatch, options, status, words
) -> None:
    monkeypatch.setitem(sys.modules, "paho.mqtt.client", None)
    faults = tmp_path / "faults.toml"
    faults.write_text("[[fault]]\nlost = 0.5\n")
    given = [str(faults) if option == "FAULTS" else option for option in options]
    found, out, err = command("simulate", "--quiet", *given)
    assert (found, out) == (status, "")
    assert err.count("\n") == 1, err
    assert all(word in err for word in words), err


# The report from the command line and from Blender


BAD_INPUT, FAILED = 2, 1


@pytest.fixture
def hall_home(world: Any, tmp_path: Path) -> Path:
    """Add a door in the hall, open from frame 13 to 37, and a PIR that sees nothing."""
    world.door(13, 37)
    world.switch("Dörr <1>", range_max=0.4)["room"] = "Hall"
    world.pir("PIR").location.x = 100
    folder = tmp_path / "secret"
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "home & garden.blend"))
    return folder


def texts(path: Path) -> list[str]:
    root = ET.fromstring(path.read_text(encoding="utf-8").removeprefix("<!DOCTYPE html>"))
    return [text.strip() for text in root.itertext() if text.strip()]


def rows(path: Path) -> list[list[str]]:
    root = ET.fromstring(path.read_text(encoding="utf-8").removeprefix("<!DOCTYPE html>"))
    return [["".join(cell.itertext()) for cell in row] for row in root.iter("tr")]


def test_the_page_tells_the_run(hall_home: Path, command: Any) -> None:
    page = hall_home / "report.html"
    status, out, _ = command("simulate", "--report", page, "--quiet")
    assert status == 0 and out.startswith("time_s,frame,sensor")
    shown = texts(page)
    for text in ("home & garden.blend", "1 to 48", "24 fps", "Timeline", "Hall", "Dörr <1>"):
        assert text in shown, text
    # The switch is numbered first, because it has a room. At 24 Hz it opens at 0.5 s, closes at 1.5
    # s.
    assert rows(page)[1][:4] == ["1", "Dörr <1>", "Optical switch", "Hall"]
    assert rows(page)[1][5:9] == ["2", "0.5", "1.5", "50.0%"]
    assert rows(page)[-2][2] == "update_rate 24 Hz, range_max 0.4 m"
    assert "secret" not in page.read_text(encoding="utf-8")  # no path of the file


def test_the_picture_has_timeline_and_plan(hall_home: Path, command: Any) -> None:
    picture = hall_home / "report.SVG"
    assert command("simulate", "--report", picture, "--quiet")[0] == 0
    shown = texts(picture)
    assert "Dörr <1>" in shown and "time in s" in shown
    assert any(text.startswith("Floor plan") for text in shown)


def test_of_what_is_animated_no_single_value_is_told(hall_home: Path, command: Any) -> None:
    obj, pages = bpy.data.objects["PIR"], [hall_home / "one.html", hall_home / "two.html"]
    for frame, angle in ((1, 0.5), (24, 1.0)):
        obj.angen_sensor.pir.threshold = angle
        obj.keyframe_insert("angen_sensor.pir.threshold", frame=frame)
    for page, frame in zip(pages, (1, 20), strict=True):
        bpy.context.scene.frame_set(frame)
        assert command("simulate", "--report", page, "--quiet")[0] == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()
    assert rows(pages[0])[-1][2].endswith("vertical_fov 0°, threshold animated")


def test_the_report_keeps_to_the_chosen_sensors_and_frames(hall_home: Path, command: Any) -> None:
    page = hall_home / "r.html"
    arguments = ("--sensor", "PIR", "--frames", "5:28", "--report", page, "--quiet")
    assert command("simulate", *arguments)[0] == 0
    assert "5 to 28" in texts(page) and "Dörr <1>" not in texts(page)
    assert "What one sensor reported in 1 s." in texts(page)


def test_a_sensor_that_is_off_is_told_as_not_simulated(
    world: Any, hall_home: Path, command: Any
) -> None:
    bpy.data.objects["PIR"].angen_sensor.enabled = False
    assert command("simulate", "--report", hall_home / "r.html", "--quiet")[0] == 0
    assert "not simulated" in rows(hall_home / "r.html")[2]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("report.pdf", "report.pdf must end in .html (the whole report) or .svg"),
        ("report", "must end in .html"),
        ("none/r.html", "does not exist; make it first"),
        (".", "is a folder"),
    ],
)
def test_a_wrong_name_is_refused_before_the_run(
    hall_home: Path, command: Any, name: str, said: str
) -> None:
    status, out, error = command("simulate", "--report", hall_home / name)
    assert (status, out) == (BAD_INPUT, "")
    assert "--report" in error and said in error


def test_where_one_file_fails_none_is_written(hall_home: Path, command: Any) -> None:
    """The samples of 'PIR' cannot be written where a folder has their name."""
    (hall_home / "samples" / "PIR.csv").mkdir(parents=True)
    report = hall_home / "r.html"
    status, _, error = command("simulate", "--report", report, "--samples", hall_home / "samples")
    assert status == FAILED and "it is a folder" in error
    assert not report.exists()


def test_the_operator_needs_a_recording_and_writes_the_same(hall_home: Path, command: Any) -> None:
    path = hall_home / "by_hand.html"
    assert not bpy.ops.angen.export_report.poll()
    bpy.ops.angen.simulate()
    assert bpy.ops.angen.export_report(filepath=str(path)) == {"FINISHED"}
    assert command("simulate", "--report", hall_home / "headless.html", "--quiet")[0] == 0
    assert path.read_bytes() == (hall_home / "headless.html").read_bytes()
    assert bpy.ops.angen.export_report.poll()  # the recording is still fresh
    with pytest.raises(RuntimeError, match=re.escape("must end in .html")):
        bpy.ops.angen.export_report(filepath=str(hall_home / "r.txt"))
