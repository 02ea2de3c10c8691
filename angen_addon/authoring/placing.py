# SPDX-License-Identifier: GPL-3.0-or-later
"""Places sensors on surfaces: computes a sensor's matrix from a point and normal of the surface.

It does not read the scene. Lengths are Blender units.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from mathutils import Matrix, Vector

from ...sensor_logic.kinds import KINDS
from ..kinds import appearance_of

if TYPE_CHECKING:
    from .housing import Housing

UP = Vector((0.0, 0.0, 1.0))
# Surfaces within this angle of the vertical are walls, from which motion detectors look level.
WALL = math.radians(30)
# A direction guides a sensor if at least this share of its length is along the surface.
FOLLOWED = 0.3


# How a kind stands: from the surface's normal, and a function from a direction to the unit "up"
# across it, to the sensor's Y and Z axes.
Stand = Callable[[Vector, Callable[[Vector], Vector]], tuple[Vector, Vector]]


def looking_out(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """It looks away from the surface, with +Y as far up as possible."""
    return up(normal), -normal


def looking_level(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """It looks away from the surface, and from a wall level."""
    level = Vector((normal.x, normal.y, 0.0))
    if abs(normal.z) < math.sin(WALL) and level.length > 0:
        return looking_out(level.normalized(), up)
    return looking_out(normal, up)


def lying(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """It lies on the surface, +Z away from it."""
    return up(normal), normal


def beside_it(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """It stands on its +Y side and looks along the surface, on a wall horizontally."""
    return -normal, normal.cross(up(normal))


def axes_on(kind: str, normal: Vector, turn: float = 0.0, along: Iterable[Vector] = ()) -> Matrix:
    """The axes (3 × 3, orthonormal, right-handed) of a sensor on a surface with a unit normal.

    `turn` (rad) is about the normal. On a level surface, where up gives no direction, the first of
    `along` that is not across it does, such as the axes of the surface's object.
    """
    guides = [UP, *along, Vector((0, 1, 0)), Vector((1, 0, 0))]
    y, z = appearance_of(KINDS[kind]).stand(normal, lambda forward: _guide(forward, guides))
    axes = Matrix((y.cross(z), y, z)).transposed()
    return Matrix.Rotation(turn, 3, normal) @ axes


def _guide(forward: Vector, directions: Iterable[Vector]) -> Vector:
    """The unit component across `forward` of the first direction that has enough of it."""
    for direction in directions:
        if direction.length == 0:
            continue
        unit = direction.normalized()
        across = unit - forward * unit.dot(forward)
        if across.length >= FOLLOWED:
            return across.normalized()
    raise ValueError("one of X, Y and Z is always across a unit vector")


def place_on(
    kind: str,
    housing: Housing,
    point: Vector,
    normal: Vector,
    turn: float = 0.0,
    along: Iterable[Vector] = (),
    unit_scale: float = 1.0,
) -> Matrix:
    """The world matrix of a sensor whose housing touches the surface at `point` from outside."""
    normal = normal.normalized()
    axes = axes_on(kind, normal, turn, along)
    off = housing.reach(axes, normal) / unit_scale
    return Matrix.Translation(point + normal * off) @ axes.to_4x4()


def parent_keeping(obj: object, parent: object, world: Matrix) -> bool:
    """Puts `obj` at `world` and parents it to `parent`, whatever that object's scale or shear.
    Returns False where the parent's matrix has no inverse, and leaves `obj` without a parent."""
    place, child = parent.matrix_world.copy(), obj  # type: ignore[attr-defined]
    followed = abs(place.determinant()) > 1e-12
    if followed:
        child.parent = parent  # type: ignore[attr-defined]
        child.matrix_parent_inverse = place.inverted()  # type: ignore[attr-defined]
    child.matrix_basis = world  # type: ignore[attr-defined]
    return followed
