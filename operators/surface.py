# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the surface that a ray hits first, as the user sees it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from mathutils import Vector

# A ray may pass this many objects.
PASSED = 64
# A ray that passes an object starts again this share of the distance further on.
STEP = 1e-6


class SurfacePoint(NamedTuple):
    """A point where a ray hit: `normal` points to the side that the ray came from. `whole`: the ray
    hit the object itself, not an instance of it elsewhere."""

    point: Vector
    normal: Vector
    object: Any
    whole: bool

    @property
    def along(self) -> list[Vector]:
        """The axes of the object, to align with."""
        matrix = self.object.matrix_world
        return [matrix.col[1].xyz, matrix.col[0].xyz]


def first_surface(
    scene: Any,
    depsgraph: Any,
    origin: Vector,
    direction: Vector,
    length: float = 1e6,
    passes: Callable[[Any], bool] | None = None,
    culled: bool = False,
) -> SurfacePoint | None:
    """The surface that a ray hits first within `length` Blender units. The ray passes objects that
    sensors ignore or for which `passes` returns True and, with `culled`, the backs of faces."""
    direction = direction.normalized()
    start, left = origin.copy(), length
    for _ in range(PASSED):
        if left <= 0.0:
            return None
        hit, point, normal, _, obj, matrix = scene.ray_cast(
            depsgraph, start, direction, distance=left
        )
        if not hit:
            return None
        original = obj.original
        back = normal.dot(direction) > 0.0
        if not (original.angen_ignored or (passes and passes(original)) or (culled and back)):
            whole = all(
                (a - b).length < 1e-6 for a, b in zip(matrix, obj.matrix_world, strict=True)
            )
            return SurfacePoint(point, (-normal if back else normal).normalized(), original, whole)
        gone = (point - start).length + max(STEP, STEP * point.length)
        start, left = start + direction * gone, left - gone
    return None


def belongs_to(obj: Any, owner: Any) -> bool:
    """Whether an object is `owner` or a child of it."""
    while obj is not None:
        if obj == owner:
            return True
        obj = obj.parent
    return False
