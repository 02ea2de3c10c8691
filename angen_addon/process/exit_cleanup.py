# SPDX-License-Identifier: GPL-3.0-or-later
"""Cleans up before the end of a Python process that has Blender as a module, such as a script.

Blender frees its data after Python has ended there. Handlers and classes of extensions, and drivers
in Python, then make it crash or hang, so they must be removed before.

Blender frees its module with the last reference to it. Blender 4.2 never drops a registered
PropertyGroup class. If its properties have an `update`, `get` or `set` function, that function
refers to its module and so to `bpy`, which then outlives Python. So these classes are emptied.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy

from .standalone import standard_output_silenced

_unregister: Callable[[], None] | None = None


def unregister_at_exit(unregister: Callable[[], None]) -> None:
    """Call `unregister` and close the open file before Python ends.

    Where Blender is a program of its own, Blender does so itself.
    """
    global _unregister
    if not bpy.app.binary_path:
        if _unregister is None:
            atexit.register(_clean_up)
        _unregister = unregister


def _clean_up() -> None:
    with standard_output_silenced():
        if _unregister is not None:
            _unregister()
        _empty_groups()
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _empty_groups() -> None:
    """Empty the extension's PropertyGroup classes, which are unregistered by now."""
    extension = __package__.rsplit(".", 2)[0] + "."
    for group in bpy.types.PropertyGroup.__subclasses__():
        if group.__module__.startswith(extension):
            group.__annotations__.clear()
