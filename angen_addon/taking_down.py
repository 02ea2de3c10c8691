# SPDX-License-Identifier: GPL-3.0-or-later
"""The end of a Python that has Blender as a module: a script, a worker, a test session.

Blender is taken down after Python there. What Python owns by then, the handlers and classes of
extensions and the drivers of the open file that are Python, makes it crash or hang.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable

import bpy

from .quiet import standard_output_silenced

_unregister: Callable[[], None] | None = None


def expect(unregister: Callable[[], None]) -> None:
    """Has it all let go at the end of the process, while there is Python; also of the file that is
    open then, if the extension is off by that time. In a Blender program there is no need."""
    global _unregister
    if not bpy.app.binary_path:
        if _unregister is None:
            atexit.register(_let_go)
        _unregister = unregister


def _let_go() -> None:
    with standard_output_silenced():
        if _unregister is not None:
            _unregister()
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
