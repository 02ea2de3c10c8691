# SPDX-License-Identifier: GPL-3.0-or-later
"""The four views of each sensor that looks at four walls: as rays, and by Cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from ..animation import stays
from .frozen import Simulated
from .materials import Nodes, is_clear
from .picture import CORNERS, Picture, Seen
from .scene import Housings, is_left_out

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
# So many things that may go away, or let light pass, are looked through; and from this far behind
# each, in Blender units.
THROUGH, STEP = 16, 1e-4


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


def view_rays(request: Any) -> tuple[Array, Array, Array]:
    """Origins (4, 5, 3), unit directions (4, 5, 3) and reach (4, 5), in Blender units, of what a
    light sensor asks (a LightRequest): the axis and the corners of each view along −Z, −X, +Z, +X.

    They start on the plane at clip_start and reach that at clip_end.
    """
    ways = np.array([[view[:, 2], *_rays(request, view)] for view in _views(request)])
    size = np.linalg.norm(ways, axis=-1)
    start = max(request.clip_start, NEAREST_CLIP)
    origins = request.matrix[:3, 3] + start * ways
    return origins, ways / size[..., None], (request.clip_end - start) * size


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


class StillWalls:
    """Tells whether a camera could look along a way in the scene at any frame. What stands still
    and is opaque is in the way at all of them. Asks the scene as it is evaluated now."""

    def __init__(self, scene: Any, view_layer: Any, simulated: Simulated) -> None:
        self._scene = scene
        self._depsgraph = view_layer.depsgraph
        self._simulated = simulated
        self._housings = Housings()
        self._closes: dict[int, bool] = {}

    def are_between(self, origins: Array, ways: Array, length: float) -> bool:
        """Whether on all ways (n, 3) from origins (n, 3) something is met within `length` times
        the way. In doubt it is not."""
        reaches = length * np.linalg.norm(ways, axis=1)
        return length > 0.0 and all(map(self._is_between, origins, ways, reaches))

    def _is_between(self, origin: Array, way: Array, reach: float) -> bool:
        way = way / np.linalg.norm(way)
        for _ in range(THROUGH):
            hit, place, _, _, obj, _ = self._scene.ray_cast(
                self._depsgraph, origin.tolist(), way.tolist(), distance=reach
            )
            if not hit or self._is_wall(obj):
                return bool(hit)
            gone = float((np.array(place) - origin) @ way) + STEP
            origin, reach = origin + gone * way, reach - gone
            if reach <= 0.0:
                return False
        return False

    def _is_wall(self, obj: Any) -> bool:
        uid = obj.original.session_uid
        if uid not in self._closes:
            self._closes[uid] = self._closes_ways(obj.original)
        return self._closes[uid]

    def _closes_ways(self, obj: Any) -> bool:
        if not obj.visible_camera or is_left_out(obj, self._housings) or obj in self._simulated:
            return False
        data = obj.data
        still = stays(obj) and not obj.modifiers and not getattr(data, "shape_keys", None)
        return still and not any(
            slot.material and is_clear(slot.material) for slot in obj.material_slots
        )
