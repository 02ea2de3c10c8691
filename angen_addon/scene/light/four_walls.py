# SPDX-License-Identifier: GPL-3.0-or-later
"""The four views of each sensor that looks at four walls, by Cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .nodes import Nodes
from .picture import CORNERS, Picture, Seen
from .still_walls import StillWalls

Array = NDArray[np.float64]
WALLS = 4
# Pixels of a request, and what their radiance is multiplied with.
COUNT, FACTOR = WALLS, 1.0
NEAREST_CLIP = 1e-6
WIDEST = math.radians(170.0)
# In so narrow a view, what is on its axis and its edges is taken to be all over it.
NARROW = math.radians(3.0)
# What a view does not see any more is seen from here on: nothing but the world.
BEYOND = 1e8
# The lid at the end of a view is this much larger than the view.
OVERLAP = 1.01
# A lid knows rays of its own view by their length, within this share.
SAME_LENGTH = 1e-3


def lids(request: Any, walls: StillWalls) -> tuple[int, ...]:
    """The views (0 … 3) that may reach their far clip plane, and need a lid there."""
    if request.field_of_view > NARROW:
        return tuple(range(WALLS))
    length = request.clip_end - max(request.clip_start, NEAREST_CLIP)
    views = enumerate(_views(request))
    return tuple(n for n, view in views if not _is_closed(request, view, length, walls))


def collide(scene: Any, walls: StillWalls, one: Seen, other: Seen) -> bool:
    """Whether a view of one request may meet the lid of one of the other, no wall before it: where
    paths go through one more surface, Cycles draws other random numbers."""
    return _meets_lid(one, other, walls) or _meets_lid(other, one, walls)


def rays(scene: Any, request: Any) -> list[tuple[Array, Array]]:
    """Of each pixel, where the rays through its corners start (4, 3), and their directions."""
    start, found = max(request.clip_start, NEAREST_CLIP), []
    for view in _views(request):
        ways = _rays(request, view)
        found.append((request.matrix[:3, 3] + start * ways, ways))
    return found


def furnish(picture: Picture, scene: Any, together: Sequence[Seen]) -> None:
    """Adds a square at the far clip plane of each open view, from which only the world is seen."""
    corners, reaches = [], []
    for seen in together:
        request = seen.request
        for wall in seen.lids:
            ways = _rays(request, _views(request)[wall], OVERLAP)
            corners.append(request.matrix[:3, 3] + request.clip_end * ways)
            reaches.append((request.clip_end - max(request.clip_start, NEAREST_CLIP)) * ways)
        if request.field_of_view > WIDEST:
            picture.notes.append(f"'{request.name}' sees {math.degrees(WIDEST):.0f}° at most")
    if corners:
        picture.add_squares(corners, {"angen_reach": reaches}, _lid(picture.own))


def _views(request: Any) -> list[Array]:
    """Axes (3, 3) of the four views, columns right, up, ahead; each a quarter turn on."""
    x, y, z = (request.matrix[:3, i] for i in range(3))
    return [np.stack(axes, axis=1) for axes in ((x, y, -z), (-z, y, -x), (-x, y, z), (z, y, x))]


def _slope(request: Any) -> float:
    return math.tan(min(request.field_of_view, WIDEST) / 2)


def _rays(request: Any, view: Array, enlarged: float = 1.0) -> Array:
    """Vectors (4, 3) from the sensor to the corners of its view a metre ahead."""
    half = _slope(request) * enlarged
    return np.array([view @ (half * a, half * b, 1.0) for a, b in 2 * CORNERS - 1])


def _is_closed(request: Any, view: Array, length: float, walls: StillWalls) -> bool:
    """Whether still walls close a narrow view within a length, as far as its axis and its edges
    tell."""
    ways = np.vstack([view[:, 2], _rays(request, view)])
    starts = request.matrix[:3, 3] + max(request.clip_start, NEAREST_CLIP) * ways
    return walls.are_between(starts, ways, length)


def _meets_lid(beam: Seen, other: Seen, walls: StillWalls) -> bool:
    """Whether a view of `beam` may meet the lid of one of `other`."""
    if not other.lids:
        return False
    one, two = beam.request, other.request
    wide, size = math.sqrt(2) * _slope(one), OVERLAP * math.sqrt(2) * _slope(two) * two.clip_end
    beams, ends = _views(one), _views(two)
    ahead = np.array([view[:, 2] for view in beams])
    far = np.array([ends[wall][:, 2] * two.clip_end for wall in other.lids])
    far += two.matrix[:3, 3] - one.matrix[:3, 3]
    along = np.clip(far @ ahead.T, 0.0, one.clip_end)
    apart = np.linalg.norm(far[:, None, :] - along[:, :, None] * ahead, axis=2)
    for end, number in np.argwhere(apart <= wide * (along + size) + size):
        length = float(along[end, number]) - size - max(one.clip_start, NEAREST_CLIP)
        if one.field_of_view > NARROW or not _is_closed(one, beams[number], length, walls):
            return True
    return False


def _lid(own: Any) -> Any:
    """Lets rays pass that do not come from its own view: theirs have another length."""
    nodes = Nodes(own)
    reach = nodes.vector("angen_reach")
    length = nodes.add("ShaderNodeVectorMath", "LENGTH", _0=reach).outputs["Value"]
    path = nodes.add("ShaderNodeLightPath").outputs["Ray Length"]
    share = nodes.add("ShaderNodeMath", "DIVIDE", _0=path, _1=length).outputs[0]
    same = nodes.add("ShaderNodeMath", "COMPARE", _0=share, _1=1.0, _2=SAME_LENGTH).outputs[0]
    way = nodes.add("ShaderNodeVectorMath", "NORMALIZE", _0=reach).outputs["Vector"]
    far = nodes.add("ShaderNodeVectorMath", "SCALE", _0=way, scale=BEYOND).outputs["Vector"]
    portal = nodes.add("ShaderNodeBsdfRayPortal", position=far, direction=way).outputs[0]
    clear = nodes.add("ShaderNodeBsdfTransparent").outputs[0]
    mixed = nodes.add("ShaderNodeMixShader", _0=same, _1=clear, _2=portal).outputs[0]
    nodes.add("ShaderNodeOutputMaterial", surface=mixed)
    return nodes.material
