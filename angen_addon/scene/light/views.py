# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the four views of a light sensor look, as rays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from .eevee import NEAREST_CLIP, WALLS, WIDEST

# Of a picture, in turn.
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def view_rays(request: Any) -> tuple[Array, Array, Array]:
    """Origins (4, 5, 3), unit directions (4, 5, 3) and reach (4, 5), in Blender units, of what a
    light sensor asks (a LightRequest): the axis and the corners of each view along −Z, −X, +Z, +X.

    They start on the plane at clip_start and reach that at clip_end.
    """
    t = math.tan(min(request.field_of_view, WIDEST) / 2)
    ways = np.array([(0.0, 0.0, -1.0), *((a * t, b * t, -1.0) for a, b in CORNERS)])
    turned = np.stack([ways @ _turn(wall).T for wall in range(WALLS)])
    world = turned @ request.matrix[:3, :3].T
    size = np.linalg.norm(world, axis=-1)
    start = max(request.clip_start, NEAREST_CLIP)
    origins = request.matrix[:3, 3] + world * start
    return origins, world / size[..., None], (request.clip_end - start) * size


def _turn(wall: int) -> Array:
    """The rotation (3, 3) of a view: quarter turns about Y."""
    c, s = round(math.cos(wall * math.pi / 2)), round(math.sin(wall * math.pi / 2))
    return np.array([(c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)])
