# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings of new sensors, and the axes of sensors on a surface.

A housing has the real size of its part, and lines that show where the sensor looks. The lines are
edges without faces, so that no ray hits them and no render shows them.

All lengths are in m, in the sensor's axes. A sensor looks from the origin along −Z with +Y up, and
its housing is behind the origin. The beam of an optical switch starts at the origin along −Z. Its
fork is open towards −Y, and stands on a surface on its +Y side. A pressure pad lies on z = 0, with
its upper side towards +Z.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
from mathutils import Matrix, Vector

from ..scene.marks import HOUSING_MARK

Point = tuple[float, float, float]
# The faces of a box, which look outwards. Its corners are in the order of `Housing.box`.
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
# The number of corners of a round body.
SEGMENTS = 16

# A pyramid of length 1 that opens along −Z, with a triangle on its +Y side, as cameras have.
VIEW_LENGTH = 0.2
VIEW_POINTS: tuple[Point, ...] = (
    (0, 0, 0),
    (-0.5, -0.5, -1),
    (0.5, -0.5, -1),
    (0.5, 0.5, -1),
    (-0.5, 0.5, -1),
    (-0.3, 0.6, -1),
    (0.3, 0.6, -1),
    (0, 0.9, -1),
)
VIEW_EDGES = [
    (0, 1),
    (0, 2),
    (0, 3),
    (0, 4),
    (1, 2),
    (2, 3),
    (3, 4),
    (4, 1),
    (5, 6),
    (6, 7),
    (7, 5),
]


@dataclass
class Housing:
    """The mesh of a housing: points in m, faces of closed bodies, and edges without faces.

    Faces and edges are tuples of point indices. The normals of faces point outwards.
    """

    points: list[Point] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)
    edges: list[tuple[int, int]] = field(default_factory=list)

    def box(self, low: Point, high: Point) -> Housing:
        """Add a box between two corners."""
        corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1])
                   for z in (low[2], high[2])]  # fmt: skip
        return self._add(corners, BOX_FACES)

    def lathe(self, profile: Sequence[tuple[float, float]]) -> Housing:
        """Add a body of revolution about Z.

        `profile` holds the radius and the z of each of its rings, in order of z. A radius of 0 at
        an end makes a point.
        """
        points: list[Point] = []
        rings: list[list[int]] = []
        for radius, z in profile:
            n = SEGMENTS if radius else 1
            rings.append(list(range(len(points), len(points) + n)))
            turns = (2 * math.pi * i / n for i in range(n))
            points += [(radius * math.cos(a), radius * math.sin(a), z) for a in turns]
        faces: list[tuple[int, ...]] = []
        for low, high in itertools.pairwise(rings):
            for i in range(SEGMENTS):
                j = (i + 1) % SEGMENTS
                ring = (
                    low[i % len(low)],
                    low[j % len(low)],
                    high[j % len(high)],
                    high[i % len(high)],
                )
                faces.append(tuple(dict.fromkeys(ring)))
        if len(rings[0]) > 1:
            faces.append(tuple(reversed(rings[0])))
        if len(rings[-1]) > 1:
            faces.append(tuple(rings[-1]))
        return self._add(points, faces)

    def lines(self, points: Iterable[Point], edges: Iterable[tuple[int, int]]) -> Housing:
        """Add edges without faces."""
        first = len(self.points)
        self.points += points
        self.edges += [(first + a, first + b) for a, b in edges]
        return self

    def _add(self, points: Sequence[Point], faces: Iterable[tuple[int, ...]]) -> Housing:
        first = len(self.points)
        self.points += points
        self.faces += [tuple(first + i for i in face) for face in faces]
        return self

    def outline(self) -> list[tuple[int, int]]:
        """Return all edges, including those of faces, as pairs of point indices, each once."""
        found = {tuple(sorted(e)) for e in self.edges}
        for face in self.faces:
            found |= {tuple(sorted(e)) for e in zip(face, face[1:] + face[:1], strict=True)}
        return sorted(found)  # type: ignore[arg-type]

    def reach(self, axes: Matrix, normal: Vector) -> float:
        """Return how far (m) the rotated body extends from its origin along −`normal`.

        `axes` (3, 3) is the rotation.
        """
        solid = {i for face in self.faces for i in face}
        return max((-normal.dot(axes @ Vector(self.points[i])) for i in solid), default=0.0)


