# SPDX-License-Identifier: GPL-3.0-or-later
"""Which surfaces weigh with the mass of which object, as `scene.contact.contact_bodies` has it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ..scene.rays.solids import SURFACE_TYPES
from .sensing import has_mass

# What can have a surface, or have something with a surface hang on it.
BEARER_TYPES = SURFACE_TYPES | {"ARMATURE", "EMPTY", "LATTICE"}


@dataclass(frozen=True)
class Weighed:
    """What weighs with an object's mass: the `surfaces`; `apart` are those that hang on it too,
    but have a mass of their own, or of something nearer, each with what bears it."""

    surfaces: list[Any]
    apart: list[tuple[Any, Any]]


def chain(obj: Any) -> Iterator[Any]:
    """The objects whose mass a surface may weigh with, nearest first: its own, its armatures',
    its parents'."""
    yield obj
    for modifier in obj.modifiers:
        if modifier.type == "ARMATURE" and modifier.object is not None:
            yield modifier.object
    parent, seen = obj.parent, set()
    while parent is not None and parent not in seen:
        seen.add(parent)
        yield parent
        parent = parent.parent


def bearer(obj: Any) -> Any:
    """The object whose mass a surface weighs with; None: it weighs nothing."""
    return next((candidate for candidate in chain(obj) if has_mass(candidate)), None)


def weighed_with(obj: Any, view_layer: Any) -> Weighed:
    """What weighs with the mass of `obj`, or would if it had one."""
    found = Weighed([], [])
    for surface in _surfaces(view_layer):
        candidates = list(chain(surface))
        if obj not in candidates:
            continue
        nearer = candidates[: candidates.index(obj)]
        other = next((candidate for candidate in nearer if has_mass(candidate)), None)
        if other is None:
            found.surfaces.append(surface)
        else:
            found.apart.append((surface, other))
    return found


def _surfaces(view_layer: Any) -> Iterator[Any]:
    for obj in view_layer.objects:
        ignored = obj.type not in SURFACE_TYPES or obj.angen_ignored
        if not ignored and obj.visible_get(view_layer=view_layer):
            yield obj
