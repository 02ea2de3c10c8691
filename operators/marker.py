# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sensor looks like while it has no housing of its own: lines that show where it looks.

Edges without faces: no ray meets them and no render shows them.
"""

from __future__ import annotations

import bpy

SIZE_M = 0.2

Point = tuple[float, float, float]
# In units of the size: a pyramid that opens along −Z with a triangle on its +Y side, as cameras
# and lights have; a beam along −Z across a gap; an arrow along +Z out of a square.
VIEW: tuple[list[Point], list[tuple[int, int]]] = (
    [
        (0, 0, 0),
        (-0.5, -0.5, -1),
        (0.5, -0.5, -1),
        (0.5, 0.5, -1),
        (-0.5, 0.5, -1),
        (-0.3, 0.6, -1),
        (0.3, 0.6, -1),
        (0, 0.9, -1),
    ],
    [(0, 1), (0, 2), (0, 3), (0, 4), (1, 2), (2, 3), (3, 4), (4, 1), (5, 6), (6, 7), (7, 5)],
)
BEAM: tuple[list[Point], list[tuple[int, int]]] = (
    [(0, 0, 0), (0, 0, -0.25), (-0.1, 0, 0), (0.1, 0, 0), (0, -0.1, 0), (0, 0.2, 0)]
    + [(-0.1, 0, -0.25), (0.1, 0, -0.25)],
    [(0, 1), (2, 3), (4, 5), (6, 7)],
)
PAD: tuple[list[Point], list[tuple[int, int]]] = (
    [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0), (0, 0, 0), (0, 0, 0.5)]
    + [(-0.1, 0, 0.4), (0.1, 0, 0.4)],
    [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (5, 7)],
)
SHAPES = {"PIR": VIEW, "LIGHT": VIEW, "OPTICAL_SWITCH": BEAM, "PRESSURE": PAD}


def marker_mesh(kind: str, unit_scale: float) -> bpy.types.Mesh:
    """The marker of a kind, the same size whatever the scene's units."""
    points, edges = SHAPES[kind]
    size = SIZE_M / unit_scale
    mesh = bpy.data.meshes.new("Sensor marker")
    mesh.from_pydata([tuple(c * size for c in point) for point in points], edges, [])
    return mesh
