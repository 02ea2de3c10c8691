# SPDX-License-Identifier: GPL-3.0-or-later
"""The base class of probes that read one property of the surfaces that rays hit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from ....sensor_logic.model import Answers, Array, Index
from ..instances import Uid
from ..rays.caster import RayCaster, RayHits, Rays


class MetSurfaces(ABC):
    """Reads one property of the surfaces that the rays of a ray caster hit.

    Attributes
    ----------
    need
        The name of the query, which kinds have in their `needs`.
    reads_shading
        Whether the property depends on the colours of materials.
    """

    need: ClassVar[str]
    reads_shading: ClassVar[bool] = False

    @staticmethod
    def changes_by_itself(scene: Any) -> bool:
        """Return whether the property can change with the frame while nothing moves."""
        return False

    def __init__(self, caster: RayCaster) -> None:
        self._rays = caster
        self._listing = -1

    def see(
        self,
        depsgraph: Any,
        sensor: Uid,
        bundle: int,
        rays: Rays,
        frames: Index | None = None,
    ) -> Answers:
        """Cast a sensor's rays at some frames, and return the property of the surfaces hit.

        Call it after the caster was updated. Lengths are in Blender units.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        sensor, bundle, rays
            As for `RayCaster.cast_at`.
        frames
            Indices (k,) of the frames of the caster; None for the last one.

        Returns
        -------
        Answers
            The property at each frame, in the form that `_values_at` returns.
        """
        self._update(depsgraph)
        if frames is None:
            frames = np.array([len(self._rays.frames) - 1])
        found = self._rays.see_at(sensor, bundle, rays, frames)
        return Answers([self._values_at(depsgraph, seen) for seen in found.table], found.rows)

    @property
    def hits(self) -> Answers:
        """The hits of the latest call of `see`, as read-only `RayHits` for each frame."""
        return self._rays.seen

    def ranges(self, sensor: Uid, bundle: int) -> Array:
        """Return the ranges (n,) of the rays of the latest call of `see`."""
        return self._rays.last_ranges(sensor, bundle)

    @abstractmethod
    def _update(self, depsgraph: Any) -> None:
        """Read the changes since the last call."""

    @abstractmethod
    def _values_at(self, depsgraph: Any, seen: RayHits) -> Any:
        """Return the property of the surfaces that the rays of `seen` hit."""
