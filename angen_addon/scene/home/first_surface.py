# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the surfaces of a scene along a ray: walls, floors and furniture to place sensors on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from mathutils import Vector

from ..sensors import unit_scale

UP = Vector((0.0, 0.0, 1.0))
# The greatest number of objects that a ray goes through.
PASSED = 64
# Behind an object the ray starts again, farther on by this fraction of the distance so far.
STEP = 1e-6


class SurfacePoint(NamedTuple):
    """The point where a ray hits a surface.

    Attributes
    ----------
    point, normal
        The point, and the surface's normal there, towards the start of the ray.
    object
        The object that has the surface.
    whole
        True if the ray hit the object itself, False if it hit an instance of the object, as in a
        linked home.
    """

    point: Vector
    normal: Vector
    object: Any
    whole: bool

    @property
    def axes(self) -> list[Vector]:
        """The Y and X axes of the object, to which a housing is aligned."""
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
    """Return the first surface that a ray hits within `length` Blender units, or None.

    The ray passes through objects that sensors ignore, and through objects for which `passes`
    returns True. If `culled` is True, it also passes through faces whose normal points along the
    ray.
    """
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
            # An instance can stand where the object itself would, which is not in the scene.
            whole = depsgraph.view_layer.objects.get(original.name) == original and all(
                (a - b).length < 1e-6 for a, b in zip(matrix, obj.matrix_world, strict=True)
            )
            return SurfacePoint(point, (-normal if back else normal).normalized(), original, whole)
        gone = (point - start).length + max(STEP, STEP * point.length)
        start, left = start + direction * gone, left - gone
    return None


def belongs_to(obj: Any, owner: Any) -> bool:
    """Return whether an object is `owner` or one of its descendants."""
    while obj is not None:
        if obj == owner:
            return True
        obj = obj.parent
    return False


# A surface counts as a floor if the z component of its normal is larger.
FLOOR_NORMAL_Z = 0.5
# m: a ledge reaches less far from the wall, such as a picture or a skirting board.
LEDGE = 0.1


def floor_below(scene: Any, depsgraph: Any, place: Vector, on: SurfacePoint) -> SurfacePoint | None:
    """Return the floor below the point `place` of the surface `on`, or None.

    Steep surfaces do not count. If `on` is not steep, its own object does not count. A ledge, such
    as the top of a picture frame, counts only if nothing else is below.
    """
    carrier = on.object if on.normal.z > FLOOR_NORMAL_Z else None
    scale = unit_scale(scene)
    off = UP * (1e-3 / scale)
    level = Vector((on.normal.x, on.normal.y, 0.0))
    beside = level.normalized() * (LEDGE / scale)
    ledge = None
    start = place

    def down(origin: Vector) -> SurfacePoint | None:
        return first_surface(scene, depsgraph, origin, -UP, passes=lambda o: o == carrier)

    for _ in range(PASSED):
        hit = down(start - off)
        if hit is None:
            break
        if hit.normal.z > FLOOR_NORMAL_Z:
            other = down(hit.point + off + beside)
            if other is not None and hit.point.z - other.point.z < 2 * off.z:
                return hit
            ledge = ledge or hit
        start = hit.point
    return ledge
