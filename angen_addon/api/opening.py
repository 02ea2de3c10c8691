# SPDX-License-Identifier: GPL-3.0-or-later
"""Open a home for scripts, in a process that has the bpy module."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from ...parts import part
from ...sensor_logic.logs.error import AngenError
from ..process.standalone import open_file, unreadable
from ..process.system import standard_output_silenced

if TYPE_CHECKING:
    from .home import Home


def open_home_file(path: str | Path, module: str = "angen_addon.api.home") -> Home:
    """Open a blend file, and return its home. Raise AngenError if it cannot be opened.

    `module` is the name of the module whose class `Home` is used.
    """
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
        made: type[Home] = part(module).Home
        problem = open_file(file, False)
    if problem:
        raise AngenError(problem)
    return made.open(file)
