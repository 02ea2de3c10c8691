# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a camera could look along a way in the scene at any frame: what stands still and is
opaque is in the way at all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..animation import stays
from .frozen import Simulated
from .scene import Housings, is_left_out
from .surfaces import is_clear

Array = NDArray[np.float64]
# So many things that may go away, or let light pass, are looked through; and from this far behind
# each, in Blender units.
THROUGH, STEP = 16, 1e-4


class StillWalls:
    """Asks the scene as it is evaluated now."""

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
