# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of what geometry nodes make and instance: a mesh that no object of the file has."""

from __future__ import annotations

from typing import Any

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ....sensor_logic.geometry.ray_tree import RayTree
from .geometry import Geometry, evaluated_materials, slots_of, triangles_of, uids_of


class MadeByNodes(Geometry):
    """It is gone as soon as Blender lists the next instance: all that is ever asked of it is copied
    then, while it is `seen`."""

    __slots__ = ("_faces", "_materials", "_slots")

    lasting = False

    def __init__(self, seen: Any) -> None:
        super().__init__(None)
        self.read(seen)
        self._materials = uids_of(evaluated_materials(seen))
        self._faces = self._slots = slots_of(seen, by_triangle=False)

    def same(self, other: Any) -> bool:
        """Whether another is made of the same faces and materials."""
        return (
            isinstance(other, MadeByNodes)
            and self._surface is not None
            and other._surface is not None
            and self._surface.same(other._surface)
            and self._materials == other._materials
            and np.array_equal(self._faces, other._faces)
        )

    def finish(self, seen: Any, depsgraph: Any) -> None:
        """Copies what takes long, where no equal one is known."""
        self._triangles = triangles_of(seen)[1]
        if np.isfinite(self.lo).all():
            self._built.tree = self._tree_of(seen, depsgraph)
            if self._built.by_triangle:
                self._slots = slots_of(seen, by_triangle=True)

    def triangles(self, depsgraph: Any) -> NDArray[np.int32]:
        return self._triangles

    def tree(self, depsgraph: Any) -> BVHTree | RayTree:
        assert self._built.tree is not None, "rays meet only what has bounds"
        return self._built.tree

    def material_slots(self, depsgraph: Any) -> NDArray[np.int32]:
        return self._slots

    def materials(self, depsgraph: Any) -> list[int]:
        return self._materials


def made_shape(
    depsgraph: Any, seen: Any, made: dict[int, MadeByNodes], last: Geometry | None
) -> MadeByNodes:
    """The shape of an instance of what nodes made, shared by all instances of the same mesh in this
    listing; `last`, where it is as it was then."""
    pointer = seen.data.as_pointer()
    if pointer not in made:
        found = MadeByNodes(seen)
        if isinstance(last, MadeByNodes) and found.same(last):
            found = last
        else:
            found.finish(seen, depsgraph)
        made[pointer] = found
    return made[pointer]
