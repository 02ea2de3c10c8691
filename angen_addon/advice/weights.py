# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the surfaces that weigh with the mass of an object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ..scene.bearers import candidates, has_mass
from ..scene.rays.solids import SURFACE_TYPES

# Types of objects that have a surface, or can be the parent or armature of one.
BEARER_TYPES = SURFACE_TYPES | {"ARMATURE", "EMPTY", "LATTICE"}


@dataclass(frozen=True)
class Weighed:
    """`surfaces`: those that weigh with an object's mass. `apart`: its other parts, which have a
    mass of their own or of something nearer, each with the object that has that mass."""

    surfaces: list[Any]
    apart: list[tuple[Any, Any]]


def weighed_with(obj: Any, view_layer: Any) -> Weighed:
    """The surfaces that weigh with the mass of `obj`, or would if it had one."""
    found = Weighed([], [])
    for surface in _surfaces(view_layer):
        possible = list(candidates(surface))
        if obj not in possible:
            continue
        other = next(filter(has_mass, possible[: possible.index(obj)]), None)
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
