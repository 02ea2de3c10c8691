# SPDX-License-Identifier: GPL-3.0-or-later
"""Ängen Sensors: ambient sensors in a home, authored and simulated in Blender.

Blender calls `register` and `unregister`. Scripts and notebooks import this package as
`angen_sensors` and begin with `open` (angen_addon/api/package.py); docs/package.md has examples.
Functions here import modules that need Blender only when they are called. So a process without
Blender can import the physics.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

_registered: list[Any] = []


def register() -> None:
    """Register all modules; Blender calls this function.

    Raise `RuntimeError` if another copy of the extension is registered. After any error nothing is
    registered.
    """
    import bpy

    from .angen_addon.process import exit_cleanup
    from .angen_addon.translations.interface import prepare_classes
    from .parts import MODULES, part, runs_here

    if hasattr(bpy.types.Object, "angen_sensor"):
        raise RuntimeError(
            "Ängen Sensors is on already, from another repository or file: switch that one off in "
            "Preferences ▸ Add-ons, or restart Blender"
        )
    try:
        for name in MODULES:
            if runs_here(name):
                module = part(name)
                prepare_classes()
                module.register()
                _registered.append(module)
    except BaseException:
        unregister()
        raise
    exit_cleanup.unregister_at_exit(unregister)


def unregister() -> None:
    """Unregister all modules; Blender calls this function."""
    while _registered:
        _registered.pop().unregister()


def __getattr__(name: str) -> Any:
    """Return a name of the package for scripts, which the extension's zip lacks."""
    if name.startswith("_") or find_spec(".angen_addon.api", __package__) is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(".angen_addon.api.package", __package__), name)
