# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a camera could look along a way in the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene import Housings, is_left_out
from .surfaces import is_clear

Array = NDArray[np.float64]


class Ways:
    """Asks the scene as it is evaluated now."""

    def __init__(self, scene: Any, view_layer: Any) -> None:
        self._scene = scene
        self._depsgraph = view_layer.depsgraph
        self._housings = Housings()
        self._clear: dict[int, bool] = {}

    def are_closed(self, origins: Array, ways: Array, length: float) -> bool:
        """Whether on all ways (n, 3) from origins (n, 3) something opaque is met within `length`
        times the way. In doubt they are open."""
        reaches = np.linalg.norm(ways, axis=1)
        return length > 0.0 and all(
            self._meets_opaque(origin, way, length * float(reach))
            for origin, way, reach in zip(origins.tolist(), ways.tolist(), reaches, strict=True)
        )

    def _meets_opaque(self, origin: list[float], way: list[float], length: float) -> bool:
        hit, _, _, _, obj, _ = self._scene.ray_cast(self._depsgraph, origin, way, distance=length)
        if not hit or not obj.visible_camera or is_left_out(obj.original, self._housings):
            return False
        return not any(
            slot.material and self._is_clear(slot.material) for slot in obj.material_slots
        )

    def _is_clear(self, material: Any) -> bool:
        uid = material.original.session_uid
        if uid not in self._clear:
            self._clear[uid] = is_clear(material)
        return self._clear[uid]
