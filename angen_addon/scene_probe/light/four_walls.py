# SPDX-License-Identifier: GPL-3.0-or-later
"""The four views of each sensor that looks at four walls, by Cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .nodes import Nodes
from .picture import CORNERS, Picture, Seen, add_squares, share_out
from .ways import Ways

Array = NDArray[np.float64]
WALLS = 4
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


def batches(requests: Sequence[Any], ways: Ways) -> list[dict[int, Seen]]:
    """The requests by their first pixels in a picture; in as many pictures as they need."""

    def collide(one: Seen, other: Seen) -> bool:
        return _meets_lid(one, other, ways) or _meets_lid(other, one, ways)

    return share_out([Seen(r, _open_views(r, ways)) for r in requests], WALLS, collide)


class Views:
    """The views of one batch of requests in a light scene, of so many light paths a request."""

    def __init__(self, light_scene: Any, together: dict[int, Seen], samples: int) -> None:
        self._first = list(together)
        if any(seen.lids for seen in together.values()):
            _add_lids(light_scene, list(together.values()))
        rays = {}
        for first, seen in together.items():
            request = seen.request
            start = max(request.clip_start, NEAREST_CLIP)
            for wall, view in enumerate(_views(request)):
                ways = _rays(request, view)
                rays[first + wall] = request.matrix[:3, 3] + start * ways, ways
            if request.field_of_view > WIDEST:
                light_scene.notes.append(
                    f"'{request.name}' sees {math.degrees(WIDEST):.0f}° at most"
                )
        self._picture = Picture(light_scene, rays, max(1, math.ceil(samples / WALLS)))

    def light(self) -> list[Array]:
        """Linear radiance (4, 3) of the views along −Z, −X, +Z, +X of each request."""
        pixels = self._picture.pixels()
        return [pixels[first : first + WALLS] for first in self._first]


def _views(request: Any) -> list[Array]:
    """Axes (3, 3) of the four views, columns right, up, ahead; each a quarter turn on."""
    x, y, z = (request.matrix[:3, i] for i in range(3))
    return [np.stack(axes, axis=1) for axes in ((x, y, -z), (-z, y, -x), (-x, y, z), (z, y, x))]


def _rays(request: Any, view: Array, enlarged: float = 1.0) -> Array:
    """Vectors (4, 3) from the sensor to the corners of its view a metre ahead."""
    half = math.tan(min(request.field_of_view, WIDEST) / 2) * enlarged
    return np.array([view @ (half * a, half * b, 1.0) for a, b in 2 * CORNERS - 1])


def _axis_and_edges(request: Any, view: Array) -> Array:
    """Vectors (5, 3) along which a view is looked through, a metre ahead."""
    return np.vstack([view[:, 2], _rays(request, view)])


def _open_views(request: Any, ways: Ways) -> tuple[int, ...]:
    """The walls that may be farther away than the far clip plane."""
    if request.field_of_view > NARROW:
        return tuple(range(WALLS))
    start = max(request.clip_start, NEAREST_CLIP)
    found = []
    for wall, view in enumerate(_views(request)):
        rays = _axis_and_edges(request, view)
        starts = request.matrix[:3, 3] + start * rays
        if not ways.are_closed(starts, rays, request.clip_end - start):
            found.append(wall)
    return tuple(found)


def _meets_lid(beam: Seen, other: Seen, ways: Ways) -> bool:
    """Whether a view of `beam` may meet the lid at the end of one of `other`, no wall before it.

    Where paths go through one more surface, Cycles draws other random numbers.
    """
    if not other.lids:
        return False
    one, two = beam.request, other.request
    slopes = [math.sqrt(2) * math.tan(min(r.field_of_view, WIDEST) / 2) for r in (one, two)]
    start, size = max(one.clip_start, NEAREST_CLIP), OVERLAP * slopes[1] * two.clip_end
    beams, ends = _views(one), _views(two)
    ahead = np.array([view[:, 2] for view in beams])
    lids = np.array([ends[wall][:, 2] * two.clip_end for wall in other.lids])
    lids += two.matrix[:3, 3] - one.matrix[:3, 3]
    along = np.clip(lids @ ahead.T, 0.0, one.clip_end)
    apart = np.linalg.norm(lids[:, None, :] - along[:, :, None] * ahead, axis=2)
    for end, number in np.argwhere(apart <= slopes[0] * (along + size) + size):
        rays = _axis_and_edges(one, beams[number])
        starts = one.matrix[:3, 3] + start * rays
        if one.field_of_view > NARROW or not ways.are_closed(
            starts, rays, float(along[end, number]) - size - start
        ):
            return True
    return False


def _add_lids(light_scene: Any, together: Sequence[Seen]) -> None:
    """A square at the far clip plane of each open view, from which only the world is seen."""
    corners, reaches = [], []
    for seen in together:
        request = seen.request
        for wall in seen.lids:
            rays = _rays(request, _views(request)[wall], OVERLAP)
            corners.append(request.matrix[:3, 3] + request.clip_end * rays)
            reaches.append((request.clip_end - max(request.clip_start, NEAREST_CLIP)) * rays)
    add_squares(light_scene, corners, {"angen_reach": reaches}, _lid(light_scene.own))


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
