# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sensor looks like when it is added: lines that show where it looks, or a pad.

The lines are edges without faces: no ray meets them and no render shows them. A pad is a real
thing that others stand on, so that it has a surface.
"""

from __future__ import annotations

import bpy

SIZE_M = 0.2
# Of a pad, as they are laid under furniture and on seats: side and thickness.
PAD_SIDE_M, PAD_THICKNESS_M = 0.3, 0.01

Point = tuple[float, float, float]
# In units of the size: a pyramid that opens along −Z with a triangle on its +Y side, as cameras
# and lights have; a beam along −Z across a gap.
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
SHAPES = {"PIR": VIEW, "LIGHT": VIEW, "OPTICAL_SWITCH": BEAM}
# Corners at −x and +x, −y and +y, below and above; faces that look outwards.
PAD_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def marker_mesh(kind: str, unit_scale: float) -> bpy.types.Mesh:
    """The mesh of a new sensor of a kind, the same size whatever the scene's units."""
    if kind == "PRESSURE":
        return _pad_mesh(unit_scale)
    points, edges = SHAPES[kind]
    size = SIZE_M / unit_scale
    mesh = bpy.data.meshes.new("Sensor marker")
    mesh.from_pydata([tuple(c * size for c in point) for point in points], edges, [])
    return mesh


def _pad_mesh(unit_scale: float) -> bpy.types.Mesh:
    """A flat box whose origin is the middle of its underside."""
    half, top = PAD_SIDE_M / 2 / unit_scale, PAD_THICKNESS_M / unit_scale
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (0.0, top)]
    mesh = bpy.data.meshes.new("Pressure pad")
    mesh.from_pydata(corners, [], PAD_FACES)
    return mesh
