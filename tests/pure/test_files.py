# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files are written completely or not at all; each sensor's samples have their own file."""

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.logs.error import AngenError
from angen_sensors.sensor_logic.logs.files import check_folder, file_names, write_files

ROOT = Path(__file__).resolve().parents[2]


def contents(folder):
    return {p.name: p.read_bytes() if p.is_file() else None for p in folder.iterdir()}


def test_files_are_written_byte_for_byte_and_replaced(tmp_path):
    (tmp_path / "a.csv").write_text("a long text of before")
    write_files({tmp_path / "a.csv": "ä,1\r\n", tmp_path / "b.csv": ""})
    assert contents(tmp_path) == {"a.csv": "ä,1\r\n".encode(), "b.csv": b""}


@pytest.mark.parametrize(
    ("second", "text"),
    [("missing/b.csv", "new"), ("folder_b.csv", "new"), ("b.csv", "\udcff")],
    ids=["no folder", "a folder there", "cannot be encoded"],
)
def test_a_failure_at_the_second_file_leaves_all_as_it_was(tmp_path, second, text):
    (tmp_path / "a.csv").write_text("old")
    (tmp_path / "folder_b.csv").mkdir()
    with pytest.raises(AngenError, match=r"b\.csv"):
        write_files({tmp_path / "a.csv": "new", tmp_path / second: text})
    assert contents(tmp_path) == {"a.csv": b"old", "folder_b.csv": None}


@pytest.mark.skipif(sys.platform == "win32", reason="has no limits of this kind")
def test_a_full_disk_leaves_all_as_it_was(tmp_path):
    """A limit on file sizes replaces the full disk."""
    import resource

    (tmp_path / "a.csv").write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(AngenError, match=r"b\.csv"):
            write_files({tmp_path / "a.csv": "new", tmp_path / "b.csv": "x" * 20_000})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert contents(tmp_path) == {"a.csv": b"old"}


def test_an_interrupt_leaves_nothing_behind(tmp_path, monkeypatch):
    def interrupted(handle):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_files({tmp_path / "a.csv": "new"})
    assert contents(tmp_path) == {}


@pytest.mark.skipif(sys.platform == "win32", reason="has no such permissions")
def test_files_get_the_permissions_of_ordinary_files(tmp_path):
    before = os.umask(0o027)
    try:
        write_files({tmp_path / "a.csv": "new"})
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.csv").stat().st_mode) == 0o640


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="has no named pipes")
def test_a_pipe_or_device_is_written_to_and_not_replaced(tmp_path):
    """As with `--events /dev/null`, which root could replace by a plain file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_text()), daemon=True)
    reader.start()
    write_files({pipe: "events"})
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    reader.join(10)
    assert got == ["events"]
    assert list(tmp_path.iterdir()) == [pipe]


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "target.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to("target.csv")
    write_files({tmp_path / "link.csv": "new"})
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "target.csv").read_text() == "new"


def test_folders_that_cannot_take_a_file_are_told(tmp_path):
    check_folder(tmp_path, "--events")
    (tmp_path / "file").write_text("")
    with pytest.raises(AngenError, match=r"--events: the folder .*missing does not exist"):
        check_folder(tmp_path / "missing", "--events")
    with pytest.raises(AngenError, match="not a folder"):
        check_folder(tmp_path / "file", "--samples")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("sensor", "name"),
    [
        ("Hall PIR", "Hall PIR.csv"),
        ("Kök ö", "Kök ö.csv"),
        ("a/b\\c:d", "a_b_c_d.csv"),
        ('<>"|?*', "______.csv"),
        ("two\nlines", "two_lines.csv"),
        ("..", "_.csv"),
        (" dots. ", "dots.csv"),
        ("con", "con_.csv"),
        ("COM1.x", "COM1.x_.csv"),
        ("Console", "Console.csv"),
    ],
)
def test_sensors_name_their_files(sensor, name):
    assert file_names([sensor]) == {sensor: name}


@pytest.mark.parametrize(
    "sensors",
    [["a/b", "a_b"], ["a_b", "a/b", "a:b"], ["..", "_"], ["Hall", "HALL"], ["a/b", "a:b", "a_b-2"]],
)
def test_no_two_sensors_share_a_file(sensors):
    names = file_names(sensors)
    assert list(names) == sensors
    assert len({name.casefold() for name in names.values()}) == len(sensors)
    assert file_names(reversed(sensors)) == names, "whatever their order"
    for sensor in sensors:
        if sensor in {"a_b", "_", "a_b-2"}:
            assert names[sensor] == f"{sensor}.csv", "who can keeps its own name"


WRITER = """
import sys, time
from pathlib import Path
from sensor_logic.logs.files import WholeFiles
with WholeFiles() as parts:
    for name in "abc":
        parts.new(Path(sys.argv[1], name)).write_text(name)
    print("written", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def writer(tmp_path):
    """Start another process that is in the middle of writing three files there."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(tmp_path)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "written\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_what_a_killed_run_left_is_removed_by_the_next(writer, tmp_path):
    writer.kill()
    writer.wait()
    assert len(contents(tmp_path)) == 4
    # Files of an earlier version, of a save of Blender, and of others with such names.
    for name in (".angen-0a_b1c2d.part", ".angen-0a_b1c2d.blend@", ".angen-notes", ".angen.part"):
        (tmp_path / name).write_text("")
    write_files({tmp_path / "a.csv": "new"})
    assert sorted(contents(tmp_path)) == [".angen-notes", ".angen.part", "a.csv"]


@pytest.mark.skipif(
    sys.platform == "win32" or "ANGEN_WINDOWS" in os.environ,
    reason="the lock is of another kind there",
)
def test_a_run_that_goes_on_is_left_alone(writer, tmp_path):
    before = contents(tmp_path)
    write_files({tmp_path / "a.csv": "new"})
    assert contents(tmp_path) == {**before, "a.csv": b"new"}
