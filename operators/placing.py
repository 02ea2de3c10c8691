# SPDX-License-Identifier: GPL-3.0-or-later
"""How a sensor stands on a surface: from where the surface is and faces to the sensor's matrix.

Nothing here reads the scene. Lengths are the scene's units.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from mathutils import Matrix, Vector

from ..angen_addon.housing import Housing

UP = Vector((0.0, 0.0, 1.0))
# A surface less than this far from upright is a wall, out of which a motion detector looks level.
WALL = math.radians(30)
# A direction must keep this share of its length along a surface to be followed there.
FOLLOWED = 0.3


def axes_on(kind: str, normal: Vector, turn: float = 0.0, along: Iterable[Vector] = ()) -> Matrix:
    """The axes (3 × 3, orthonormal, right-handed) of a sensor on a surface with a unit normal.

    `turn` (rad) is about the normal. On what is level, up says nothing: the first of `along`
    that runs along the surface does, such as the axes of the object that it belongs to.
    """
    forward = _forward(kind, normal)
    guide = _guide(forward, [UP, *along, Vector((0, 1, 0)), Vector((1, 0, 0))])
    if kind == "OPTICAL_SWITCH":
        # It stands on its +Y side; the beam is level on a wall.
        y = -normal
        z = normal.cross(guide)
    else:
        z = -forward if kind != "PRESSURE" else normal
        y = guide
    axes = Matrix((y.cross(z), y, z)).transposed()
    return Matrix.Rotation(turn, 3, normal) @ axes


def _forward(kind: str, normal: Vector) -> Vector:
    """Where what looks does look."""
    level = Vector((normal.x, normal.y, 0.0))
    if kind == "PIR" and abs(normal.z) < math.sin(WALL) and level.length > 0:
        return level.normalized()
    return normal


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
