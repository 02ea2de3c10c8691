# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of a Python that has Blender as a module: a script, a worker, a test session.

Blender is taken down after Python there. What Python owns by then, the handlers and classes of
extensions and the drivers of the open file that are Python, makes it crash or hang.

Blender's module goes with the last reference to it. Blender 4.2 keeps, for good, every class of a
group of properties that was ever registered; if such a class leads to a function, as `update`,
`get` and `set` are, it leads to the function's module and so to `bpy`, which then stays until
there is no Python any more. So those classes are emptied.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy

from .quiet import standard_output_silenced

_unregister: Callable[[], None] | None = None


def expect(unregister: Callable[[], None]) -> None:
    """Has `unregister` called, and the open file closed, before Python ends; the file also where
    the extension is off by then. A Blender program does so by itself."""
    global _unregister
    if not bpy.app.binary_path:
        if _unregister is None:
            atexit.register(_let_go)
        _unregister = unregister


def _let_go() -> None:
    with standard_output_silenced():
        if _unregister is not None:
            _unregister()
        _empty_groups()
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _empty_groups() -> None:
    """Takes their properties from the extension's groups of properties, which are off by now."""
    extension = __package__.rsplit(".", 2)[0] + "."
    for group in bpy.types.PropertyGroup.__subclasses__():
        if group.__module__.startswith(extension):
            group.__annotations__.clear()
