# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that load the extension and open a file where Blender is a Python module."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

PACKAGE = "angen_sensors"
ROOT = Path(__file__).resolve().parents[2]
# Runs the command line of this very package in another Python.
_START = (
    "import runpy, sys; sys.path.insert(0, sys.argv.pop(1)); "
    "runpy.run_module('angen_addon', run_name='__main__', alter_sys=True)"
)


def load_extension() -> ModuleType:
    """Import and return the extension's root package `angen_sensors`, without registering it."""
    if PACKAGE in sys.modules:
        return sys.modules[PACKAGE]
    spec = importlib.util.spec_from_file_location(
        PACKAGE, ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = module
    spec.loader.exec_module(module)
    return module


def python_command() -> list[str]:
    """Return the command line of `angen`, up to its verb, in another Python."""
    return [sys.executable, "-c", _START, str(ROOT)]


def unreadable(file: Path) -> str:
    """Return a text on why `file` cannot be a blend file; empty if it can be one.

    Only the first bytes of the file are checked. This function does not need Blender.
    """
    # Windows calls an attempt to open a folder a lack of permission.
    if file.is_dir():
        return f"{file} is a folder; give a blend file"
    try:
        with open(file, "rb") as opened:
            start = opened.read(7)
    except OSError as error:
        return f"cannot read {file}: {error.strerror}"
    if not start:
        return f"{file} is empty: give a blend file"
    # Plain, gzip and Zstandard blend files.
    if not (start == b"BLENDER" or start[:2] == b"\x1f\x8b" or start[:4] == b"\x28\xb5\x2f\xfd"):
        return f"{file} is not a blend file: give one"
    return ""


def open_file(file: Path, trusted: bool) -> str:
    """Open `file` in Blender, and return the error as one line; empty without an error.

    `trusted` says whether drivers and scripts in the file may run Python.
    """
    import bpy

    try:
        path = str(file.absolute())
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=trusted)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        return f"cannot open {file}: {reason}"
    return ""
