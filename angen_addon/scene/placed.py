# SPDX-License-Identifier: GPL-3.0-or-later
"""Where an object is that something names: a magnet, a switch, the mark of a place.

Blender does not evaluate what viewports do not show, unless something else depends on it: its
evaluated matrix is then that of an earlier frame, or the identity.
"""

from __future__ import annotations

from typing import Any

from mathutils import Matrix

from ...sensor_logic.error import AngenError
from .animation import is_animated, motion_paths


class NotPlaced(AngenError):
    """Nothing tells where an object is; `problem` names it with the reason, `mend` is the way
    out."""

    def __init__(self, problem: str, mend: str) -> None:
        super().__init__(f"{problem}: {mend}")
        self.problem, self.mend = problem, mend


def is_placed(obj: Any, depsgraph: Any) -> bool:
    """Return whether Blender evaluates the place of an object."""
    if obj.visible_get(view_layer=depsgraph.view_layer):
        return True
    evaluated = obj.evaluated_get(depsgraph)
    # A pointer to an object brings it into the depsgraph without its evaluation, and keys that
    # hide it keep it listed.
    if not evaluated.is_evaluated:
        return False
    if evaluated.hide_viewport and is_animated(obj, "hide_viewport"):
        return False
    return any(listed == evaluated for listed in depsgraph.ids)


def placed_matrix(obj: Any, depsgraph: Any, instanced: bool = False) -> Matrix:
    """Return the matrix in the world of an object, as Blender evaluates it.

    Where Blender does not, its parents give it, unless something else moves the object.
    `instanced`: it is in a collection that is instanced. Raises NotPlaced.
    """
    gone = not (instanced or is_placed(obj, depsgraph))
    if gone and obj not in depsgraph.view_layer.objects.values():
        raise NotPlaced(
            f"'{obj.name}' is in no collection of this view layer, so it has no place",
            "tick its collection in the Outliner, or choose another object",
        )
    return _matrix(obj, depsgraph)


def _matrix(obj: Any, depsgraph: Any) -> Matrix:
    if is_placed(obj, depsgraph):
        return obj.evaluated_get(depsgraph).matrix_world
    parent = obj.parent
    held = parent is not None and (obj.parent_type != "OBJECT" or parent.type == "CURVE")
    if held or motion_paths(obj):
        raise NotPlaced(
            f"'{obj.name}' moves and is disabled in viewports, so Blender does not place it",
            "enable it there (monitor icon)",
        )
    above = _matrix(parent, depsgraph) if parent is not None else Matrix()
    return above @ obj.matrix_parent_inverse @ obj.matrix_basis
