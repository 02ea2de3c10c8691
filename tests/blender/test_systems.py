# SPDX-License-Identifier: GPL-3.0-or-later
"""What Windows and macOS do otherwise than Linux, imitated one behaviour at a time, in Blender.

Each test has the name of the behaviour, and holds on all systems.
"""

import errno
import io
import os
import sys

import bpy
import pytest
from commands import DOOR_LOG, door_home, listing


@pytest.fixture
def home(world, tmp_path):
    return door_home(world, tmp_path)


@pytest.mark.parametrize("code_page", ["cp437", "cp1252"])
def test_standard_output_with_line_ends_and_code_page_of_windows(
    home, addon_part, monkeypatch, code_page
):
    written = io.BytesIO()
    stream = io.TextIOWrapper(written, encoding=code_page, newline="\r\n")
    monkeypatch.setattr(sys, "stdout", stream)
    run = addon_part("angen_addon.commands.command_line").run_command
    assert run(["simulate", "--quiet"]) == 0
    assert written.getvalue().decode() == DOOR_LOG


def test_a_file_is_saved_where_only_files_open_for_writing_are_flushed(
    home, tmp_path, addon_part, monkeypatch
):
    """Windows has no `fsync` of a file that is open for reading only."""
    fcntl = pytest.importorskip("fcntl")
    output_files, flush = addon_part("angen_addon.output.output_files"), os.fsync

    def flush_as_windows_does(handle):
        if fcntl.fcntl(handle, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        flush(handle)

    monkeypatch.setattr(os, "fsync", flush_as_windows_does)
    with output_files.Outputs() as outputs:
        outputs.save_blend(tmp_path / "saved.blend")
        outputs.commit()
    assert (tmp_path / "saved.blend").stat().st_size > 1000


def test_a_home_in_a_folder_with_spaces_and_umlauts_and_a_path_of_250_characters(
    world, tmp_path, command
):
    start = tmp_path / "Jörg Ängström" / "Wohnung & Küche (neu) → 2"
    folder = start / ("f" * (250 - len(str(start)) - len("//home.blend")))
    folder.mkdir(parents=True)
    door_home(world, tmp_path)
    home = folder / "home.blend"
    assert len(str(home)) == 250
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    out = folder / "out"
    out.mkdir()
    outputs = ["--events", out / "e.csv", "--samples", out / "s", "--report", out / "r.html"]
    status, _, err = command("simulate", "--quiet", *outputs, "--save", out / "s.blend")
    assert (status, err) == (0, "")
    assert (out / "e.csv").read_bytes().decode() == DOOR_LOG
    found = {str(path) for path in listing(out)}
    assert found == {"e.csv", "r.html", "s.blend", *map(os.path.join, "ss", NAMES)}
    bpy.ops.wm.open_mainfile(filepath=str(out / "s.blend"))
    assert command("simulate", "--quiet")[1] == DOOR_LOG


NAMES = ("Dörr.csv", "Hall, PIR.csv")


def test_a_saved_home_that_is_open_in_another_program_is_told_before_the_run(
    home, tmp_path, command, monkeypatch
):
    saved = tmp_path / "saved.blend"
    saved.write_bytes(b"old")
    rename = os.rename

    def guarded(old, new, **options):
        if saved in (old, new):
            raise PermissionError(13, "Permission denied", str(old), 32, str(new))
        rename(old, new, **options)

    monkeypatch.setattr(os, "rename", guarded)
    status, out, err = command("simulate", "--save", saved)
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert f"--save: another program has {saved} open: close it there" in err
    assert saved.read_bytes() == b"old"


def test_a_home_that_was_saved_on_windows_finds_its_routine(lived_home, addon_part):
    """There Blender writes the path of a chosen file with backslashes."""
    day = bpy.context.scene.angen_day
    folder = lived_home.parent / "routines"
    folder.mkdir()
    (lived_home.parent / "week.toml").rename(folder / "week.toml")
    day.routine, day.date = "//routines\\week.toml", "2026-03-02"
    plan, *_ = addon_part("residents.operators.day").settings_of(bpy.context.scene)
    assert plan.name == "week.toml"


@pytest.mark.parametrize(
    ("system", "quote"), [("win32", '"{}"'), ("linux", "'{}'"), ("darwin", "'{}'")]
)
def test_the_command_of_a_study_is_quoted_for_the_shell_of_the_system(
    tmp_path, addon_part, monkeypatch, system, quote
):
    study = addon_part("studies.window.operators")
    monkeypatch.setattr(sys, "platform", system)
    path = tmp_path / "my study.toml"
    first, second = (quote.format(p) for p in (path, path.with_suffix("")))
    assert study.command(str(path)) == f"angen study run {first} --out {second}"
