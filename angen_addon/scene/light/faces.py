# SPDX-License-Identifier: GPL-3.0-or-later
"""Illuminance by Cycles, from the brightness of small white faces at the sensors.

This module has the same functions as `views`, and `Picture` calls them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from .materials import Nodes
from .views import CORNERS, Picture, Seen

# Pixels of a request, and the factor from their radiance to the light on a white face.
COUNT, FACTOR = 1, math.pi
# m: the side of a face, and its distance from its origin, which is on the wall of the sensor.
FACE = 1e-3
# A face has at least this many steps of single precision a side.
STEPS = 16.0
# Rays to a face start this far ahead of it, in sides of the face, and hit only this part of it.
# Where coordinates are coarse, rays near the edges would miss it.
AHEAD, PART = 0.5, 0.75
# Faces that are nearer to each other than this, in sides, could be confused.
APART = 4.0


def lids(request: Any, walls: Any) -> tuple[int, ...]:
    """Return (), since no view of a request needs a lid: a white face sees to any distance."""
    return ()


def collide(scene: Any, walls: Any, one: Seen, other: Seen) -> bool:
    """Return whether the white faces of two requests are so near that rays could confuse them."""
    a, b = one.request.matrix, other.request.matrix
    near = APART * max(face_size(scene, a), face_size(scene, b))
    return bool(np.abs(a[:3, 3] - b[:3, 3]).max() < near) and not np.array_equal(a, b)


def rays(scene: Any, request: Any) -> list[tuple[Array, Array]]:
    """Return the rays from a pixel to the white face of a request: origins and directions (4, 3).

    The list has a single item, since a request has a single pixel.
    """
    size, back = face_size(scene, request.matrix), request.matrix[:3, 2]
    corners = face(request.matrix, size)
    starts = PART * corners + (1.0 - PART) * corners.mean(axis=0) - AHEAD * size * back
    return [(starts, np.tile(back, (len(CORNERS), 1)))]


def furnish(picture: Picture, scene: Any, together: Sequence[Seen]) -> None:
    """Add to a picture the white faces at which its pixels look, for the requests `together`."""
    poses = [seen.request.matrix for seen in together]
    corners = [face(pose, face_size(scene, pose)) for pose in poses]
    picture.add_squares(corners, {}, white(picture.own))


def face_size(scene: Any, matrix: Array) -> float:
    """Return the side length of the white face at a sensor, in Blender units.

    It is also the distance of the face from the sensor.
    """
    metres = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    farthest = float(np.abs(matrix[:3, 3]).max())
    return max(FACE / metres, STEPS * float(np.spacing(np.float32(farthest))))


def face(matrix: Array, size: float) -> Array:
    """Return the corners (4, 3) of a square with side `size` at a sensor's pose.

    The square faces −Z, and lies in that direction from the origin of the pose.
    """
    x, y, z = matrix[:3, 0], matrix[:3, 1], matrix[:3, 2]
    middle = matrix[:3, 3] - z * size
    h = size / 2
    # Counter-clockwise seen from −Z, so that this is the front.
    return np.array([middle + h * (a * x + b * y) for a, b in ((1, -1), (-1, -1), (-1, 1), (1, 1))])


def white(own: Any) -> Any:
    """Return a new material that reflects all light diffusely. `own` registers a new datablock."""
    nodes = Nodes(own)
    diffuse = nodes.add("ShaderNodeBsdfDiffuse", color=(1.0, 1.0, 1.0, 1.0), roughness=0.0)
    nodes.add("ShaderNodeOutputMaterial", surface=diffuse.outputs[0])
    return nodes.material
