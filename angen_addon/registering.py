# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the modules of a package with Blender."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any


def of_modules(package: str, *names: str) -> tuple[Callable[[], None], Callable[[], None]]:
    """The functions that register these modules of a package, in this order, and unregister them in
    the opposite one. They import the modules first."""

    def modules() -> list[Any]:
        return [import_module(f".{name}", package) for name in names]

    def register() -> None:
        for module in modules():
            module.register()

    def unregister() -> None:
        for module in reversed(modules()):
            module.unregister()

    return register, unregister
