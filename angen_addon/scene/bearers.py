# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the object whose mass (panel Weight on Sensors) a surface carries.

It is the object of the surface itself, an armature that bends it, or a parent.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .animation import is_animated
from .instances import chain


def armatures(obj: Any) -> list[Any]:
    """Return the armatures that bend an object."""
    return [m.object for m in obj.modifiers if m.type == "ARMATURE" and m.object is not None]


def candidates(obj: Any) -> Iterator[Any]:
    """Yield the objects whose mass a surface may carry, nearest first.

    These are the object itself, its armatures, and its parents.
    """
    own, *parents = chain(obj)
    yield from (own, *armatures(obj), *parents)


def has_mass(obj: Any) -> bool:
    """Return whether an object has a mass in the panel Weight on Sensors, at any frame."""
    return obj.angen_load.mass > 0.0 or is_animated(obj, "angen_load.mass")


def bearer(obj: Any) -> Any:
    """Return the object whose mass a surface carries: the nearest with a mass, or None."""
    return next((candidate for candidate in candidates(obj) if has_mass(candidate)), None)
