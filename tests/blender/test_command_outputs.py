# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen` never writes over its inputs, writes all outputs or none, and none if it is stopped."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import bpy
import pytest
from commands import ROOT, listing, start
from tiers import mostly_slow
from tutorials import shell as posix_shell

HEADER = "time_s,frame,sensor,kind,field,value\r\n"


@pytest.fixture
def home(world, tmp_path):
    """Add a switch before a wall, another sensor, and a chair that is linked from another file."""
    files = tmp_path / "files"
    files.mkdir()
    world.box((1, 1, 1), at=(9, 9, 9), name="chair")
    bpy.ops.wm.save_as_mainfile(filepath=str(files / "furniture.blend"), copy=True)
    bpy.data.objects.remove(bpy.data.objects["chair"])
    with bpy.data.libraries.load(str(files / "furniture.blend"), link=True) as (_, target):
        target.objects = ["chair"]
    world.scene.collection.objects.link(target.objects[0])
    world.wall(0.02)
    world.switch("a")
    world.switch("b")
    bpy.ops.wm.save_as_mainfile(filepath=str(files / "home.blend"))
    return files / "home.blend"


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "--events", "{}/home.blend"],
        ["simulate", "--events", "{}/../files/./home.blend"],
        ["simulate", "--events", "{}/link.csv"],
        ["simulate", "--events", "{}/hard.csv"],
        ["simulate", "--events", "{}/linked_folder/home.blend"],
        ["simulate", "--save", "{}/home.blend"],
        ["simulate", "--save", "{}/furniture.blend"],
        ["simulate", "--samples", "{}/samples"],
        ["simulate", "--report", "{}/report.html"],
        ["coverage", "--csv", "{}/home.blend"],
        ["coverage", "--save", "{}/link.csv"],
        ["place", "--csv", "{}/furniture.blend"],
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_no_output_is_what_the_home_is_made_of(home, command, arguments):
    folder = home.parent
    (folder / "link.csv").symlink_to("home.blend")
    (folder / "report.html").symlink_to("furniture.blend")
    (folder / "linked_folder").symlink_to(".")
    os.link(home, folder / "hard.csv")
    (folder / "samples").mkdir()
    (folder / "samples" / "b.csv").symlink_to("../home.blend")
    before = listing(folder)
    status, out, err = command(*(a.format(folder) for a in arguments))
    assert (status, out, err.count("\n")) == (2, "", 1), err
    assert arguments[1] in err and "would be overwritten" in err
    assert listing(folder) == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--events", "{}/x.html", "--report", "{}/../out/x.html"], ["--events", "--report"]),
        (["--events", "{}/x", "--samples", "{}/x"], ["--events", "--samples", "different files"]),
        (["--events", "{}/a.csv", "--samples", "{}"], ["--events", "--samples (a.csv)"]),
        (["--save", "{}/x", "--events", "{}/x"], ["--save", "--events"]),
    ],
)
def test_no_output_is_another_one(home, command, tmp_path, arguments, words):
    out_folder = tmp_path / "out"
    out_folder.mkdir()
    status, out, err = command("simulate", *(a.format(out_folder) for a in arguments))
    assert (status, out, err.count("\n")) == (2, "", 1), err
    assert all(word in err for word in words), err
    assert list(out_folder.iterdir()) == []


def test_nothing_may_be_written_twice_into_no_file_at_all(home, command, tmp_path):
    status, _, err = command("simulate", "--events", os.devnull, "--quiet")
    assert (status, err) == (0, "")


def test_exports_of_the_window_spare_the_home_too(home, tmp_path):
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    before = home.read_bytes()
    with pytest.raises(RuntimeError, match="would be overwritten, and is the open file itself"):
        bpy.ops.angen.export_events(filepath=str(home))
    assert home.read_bytes() == before


@pytest.fixture
def long_run(home, world, tmp_path):
    """Start a long run, and wait until it goes through the frames; return it and its outputs."""
    world.key(bpy.data.objects["wall"], "location", {1: (0, 0, -0.02), 100_000: (1, 0, -0.02)})
    for index in range(20):
        world.pir(f"pir {index}", rays=120)
    world.switch("off", enabled=False)
    world.scene.frame_end = 100_000
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    out = tmp_path / "out"
    out.mkdir()
    outputs = ["--events", out / "e.csv", "--samples", out / "s", "--save", out / "s.blend"]
    process = start("simulate", home, *outputs)
    assert process.stderr is not None
    assert b"switched off" in process.stderr.readline()
    time.sleep(0.5)
    assert process.poll() is None
    yield process, out
    process.kill()
    process.communicate()


@pytest.mark.parametrize("name", mostly_slow(["SIGTERM", "SIGHUP", "SIGINT"], "SIGTERM"))
@pytest.mark.skipif(sys.platform == "win32", reason="has no such signals")
def test_a_job_that_is_ended_leaves_nothing(long_run, name):
    process, out = long_run
    process.send_signal(getattr(signal, name))
    said, told = process.communicate(timeout=60)
    assert (process.returncode, said) == (1, b"")
    assert b"interrupted; nothing was written" in told and b"Traceback" not in told
    assert list(out.iterdir()) == []


