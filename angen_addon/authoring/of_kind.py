# SPDX-License-Identifier: GPL-3.0-or-later
"""The housing of each kind of sensor, and the matrix of a sensor on a surface.

Nothing here reads the scene. Lengths are in Blender units.
"""

from __future__ import annotations

from collections.abc import Iterable

from mathutils import Matrix, Vector

from ...sensor_logic.kinds import KINDS
from ..appearance.appearance import appearance_of
from ..appearance.housing import Housing, marker

UP = Vector((0.0, 0.0, 1.0))
# A unit vector can orient a sensor if its component along the surface is at least this long.
FOLLOWED = 0.3


def housing_of(kind: str, preset: str = "") -> Housing:
    """Return the housing (the sensor's body) for a preset of a kind, or by default for the kind."""
    housings = appearance_of(KINDS[kind]).housings
    return housings.get(preset, housings.get("", marker))()


def axes_on(kind: str, normal: Vector, turn: float = 0.0, along: Iterable[Vector] = ()) -> Matrix:
    """Return the axes of a sensor on a surface.

    Parameters
    ----------
    kind
        Identifier of the kind.
    normal
        Unit normal of the surface.
    turn
        Angle about the normal, in radians.
    along
        Directions that orient the sensor on a level surface, such as the axes of the surface's
        object. The first that is not nearly parallel to the normal is used.

    Returns
    -------
    (3, 3) matrix
        Orthonormal and right-handed.
    """
    guides = [UP, *along, Vector((0, 1, 0)), Vector((1, 0, 0))]
    y, z = appearance_of(KINDS[kind]).stand(normal, lambda forward: _guide(forward, guides))
    axes = Matrix((y.cross(z), y, z)).transposed()
    return Matrix.Rotation(turn, 3, normal) @ axes


def _guide(forward: Vector, directions: Iterable[Vector]) -> Vector:
    """Project a direction onto the plane at right angles to `forward`; return a unit vector.

    The direction is the first of `directions` that is not nearly parallel to `forward`.
    """
    for direction in directions:
        if direction.length == 0:
            continue
        unit = direction.normalized()
        across = unit - forward * unit.dot(forward)
        if across.length >= FOLLOWED:
            return across.normalized()
    raise ValueError("no axis is perpendicular enough to the unit vector")


def place_on(
    kind: str,
    housing: Housing,
    point: Vector,
    normal: Vector,
    turn: float = 0.0,
    along: Iterable[Vector] = (),
    unit_scale: float = 1.0,
) -> Matrix:
    """Return the world matrix of a sensor whose housing touches a surface from outside.

    Parameters
    ----------
    kind
        Identifier of the kind.
    housing
        The housing of the sensor.
    point, normal
        A point of the surface, in Blender units, and the surface's normal there.
    turn, along
        As in `axes_on`.
    unit_scale
        Metres in a Blender unit.
    """
    normal = normal.normalized()
    axes = axes_on(kind, normal, turn, along)
    off = housing.reach(axes, normal) / unit_scale
    return Matrix.Translation(point + normal * off) @ axes.to_4x4()
