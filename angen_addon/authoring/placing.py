# SPDX-License-Identifier: GPL-3.0-or-later
"""How a sensor stands on a surface: from where the surface is and faces to the sensor's matrix.

Nothing here reads the scene. Lengths are the scene's units.
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
# A surface less than this far from upright is a wall, out of which a motion detector looks level.
WALL = math.radians(30)
# A direction must keep this share of its length along a surface to be followed there.
FOLLOWED = 0.3


# From a surface's normal, and what gives the unit "up" across a direction, to the sensor's Y and Z.
Stand = Callable[[Vector, Callable[[Vector], Vector]], tuple[Vector, Vector]]


def looking_out(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """It looks away from the surface, as upright as can be."""
    return up(normal), -normal


def looking_level(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """The same, level out of a wall."""
    level = Vector((normal.x, normal.y, 0.0))
    if abs(normal.z) < math.sin(WALL) and level.length > 0:
        return looking_out(level.normalized(), up)
    return looking_out(normal, up)


def lying(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """Its +Z side is the upper one."""
    return up(normal), normal


def beside_it(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """It stands on its +Y side and looks along the surface, on a wall level."""
    return -normal, normal.cross(up(normal))


def axes_on(kind: str, normal: Vector, turn: float = 0.0, along: Iterable[Vector] = ()) -> Matrix:
    """The axes (3 × 3, orthonormal, right-handed) of a sensor on a surface with a unit normal.

    `turn` (rad) is about the normal. On what is level, up says nothing: the first of `along`
    that runs along the surface does, such as the axes of the object that it belongs to.
    """
    guides = [UP, *along, Vector((0, 1, 0)), Vector((1, 0, 0))]
    y, z = appearance_of(KINDS[kind]).stand(normal, lambda forward: _guide(forward, guides))
    axes = Matrix((y.cross(z), y, z)).transposed()
    return Matrix.Rotation(turn, 3, normal) @ axes


def _guide(forward: Vector, directions: Iterable[Vector]) -> Vector:
    """The first of the directions that has something across `forward`, made a unit across it."""
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
    """Puts `obj` at `world` and lets it follow `parent`, however that is scaled, mirrored or
    sheared. False: the parent's matrix cannot be undone, `obj` stays free."""
    place, child = parent.matrix_world.copy(), obj  # type: ignore[attr-defined]
    followed = abs(place.determinant()) > 1e-12
    if followed:
        child.parent = parent  # type: ignore[attr-defined]
        child.matrix_parent_inverse = place.inverted()  # type: ignore[attr-defined]
    child.matrix_basis = world  # type: ignore[attr-defined]
    return followed
