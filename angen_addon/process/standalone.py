# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads the extension from its folder, and opens a file, where no window of Blender does it."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

PACKAGE = "angen_sensors"


def load_extension() -> ModuleType:
    """The extension's root package, as `angen_sensors`; call its `register()`."""
    if PACKAGE in sys.modules:
        return sys.modules[PACKAGE]
    root = Path(__file__).resolve().parents[2]
    spec = importlib.util.spec_from_file_location(
        PACKAGE, root / "__init__.py", submodule_search_locations=[str(root)]
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = module
    spec.loader.exec_module(module)
    return module


def unreadable(file: Path) -> str:
    """Why `file` cannot be a blend file, as far as that shows without Blender."""
    try:
        with open(file, "rb") as opened:
            start = opened.read(7)
    except IsADirectoryError:
        return f"{file} is a folder; give a blend file"
    except OSError as error:
        return f"cannot read {file}: {error.strerror}"
    if not start:
        return f"{file} is empty"
    # Plain, gzip and Zstandard blend files.
    if not (start == b"BLENDER" or start[:2] == b"\x1f\x8b" or start[:4] == b"\x28\xb5\x2f\xfd"):
        return f"{file} is not a blend file"
    return ""


def open_file(file: Path, trusted: bool) -> str:
    """Opens `file`, with its Python if it is trusted; returns why that failed, in a line."""
    import bpy

    try:
        path = str(file.absolute())
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=trusted)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        return f"cannot open {file}: {reason}"
    return ""
