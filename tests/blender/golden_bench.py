# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens sample homes for the golden files, and runs verbs on them in this process."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import bpy

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = ROOT / "sample_blends"
ADDON = "bl_ext.user_default.angen_sensors"
PROGRAM = "python -m angen_addon"


def part(name: str) -> Any:
    return import_module(f"{ADDON}.{name}")


def all_sensors() -> list[Any]:
    """Return the sensors of the open home."""
    found: list[Any] = part("angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
    return found


def chosen(*sensors: str) -> list[str]:
    """Return the options that choose these sensors."""
    return [word for name in sensors for word in ("--sensor", name)]


class Ran(NamedTuple):
    status: int
    out: str
    err: str


class Bench:
    """Where a case runs: opens sample files, runs verbs in this process, and keeps shared runs.

    Parameters
    ----------
    folder : Path
        A folder for files that verbs write.
    new_world : callable
        Makes an empty scene and returns the `World` of tests/blender/conftest.py in it.
    """

    def __init__(self, folder: Path, new_world: Callable[[], Any]) -> None:
        self.folder = folder
        self.new_world = new_world
        self._kept: dict[str, Any] = {}

    def once(self, name: str, make: Callable[[], Any]) -> Any:
        """Return what `make` gave at the first call under this name: cases share a run."""
        if name not in self._kept:
            self._kept[name] = make()
        return self._kept[name]

    def open(self, home: str) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{home}.blend"), load_ui=False)
        bpy.context.scene.angen_live = False

    def run(self, *arguments: Any, without_blender: bool = False) -> Ran:
        """Run a verb in a terminal of 100 columns, on which argparse's line breaks depend."""
        words = [str(argument) for argument in arguments]
        out, err = io.StringIO(), io.StringIO()
        with (
            patch.dict(os.environ, COLUMNS="100", NO_COLOR="1"),
            redirect_stdout(out),
            redirect_stderr(err),
        ):
            if without_blender:
                parts = part("parts")
                module = parts.part(parts.WITHOUT_BLENDER[words[0]])
                try:
                    status = module.main(words[1:], PROGRAM)
                except SystemExit as stop:
                    status = int(stop.code or 0)
            else:
                status = part("angen_addon.commands.command_line").run_command(words)
        return Ran(status, *(self.plain(stream.getvalue()) for stream in (out, err)))

    def plain(self, text: str) -> str:
        """Return a text with line ends of git, and names of files without their folders."""
        text = text.replace("\r\n", "\n")
        for folder in (f"{self.folder}{os.sep}", f"{ROOT}{os.sep}"):
            # The rest of a path, up to its end, as on Unix.
            path = re.escape(folder) + r"([^\s'\"]*)"
            text = re.sub(path, lambda found: found[1].replace(os.sep, "/"), text)
        return text

    def written(self, name: str) -> str:
        return self.plain((self.folder / name).read_bytes().decode("utf-8"))

    def transcript(self, *arguments: Any, without_blender: bool = False) -> str:
        """Return what a user types and sees: the verb, its output, messages and exit status."""
        ran = self.run(*arguments, without_blender=without_blender)
        words = [self.plain(str(word)) for word in arguments]
        typed = " ".join(f'"{word}"' if " " in word else word for word in words)
        ends = f"(exit status {ran.status})\n" if ran.status else ""
        return f"$ angen {typed}\n{ran.out}{ran.err}{ends}"
