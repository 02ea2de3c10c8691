# SPDX-License-Identifier: GPL-3.0-or-later
"""Cleanup at the end of a Python process that uses Blender as a module, such as a script.

In such a process, Blender frees its data only after Python has ended. Handlers and classes of
extensions, and drivers in Python, would then make Blender crash or hang. So they must be removed
before Python ends.

Another problem is that Blender frees the module `bpy` only with the last reference to it. Blender
4.2 never frees a PropertyGroup class that was registered. If a property of the class has an
`update`, `get` or `set` function, this function refers to its own module, and that module to `bpy`.
Then `bpy` would outlive Python. So the properties of these classes are removed too.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy

from .system import standard_output_silenced

_unregister: Callable[[], None] | None = None


def unregister_at_exit(unregister: Callable[[], None]) -> None:
    """Register an exit handler that calls `unregister` and closes the open file.

    Do nothing if Blender runs as a program, which does both itself.
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
    """Remove the properties from the extension's PropertyGroup classes."""
    # The classes must be unregistered by now.
    extension = __package__.rsplit(".", 2)[0] + "."
    for group in bpy.types.PropertyGroup.__subclasses__():
        if group.__module__.startswith(extension):
            group.__annotations__.clear()
