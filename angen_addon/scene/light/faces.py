# SPDX-License-Identifier: GPL-3.0-or-later
"""Small white faces, whose brightness is the light on them; and illuminance by Cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from .materials import Nodes
from .views import CORNERS, Picture, Seen

# Pixels of a request; of their radiance, the light on a white face.
COUNT, FACTOR = 1, math.pi
# The face is this large, and stands this far off its origin, in metres: off the wall that the
# sensor sits on. Where coordinates are coarser, as many of their steps.
FACE = 1e-3
STEPS = 16.0
# Rays to a face start this far ahead of it, in its sides, before this part of it: where coordinates
# are coarse, those before its edges would pass it. Faces so near each other could be taken for one
# another.
AHEAD, PART = 0.5, 0.75
APART = 4.0


def lids(request: Any, walls: Any) -> tuple[int, ...]:
    """A face sees as far as there is something."""
    return ()


def collide(scene: Any, walls: Any, one: Seen, other: Seen) -> bool:
    """Whether the faces of two requests could be mixed up."""
    a, b = one.request.matrix, other.request.matrix
    near = APART * max(face_size(scene, a), face_size(scene, b))
    return bool(np.abs(a[:3, 3] - b[:3, 3]).max() < near) and not np.array_equal(a, b)


def rays(scene: Any, request: Any) -> list[tuple[Array, Array]]:
    """Of each pixel, where the rays through its corners start (4, 3), and their directions."""
    size, back = face_size(scene, request.matrix), request.matrix[:3, 2]
    corners = face(request.matrix, size)
    starts = PART * corners + (1.0 - PART) * corners.mean(axis=0) - AHEAD * size * back
    return [(starts, np.tile(back, (len(CORNERS), 1)))]


def furnish(picture: Picture, scene: Any, together: Sequence[Seen]) -> None:
    """Adds what the pixels look at."""
    poses = [seen.request.matrix for seen in together]
    corners = [face(pose, face_size(scene, pose)) for pose in poses]
    picture.add_squares(corners, {}, white(picture.own))


def face_size(scene: Any, matrix: Array) -> float:
    """Side of a face at a pose, and its distance off its origin, in Blender units."""
    metres = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    farthest = float(np.abs(matrix[:3, 3]).max())
    return max(FACE / metres, STEPS * float(np.spacing(np.float32(farthest))))


def face(matrix: Array, size: float) -> Array:
    """Corners (4, 3) of a square that looks along the −Z of a pose, a bit ahead of it."""
    x, y, z = matrix[:3, 0], matrix[:3, 1], matrix[:3, 2]
    middle = matrix[:3, 3] - z * size
    h = size / 2
    # Counter-clockwise seen from −Z, so that this is the front.
    return np.array([middle + h * (a * x + b * y) for a, b in ((1, -1), (-1, -1), (-1, 1), (1, 1))])


def white(own: Any) -> Any:
    """A material that reflects all light diffusely."""
    nodes = Nodes(own)
    diffuse = nodes.add("ShaderNodeBsdfDiffuse", color=(1.0, 1.0, 1.0, 1.0), roughness=0.0)
    nodes.add("ShaderNodeOutputMaterial", surface=diffuse.outputs[0])
    return nodes.material
