# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m angen_addon` in processes of its own: files that are none, signals, full disks."""

import csv
import os
import re
import signal
import subprocess
import sys
import time
from datetime import datetime
from pathlib import Path

import bpy
import pytest
from commands import DOOR_LOG, ROOT, door_home, listing, module, one_line, save


@pytest.fixture
def home(world, tmp_path):
    return door_home(world, tmp_path)


def test_simulate_writes_the_same_to_standard_output_and_to_files(home, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    first = module("simulate", home)
    assert first.returncode == 0, first.stderr
    assert first.stdout.decode() == DOOR_LOG
    second = module(
        "simulate",
        home,
        "--events",
        out / "events.csv",
        "--samples",
        out / "samples",
        "--bake",
        "--save",
        out / "baked.blend",
        "--quiet",
    )
    assert (second.returncode, second.stdout, second.stderr) == (0, b"", b"")
    assert (out / "events.csv").read_bytes() == first.stdout
    assert sorted(p.name for p in out.iterdir()) == ["baked.blend", "events.csv", "samples"]
    assert sorted(p.name for p in (out / "samples").iterdir()) == ["Dörr.csv", "Hall, PIR.csv"]
    samples = (out / "samples" / "Dörr.csv").read_text(encoding="utf-8").split()
    assert samples[0] == "time_s,frame,open,range_m"
    assert len(samples) == 49
    bpy.ops.wm.open_mainfile(filepath=str(out / "baked.blend"))
    sensor = bpy.data.objects["Dörr"]
    bpy.context.scene.angen_live = False
    for frame, opened in ((12, False), (13, True), (36, True), (37, False)):
        bpy.context.scene.frame_set(frame)
        assert sensor.angen_sensor.active is opened


def test_files_that_are_no_blend_files(tmp_path):
    """Told before Blender starts, which is quick: one line, status 2."""
    whole = tmp_path / "empty.blend"
    whole.write_bytes(b"")
    (tmp_path / "text.blend").write_text("not a blend file")
    before = listing(tmp_path)
    for name, words in (
        ("missing.blend", "No such file"),
        ("empty.blend", "is empty"),
        ("text.blend", "not a blend file"),
        (".", "is a folder"),
    ):
        done = module("simulate", tmp_path / name)
        line = one_line(done.stderr.decode())
        assert words in line and str(tmp_path / name) in line
        assert (done.returncode, done.stdout) == (2, b"")
    assert listing(tmp_path) == before


@pytest.mark.slow
def test_damaged_and_newer_files(home, tmp_path):
    data = home.read_bytes()
    truncated = tmp_path / "truncated.blend"
    truncated.write_bytes(data[: len(data) // 2])
    header = data[:17]
    # The version stands in the header: three digits, or four since Blender 5.
    newer = header.replace(b"v%d" % (100 * bpy.app.version[0] + bpy.app.version[1]), b"v999")
    newer = newer.replace(b"v0%d" % (100 * bpy.app.version[0] + bpy.app.version[1]), b"v9999")
    assert newer != header
    (tmp_path / "newer.blend").write_bytes(newer + data[17:])
    out = tmp_path / "events.csv"
    done = module("simulate", tmp_path / "truncated.blend", "--events", out)
    error = done.stderr.decode().splitlines()
    assert (done.returncode, done.stdout) == (2, b""), error
    assert error[-1].startswith("angen: cannot open") and "truncated.blend" in error[-1]
    assert not any("Traceback" in line for line in error)
    assert not out.exists()
    # Blender reads most of a newer file; where it does, the user must know.
    done = module("simulate", tmp_path / "newer.blend", "--events", out)
    error = done.stderr.decode()
    assert "Traceback" not in error
    if done.returncode == 0:
        assert "angen: the file was saved by Blender" in error and "newer" in error
    else:
        assert (done.returncode, out.exists()) == (2, False)
        assert "angen: cannot open" in error and "newer.blend" in error


@pytest.mark.slow
def test_arguments_in_the_wrong_place():
    done = module()
    assert done.returncode == 2 and b"usage" in done.stderr
    done = module("simulate", "--frames", "1:2")
    assert done.returncode == 2 and b"usage" in done.stderr
    done = module("--help")
    assert done.returncode == 0 and b"simulate" in done.stdout and b"study" in done.stdout
    for arguments in (["simul"], ["simul", "home.blend"]):
        done = module(*arguments)
        assert done.returncode == 2
        assert one_line(done.stderr.decode()).endswith("did you mean simulate?")
    done = module("explain", "--help")
    assert done.stdout.startswith(b"usage: python -m angen_addon explain HOME.blend [-h]")
    done = module("apply", "--help")
    assert b"apply LAYOUT.json HOME.blend --save FILE.blend [options]\n" in done.stdout


def test_ctrl_c_leaves_no_file(world, tmp_path):
    """SIGINT in the middle of a long run: one line, no file, a status that is not 0."""
    world.key(world.box((1, 1, 1), at=(0, 0, -2)), "location", {1: (0, 0, -2), 100_000: (1, 0, -2)})
    for index in range(20):
        world.pir(f"pir {index}", rays=120)
    world.switch("off", enabled=False)
    world.scene.frame_end = 100_000
    home, out = save(tmp_path), tmp_path / "out"
    out.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "angen_addon", "simulate", home, "--events", out / "events.csv"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stderr is not None
    # What is switched off is the last word before the frames are gone through.
    assert b"switched off" in process.stderr.readline()
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=30)
    assert process.returncode not in (0, -signal.SIGKILL)
    assert stdout == b""
    assert b"interrupted" in stderr and b"Traceback" not in stderr
    assert list(out.iterdir()) == []


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="has no /proc")
def test_ctrl_c_while_blender_starts(home, tmp_path):
    """An exception in one of its start-up scripts, or in a handler, would be lost."""
    process = subprocess.Popen(
        [sys.executable, "-m", "angen_addon", "simulate", home, "--events", tmp_path / "e.csv"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    maps = Path(f"/proc/{process.pid}/maps")
    while "/bpy/" not in maps.read_text():
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert (process.returncode, stdout) == (1, b"")
    assert stderr == b"angen: interrupted; nothing was written\n"
    assert not (tmp_path / "e.csv").exists()


@pytest.mark.slow
def test_ctrl_c_breaks_off_a_picture_of_the_light(world, tmp_path):
    """One that takes longer than anybody waits: light paths without end."""
    lamp = world.bpy.data.lights.new("lamp", "POINT")
    world.link("lamp", lamp, (0, 0, 2))
    settings = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 16, "update_rate": 24.0}
    world.sensor("LIGHT", "meter", **settings)
    world.switch("off", enabled=False)
    world.scene.angen_light_reference = 2**24
    world.box((4, 4, 4), name="room")
    home, out = save(tmp_path), tmp_path / "out"
    out.mkdir()
    (tmp_path / "temporary").mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "angen_addon", "simulate", home, "--events", out / "events.csv"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(tmp_path / "temporary")},
    )
    assert process.stderr is not None
    assert b"switched off" in process.stderr.readline()
    time.sleep(2.0)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 1
    assert stdout == b""
    assert b"interrupted; nothing was written" in stderr and b"Traceback" not in stderr
    assert list(out.iterdir()) == [] == list((tmp_path / "temporary").iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no /dev/full")
def test_a_full_disk_under_standard_output(home):
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "angen_addon", "simulate", str(home)],
            cwd=ROOT,
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
            timeout=60,
        )
    assert done.returncode == 1
    assert b"Traceback" not in done.stderr
    assert b"No space left" in done.stderr


