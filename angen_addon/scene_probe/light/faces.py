# SPDX-License-Identifier: GPL-3.0-or-later
"""Small white faces, whose brightness is the light on them; and illuminance by Cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .nodes import Nodes
from .picture import CORNERS, Picture, Seen, add_squares, share_out

Array = NDArray[np.float64]
# The face is this large, and stands this far off its origin, in metres: off the wall that the
# sensor sits on. Where coordinates are coarser, as many of their steps.
FACE = 1e-3
STEPS = 16.0
# Rays to a face start this far ahead of it, in its sides; faces so near each other could be taken
# for one another.
AHEAD = 0.5
APART = 4.0


def batches(requests: Sequence[Any], scene: Any) -> list[dict[int, Seen]]:
    """The requests by their pixels in a picture; in as many pictures as they need."""
    near = APART * face_size(scene, [request.matrix for request in requests])

    def are_mixed_up(one: Seen, other: Seen) -> bool:
        a, b = one.request.matrix, other.request.matrix
        apart = float(np.abs(a[:3, 3] - b[:3, 3]).max())
        return apart < near and not np.array_equal(a, b)

    return share_out([Seen(request) for request in requests], 1, are_mixed_up)


class Faces:
    """The faces of one batch of requests in a light scene, of so many light paths a request."""

    def __init__(self, light_scene: Any, together: dict[int, Seen], samples: int) -> None:
        self._pixels = list(together)
        size = face_size(light_scene.scene, [s.request.matrix for s in together.values()])
        corners, rays = [], {}
        for pixel, seen in together.items():
            square, back = face(seen.request.matrix, size), seen.request.matrix[:3, 2]
            corners.append(square)
            rays[pixel] = square - AHEAD * size * back, np.tile(back, (len(CORNERS), 1))
        add_squares(light_scene, corners, {}, white(light_scene.own))
        self._picture = Picture(light_scene, rays, max(1, samples))

    def light(self) -> list[Array]:
        """W/m² (3,) of linear Rec. 709 on the −Z face of each request."""
        pixels = self._picture.pixels()
        return [math.pi * pixels[pixel] for pixel in self._pixels]


def face_size(scene: Any, matrices: Sequence[Array]) -> float:
    """Side of a face, and its distance off its origin, in Blender units."""
    metres = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    farthest = max(float(np.abs(matrix[:3, 3]).max()) for matrix in matrices)
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
