# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a tutorial of the docs unchanged, in a separate folder.

Code blocks run in their order: `python` in Blender, consecutive ones as one script; `sh` in a shell
in which `blender FILE --command angen` and `angen` are Blender's module. A block with a title is a
file, which is written. A `text` block is the output of the blocks before it, or with a title the
content of that file: `…` matches anything. A comment before a block can say its exit status.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from itertools import groupby
from pathlib import Path

import pytest

from dev import link_folder

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(
    r'^(?:<!-- ends with status (\d) -->\n)?```(\w+)(?: title="([^"]+)")?\n(.*?)^```$',
    re.MULTILINE | re.DOTALL,
)
ENABLE = "import bpy, addon_utils\naddon_utils.enable('bl_ext.user_default.angen_sensors')\n"
# Shell commands of a tutorial, and what each runs here; the extension's verbs come first.
COMMANDS = {
    "blender": 'file=$1; shift 3; verb=$1; shift; exec "$BPY" -m angen_addon "$verb" "$file" "$@"',
    "angen": 'exec "$BPY" -m angen_addon "$@"',
    "python": 'exec "$PYTHON" "$@"',
    "pip": "exit 0",
}


def shell() -> str:
    """Return the path of a POSIX shell; on Windows git brings one. Skip the test without it."""
    git = shutil.which("git")
    beside = Path(git).parents[1] / "bin" if git else Path()
    found = shutil.which("sh") or shutil.which("sh", path=str(beside))
    return found or pytest.skip("needs a POSIX shell")


def run_page(page: Path, folder: Path, bpy_python: str, python: str) -> None:
    """Run a page; `bpy_python` has Blender's module, `python` the tutorial's packages."""
    names = folder / "commands"
    names.mkdir()
    for name, line in COMMANDS.items():
        (names / name).write_text(f"#!/bin/sh\n{line}\n", newline="\n")
        (names / name).chmod(0o755)
    link_folder(names / "angen_sensors", ROOT)
    for part in ("docs", "sample_blends", "scripts"):
        link_folder(folder / part, ROOT / part)
    own = folder / "own home"
    own.mkdir()
    environment = os.environ | {
        "HOME": str(own),
        "USERPROFILE": str(own),
        "PATH": f"{names}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": f"{names}{os.pathsep}{ROOT}",
        "PWD": str(folder),
        "BPY": bpy_python,
        "PYTHON": python,
    }

    def output(command: list[str], script: str, status: int = 0) -> str:
        done = subprocess.run(
            command, input=script, cwd=folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == status, f"{page.name}:\n{script}\n{done.stdout}{done.stderr}"
        return done.stdout

    printed, ran = "", 0
    blocks = BLOCK.findall(page.read_text(encoding="utf-8"))
    for (status, language, title), some in groupby(blocks, key=lambda block: block[:3]):
        text = "\n".join(code for *_, code in some)
        if language == "text":
            found = (folder / title).read_text(encoding="utf-8") if title else printed
            pattern = ".*?".join(map(re.escape, text.strip().split("…")))
            assert re.search(pattern, found, re.DOTALL), f"{page.name}: {text}\nis not:\n{found}"
        elif title:
            (folder / title).write_text(text, encoding="utf-8")
        elif language == "python":
            begin = "" if "import angen_sensors" in text else ENABLE
            printed, ran = output([bpy_python, "-"], begin + text), ran + 1
        elif language == "sh":
            printed, ran = output([shell(), "-e"], text, int(status or 0)), ran + 1
    assert ran, f"{page.name} runs nothing"