def looking(housing: Housing) -> Housing:
    """Add to a housing the lines that show in which direction the sensor looks."""
    return housing.lines([tuple(c * VIEW_LENGTH for c in p) for p in VIEW_POINTS], VIEW_EDGES)  # type: ignore[misc]


def pad(side: float, thickness: float, length: float = 0.0) -> Housing:
    """Return a flat box, which is square if `length` is 0. Its origin is below its middle."""
    x, y = side / 2, (length or side) / 2
    return Housing().box((-x, -y, 0.0), (x, y, thickness))


def marker() -> Housing:
    """Return the housing of parts of unknown size: a cube of 30 mm behind the origin."""
    return looking(Housing().box((-0.015, -0.015, 0.0), (0.015, 0.015, 0.03)))


def housing_mesh(housing: Housing, label: str, unit_scale: float) -> bpy.types.Mesh:
    """Return a new mesh of a housing, which other sensors see through.

    `label` is that of the kind, and `unit_scale` the metres in a Blender unit.
    """
    mesh = mesh_of(housing, f"{label.partition(' (')[0]} housing", unit_scale)
    mesh[HOUSING_MARK] = True
    return mesh


def mesh_of(housing: Housing, name: str, unit_scale: float) -> bpy.types.Mesh:
    """Return a new mesh of a housing in real size; `unit_scale` is metres in a Blender unit."""
    mesh = bpy.data.meshes.new(name)
    points = [tuple(c / unit_scale for c in point) for point in housing.points]
    mesh.from_pydata(points, housing.edges, housing.faces)
    return mesh


# A surface is a wall if it is within this angle of the vertical.
WALL = math.radians(30)

# A function that returns the Y and Z axes of a sensor on a surface. Its arguments are the surface's
# normal and a function `up`. For a direction, `up` returns the unit vector at right angles to it
# that points as far up as possible.
Stand = Callable[[Vector, Callable[[Vector], Vector]], tuple[Vector, Vector]]


def looking_out(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """Return the Y and Z axis of a sensor that looks along the surface's normal.

    `up` is a function that returns the unit vector at right angles to its argument, as far up as
    possible.
    """
    return up(normal), -normal


def looking_level(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """Return the Y and Z axis of a sensor that looks along the normal; on a wall, horizontally.

    `up` is as in `looking_out`.
    """
    level = Vector((normal.x, normal.y, 0.0))
    if abs(normal.z) < math.sin(WALL) and level.length > 0:
        return looking_out(level.normalized(), up)
    return looking_out(normal, up)


def lying(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """Return the Y and Z axis of a sensor that lies on the surface, with +Z along the normal.

    `up` is as in `looking_out`.
    """
    return up(normal), normal


def beside_it(normal: Vector, up: Callable[[Vector], Vector]) -> tuple[Vector, Vector]:
    """Return the Y and Z axis of a sensor mounted on its +Y side, which looks along the surface.

    On a wall it looks horizontally. `up` is as in `looking_out`.
    """
    return -normal, normal.cross(up(normal))


def parent_keeping(obj: Any, parent: Any, world: Matrix) -> bool:
    """Parent `obj` to `parent`, and give `obj` the world matrix `world`.

    If the parent's matrix has no inverse, only set the world matrix, and return False.
    """
    place = parent.matrix_world.copy()
    followed = abs(place.determinant()) > 1e-12
    if followed:
        obj.parent = parent
        obj.matrix_parent_inverse = place.inverted()
    obj.matrix_basis = world
    return followed
