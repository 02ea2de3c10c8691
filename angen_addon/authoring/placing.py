# SPDX-License-Identifier: GPL-3.0-or-later
"""How a sensor stands on a surface, and how it gets a parent."""

from __future__ import annotations

import math
from collections.abc import Callable

from mathutils import Matrix, Vector

# Surfaces within this angle of the vertical are walls, from which motion detectors look level.
WALL = math.radians(30)

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
