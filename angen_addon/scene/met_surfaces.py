# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads properties of the surfaces that sensors' rays meet, such as their temperature."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from ...sensor_logic.model import Answers, Array, Index
from .instances import Uid
from .rays.bundles import RayHits
from .rays.caster import RayCaster


class MetSurfaces(ABC):
    """One property of the solids of a ray caster."""

    def __init__(self, caster: RayCaster) -> None:
        self._rays = caster
        self._listing = -1

    def see(
        self,
        depsgraph: Any,
        sensor: Uid,
        bundle: int,
        origins: Array,
        directions: Array,
        length: Array,
        frames: Index | None = None,
    ) -> Answers:
        """Casts a sensor's rays at each of the kept frames `frames` (k,), or at the last one, and
        returns what they find there. In Blender units, after the caster was brought up to date; the
        other arguments as of `RayCaster.cast`."""
        self._follow(depsgraph)
        if frames is None:
            frames = np.array([len(self._rays.frames) - 1])
        found = self._rays.see_at(sensor, bundle, origins, directions, length, frames)
        return Answers([self._found(depsgraph, seen) for seen in found.table], found.rows)

    def ranges(self, sensor: Uid, bundle: int) -> Array:
        """How far (n,) the rays get that `see` was asked about last."""
        return self._rays.last_ranges(sensor, bundle)

    @abstractmethod
    def _follow(self, depsgraph: Any) -> None:
        """Reads what changed since the last look."""

    @abstractmethod
    def _found(self, depsgraph: Any, seen: RayHits) -> Any:
        """The property where rays end."""
