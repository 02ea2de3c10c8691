# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m angen_addon` in separate processes: wrong files, signals, full disks."""

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
from commands import DOOR_LOG, ROOT, door_home, listing, module, one_line, save, start
from tiers import mostly_slow


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
    """The error comes before Blender starts, which is quick: one line, status 2."""
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
    # The version is in the header: three digits, or four since Blender 5.
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
    # Blender reads most of a newer file; then the user must get a warning.
    done = module("simulate", tmp_path / "newer.blend", "--events", out)
    error = done.stderr.decode()
    assert "Traceback" not in error
    if done.returncode == 0:
        assert "angen: the file was saved by Blender" in error and "newer" in error
    else:
        assert (done.returncode, out.exists()) == (2, False)
        assert "angen: cannot open" in error and "newer.blend" in error


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="has no /proc")
def test_ctrl_c_while_blender_starts(home, tmp_path):
    """An exception in one of its start-up scripts, or in a handler, would be lost."""
    process = start("simulate", home, "--events", tmp_path / "e.csv")
    maps = Path(f"/proc/{process.pid}/maps")
    while "/bpy/" not in maps.read_text(encoding="utf-8"):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert (process.returncode, stdout) == (1, b"")
    assert stderr == b"angen: interrupted; nothing was written\n"
    assert not (tmp_path / "e.csv").exists()


@pytest.mark.slow
def test_ctrl_c_breaks_off_a_picture_of_the_light(world, tmp_path):
    """The picture has too many light paths to ever finish."""
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
    environment = {**os.environ, "TMPDIR": str(tmp_path / "temporary")}
    process = start("simulate", home, "--events", out / "events.csv", env=environment)
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
@pytest.mark.parametrize("to", ["a full disk", "a reader that went away"])
def test_standard_output_that_takes_nothing_is_no_traceback(home, to):
    """The reader of the pipe ends first, as in `| head -1`."""
    if to == "a full disk":
        out = os.open("/dev/full", os.O_WRONLY)
    else:
        reading, out = os.pipe()
        os.close(reading)
    process = start("simulate", home, stdout=out)
    os.close(out)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 1 and b"Traceback" not in told
    assert to != "a full disk" or b"No space left" in told


@pytest.mark.slow
def test_the_first_example_of_days_is_of_real_detectors_without_light(tmp_path):
    """The commands are those of the page, with a day of one evening in place of the week."""
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


# Processes end with their own exit status, also if the file has drivers in Python, whose remains
# crash Blender's module, or if Python functions outlive the end


EXPRESSIONS = ("round(frame, 1) / 12 - 1", "[0, frame / 12][1] - 1", "noise.random() * 0 - 1")
USE = """
import sys
sys.path.insert(0, {root!r})

def use(path):
    import bpy
    from angen_addon.process.standalone import load_extension
    load_extension().register()
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.context.scene.frame_set(5)
    assert bpy.data.objects["wall"].location.x != 9
"""
WORKER = """
if __name__ == "__main__":
    import multiprocessing
    worker = multiprocessing.get_context("spawn").Process(target=use, args=(sys.argv[1],))
    worker.start()
    worker.join()
    sys.exit(worker.exitcode)
"""

WITH_EXTENSION = """
import sys
sys.path.insert(0, {root!r})
import bpy
from angen_addon.process.standalone import load_extension
extension = load_extension()
extension.register()
scene = bpy.context.scene
thing = bpy.context.object
"""
SIMULATED = """
thing.angen_sensor.kind = {kind!r}
scene.frame_end = 3
assert bpy.ops.angen.simulate() == {{"FINISHED"}}
"""
WAYS = {
    "nothing": "",
    "switched off": "extension.unregister()",
    "off and on": "extension.unregister()\nextension.register()",
    "light": SIMULATED.format(kind="LIGHT"),
    "rigid bodies": "bpy.ops.rigidbody.object_add()" + SIMULATED.format(kind="PRESSURE"),
    "undo": SIMULATED.format(kind="PIR")
    + "bpy.ops.ed.undo_push()\nthing.location.x = 2\nbpy.ops.ed.undo_push()\nbpy.ops.ed.undo()",
    "held": "held = [bpy, thing, thing.angen_sensor, type(scene.angen_coverage)]",
}


@pytest.fixture
def driven(world, tmp_path):
    """Add a wall that drivers move, before a switch."""
    wall, other = world.wall(0.02), world.wall(90.0, "other")
    for index, expression in enumerate(EXPRESSIONS):
        curve = (other if index else wall).driver_add("location", index)
        curve.driver.type = "SCRIPTED"
        curve.driver.expression = expression
    world.scene.frame_end = 24
    world.switch()
    path = tmp_path / "driven.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def run(*arguments, cwd=ROOT):
    done = subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120
    )
    return done.returncode, done.stdout, done.stderr


def test_the_command_line_ends_and_leaves_no_folder_behind(driven, tmp_path, monkeypatch):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    status, out, err = run("-m", "angen_addon", "simulate", driven)
    assert status == 0, err
    assert [row.split(",")[1] for row in out.splitlines()[1:]] == ["1", "6", "19"]
    assert "memory" not in err
    assert list(folder.iterdir()) == []
    status, _, err = run("-m", "angen_addon", "simulate", driven, "--sensor", "nobody")
    assert status == 2, err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("end", "status"),
    mostly_slow([("sys.exit(3)", 3), ("", 0), ("raise ValueError('mine')", 1)], ("sys.exit(3)", 3)),
)
def test_a_script_ends_with_its_own_status(driven, tmp_path, end, status):
    script = tmp_path / "script.py"
    script.write_text(f"{USE.format(root=str(ROOT))}\nuse(sys.argv[1])\n{end}\n")
    found, _, err = run(script, driven, cwd=tmp_path)
    assert found == status, err
    assert ("mine" in err) is (status == 1)


@pytest.mark.parametrize("way", mostly_slow(WAYS, "off and on"))
def test_a_script_ends_after(way, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(f"{WITH_EXTENSION.format(root=str(ROOT))}\n{WAYS[way]}\nsys.exit(3)\n")
    status, out, err = run(script, cwd=tmp_path)
    assert status == 3, out + err
    assert "memory" not in out + err


@pytest.mark.slow
def test_a_worker_process_ends_as_it_should(driven, tmp_path):
    script = tmp_path / "worker.py"
    script.write_text(USE.format(root=str(ROOT)) + WORKER)
    status, _, err = run(script, driven, cwd=tmp_path)
    assert status == 0, err


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="sample blends are built with Blender 4.2")
@pytest.mark.parametrize("name", mostly_slow(["pressure", "light", "light_control"], "pressure"))
def test_sample_blends_are_built_with_status_zero(tmp_path, name):
    """`make sample` stops at the first script that crashes at its end."""
    script, out = ROOT / "sample_blends" / f"build_{name}.py", tmp_path / f"{name}.blend"
    done = subprocess.run([sys.executable, str(script), "--out", str(out)], check=False)
    assert done.returncode == 0
    assert out.exists()
