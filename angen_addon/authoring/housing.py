# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings of new sensors: the part in its real size, lines that show where it looks, and how it
stands on a surface.

All lengths are metres in the sensor's own axes. It looks from the origin along −Z with +Y up, and
its housing is behind the origin. A switch's beam starts at the origin along −Z; its fork is open
towards −Y and stands on its +Y side. A pad lies on z = 0, its upper side towards +Z. The lines are
edges without faces, so that no ray hits them and no render shows them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy
from mathutils import Matrix, Vector

Point = tuple[float, float, float]
# Corners at −x and +x, −y and +y, −z and +z; faces that look outwards.
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
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
    """Points in metres, closed bodies of outward faces, and edges without faces."""

    points: list[Point] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)
    edges: list[tuple[int, int]] = field(default_factory=list)

    def box(self, low: Point, high: Point) -> Housing:
        corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1])
                   for z in (low[2], high[2])]  # fmt: skip
        return self._add(corners, BOX_FACES)

    def lathe(self, profile: Sequence[tuple[float, float]]) -> Housing:
        """Adds a body of revolution about Z; `profile`: (radius, z) of its rings, upwards. A radius
        of 0 at an end gives a point."""
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
        """All edges, including those of the faces, each once."""
        found = {tuple(sorted(e)) for e in self.edges}
        for face in self.faces:
            found |= {tuple(sorted(e)) for e in zip(face, face[1:] + face[:1], strict=True)}
        return sorted(found)  # type: ignore[arg-type]

    def reach(self, axes: Matrix, normal: Vector) -> float:
        """How far in m the body, turned by `axes` (3 × 3), extends below its origin along
        `normal`."""
        solid = {i for face in self.faces for i in face}
        return max((-normal.dot(axes @ Vector(self.points[i])) for i in solid), default=0.0)


def looking(housing: Housing) -> Housing:
    """Adds the lines that show where the sensor looks."""
    return housing.lines([tuple(c * VIEW_LENGTH for c in p) for p in VIEW_POINTS], VIEW_EDGES)  # type: ignore[misc]


def pad(side: float, thickness: float, length: float = 0.0) -> Housing:
    """A flat box whose origin is the middle of its underside, square without a `length`."""
    x, y = side / 2, (length or side) / 2
    return Housing().box((-x, -y, 0.0), (x, y, thickness))


def marker() -> Housing:
    """The housing of parts of unknown size: a cube of 30 mm behind the origin."""
    return looking(Housing().box((-0.015, -0.015, 0.0), (0.015, 0.015, 0.03)))


def mesh_of(housing: Housing, name: str, unit_scale: float) -> bpy.types.Mesh:
    """A new mesh of a housing in its real size, for a scene of this unit scale."""
    mesh = bpy.data.meshes.new(name)
    points = [tuple(c / unit_scale for c in point) for point in housing.points]
    mesh.from_pydata(points, housing.edges, housing.faces)
    return mesh


# How a sensor stands on a surface, and how it gets a parent.

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


def parent_keeping(obj: Any, parent: Any, world: Matrix) -> bool:
    """Puts `obj` at `world` and parents it to `parent`, whatever that object's scale or shear.
    Returns False where the parent's matrix has no inverse, and leaves `obj` without a parent."""
    place = parent.matrix_world.copy()
    followed = abs(place.determinant()) > 1e-12
    if followed:
        obj.parent = parent
        obj.matrix_parent_inverse = place.inverted()
    obj.matrix_basis = world
    return followed
