# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares the objects and instances that a depsgraph lists with earlier ones."""

from __future__ import annotations

from typing import Any

from ..instances import UNUSED_LEVEL, Uid, chain


def pointers_of(depsgraph: Any) -> list[int]:
    """What tells whether its objects are the same: what is evaluated has no session uid."""
    return [evaluated.as_pointer() for evaluated in depsgraph.objects]


def name_of(original: Any, owner: Any, made_by_nodes: bool) -> str:
    """The object's name, and for an instance also that of what brings it forth."""
    if original == owner or made_by_nodes:
        return str(owner.name)
    return f"{original.name} in {owner.name}"


def is_own_surface(instance: Any, original: Any, owner: Any) -> bool:
    """Curves, text and the like come twice: as themselves and as an instance of their mesh."""
    return (
        original == owner and original.type != "MESH" and instance.persistent_id[1] == UNUSED_LEVEL
    )


def is_transient(depsgraph: Any, seen: Any, original: Any) -> bool:
    """Whether an instance is of a mesh that nodes made, not of the object it is listed under."""
    data = original.evaluated_get(depsgraph).data
    return data is None or seen.data.as_pointer() != data.as_pointer()


def owners_of(owner: Any) -> frozenset[Uid]:
    return frozenset(obj.session_uid for obj in chain(owner))
