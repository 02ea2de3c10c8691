# SPDX-License-Identifier: GPL-3.0-or-later
"""Spares Cycles from building its tree of triangles anew at each picture.

In a background render Cycles puts all meshes that are shown once into one tree, which is built
again whatever moved. A mesh that is shown twice has a tree of its own, which is kept. So each is
shown a second time, where hardly a ray sees it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import bpy
from mathutils import Matrix

from ..timed import INSTANCING_MODIFIERS
from .surfaces import glows

# Tiny and out of the way: the bounds of the scene hardly grow.
PLACE, SCALE = (0.0, 0.0, -10.0), 1e-6
# What no ray at all sees, Cycles leaves out: those that fog scatters might meet such a speck.
RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")


def twins(objects: Iterable[Any], own: Callable[[Any], Any]) -> Any:
    """An object that shows those of `objects` a second time that may be. `own`: takes charge of
    what is made."""
    again = own(bpy.data.collections.new(".angen_light"))
    for obj in objects:
        if _may_be_twice(obj):
            again.objects.link(obj)
    holder = own(bpy.data.objects.new(".angen_light", None))
    holder.instance_type, holder.instance_collection = "COLLECTION", again
    holder.matrix_world = Matrix.Translation(PLACE) @ Matrix.Diagonal((SCALE, SCALE, SCALE, 1.0))
    for rays in RAYS:
        setattr(holder, f"visible_{rays}", False)
    return holder


def _may_be_twice(obj: Any) -> bool:
    if obj.type != "MESH" or obj.instance_type != "NONE":
        return False
    # What these make would be made twice too.
    if any(modifier.type in INSTANCING_MODIFIERS for modifier in obj.modifiers):
        return False
    materials = [slot.material for slot in obj.material_slots if slot.material]
    # What glows or fills a space is looked for wherever it is.
    return not any(glows(material) or _fills(material) for material in materials)


def _fills(material: Any) -> bool:
    tree = material.node_tree
    return tree is not None and any(
        node.type == "OUTPUT_MATERIAL" and node.inputs["Volume"].is_linked for node in tree.nodes
    )
