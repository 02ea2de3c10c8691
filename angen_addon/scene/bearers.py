# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the object whose mass a surface weighs with: itself, an armature that bends it, or a
parent."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .animation import is_animated
from .instances import chain


def armatures(obj: Any) -> list[Any]:
    """The armatures that bend an object."""
    return [m.object for m in obj.modifiers if m.type == "ARMATURE" and m.object is not None]


def candidates(obj: Any) -> Iterator[Any]:
    """The objects whose mass a surface may weigh with, nearest first: its own, its armatures',
    its parents'."""
    own, *parents = chain(obj)
    yield from (own, *armatures(obj), *parents)


def has_mass(obj: Any) -> bool:
    """Whether an object has a mass (Weight on Sensors), at this frame or at another."""
    return obj.angen_load.mass > 0.0 or is_animated(obj, "angen_load.mass")


def bearer(obj: Any) -> Any:
    """The object whose mass a surface weighs with; None: it weighs nothing."""
    return next((candidate for candidate in candidates(obj) if has_mass(candidate)), None)