def test_a_reader_that_goes_away_is_no_traceback(home):
    """As with `| head -1`."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "angen_addon", "simulate", str(home)],
        cwd=ROOT,
        stdout=writing,
        stderr=subprocess.PIPE,
        check=False,
        timeout=60,
    )
    os.close(writing)
    assert done.returncode == 1
    assert b"Traceback" not in done.stderr


@pytest.mark.slow
def test_the_first_example_of_days_is_of_real_detectors_without_light(tmp_path):
    """The pages' own words, but for five minutes of an evening in place of the week."""
    found = set()
    for page in ("README.md", "docs/residents.md"):
        text = (ROOT / page).read_text(encoding="utf-8").replace("\\\n", " ")
        first = re.search(r"^    .*angen day (.*)$", text, re.M)[1]
        found.add(tuple(first[first.index("--routine") :].split()))
    (words,) = found
    changed = {"sample_blends/week.toml": "sample_blends/story.toml", "7": "1"}
    changed["week"] = out = tmp_path / "days"
    words = [changed.get(word, word) for word in words]
    done = module("day", ROOT / "sample_blends" / "angen.blend", *words, timeout=600)
    assert done.returncode == 0, done.stderr
    events = list(csv.DictReader((out / "events.csv").read_text(encoding="utf-8").splitlines()))
    assert {event["kind"] for event in events} == {"PIR", "OPTICAL_SWITCH"}
    begins, on = {}, []
    for event in events:
        when = datetime.fromisoformat(event["time"])
        if event["field"] == "moved" and event["value"] == "1":
            begins[event["sensor"]] = when
        elif event["sensor"] in begins:
            on.append((when - begins.pop(event["sensor"])).total_seconds())
    assert len(on) > 20
    assert min(on) > 1.0
