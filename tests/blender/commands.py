# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers that run the command line in separate processes, make a home, and read its logs."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy

ROOT = Path(__file__).resolve().parents[2]


def module(*arguments: Any, **options: Any) -> subprocess.CompletedProcess[Any]:
    """Run `python -m angen_addon ARGUMENTS` in a separate process."""
    command = [sys.executable, "-m", "angen_addon", *map(str, arguments)]
    given = {"capture_output": True, "timeout": 60, **options}
    return subprocess.run(command, cwd=ROOT, check=False, **given)


def start(*arguments: Any, **options: Any) -> subprocess.Popen[bytes]:
    """Start `python -m angen_addon ARGUMENTS`, with pipes for its output."""
    command = [sys.executable, "-m", "angen_addon", *map(str, arguments)]
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.Popen(command, cwd=ROOT, **given)


HEADER = "time_s,frame,sensor,kind,field,value"
DOOR_LOG = "\r\n".join(
    [
        HEADER,
        "0.000000,1,Dörr,OPTICAL_SWITCH,open,0",
        '0.000000,1,"Hall, PIR",PIR,moved,0',
        "0.500000,13,Dörr,OPTICAL_SWITCH,open,1",
        "1.500000,37,Dörr,OPTICAL_SWITCH,open,0",
        "",
    ]
)


def save(folder, name="home.blend", compress=False):
    path = folder / name
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=compress)
    return path


def door_home(world, tmp_path):
    """Add a door, open from frame 13 to 37, its switch, and a PIR that sees nothing."""
    world.door(13, 37)
    world.switch("Dörr")["room"] = "Hall"
    world.pir("Hall, PIR").location.x = 100
    folder = tmp_path / "files"
    folder.mkdir()
    return save(folder)


def listing(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def one_line(text):
    """Return the error line; assert that standard error is no blank and no traceback."""
    lines = text.splitlines()
    assert len(lines) == 1, text
    assert lines[0].startswith("angen: "), text
    return lines[0]
