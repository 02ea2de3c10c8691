# SPDX-License-Identifier: GPL-3.0-or-later
"""Ängen Sensors: ambient sensors in a home, authored and simulated in Blender.

Blender calls `register` and `unregister`. Scripts and notebooks import this package as
`angen_sensors` and begin with `open`; docs/package.md has examples. Functions here import modules
that need Blender only when they are called. So a process without Blender can import the physics.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from pathlib import Path

    from .residents.blender.api import Home


_registered: list[Any] = []


def register() -> None:
    """Register all modules; Blender calls this function."""
    from .angen_addon.process import exit_cleanup
    from .angen_addon.translations.interface import prepare_classes
    from .parts import MODULES, installed, part

    for name in MODULES:
        if installed(name):
            module = part(name)
            prepare_classes()
            module.register()
            _registered.append(module)
    exit_cleanup.unregister_at_exit(unregister)


def unregister() -> None:
    """Unregister all modules; Blender calls this function."""
    while _registered:
        _registered.pop().unregister()


def open(path: str | Path) -> Home:
    """Open a blend file and return its `Home`. Raise AngenError if the file cannot be opened.

    Blender holds one file at a time: a home opened before is closed.
    """
    from .angen_addon.api.opening import open_home_file
    from .parts import HOMES, installed

    return cast("Home", open_home_file(path, next(name for name in HOMES if installed(name))))


# The public names besides `open`, and their modules; only homes need Blender's module.
_NAMES = {
    "AngenError": "sensor_logic.logs.error",
    "EventRow": "angen_addon.api.recording",
    "Evidence": "angen_addon.api.recording",
    "Home": "residents.blender.api",
    "HomeSensor": "angen_addon.api.home",
    "Recording": "angen_addon.api.recording",
}


def __getattr__(name: str) -> Any:
    if name not in _NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_NAMES[name]}", __package__), name)