SLOW_DISK = """
import os, runpy, sys, time
fsync, seconds = os.fsync, 60 if sys.argv[1] == "killed" else 0
def slow(handle):
    fsync(handle)
    print("written", file=sys.stderr, flush=True)
    time.sleep(seconds)
os.fsync = slow
sys.argv = ["angen_addon", *sys.argv[2:]]
runpy.run_module("angen_addon", run_name="__main__", alter_sys=True)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="has no SIGKILL")
def test_killed_as_it_writes_nothing_has_landed_and_the_next_run_cleans_up(home, tmp_path):
    """The saved file, which is written first, is put in place with the others too."""
    out = tmp_path / "out"
    (out / "s").mkdir(parents=True)
    outputs = ["--events", out / "e.csv", "--samples", out / "s", "--save", out / "s.blend"]
    arguments = ["simulate", home, *outputs, "--quiet"]

    def run(how):
        return subprocess.Popen(
            [sys.executable, "-c", SLOW_DISK, how, *map(str, arguments)],
            cwd=ROOT,
            stderr=subprocess.PIPE,
        )

    process = run("killed")
    assert process.stderr is not None
    assert process.stderr.readline() == b"written\n"
    process.kill()
    process.communicate()
    left = [path.name for path in out.rglob("*") if path.is_file()]
    assert left and all(name.startswith(".angen-") for name in left)
    process = run("goes on")
    process.communicate(timeout=60)
    assert process.returncode == 0
    found = sorted(str(path.relative_to(out)) for path in out.rglob("*") if path.is_file())
    assert found == ["e.csv", "s.blend", "s/a.csv", "s/b.csv"]


def shell(home, text, **options):
    """Run a shell command, in which ANGEN stands for `python -m angen_addon simulate HOME`."""
    run = f"'{sys.executable}' -m angen_addon simulate '{home}' --quiet"
    return subprocess.run(
        [posix_shell(), "-c", text.replace("ANGEN", run)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        **options,
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="has another shell")
def test_closed_streams(home, tmp_path):
    events = tmp_path / "events.csv"
    before = listing(home.parent)
    done = shell(home, "ANGEN >&-")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "standard output is closed: give --events" in done.stderr
    for closed in (">&-", "<&- >&- 2>&-"):
        events.unlink(missing_ok=True)
        done = shell(home, f"ANGEN --events '{events}' {closed}")
        assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), closed
        assert events.read_bytes().decode().startswith(HEADER)
    done = shell(home, "ANGEN 2>&-")
    assert done.returncode == 0 and done.stdout.startswith(HEADER.strip())
    done = shell(home, "ANGEN --sensor nobody 2>&-")
    assert (done.returncode, done.stdout) == (2, ""), "no error among the events"
    assert listing(home.parent) == before


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no /dev/full")
def test_a_full_disk_under_standard_error_costs_no_events(home):
    done = shell(home, "ANGEN 2>/dev/full")
    assert done.returncode == 0 and done.stdout.startswith(HEADER.strip())
    assert shell(home, "ANGEN --sensor nobody 2>/dev/full").returncode == 2


def test_names_that_are_formulas(home, command, world, tmp_path):
    """Logs have the names unchanged, those for spreadsheets do not; both have the same events."""
    world.switch("=cmd()|' /C calc'!A0")
    log, sheet = tmp_path / "log.csv", tmp_path / "sheet.csv"
    assert command("simulate", "--events", log)[0] == 0
    assert command("simulate", "--events", sheet, "--spreadsheet")[0] == 0
    shown = sheet.read_text(encoding="utf-8-sig")
    assert ",=cmd()" in log.read_text() and ",=cmd()" not in shown
    assert shown.replace("'=cmd", "=cmd") == log.read_text()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    bpy.ops.angen.export_events(filepath=str(tmp_path / "window.csv"), spreadsheet=True)
    assert (tmp_path / "window.csv").read_bytes() == sheet.read_bytes()
    samples = ["--spreadsheet", "comma", "--samples", tmp_path / "comma"]
    assert command("simulate", "--events", sheet, *samples)[0] == 0
    options = {"spreadsheet": True, "decimal_comma": True}
    bpy.ops.angen.export_events(filepath=str(tmp_path / "window.csv"), **options)
    assert (tmp_path / "window.csv").read_bytes() == sheet.read_bytes()
    assert sheet.read_bytes().startswith(b"\xef\xbb\xbftime_s;frame;sensor;kind;field;value\r\n0,0")
    bpy.ops.angen.export_samples(directory=str(tmp_path), folder="window", **options)
    assert listing(tmp_path / "comma") == listing(tmp_path / "window")
    assert (tmp_path / "comma" / "a.csv").read_bytes().count(b"\xef\xbb\xbf") == 1
