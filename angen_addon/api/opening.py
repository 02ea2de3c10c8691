# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a home without a window: for the command line, and with Blender's module for scripts."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from ...sensor_logic.error import AngenError
from ..process.quiet import standard_output_silenced

if TYPE_CHECKING:
    from .home import Home


def opened(path: str | Path) -> Home:
    """The home in a blend file. Raises AngenError."""
    file = Path(path)
    problem = unreadable(file)
    if problem:
        raise AngenError(problem)
    with standard_output_silenced():
        try:
            import bpy
        except ImportError as error:
            raise AngenError(
                f"Blender's Python module is missing ({error}): pip install bpy, with Python 3.11 "
                "or 3.13"
            ) from None
        if not hasattr(bpy.types.Object, "angen_sensor"):
            import_module("...", __package__).register()
        home = import_module(".home", __package__)
        problem = open_file(file, False)
    if problem:
        raise AngenError(problem)
    found: Home = home.open_home(file)
    return found


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
