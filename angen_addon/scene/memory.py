# SPDX-License-Identifier: GPL-3.0-or-later
"""How the add-on forgets what it keeps in memory of the open file.

Each module that keeps something registers a function that forgets it. Blender's handlers call these
functions: those for undo before undo and redo, which replace all of Blender's data, and all of them
before another file opens.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Forget = TypeVar("Forget", bound=Callable[[], None])

_at_undo: list[Callable[[], None]] = []
_at_load: list[Callable[[], None]] = []


def forgets_at_undo(forget: Forget) -> Forget:
    """Call `forget` before undo and redo, and before another file opens; usable as a decorator.

    Register what holds references to Blender's data.
    """
    _at_undo.append(forget)
    return forget


def forgets_at_load(forget: Forget) -> Forget:
    """Call `forget` before another file opens, after all functions for undo, as a decorator.

    Register what undo does not change, such as recordings.
    """
    _at_load.append(forget)
    return forget


def forget_references() -> None:
    """Forget all references to Blender's data, because undo or redo will replace that data."""
    for forget in _at_undo:
        forget()


def forget_file() -> None:
    """Forget all that is kept in memory of the open file, because another file opens."""
    forget_references()
    for forget in _at_load:
        forget()
