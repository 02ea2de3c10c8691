# SPDX-License-Identifier: GPL-3.0-or-later
"""The names of the Python package `angen_sensors`: `open`, and the classes of what it returns."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...parts import installed
from .opening import open_home_file

if TYPE_CHECKING:
    from .home import Home

# The modules with the class `Home`: the first that is installed is used.
HOMES = ("residents.blender.api", "angen_addon.api.home")
# The modules of the public names besides `open`; only those of homes need Blender's module.
_NAMES = {
    "AngenError": "sensor_logic.logs.error",
    "EventRow": "angen_addon.api.recording",
    "Evidence": "angen_addon.api.recording",
    "Home": "residents.blender.api",
    "HomeSensor": "angen_addon.api.home",
    "Recording": "angen_addon.api.recording",
}


def open(path: str | Path) -> Home:
    """Open a blend file and return its `Home`. Raise AngenError if the file cannot be opened.

    Blender holds one file at a time: a home opened before is closed.
    """
    return open_home_file(path, next(name for name in HOMES if installed(name)))


def __getattr__(name: str) -> Any:
    if name not in _NAMES:
        raise AttributeError(f"the package angen_sensors has no attribute {name!r}")
    return getattr(import_module(f"...{_NAMES[name]}", __package__), name)
